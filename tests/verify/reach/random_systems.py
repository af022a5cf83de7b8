"""Small random systems, teams and claims, with numbers that meet each other often."""

from fractions import Fraction as F

from tests.support.system_cases import form, policy, team
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Affine, Feature, HalfSpace, Measure, Piece, System, Variable

HALVES = [F(n, 2) for n in range(-4, 5)]
FACTORS = [F(-1), F(-1, 2), F(0), F(1, 2), F(1), F(1, 3)]


def some(random, values):
    return values[int(random.integers(len(values)))]


def affine(random, names, constant=HALVES):
    chosen = [name for name in names if random.random() < 0.7] or [some(random, names)]
    return Affine.of({name: some(random, FACTORS) or F(1) for name in chosen}, some(random, constant))


def feature(random, names):
    measure = some(random, [measure for measure in Measure if measure is not Measure.EQUALS])  # random_modes has those
    bounds = (F(-1, 2), F(1)) if measure is Measure.CLIP else None
    return Feature(affine(random, names), measure, bounds)


def nested(random, depth, features, actions):
    if not depth or random.random() < 0.2:
        return int(random.integers(actions))
    threshold = float(some(random, [*HALVES, F(1, 10), F(1, 3)]))
    test = (int(random.integers(features)), threshold)
    return (test, nested(random, depth - 1, features, actions), nested(random, depth - 1, features, actions))


def polytope(random, names, strict=0.3):
    found = []
    for _ in range(int(random.integers(1, 4))):
        found.append(HalfSpace(affine(random, names), bool(random.random() < strict)))
    return tuple(found)


def start(random, names):
    found = []
    for name in names:
        low = some(random, HALVES)
        high = low + some(random, [F(0), F(1, 2), F(1)])
        found += [HalfSpace(form(low, **{name: -1})), HalfSpace(form(-high, **{name: 1}))]
    if random.random() < 0.4:
        found.append(HalfSpace(affine(random, names), bool(random.random() < 0.3)))
    return tuple(found)


def pieces(random, names, agents, actions):
    boxes = [{}]
    if random.random() < 0.4:
        cut, name = some(random, HALVES), some(random, names)
        far = F(20) if random.random() < 0.7 else F(2)
        boxes = [{name: (-far, cut)}, {name: (cut, far)}]
    found = []
    for where in boxes:
        move = {name: affine(random, names, [F(0), F(1, 4)]) for name in names}
        effect = {
            (agent, action): {some(random, names): Affine((), some(random, HALVES))}
            if random.random() < 0.8
            else {some(random, names): affine(random, names)}
            for agent in agents
            for action in actions
        }
        error = {name: (-some(random, [F(0), F(1, 8)]), F(1, 8)) for name in names if random.random() < 0.3}
        found.append(Piece(where, move, effect, error))
    return tuple(found)


def case(random):
    """A system, a team and a claim."""
    names = ["x", "y", "z"][: int(random.integers(1, 4))]
    agents = ["a", "b"][: int(random.integers(1, 3))]
    actions = ["go", "rest", "back"][: int(random.integers(2, 4))]
    features = {agent: {f"f{n}": feature(random, names) for n in range(2)} for agent in agents}
    variables = tuple(Variable(name, "1", (F(-3), F(3))) for name in names)
    system = System("random", variables, features, start(random, names), pieces(random, names, agents, actions), 3)
    profile = team(*(policy(agent, ["f0", "f1"], actions, nested(random, 2, 2, len(actions))) for agent in agents))
    kind = some(random, [kind for kind in Pattern if kind not in (Pattern.DECIDES, Pattern.ALWAYS)])
    steps = int(random.integers(0, 4))
    regions = tuple(polytope(random, names) for _ in range(int(random.integers(1, 3))))
    if kind in (Pattern.STAYS_IN, Pattern.REACHES_AND_STAYS) and random.random() < 0.5:
        size = some(random, [F(2), F(4), F(8)])
        regions = (tuple(HalfSpace(form(-size, **{name: sign})) for name in names for sign in (1, -1)),)
    by = int(random.integers(0, steps + 1)) if kind is Pattern.REACHES_AND_STAYS else 0
    return system, profile, SystemClaim(kind, regions, steps, by)
