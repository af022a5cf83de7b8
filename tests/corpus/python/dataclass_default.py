from dataclasses import dataclass
@dataclass(frozen=True)
class P:
    lo: float = -0.2
    hi: float = 0.2
p = P(hi=0.25)
def act(obs, p=p):
    z = obs[3] if obs[3] > 0 else -obs[3]
    ok = p.lo < obs[0] < p.hi
    if ok and z <= 0.5: return "stay"
    elif not ok and obs[0] >= p.hi: return "left"
    return "right"
