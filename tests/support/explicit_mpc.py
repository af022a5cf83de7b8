"""A double integrator's explicit model predictive controller, in exact numbers, and as a tree in if/else Python.

Source: Bemporad, Morari, Dua, Pistikopoulos, The explicit linear quadratic regulator for constrained systems (2002).
The control of each step is free or at one of its bounds. Each choice that is optimal somewhere is so in a polygon of
states, where the first control is affine in the state.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import NamedTuple

from codegen.importers.origin import Names, Said, profile_of
from codegen.importers.python.source import from_python
from codegen.policy_json import dumps
from maviper.cli import main

ONE = Fraction(1)


@dataclass(frozen=True)
class Problem:
    """The sum over `horizon` steps of x^2 + speed v^2 + effort u^2, of which the last state weighs `last` as
    much; |u| is at most `most`; x' = x + dt v + dt^2/2 u, v' = v + dt u.
    """

    horizon: int = 2
    dt: Fraction = Fraction(1, 2)
    speed: Fraction = Fraction(1, 2)
    effort: Fraction = Fraction(1, 2)
    last: Fraction = Fraction(3)
    most: Fraction = ONE

    def quadratic(self):
        """H and F of 1/2 U'HU + s'FU, for the state s."""
        columns = [[self._moved(step, at) for at in range(self.horizon)] for step in range(1, self.horizon + 1)]
        n = self.horizon
        h = [[2 * self.effort * (row == column) for column in range(n)] for row in range(n)]
        f = [[Fraction(0)] * n for _ in range(2)]
        for step, moved in enumerate(columns, 1):
            weight = 2 * (self.last if step == n else ONE)
            free = ((ONE, step * self.dt), (Fraction(0), ONE))  # rows x and v, of the state
            for part, cost in enumerate((ONE, self.speed)):
                for row in range(n):
                    for column in range(n):
                        h[row][column] += weight * cost * moved[row][part] * moved[column][part]
                    for at in range(2):
                        f[at][row] += weight * cost * free[part][at] * moved[row][part]
        return h, f

    def _moved(self, step, at):
        """What the control of a step adds to x and v some steps later."""
        if at >= step:
            return Fraction(0), Fraction(0)
        return self.dt**2 / 2 + (step - at - 1) * self.dt**2, self.dt


class Form(NamedTuple):
    """a x + b v + c."""

    a: Fraction
    b: Fraction
    c: Fraction

    def at(self, x, v):
        """Its value."""
        return self.a * x + self.b * v + self.c


class Region(NamedTuple):
    """Where some controls are at bounds: all `forms` are at most 0, and the first control is `law`."""

    forms: tuple[Form, ...]
    law: Form


def solved(matrix, right):
    """The columns x of matrix x = right, by elimination."""
    n, rows = len(matrix), [[*row, *more] for row, more in zip(matrix, right, strict=True)]
    for at in range(n):
        pivot = next(row for row in range(at, n) if rows[row][at])
        rows[at], rows[pivot] = rows[pivot], rows[at]
        rows[at] = [value / rows[at][at] for value in rows[at]]
        for row in range(n):
            if row != at and rows[row][at]:
                rows[row] = [one - rows[row][at] * other for one, other in zip(rows[row], rows[at], strict=True)]
    return [row[n:] for row in rows]


def regions(problem, box):
    """The regions that meet a box ((low, high) of x, of v) in more than an edge."""
    h, f = problem.quadratic()
    found = []
    for kinds in product((0, -1, 1), repeat=problem.horizon):
        free = [at for at, kind in enumerate(kinds) if not kind]
        controls = [Form(Fraction(0), Fraction(0), kind * problem.most) for kind in kinds]
        if free:
            right = [
                [
                    -f[0][row],
                    -f[1][row],
                    -sum((h[row][at] * controls[at].c for at in range(len(kinds)) if kinds[at]), Fraction(0)),
                ]
                for row in free
            ]
            for at, values in zip(free, solved([[h[row][at] for at in free] for row in free], right), strict=True):
                controls[at] = Form(*values)
        forms = []
        for at, kind in enumerate(kinds):
            if not kind:
                one = controls[at]
                forms += [one._replace(c=one.c - problem.most), Form(-one.a, -one.b, -one.c - problem.most)]
                continue
            slope = Form(
                *(
                    sum((h[at][other] * controls[other][part] for other in range(len(kinds))), Fraction(0))
                    + (f[part][at] if part < 2 else 0)
                    for part in range(3)
                )
            )
            forms.append(slope if kind > 0 else Form(*(-value for value in slope)))
        polygon = corners(box)
        for form in forms:
            polygon = parted(polygon, form)[0]
        if area(polygon):
            found.append(Region(tuple(form for form in forms if form.a or form.b), controls[0]))
    return found


def corners(box):
    """A box as a polygon."""
    (left, right), (low, high) = box
    return [(left, low), (right, low), (right, high), (left, high)]


def parted(polygon, form):
    """The parts of a convex polygon where a form is at most 0, and at least 0."""
    sides = [], []
    for (x, v), (y, w) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        here, there = form.at(x, v), form.at(y, w)
        for side, sign in zip(sides, (1, -1), strict=True):
            if here * sign <= 0:
                side.append((x, v))
            if here * there < 0:
                share = here / (here - there)
                side.append((x + share * (y - x), v + share * (w - v)))
    return sides


def area(polygon):
    """Twice its area."""
    pairs = zip(polygon, polygon[1:] + polygon[:1], strict=True)
    return abs(sum((x * w - y * v for (x, v), (y, w) in pairs), Fraction(0)))


def tree(known, polygon):
    """Nested (form, left, right), and laws at the leaves. At each node the form that leaves the fewest regions."""
    meeting = [(region, part) for region in known if area(part := within(polygon, region))]
    laws = {region.law for region, _ in meeting}
    if len(laws) == 1:
        return laws.pop()
    best = None
    for form in dict.fromkeys(form for region, _ in meeting for form in region.forms):
        sides = parted(polygon, form)
        counts = [sum(bool(area(parted(part, form)[side])) for _, part in meeting) for side in (0, 1)]
        if all(area(side) for side in sides) and (best is None or (max(counts), sum(counts)) < best[0]):
            best = (max(counts), sum(counts)), form, sides
    assert best is not None
    _, form, sides = best
    return form, tree(known, sides[0]), tree(known, sides[1])


def within(polygon, region):
    """The part of a polygon in a region."""
    for form in region.forms:
        polygon = parted(polygon, form)[0] if polygon else polygon
    return polygon


def leaves(node):
    """The laws at the leaves."""
    return [node] if isinstance(node, Form) else [*leaves(node[1]), *leaves(node[2])]


def python(node, level=1):
    """The tree as if/else Python; numbers are the nearest doubles."""
    pad = "    " * level
    if isinstance(node, Form):
        return [f"{pad}return {_sum(node)}"]
    form, left, right = node
    test = f"{pad}if {_sum(form._replace(c=Fraction(0)))} <= {float(-form.c)!r}:"
    return [test, *python(left, level + 1), *python(right, level)]


def _sum(form):
    parts = [f"{float(weight)!r} * {name}" for weight, name in ((form.a, "x"), (form.b, "v")) if weight]
    parts += [repr(float(form.c))] if form.c or not parts else []
    return " + ".join(parts)


BOX = ((Fraction(-4), Fraction(4)), (Fraction(-3), Fraction(3)))
WORLD = """
name = "double integrator"
steps = 12
dt = "0.5 s"
[variables]
x = { unit = "m", range = [-4, 4] }
v = { unit = "m/s", range = [-3, 3] }
[agents.cart.features]
x = "x"
v = "v"
[agents.cart.outputs]
push = "m/s^2"
[start]
box = { x = [-1, 1], v = [-0.5, 0.5] }
[dynamics.next]
x = "x + dt*v + 0.5*dt**2*cart.push"
v = "v + dt*cart.push"
"""
# within it no control is at a bound, and the linear law of the controller leads back into it
LASTING = """
[[property]]
label = "stays for ever"
name = "always"
region = { box = { x = [-1, 1], v = [-1, 1] } }
invariant = { box = { x = [-1, 1], v = [-1, 1] }, where = [
  "0.9053*x + 1.3561[s]*v <= 1[m]", "-0.9053*x - 1.3561[s]*v <= 1[m]",
] }
"""


def controller(horizon):
    """A problem and the tree of its controller."""
    problem = Problem(horizon)
    text = "def cart(x, v):\n" + "\n".join(python(tree(regions(problem, BOX), corners(BOX)))) + "\n"
    said = Said(arrays="float64", outputs=("push",))
    return problem, profile_of(from_python(text.encode(), "cart.py", said), Names(outputs=("push",)))


def prove_lasting(folder):
    """The certificate that the controller stays in a region for ever, with profile and world file beside it."""
    start, inside = "x = [-1, 1], v = [-0.5, 0.5]", "x = [-0.5, 0.5], v = [-0.2, 0.2]"
    (folder / "cart.json").write_text(dumps(controller(2)[1]))
    (folder / "world.toml").write_text(WORLD.replace(start, inside) + LASTING)
    asked = ["verify", str(folder / "cart.json"), "--world", str(folder / "world.toml"), "--max-boxes", "300000"]
    assert main.run([*asked, "-o", str(folder / "out")]) == 0
    (path,) = (folder / "out").glob("certificate-*.json")
    return path
