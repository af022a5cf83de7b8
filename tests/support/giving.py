"""World files and random agents that give numbers or test sums in them, with numbers of a size that has bounds."""

from dataclasses import replace

import numpy as np

from codegen.sums import Sum
from tests.support import summed

VARIABLES = ("p", "q", "r")
FEATURES = ("p - 2*q", "0.1*r + 0.3", "q", "p + q - r", "3*p - 0.7")  # of the five features of random agents

CART = """
import numpy as np
def cart(x, v):
    if x + v <= -1.5:
        return 2.0
    return np.clip(-1.25 * x - 1.5 * v, -2.0, 2.0)
"""

INTEGRATOR = """
name = "double integrator"
steps = 12
dt = "0.1 s"
[variables]
x = { unit = "m", range = [-5, 5] }
v = { unit = "m/s", range = [-5, 5] }
[agents.cart.features]
x = "x"
v = "v"
ACTS
[start]
box = { x = [-1, 1], v = [-SPEED, SPEED] }
[dynamics.next]
x = "x + dt*v"
v = "v + dt*cart.push"
"""
GIVES = '[agents.cart.outputs]\npush = "m/s^2"'


def integrator(speed, acts=GIVES):
    """A world file of a cart that pushes, without claims; `speed`: at most, of a start."""
    return INTEGRATOR.replace("ACTS", acts).replace("SPEED", speed)


def world(outputs=0, actions=("left", "stay", "right"), more=""):
    acting = (
        "[agents.agent_0.outputs]\n" + "".join(f'u{place} = "N"\n' for place in range(outputs))
        if outputs
        else "[agents.agent_0.actions]\n" + "".join(f"{name} = {{ push = 0 }}\n" for name in actions)
    )
    features = "".join(f'x{place} = "{text}"\n' for place, text in enumerate(FEATURES))
    variables = "".join(f"{name} = {{ range = [-3, 3] }}\n" for name in VARIABLES)
    start = ", ".join(f"{name} = [-1, 1]" for name in VARIABLES)
    rules = "".join(f'{name} = "{name}"\n' for name in VARIABLES)
    dynamics = "" if outputs else f"[dynamics.next]\n{rules}"
    head = f'name = "w"\nsteps = 3\n[variables]\n{variables}[agents.agent_0.features]\n{features}{acting}'
    return f"{head}[start]\nbox = {{ {start} }}\n{dynamics}{more}"


def tree(seed, arithmetic, outputs, gives=None, bounded=True):
    """A random tree whose numbers are of a size at which roundings have bounds."""
    return tamed(summed.policy(seed, arithmetic, outputs=outputs, gives=gives, bounded=bounded, inner=0.3, over=0.3))


def tamed(drawn):
    """A random agent with numbers of such a size, as profiles have it: equal sums stand once, and a tree without sums
    and outputs has no arithmetic.
    """

    def tame(each):
        if not isinstance(each, Sum):
            return each
        return Sum(tuple((w if 2.0**-20 < abs(w) < 2.0**20 else 0.5, tame(place)) for w, place in each.terms))

    made, n = drawn.tree, len(drawn.features)
    sums, vectors = tuple(map(tame, made.sums)), tuple(tuple(map(tame, each)) for each in made.vectors)
    firsts = [
        [next(k for k, one in enumerate(known) if repr(one) == repr(each)) for each in known]
        for known in (sums, vectors)
    ]
    kept = [sorted(set(places)) for places in firsts]
    feature = [f if f < n else n + kept[0].index(firsts[0][f - n]) for f in made.feature.tolist()]
    action = made.action
    if vectors:
        action = np.array([a if a < 0 else kept[1].index(firsts[1][a]) for a in made.action.tolist()])
    named = {"sums": tuple(sums[k] for k in kept[0]), "vectors": tuple(vectors[k] for k in kept[1])}
    named |= {} if sums or vectors else {"arithmetic": ""}
    return replace(drawn, tree=replace(made, feature=np.array(feature), action=action, **named))
