"""Small random systems with modes, cases and choices, and teams that test for modes."""

from fractions import Fraction as F

from tests.support.system_cases import box, form, policy, team
from tests.verify.reach.random_systems import HALVES, affine, nested, polytope, some
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Affine, Feature, HalfSpace, Measure, Piece, System, Variable

MODES = ("off", "slow", "fast")
FAR = F(8)


def at(mode):
    """The half spaces of a mode."""
    return (HalfSpace(form(-mode, m=1)), HalfSpace(form(mode, m=-1)))


def cases(random, names):
    """Boxes with conditions that hold every state once: for each mode one, or two on either side of an end."""
    found = []
    for mode in range(len(MODES)):
        where = {"m": (F(mode), F(mode)), **dict.fromkeys(names, (-FAR, FAR))}
        if random.random() < 0.5:
            found.append((where, ()))
            continue
        total, strict = affine(random, names, HALVES), bool(random.random() < 0.5)
        other = Affine().plus(total, F(-1))
        found += [(where, (HalfSpace(total, strict),)), (where, (HalfSpace(other, not strict),))]
    return found


def after(random, actions):
    """What becomes of the mode: what it is, another one, or one for each action."""
    way = random.random()
    if way < 0.3:
        return form(m=1), {}
    if way < 0.6:
        return form(int(random.integers(len(MODES)))), {}
    return form(), {action: form(int(random.integers(len(MODES)))) for action in actions}


def pieces(random, names, actions):
    found = []
    for where, when in cases(random, names):
        move, modes = after(random, actions)
        error = {name: (F(0), F(1, 8)) for name in names if random.random() < 0.2}
        ways = int(random.integers(1, 4))
        own = {name: affine(random, names, [F(0), F(1, 4)]) for name in names}
        pushed = some(random, names)
        for way in range(ways):
            effect = {}
            for action in actions:
                effect["a", action] = {pushed: form(some(random, HALVES))}
                if action in modes:
                    effect["a", action]["m"] = modes[action]
            choice = {"push": str(way)} if ways > 1 else {}
            found.append(Piece(where, {**own, "m": move}, effect, error, when, choice))
    return tuple(found)


def feature(random, names):
    if random.random() < 0.5:
        return Feature(form(-int(random.integers(len(MODES))), m=1), Measure.EQUALS)
    if random.random() < 0.2:
        return Feature(affine(random, names), Measure.EQUALS)
    return Feature(affine(random, names))


def testing(features, nested):
    """A tree whose tests for equality ask for it: others always go one way."""
    if isinstance(nested, int):
        return nested
    (place, threshold), *below = nested
    threshold = 0.5 if features[f"f{place}"].measure is Measure.EQUALS else threshold
    return ((place, threshold), *(testing(features, each) for each in below))


def case(random):
    """A system, a team and a claim."""
    names = ["x", "y"][: int(random.integers(1, 3))]
    actions = ["go", "rest", "back"][: int(random.integers(2, 4))]
    features = {"a": {f"f{n}": feature(random, names) for n in range(3)}}
    variables = (*(Variable(name, "1", (-FAR, FAR)) for name in names), Variable("m", "1", (F(0), F(2)), MODES))
    low = {name: some(random, HALVES) for name in names}
    starts = {name: (low[name], low[name] + some(random, [F(0), F(1, 2), F(1)])) for name in names}
    mode = int(random.integers(len(MODES)))
    start = box(**starts, m=(mode, mode))
    system = System("modes", variables, features, start, pieces(random, names, actions), 3)
    tree = testing(features["a"], nested(random, 3, 3, len(actions)))
    profile = team(policy("a", ["f0", "f1", "f2"], actions, tree))
    kind = some(random, [kind for kind in Pattern if kind not in (Pattern.DECIDES, Pattern.ALWAYS)])
    steps = int(random.integers(1, 4))
    region = polytope(random, names)
    if kind in (Pattern.STAYS_IN, Pattern.REACHES_AND_STAYS):
        size = some(random, [F(1), F(2), F(4)])
        region = tuple(HalfSpace(form(-size, **{name: sign})) for name in names for sign in (1, -1))
    if random.random() < 0.4:
        region = (*region, *at(int(random.integers(len(MODES)))))
    by = int(random.integers(0, steps + 1)) if kind is Pattern.REACHES_AND_STAYS else 0
    return system, profile, SystemClaim(kind, (region,), steps, by)
