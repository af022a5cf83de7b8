"""Stated systems with teams: built in a few lines, and those that claims are proved and broken of."""

from fractions import Fraction as F

import numpy as np

from codegen import ir
from verify.systems.claims import SystemClaim, SystemKind
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
    rows = []

    def add(node):
        place = len(rows)
        rows.append(None)
        if isinstance(node, int):
            rows[place] = (-1, 0.0, -1, -1, node)
        else:
            (feature, threshold), left, right = node
            rows[place] = (feature, threshold, add(left), add(right), -1)
        return place

    add(nested)
    return ir.Tree(*(np.array(column) for column in zip(*rows, strict=True)))


def policy(agent, features, actions, nested):
    specs = tuple(ir.FeatureSpec(name, "1", -100.0, 100.0, None) for name in features)
    return ir.AgentPolicy(agent, "team", specs, tuple(ir.ActionSpec(name, None) for name in actions), tree(nested))


def team(*policies):
    return ir.PolicyProfile(SPEC, policies, ir.Provenance("by hand", "", 0, "", "tests"))


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
    return SystemClaim("stays_in", SystemKind.STAYS_IN, (box(**bounds),), steps, label=label)
