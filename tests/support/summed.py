"""Seeded profiles whose trees test sums and give numbers, and an evaluation of them in exact arithmetic."""

import math
import struct
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS, OBSERVED, Sum, choose_numbers

ARITHMETICS = (DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS)
EXTREME = (1.0, -1.0, 0.5, -2.0, 0.1, -3.3, 1e-30, 1e30, 2.0**-126, -3e38, 7.0)


def number(value, numbers):
    """The nearest of the numbers, as a Python float, never subnormal."""
    near = float(np.dtype(numbers).type(value))
    return near if near == 0 or abs(near) >= float(np.finfo(numbers).tiny) else 1.0


def a_sum(rng, n_features, arithmetic, *, test, inner=0.0, over=0.0):
    """A sum of features with weights of every size; most of them differences or short sums, `inner`: some of these
    with a sum in them; `over`: some terms are divided.
    """
    numbers = OBSERVED[arithmetic]
    count = int(rng.integers(2, 4)) if test else int(rng.integers(0, 4))
    places = [int(place) for place in rng.permutation(n_features)[:count]]
    weights = [1.0, -1.0] if rng.random() < 0.5 else [float(rng.choice(EXTREME)) for _ in places]
    weights = (weights + [float(rng.normal()) for _ in places])[:count]
    terms = [(number(weight, numbers), place) for weight, place in zip(weights, places, strict=True)]
    if inner and terms and rng.random() < inner:
        weight = rng.choice([1.0, -1.0] if arithmetic == DOUBLE_SUMS else [1.0, -1.0, 2.5, -0.3])
        part = a_sum(rng, n_features, arithmetic, test=True, inner=inner / 2, over=over)
        terms.insert(int(rng.integers(len(terms) + 1)), (number(weight, numbers), part))
    if over and arithmetic != DOUBLE_SUMS:
        odd = [term for term in terms if rng.random() < over and math.frexp(abs(term[0]))[0] != 0.5]
        terms = [
            (1 / Fraction(weight), place) if (weight, place) in odd else (weight, place) for weight, place in terms
        ]
    if not terms or rng.random() < 0.4:
        value = float(rng.choice([0.0, -0.0, 0.25, -1.0, float(rng.normal())]))
        terms.insert(int(rng.integers(len(terms) + 1)), (number(value, choose_numbers(arithmetic)), ir.CONSTANT))
    return Sum(tuple(terms))


class _Growing:
    def __init__(self, rng, n_features, arithmetic, outputs, levels, **inner):
        self.rng, self.n, self.arithmetic, self.outputs, self.levels = rng, n_features, arithmetic, outputs, levels
        self.inner = inner
        self.rows, self.sums, self.vectors = [], [], []

    def node(self, level=0):
        place, rng = len(self.rows), self.rng
        self.rows.append(None)
        if level == self.levels or (level > 1 and rng.random() < 0.2):
            if self.outputs:
                given = {"test": False, **self.inner}
                vector = tuple(a_sum(rng, self.n, self.arithmetic, **given) for _ in range(self.outputs))
                action = self._place(self.vectors, vector)
            else:
                action = int(rng.integers(3))
            self.rows[place] = (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, action)
            return place
        drawn = rng.choice([0.0, 0.1, -0.5, float(rng.normal())])
        if rng.random() < 0.3:
            feature, threshold = int(rng.integers(self.n)), number(drawn, OBSERVED[self.arithmetic])
        else:
            made = a_sum(rng, self.n, self.arithmetic, test=True, **self.inner)
            feature = self.n + self._place(self.sums, made)
            threshold = number(drawn, choose_numbers(self.arithmetic))
        left = self.node(level + 1)
        right = self.node(level + 1)
        self.rows[place] = (feature, threshold, left, right, ir.NO_ACTION)
        return place

    @staticmethod
    def _place(known, each):
        keys = [repr(one) for one in known]
        if repr(each) not in keys:
            known.append(each)
            return len(keys)
        return keys.index(repr(each))


def policy(seed, arithmetic, *, outputs=0, gives=None, levels=4, n_features=5, bounded=True, agent="agent_0", **inner):
    """An agent with a random tree of sums; `outputs`: how many numbers it gives (0: it takes one of three actions);
    `inner`, `over`: how many of its sums weigh another one, and of its terms are divided.
    """
    rng = np.random.default_rng(seed)
    growing = _Growing(rng, n_features, arithmetic, outputs, levels, **inner)
    growing.node()
    gives = gives or choose_numbers(arithmetic)
    tree = ir.Tree(
        *(np.array(column) for column in zip(*growing.rows, strict=True)),
        numbers=OBSERVED[arithmetic],
        arithmetic=arithmetic,
        sums=tuple(growing.sums),
        vectors=tuple(growing.vectors),
        gives=gives if outputs else "float32",
    )
    features = tuple(ir.FeatureSpec(f"x{place}", "m", -3.0, 3.0, None) for place in range(n_features))
    actions = () if outputs else tuple(ir.ActionSpec(name, None) for name in ("left", "stay", "right"))
    bounds = (-1.0, 1.5) if bounded or gives != choose_numbers(arithmetic) else (None, None)
    given = tuple(ir.OutputSpec(f"u{place}", "N", *bounds) for place in range(outputs))
    return ir.AgentPolicy(agent, "team", features, actions, tree, outputs=given)


def profile(*policies):
    """A profile of these agents, in a world that nobody states."""
    entities = tuple(ir.EntitySpec(each.agent, 0.0, 0.0, None, False) for each in policies)
    world = ir.WorldSpec("sums", "", entities, (), (), 0.0, 0.0, 0.0, 0.0, 1)
    return ir.PolicyProfile(world, tuple(policies), ir.Provenance("random", "none", 0, "", "tests"))


def every(seed, levels=4, **inner):
    """A profile of each kind, by its name: both kinds of leaves in every arithmetic, and what is rounded at the end."""
    found, given = {}, {"levels": levels, **inner}
    for place, arithmetic in enumerate(ARITHMETICS):
        found[f"actions, {arithmetic}"] = profile(policy(seed + place, arithmetic, **given))
        found[f"outputs, {arithmetic}"] = profile(policy(seed + place, arithmetic, outputs=3, **given))
        found[f"no bounds, {arithmetic}"] = profile(policy(seed + place, arithmetic, outputs=2, bounded=False, **given))
    rounded = policy(seed, DOUBLE_SUMS, outputs=2, gives="float32", **given)
    found["double sums given as float32"] = profile(rounded)
    both = policy(seed, FLOAT64_SUMS, **given, agent="agent_1")
    found["agents of two kinds"] = profile(rounded, both)
    return found


# --- the meaning once more, in exact arithmetic


def rounded(exact, numbers):
    """The nearest of the numbers, ties to even, of an exact fraction; infinite beyond the largest."""
    digits, least = (24, -149) if numbers == "float32" else (53, -1074)
    if exact == 0:
        return 0.0
    size = abs(exact)
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    exponent -= size < Fraction(2) ** exponent
    step = Fraction(2) ** max(exponent - digits + 1, least)
    whole, rest = divmod(size, step)
    whole += rest * 2 > step or (rest * 2 == step and whole % 2 == 1)
    largest = Fraction(2) ** (128 if numbers == "float32" else 1024)
    value = math.inf if whole * step >= largest else float(whole * step)
    return -value if exact < 0 else value


def _added(a, b, numbers):
    if not (math.isfinite(a) and math.isfinite(b)) or (a == 0 and b == 0):
        return a + b  # no rounding: infinities, NaN, signs of zero
    return rounded(Fraction(a) + Fraction(b), numbers)


def _times(a, b, numbers):
    if not (math.isfinite(a) and math.isfinite(b)) or a == 0 or b == 0:
        return a * b
    found = rounded(Fraction(a) * Fraction(b), numbers)
    return math.copysign(found, a) * math.copysign(1, b) if found == 0 else found


def exact_value(each, x, arithmetic):
    """The value of a sum for the observation x, as Python's floats."""
    numbers = choose_numbers(arithmetic)
    total = None
    for weight, place in each.terms:
        seen = exact_value(place, x, arithmetic) if isinstance(place, Sum) else x[place]
        divided = isinstance(weight, Fraction) and math.isfinite(seen) and seen != 0
        weight = weight if divided or not isinstance(weight, Fraction) else math.copysign(1, weight)
        term = weight if place == ir.CONSTANT else _times(weight, seen, numbers)
        total = term if total is None else _added(total, term, numbers)
    return total


def exact_decision(policy, x):
    """The action, or the tuple of numbers, for one observation in the agent's numbers."""
    tree, node = policy.tree, 0
    while tree.feature[node] != ir.NO_FEATURE:
        place = int(tree.feature[node])
        value = x[place] if place < len(x) else exact_value(tree.sums[place - len(x)], x, tree.arithmetic)
        node = int(tree.left[node] if value <= float(tree.threshold[node]) else tree.right[node])
    if not policy.outputs:
        return int(tree.action[node])
    return tuple(
        _bounded(exact_value(each, x, tree.arithmetic), output, tree.gives)
        for each, output in zip(tree.vectors[int(tree.action[node])], policy.outputs, strict=True)
    )


def _bounded(value, output, gives):
    if output.low is not None and value < output.low:
        value = output.low
    elif output.high is not None and value > output.high:
        value = output.high
    if not math.isfinite(value) or value == 0:
        return value
    return rounded(Fraction(value), gives) or math.copysign(0.0, value)


def bits(values):
    """Numbers as bits, every NaN the same."""
    return [struct.pack("<d", value) if value == value else b"NaN" for value in values]


def difference(threshold, numbers="float64"):
    """A profile of one agent that asks x0 - x1 <= threshold, all in these numbers, and takes the action 0 or 1."""
    arithmetic = FLOAT64_SUMS if numbers == "float64" else FLOAT32_STEPS
    arrays = ([5, -1, -1], [threshold, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])
    sums = (Sum(((1.0, 0), (-1.0, 1))),)
    made = policy(0, FLOAT64_SUMS)
    tree = ir.Tree(*arrays, numbers=numbers, arithmetic=arithmetic, sums=sums)
    return profile(ir.AgentPolicy("agent_0", "team", made.features, made.actions, tree))


def together(seed, levels=3, **inner):
    """One profile with an agent of each kind, so that each compiler is asked once; a team that gives and acts."""
    found = []
    for kind in every(seed, levels, **inner).values():
        found += [replace(each, agent=f"agent_{len(found) + place}") for place, each in enumerate(kind.agents)]
    return profile(*found)
