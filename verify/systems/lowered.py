"""Agents that test sums or give numbers, lowered: as agents that test single features and take actions.

Does: makes of such an agent a plain tree over exact affine features, in which each leaf is an action that sets the
  agent's inputs to affine forms of the state; states how much rounding may change each sum, as a variable of its own.
Assumes: a checked profile, whose features the file states; states within the ranges of the variables.
Does not: leave out a decision. In each state within the ranges there are values of these variables, within their
  bounds, with which the plain agent decides as the real one (observing.py says which).

A sum that an agent computes is its exact value plus an error. The error has a bound known from the order of the
operations and the ranges of the features: see `Errors`. A variable of a system holds error and bound together, so it is
between 0 and twice the bound; each step sets it anew. So a test of a sum is a test of an affine feature, and
`y = clip(sum)` is a test of either bound and an affine effect. Outputs share one such variable each, since one leaf at
a time gives them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.ir import CONSTANT, MAX_LENGTH, NO_FEATURE, ROOT, ActionSpec, AgentPolicy, FeatureSpec, Sum, Tree, outputs
from codegen.numbers import neighbour
from codegen.sums import DOUBLE_SUMS, choose_numbers
from verify.systems.expressions import Expression, Number, of_affine
from verify.systems.system import Affine, Feature, Interval, Measure

MAX_ACTIONS = 1_024
ROUNDING = "rounding_of_"  # begins the names of what roundings are, after the agent's
LARGEST = Fraction(2) ** 100  # of numbers in a sum: far from what overflows
# of float32 and float64: half a unit in the last place of 1, half the least number above 0
HALVES = {FLOAT32: (Fraction(1, 2**24), Fraction(1, 2**150)), FLOAT64: (Fraction(1, 2**53), Fraction(1, 2**1075))}
EXACT = (Measure.SIGN, Measure.POSITIVE, Measure.EQUALS)  # observed without rounding
ADVICE = "verify the agent by sampling, or state narrower ranges"


@dataclass(frozen=True)
class Rounded:
    """The rounding that a variable holds: by how much something that is computed in a state is above its exact value.

    `sums`: of which one, by the leaf's vector, or the same whatever the leaf is; `given`: what becomes of an output in
    its last rounding, instead.
    """

    variable: str
    bound: Fraction  # the variable is the rounding and this bound
    sums: tuple[Sum, ...]
    output: int | None = None  # the place of the output whose sums these are, by vector; None: one sum, which is tested
    given: bool = False

    @property
    def range(self) -> Interval:
        """The range of the variable. It begins at 0, so that one cell of any width holds it."""
        return Fraction(0), 2 * self.bound

    @property
    def form(self) -> Affine:
        """The rounding itself."""
        return Affine(((self.variable, Fraction(1)),), -self.bound)


@dataclass(frozen=True)
class Acting:
    """An agent as proofs read it."""

    real: AgentPolicy
    policy: AgentPolicy  # plain
    features: Mapping[str, Feature]  # that its tree tests, beside those of the file
    settings: Mapping[str, Mapping[str, Expression]]  # what each of its actions sets; of an agent with actions nothing
    roundings: tuple[Rounded, ...]


def acting(policy: AgentPolicy, features: Mapping[str, Feature], ranges: Mapping[str, Interval]) -> Acting:
    """The agent as proofs read it. `features`: its own, by name, as the file states them; `ranges`: of variables.

    InputError for sums of features that are not affine, and numbers that are too large to bound their roundings.
    """
    return _Reading(policy, features, ranges).acting()


class Errors:
    """The largest errors of what is computed in floats: bounds, in exact numbers.

    A rounding to nearest is off by at most half a unit in the last place: `u |x| + s`, with u = 2^-53 and s = 2^-1075
    in float64, and 2^-24, 2^-150 in float32. An addition is exact among subnormal numbers, so `u |x|` bounds its own.
    """

    def __init__(self, policy: AgentPolicy, sizes: Mapping[int, Fraction | None]) -> None:
        """`sizes`: the largest absolute value of each affine feature, by place; None: observed without rounding."""
        tree = policy.tree
        self._kept = {place for place, each in enumerate(policy.features) if each.initial is not None}
        self._seen = HALVES[policy.numbers]
        self._added = HALVES[choose_numbers(tree.arithmetic) if tree.arithmetic else FLOAT64]
        self._exact_products, self._gives = tree.arithmetic == DOUBLE_SUMS, HALVES[tree.gives]
        self._sizes = sizes

    def bound_feature(self, place: int) -> Fraction:
        """Of a feature that is observed; of what is remembered there is none, since floats hold whole numbers."""
        size = None if place in self._kept else self._sizes[place]
        if size is not None and size > LARGEST:
            raise InputError("a feature may be too large to bound its roundings", "", ADVICE)
        return Fraction(0) if size is None else _rounding(self._seen, size)

    def of(self, each: Sum) -> Fraction:
        """Of a sum: of its features, its products and its additions, in their order."""
        total, error = self._bound(each)
        if total > LARGEST:
            raise InputError("a sum may be too large to bound its roundings", "", ADVICE)
        return error

    def _bound(self, each: Sum) -> tuple[Fraction, Fraction]:
        """Returns the largest absolute value of a sum, roundings included, and its error."""
        total = error = Fraction(0)
        for count, (weight, place) in enumerate(each.terms):
            factor = abs(Fraction(weight))
            if place == CONSTANT:
                size, off = factor, Fraction(0)
            else:
                if isinstance(place, Sum):
                    size, off = self._bound(place)
                else:
                    off = self.bound_feature(place)
                    size = (self._sizes[place] or 1) + off
                size, off = factor * size, factor * off
                if not self._exact_products and factor != 1:
                    rounding = _rounding(self._added, size)
                    size, off = size + rounding, off + rounding
            total, error = total + size, error + off
            if count:
                rounding = self._added[0] * total
                total, error = total + rounding, error + rounding
        return total, error

    def bound_output(self, largest: Fraction) -> Fraction:
        """Of the last rounding of a number."""
        return _rounding(self._gives, largest)


def _rounding(half: tuple[Fraction, Fraction], size: Fraction) -> Fraction:
    return half[0] * size + half[1]


def _short(bound: Fraction) -> Fraction:
    """The least power of two that is not below a number above 0."""
    power = bound.numerator.bit_length() - bound.denominator.bit_length()
    return Fraction(2) ** (power if Fraction(2) ** power >= bound else power + 1)


class _Reading:
    """Makes the plain agent, node by node in preorder."""

    def __init__(self, policy: AgentPolicy, features: Mapping[str, Feature], ranges: Mapping[str, Interval]) -> None:
        self.real, self._tree, self._ranges = policy, policy.tree, ranges
        self._stated = [features[each.name] for each in policy.features]
        self._taken = {*features, *ranges}
        self._roundings: dict[str, Rounded] = {}
        rounded = {place: each for place, each in enumerate(self._stated) if each.measure not in EXACT}
        sizes = {place: max(map(abs, self._reach(each.form))) for place, each in rounded.items()}
        self._errors = Errors(policy, dict.fromkeys(range(len(self._stated))) | sizes)
        self._features: dict[str, Feature] = {}  # of the plain agent, in order
        self._added: dict[str, Feature] = {}
        self._settings: dict[str, dict[str, Expression]] = {}
        self._rows: list[tuple[int, float, int, int, int]] = []

    def acting(self) -> Acting:
        """The agent as proofs read it."""
        self._node(ROOT)
        columns = [np.array(column) for column in zip(*self._rows, strict=True)]
        tree = Tree(*columns, numbers=FLOAT64)
        kept = {each.name: each for each in self.real.memory}
        seen = tuple(
            kept.get(name, FeatureSpec(name, "none", -MAX_LENGTH, MAX_LENGTH, None)) for name in self._features
        )
        actions = tuple(ActionSpec(name, None) for name in self._settings) if self.real.outputs else self.real.actions
        seen = seen or (FeatureSpec(self.real.features[0].name, "none", -MAX_LENGTH, MAX_LENGTH, None),)
        plain = AgentPolicy(self.real.agent, self.real.team, seen, actions, tree)
        return Acting(self.real, plain, self._added, self._settings, tuple(self._roundings.values()))

    # --- nodes

    def _node(self, node: int) -> int:
        place = int(self._tree.feature[node])
        if place == NO_FEATURE:
            if not self.real.outputs:
                return self._ending(int(self._tree.action[node]))
            return self._output(node, 0, {}, f"leaf_{node}")
        plain = self._single(place) if place < len(self._stated) else self._sum(place - len(self._stated))
        left, right = int(self._tree.left[node]), int(self._tree.right[node])
        threshold = float(self._tree.threshold[node])
        return self._split(plain, threshold, lambda: self._node(left), lambda: self._node(right))

    def _split(self, plain: int, threshold: float, left: Callable[[], int], right: Callable[[], int]) -> int:
        place = len(self._rows)
        self._rows.append((plain, threshold, 0, 0, -1))
        first, second = left(), right()
        self._rows[place] = (plain, threshold, first, second, -1)
        return place

    def _ending(self, action: int) -> int:
        self._rows.append((NO_FEATURE, 0.0, -1, -1, action))
        return len(self._rows) - 1

    def _output(self, node: int, output: int, settings: dict[str, Expression], name: str) -> int:
        """The part of the plain tree that gives a leaf's outputs from one on. `name`: of the action, so far."""
        if output == len(self.real.outputs):
            if len(self._settings) == MAX_ACTIONS:
                what = f"outputs are cut in more than {MAX_ACTIONS} ways"
                raise InputError(what, self.real.agent, "use fewer leaves")
            self._settings[name] = settings
            return self._ending(len(self._settings) - 1)
        spec, vector = self.real.outputs[output], int(self._tree.action[node])
        given, key = self._tree.vectors[vector][output], f"{self.real.agent}.{spec.name}"

        def ends(number: float, more: str) -> Callable[[], int]:
            value = Number(Fraction(float(np.dtype(self._tree.gives).type(number))))
            return lambda: self._output(node, output + 1, {**settings, key: value}, f"{name}{more}")

        if not given.places:
            return ends(self._constant(vector, output), "")()
        # the output before it is cut, with its rounding, whose bound is that of all leaves
        variable = f"{self.real.agent}.{ROUNDING}output_{output + 1}"
        if variable not in self._roundings:
            sums = tuple(vector[output] for vector in self._tree.vectors)
            bound = max(self._errors.of(each) for each in sums)
            self._roundings[variable] = Rounded(variable, _short(bound), sums, output)
        form = self._form(given).plus(self._roundings[variable].form)
        low, high = self._reach(form)

        def inner() -> int:
            value = of_affine(self._last(output, form, low, high))
            return self._output(node, output + 1, {**settings, key: value}, name)

        def below_high() -> int:
            if spec.high is None or high <= Fraction(spec.high):
                return inner()
            return self._split(self._feature(form), spec.high, inner, ends(spec.high, f"-{output}_most"))

        if spec.low is None or low >= Fraction(spec.low):
            return below_high()
        last = float(neighbour(spec.low, -np.inf, FLOAT64))  # below the bound is at most the number before it
        return self._split(self._feature(form), last, ends(spec.low, f"-{output}_least"), below_high)

    def _constant(self, vector: int, output: int) -> float:
        """Returns what a leaf gives whatever is observed, cut and rounded: as the reference computes it."""
        arrays = ([NO_FEATURE], [0.0], [-1], [-1], [0])
        tree = Tree(
            *(np.array(each) for each in arrays),
            numbers=self.real.numbers,
            arithmetic=self._tree.arithmetic,
            vectors=(self._tree.vectors[vector],),
            gives=self._tree.gives,
        )
        alone = AgentPolicy(self.real.agent, self.real.team, self.real.features, (), tree, outputs=self.real.outputs)
        return float(outputs(alone, np.zeros((1, len(self.real.features)), self.real.numbers))[0, output])

    # --- features of the plain agent

    def _feature(self, form: Affine) -> int:
        """The place of a feature that measures a form."""
        known = [place for place, each in enumerate(self._features.values()) if each == Feature(form)]
        if known:
            return known[0]
        name = f"sum_{len(self._added) + 1}"
        while name in self._taken:
            name += "_"
        self._added[name] = self._features[name] = Feature(form)
        return len(self._features) - 1

    def _single(self, place: int) -> int:
        """A feature of the file: as it is where it is observed in float64, or without rounding; what is remembered."""
        stated, name = self._stated[place], self.real.features[place].name
        if self.real.numbers == FLOAT64 or stated.measure in EXACT or self.real.features[place].initial is not None:
            self._features.setdefault(name, stated)
            return list(self._features).index(name)
        if stated.measure is not Measure.VALUE:
            raise self._make_feature_error(place, "is rounded to float32 after it is clipped")
        bound = self._errors.bound_feature(place)
        return self._feature(self._with(stated.form, f"feature_{place + 1}", Sum(((1.0, place),)), bound))

    def _sum(self, place: int) -> int:
        """A feature that measures a sum with its rounding."""
        each = self._tree.sums[place]
        return self._feature(self._with(self._form(each), f"sum_{place + 1}", each, self._errors.of(each)))

    def _with(self, form: Affine, name: str, each: Sum, bound: Fraction) -> Affine:
        variable = f"{self.real.agent}.{ROUNDING}{name}"
        return form.plus(self._roundings.setdefault(variable, Rounded(variable, _short(bound), (each,))).form)

    def _last(self, output: int, form: Affine, low: Fraction, high: Fraction) -> Affine:
        """The form after the last rounding of an output."""
        if self._tree.gives == choose_numbers(self._tree.arithmetic):
            return form
        spec = self.real.outputs[output]
        ends = [low if spec.low is None else Fraction(spec.low), high if spec.high is None else Fraction(spec.high)]
        variable = f"{self.real.agent}.{ROUNDING}given_{output + 1}"
        sums = tuple(vector[output] for vector in self._tree.vectors)
        bound = _short(self._errors.bound_output(max(map(abs, ends))))
        return form.plus(self._roundings.setdefault(variable, Rounded(variable, bound, sums, output, given=True)).form)

    def _form(self, each: Sum) -> Affine:
        """The exact value of a sum."""
        form = Affine()
        for place, weight in each.expand().items():
            if place == CONSTANT:
                form = form.plus(Affine((), weight))
                continue
            if self._stated[place].measure is not Measure.VALUE:
                what = f"is {self._stated[place].measure.value}(..), and stands in a sum"
                raise self._make_feature_error(place, what)
            form = form.plus(self._stated[place].form, weight)
        return form

    def _make_feature_error(self, place: int, what: str) -> InputError:
        where = f"{self.real.agent}: feature {self.real.features[place].name}"
        return InputError(f"the feature {what}", where, "sums are proved of affine features only")

    # --- ranges

    def _reach(self, form: Affine) -> Interval:
        """The least and most that a form is within the ranges, and within the bounds of roundings."""
        least = most = form.constant
        for name, factor in form.terms:
            bounds = self._roundings[name].range if name in self._roundings else self._ranges[name]
            low, high = sorted(factor * end for end in bounds)
            least, most = least + low, most + high
        return least, most
