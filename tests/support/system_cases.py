"""Stated systems with teams: built in a few lines, and those that claims are proved and broken of."""

from fractions import Fraction as F

import z3

from codegen import ir
from codegen.paths import in_preorder
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Affine, Feature, HalfSpace, Piece, System, Variable

SPEC = ir.WorldSpec("stated", "", (), (), (), 0.0, 0.0, -1.0, 1.0, 1)


def form(constant=0, **terms):
    return Affine.of({name: F(factor) for name, factor in terms.items()}, F(constant))


def box(**bounds):
    """A polytope from name=(low, high)."""
    found = []
    for name, (low, high) in bounds.items():
        found += [HalfSpace(form(F(low), **{name: -1})), HalfSpace(form(-F(high), **{name: 1}))]
    return tuple(found)


def tree(nested):
    """A tree from ((feature, threshold), left, right) and actions."""
    return in_preorder(nested, lambda node: node if isinstance(node, int) else (*node[0], *node[1:]), "float32")


def policy(agent, features, actions, nested):
    specs = tuple(ir.FeatureSpec(name, "1", -100.0, 100.0, None) for name in features)
    return ir.AgentPolicy(agent, "team", specs, tuple(ir.ActionSpec(name, None) for name in actions), tree(nested))


def team(*policies):
    return ir.PolicyProfile(SPEC, policies, ir.Provenance("by hand", "", 0, "", "tests"))


def ends_of(system):
    """The bounds of each variable at the start, by ranges and half spaces that name it alone: name -> [low, high]."""
    found = {one.name: list(one.range) for one in system.variables}
    for half in system.start:
        if len(half.form.terms) == 1:
            ((name, factor),) = half.form.terms
            end, side = -half.form.constant / factor, int(factor > 0)
            found[name][side] = (min if side else max)(found[name][side], end)
    return found


def double_integrator(axes=3, half=F(1, 2), error=F(0), force=F(1, 2), dt=F(1, 5), steps=30):
    """Positions and velocities on each axis; an action pushes every axis one way or the other."""
    names = "xyz"[:axes]
    variables = [Variable(n, "m", (F(-10), F(10))) for n in names] + [
        Variable(f"v{n}", "m/s", (F(-10), F(10))) for n in names
    ]
    move = {n: form(**{n: 1, f"v{n}": dt}) for n in names} | {f"v{n}": form(**{f"v{n}": 1}) for n in names}
    actions = [f"push{number}" for number in range(2**axes)]
    effect = {}
    for number, action in enumerate(actions):
        push = {n: (1 if number >> bit & 1 else -1) * force for bit, n in enumerate(names)}
        effect["drone", action] = {n: form(push[n] * dt * dt / 2) for n in names} | {
            f"v{n}": form(push[n] * dt) for n in names
        }
    features = {"drone": {name: Feature(form(**{name: 1})) for name in move}}
    features["drone"] |= {f"s{n}": Feature(form(**{n: 1, f"v{n}": 2})) for n in names}
    start = box(**dict.fromkeys(names, (-half, half)), **{f"v{n}": (0, 0) for n in names})
    piece = Piece({}, move, effect, dict.fromkeys(move, (-error, error)) if error else {})
    return System("double integrator", tuple(variables), features, start, (piece,), steps)


def switching(axes=3):
    """Pushes each axis against the sign of position plus twice the velocity."""

    def nested(bit, number):
        if bit == axes:
            return number
        return ((bit, 0.0), nested(bit + 1, number | 1 << bit), nested(bit + 1, number))

    names = [f"s{n}" for n in "xyz"[:axes]]
    return team(policy("drone", names, [f"push{number}" for number in range(2**axes)], nested(0, 0)))


def stays(system, steps, label="", **bounds):
    return SystemClaim(Pattern.STAYS_IN, (box(**bounds),), steps, label=label)


def pendulum(half=F(1, 20), error=F(0), steps=20):
    """A cart under an inverted pendulum, linearised around the top, 0.02 s a step; all four variables are coupled."""
    dt = F(1, 50)
    names = {"x": "m", "v": "m/s", "angle": "rad", "rate": "rad/s"}
    variables = tuple(Variable(name, unit, (F(-5), F(5))) for name, unit in names.items())
    move = {
        "x": form(x=1, v=dt),
        "v": form(v=1, angle=-F(72, 100) * dt),
        "angle": form(angle=1, rate=dt),
        "rate": form(rate=1, angle=F(158, 10) * dt),
    }
    effect = {
        ("cart", action): {"v": form(push * F(976, 1000) * dt), "rate": form(-push * F(146, 100) * dt)}
        for action, push in (("left", F(-5)), ("rest", F(0)), ("right", F(5)))
    }
    features = {name: Feature(form(**{name: 1})) for name in names}
    features["lean"] = Feature(form(angle=1, rate=F(1, 4), x=F(1, 50), v=F(1, 25)))
    start = box(**dict.fromkeys(names, (-half, half)))
    piece = Piece({}, move, effect, dict.fromkeys(move, (-error, error)) if error else {})
    return System("inverted pendulum", variables, {"cart": features}, start, (piece,), steps)


def balancing():
    """Pushes to the side to which the pendulum leans, and rests near the top."""
    return team(policy("cart", ["lean"], ["left", "rest", "right"], ((0, -0.02), 0, ((0, 0.02), 1, 2))))


def corridor(start=F(1, 2), steps=15):
    """Two agents face each other in a corridor; each sees how far the other is, and may pass at its own side."""
    variables = tuple(Variable(name, "m", (F(-9), F(9))) for name in ("x1", "y1", "x2", "y2"))
    move = {name: form(**{name: 1}) for name in ("x1", "y1", "x2", "y2")}
    steps_of = {"on": (F(1, 5), F(0)), "aside": (F(0), F(1, 5)), "stay": (F(0), F(0))}
    effect = {}
    for agent, sign in (("1", 1), ("2", -1)):
        for action, (along, across) in steps_of.items():
            effect[f"agent{agent}", action] = {f"x{agent}": form(sign * along), f"y{agent}": form(sign * across)}
    gap, side = form(x2=1, x1=-1), form(y1=1, y2=-1)
    features = {name: {"gap": Feature(gap), "side": Feature(side)} for name in ("agent1", "agent2")}
    at = box(x1=(-2 - start, -2 + start), x2=(2 - start, 2 + start), y1=(F(-1, 10), F(1, 10)), y2=(F(-1, 10), F(1, 10)))
    piece = Piece({}, move, effect, {"x1": (F(-1, 100), F(1, 100)), "x2": (F(-1, 100), F(1, 100))})
    return System("corridor", variables, features, at, (piece,), steps)


def passing():
    """Each goes aside when the other is near and in front, else on."""
    tests = ((0, 1.5), ((0, -0.5), 0, ((1, 0.5), 1, 0)), 0)
    actions = ["on", "aside", "stay"]
    return team(*(policy(agent, ["gap", "side"], actions, tests) for agent in ("agent1", "agent2")))


def collision(near=F(2, 5)):
    """The states in which the two agents of the corridor are close on both axes."""
    gaps = [form(-near, x2=1, x1=-1), form(-near, x2=-1, x1=1), form(-near, y1=1, y2=-1), form(-near, y1=-1, y2=1)]
    return tuple(HalfSpace(gap) for gap in gaps)


def decided(profile, system, claims, budgets=None):
    """What the search says of claims, in order; by symbolic states alone, unless budgets say otherwise."""
    budgets = budgets or Budgets(covers=False)
    asked = (Question(ClosedLoop(profile, system), claim, UNBOUNDED, budgets=budgets) for claim in claims)
    return [decide(question) for question in asked]


def possible(test, milliseconds=60_000):
    """Whether Z3 finds that a test can hold; None where it does not know in time."""
    solver = z3.Solver(ctx=test.ctx)
    solver.set("timeout", milliseconds)
    solver.add(test)
    answer = solver.check()
    return None if answer == z3.unknown else answer == z3.sat
