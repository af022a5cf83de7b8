"""Affine forms as arrays: sets of states that depend on the start, cut by tests and moved by pieces.

Does: the data of a list of forms; bounds of sums over them; cuts and images, with fewer columns where there are many;
  sends forms down the trees of all agents; finds the pieces that a form meets, and moves it.
Assumes: float64 that rounds to nearest (rounding.py asks). Whatever order sums are taken in, what rounding loses is
  bounded and put into the radius. The exact sides of tests, as systems/reading.py has them.
Does not: know claims; refuse what is not finite, which the sweep does.

A form is the set of all  middle + sum of z_j columns_j + r,  each z_j in [-1, 1], each |r_i| at most radius_i. A box
keeps no trace of where its states came from, so rotations and x + dt v widen it. A form keeps it in its columns.

A sum of n products of floats, in any order and with or without fused operations, is off by at most n u / (1 - n u)
times the sum of absolute products, u = 2^-53 (Higham, Accuracy and Stability of Numerical Algorithms, 3.1), besides
what underflows. `LOST` is twice u, so (n + 4) LOST has room for factors that are rounded themselves, and for the
rounding of the bound.

Where a form meets several pieces, one of them moves all of it, with an error that has room for what the others do,
unless that error is large: then the form is cut at the bounds of their boxes. Were a form always cut, a curved rule
that is enclosed by many pieces would leave ever more slivers at their borders.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import NamedTuple

import numpy as np

from codegen.ir import NO_FEATURE, AgentPolicy, Bool, Float64, Int64, splits
from verify.checker.covers.boxes import BoxList, end_of, linear, opposite
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.covers.trees import PairNumbers, choices_of
from verify.checker.reading import RejectedError
from verify.checker.systems.reading import goes_left
from verify.claims.formula import FALSE, TRUE, Formula, Linear, Or
from verify.systems.system import Affine, HalfSpace, System

LOST = 2.0**-52
_MORE = 1.0 + 2.0**-44  # widens a bound that was computed in a few roundings
_UNDER = 2.0**-960  # more than underflow takes from any sum here
LEAST = 2.0**-900  # of a factor other than 0
MAX_NUMBERS = 1 << 26  # in the columns of one list


class FormList(NamedTuple):
    """Forms: `middle` and `radius` [n, variables], `columns` [n, k, variables]; `part` and `joint` as of boxes."""

    middle: Float64
    columns: Float64
    radius: Float64
    part: Int64
    joint: Int64

    @property
    def size(self) -> int:
        """The number of forms."""
        return len(self.part)

    def take(self, which: Bool | Int64) -> FormList:
        """Some of the forms, by a mask or by their numbers."""
        return FormList(
            self.middle[which], self.columns[which], self.radius[which], self.part[which], self.joint[which]
        )

    def reach(self) -> Float64:
        """Returns about how far the columns and the radius reach from the middle, [n, variables]."""
        return np.abs(self.columns).sum(axis=1) + self.radius

    def bounds(self) -> tuple[Float64, Float64]:
        """Bounds of each variable, [n, variables]."""
        reach = self.reach()
        lost = (np.abs(self.middle) + reach) * (self.columns.shape[1] + 4) * LOST + _UNDER
        reach = np.where(reach > 0, reach * _MORE + lost, 0.0)
        return self.middle - reach, self.middle + reach

    @property
    def finite(self) -> Bool:
        """True for each form that has finite numbers only, [n]."""
        whole = np.abs(self.columns).sum(axis=(1, 2)) + np.abs(self.middle).sum(axis=1) + self.radius.sum(axis=1)
        return np.isfinite(whole)


def of_boxes(boxes: BoxList) -> FormList:
    """Forms around boxes, with a column for each variable along which some box is wide."""
    middle = 0.5 * boxes.low + 0.5 * boxes.high
    half = np.maximum(boxes.high - middle, middle - boxes.low)
    half = np.where(half > 0, half * _MORE + np.abs(middle) * 2 * LOST + _UNDER, 0.0)
    wide = np.flatnonzero((half > 0).any(axis=0))
    columns = np.zeros((boxes.size, len(wide), half.shape[1]))
    columns[:, np.arange(len(wide)), wide] = half[:, wide]
    return FormList(middle, columns, np.zeros_like(middle), boxes.part, boxes.joint)


def together(lists: Sequence[FormList]) -> FormList:
    """The forms of some lists in one. RejectedError for too many."""
    if sum(each.columns.size for each in lists) > MAX_NUMBERS:
        raise RejectedError(f"a list of forms has more than {MAX_NUMBERS:,} numbers")
    kept = [each for each in lists if each.size] or lists[:1]
    return kept[0] if len(kept) == 1 else FormList(*map(np.concatenate, zip(*kept, strict=True)))


class Sums(NamedTuple):
    """A sum of multiples of variables over forms: `value` in the middle [n], `slopes` along the columns [n, k], and a
    bound of all else, `rest` [n].
    """

    value: Float64
    slopes: Float64
    rest: Float64

    @property
    def low(self) -> Float64:
        """A number at most the sum, [n]."""
        return self.value - self._reach

    @property
    def high(self) -> Float64:
        """A number at least the sum, [n]."""
        return self.value + self._reach

    @property
    def _reach(self) -> Float64:
        reach = np.abs(self.slopes).sum(axis=1) + self.rest
        lost = (np.abs(self.value) + reach) * (self.slopes.shape[1] + 4) * LOST
        return np.where(reach > 0, reach * _MORE + lost, 0.0)

    def take(self, which: Bool) -> Sums:
        """Those of some of the forms."""
        return Sums(*(column[which] for column in self))

    def negative(self) -> Sums:
        """Of the negated multiples."""
        return Sums(-self.value, -self.slopes, self.rest)


def sums(forms: FormList, weights: Float64) -> Sums:
    """Sums the variables of forms by weights. `weights`: [variables], or for each form, [n, variables]; each the float
    nearest to an exact number, which is 0 or not below LEAST.
    """
    weights = np.broadcast_to(weights, forms.middle.shape)
    value = (forms.middle * weights).sum(axis=1)
    slopes = np.einsum("nkd,nd->nk", forms.columns, weights)
    size = np.abs(weights)
    lost = (size * (np.abs(forms.middle) + forms.reach())).sum(axis=1) * (sum(forms.columns.shape[1:]) + 8) * LOST
    plain = ((size > 0).sum(axis=1) == 1) & (size.max(axis=1) == 1)  # one variable: nothing is rounded
    rest = (size * forms.radius).sum(axis=1)
    return Sums(value, slopes, np.where(plain, rest, (rest + lost) * _MORE + _UNDER))


def narrow_forms(forms: FormList, of: Sums, most: float | Float64) -> FormList:
    """Forms that hold all states in which a sum is at most a number (of each form, [n])."""
    slopes = np.abs(of.slopes)
    reach = slopes.sum(axis=1)
    room = (most - of.value) + (reach + of.rest)
    room += (np.abs(most) + np.abs(of.value) + reach + of.rest) * (slopes.shape[1] + 8) * LOST
    ends = np.divide(room[:, None] - slopes, slopes, out=np.ones_like(slopes), where=slopes > 0)
    ends = np.clip(ends + (np.abs(ends) + 1) * 8 * LOST, -1.0, 1.0)  # of each z_j, with the sign of its slope
    half = np.where(ends < 1, 0.5 * (1 + ends) + 4 * LOST, 1.0)
    shift = np.where(ends < 1, 0.5 * (ends - 1), 0.0) * np.sign(of.slopes)
    middle = forms.middle + np.einsum("nk,nkd->nd", shift, forms.columns)
    wide = np.abs(forms.columns).sum(axis=1)
    lost = (np.abs(forms.middle) + wide) * (slopes.shape[1] + 8) * LOST + _UNDER
    radius = np.where(wide > 0, (forms.radius + lost) * _MORE, forms.radius)
    columns = forms.columns * half[:, :, None]
    return forms._replace(middle=middle, columns=columns, radius=radius)


def sides(of: Sums, last: float | Float64, up: float | Float64) -> tuple[Bool, Bool]:
    """Marks the forms that lie in a half line of a sum wholly, and those that do in part, [n] each. `last`: the largest
    float in it, `up`: no less than its end; of each form, [n], or of all.
    """
    met, whole = ~(of.low > last), of.high <= up
    return met & whole, met & ~whole


class FormCut(NamedTuple):
    """An inequality as a cut of forms: `weights` as of `sums`; `last` and `up` as of `sides`."""

    weights: Float64
    last: float
    up: float

    def within(self, forms: FormList) -> FormList:
        """For each form with a state that may meet the inequality, a form around all such states."""
        of = sums(forms, self.weights)
        whole, crossing = sides(of, self.last, self.up)
        if whole.all():
            return forms
        return together([forms.take(whole), narrow_forms(forms.take(crossing), of.take(crossing), self.up)])

    def may_meet(self, forms: FormList) -> Bool:
        """Returns True for each form with a state that may meet the inequality, [n]."""
        return ~(sums(forms, self.weights).low > self.last)


class Moves(NamedTuple):
    """The motion of each form in a step: `matrix` [n, d, d] of floats nearest to exact numbers, each 0 or not below
    LEAST; `shift` [n, d]; an error of at most `error` [n, d], which becomes a column for the variables `kept`.
    """

    matrix: Float64
    shift: Float64
    error: Float64
    kept: Int64

    def of(self, forms: FormList) -> FormList:
        """The forms after a step."""
        count, k, d = forms.columns.shape
        turned = self.matrix.transpose(0, 2, 1)
        size = np.abs(turned)
        middle = np.einsum("nd,nde->ne", forms.middle, turned) + self.shift
        columns = np.zeros((count, k + len(self.kept), d))
        columns[:, :k] = forms.columns @ turned
        columns[:, k + np.arange(len(self.kept)), self.kept] = self.error[:, self.kept]
        lost = self.error.copy()
        lost[:, self.kept] = 0.0
        reach = np.abs(forms.middle) + np.abs(forms.columns).sum(axis=1)
        reach = np.einsum("nd,nde->ne", reach, size) + np.abs(self.shift)
        radius = np.einsum("nd,nde->ne", forms.radius, size) + lost
        rounded = (radius + reach * (d + k + 8) * LOST) * _MORE + _UNDER
        return FormList(middle, columns, np.where(self._rounds, rounded, radius), forms.part, forms.joint)

    @property
    def _rounds(self) -> Bool:
        """Where more happens than that one variable is copied, or one number taken, [n, d]."""
        size = np.abs(self.matrix)
        terms = (size > 0).sum(axis=2)
        copied = (terms == 1) & (size.max(axis=2) == 1) & (self.shift == 0)
        return ~((copied | (terms == 0)) & (self.error == 0))


def with_fewer_columns(forms: FormList, most: int) -> FormList:
    """The forms, with at most so many columns: those that reach least become one for each variable."""
    count, k, d = forms.columns.shape
    if k <= most or not count:
        return forms
    size = np.abs(forms.columns)
    whole = size.sum(axis=1)
    share = (size / np.where(whole > 0, whole, 1.0)[:, None, :]).max(axis=2)
    order = np.argsort(share, axis=1, kind="stable")
    few = order[:, : k - most // 2]
    kept = np.sort(order[:, k - most // 2 :], axis=1)
    rows = np.arange(forms.size)[:, None]
    boxed = size[rows, few].sum(axis=1)
    boxed = boxed * _MORE + boxed * k * LOST
    columns = np.zeros((count, kept.shape[1] + d, d))
    columns[:, : kept.shape[1]] = forms.columns[rows, kept]
    columns[:, kept.shape[1] + np.arange(d), np.arange(d)] = boxed
    return forms._replace(columns=columns)


def weight(exact: Fraction) -> float:
    """The float nearest to a factor. RejectedError where it is too small or large for this arithmetic."""
    factor = 0.0 if not exact else float(exact) if abs(exact.numerator) < abs(exact.denominator) << 900 else np.inf
    if exact and not LEAST <= abs(factor) <= 1 / LEAST:
        raise RejectedError("a number is too small or too large for the arithmetic of forms")
    return factor


def weights(inequality: Linear, columns: Mapping[str, int]) -> Float64:
    """The factors of an inequality, by column."""
    factors = np.zeros(len(columns))
    for factor, name in inequality.terms:
        factors[columns[name]] = weight(factor)
    return factors


def cut_of(inequality: Linear, columns: Mapping[str, int]) -> FormCut:
    """An inequality as a cut of forms."""
    end = end_of(inequality.bound, inequality.strict)
    return FormCut(weights(inequality, columns), end.last, end.up)


class FormRegion:
    """A polytope, by the cuts of its half spaces and of their opposites."""

    def __init__(self, region: Sequence[HalfSpace], columns: Mapping[str, int]) -> None:
        self._sides = [(cut_of(each, columns), cut_of(opposite(each), columns)) for each in map(linear, region)]

    def within(self, forms: FormList) -> FormList:
        """Forms around the states that may lie in it."""
        for inside, _ in self._sides:
            forms = inside.within(forms)
        return forms

    def outside(self, forms: FormList) -> FormList:
        """Forms around the states that may lie outside of it."""
        outer_parts = [forms.take(np.zeros(forms.size, dtype=np.bool_))]
        for inside, outside in self._sides:
            outer_parts.append(outside.within(forms))
            forms = inside.within(forms)
        return together(outer_parts)


class FormTree:
    """One agent's tree: of each test the factors, and the ends of the two half lines as of `sides`. A test for equality
    goes left on both sides of a number: it is two nodes, the second of them behind the whole tree.
    """

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        tree, features, self.actions = policy.tree, system.features[policy.agent], len(policy.actions)
        tests: dict[int, Formula] = {
            node: goes_left(
                features[policy.features[int(tree.feature[node])].name], float(tree.threshold[node]), policy.numbers
            )
            for node in splits(tree)
        }
        twice = [node for node, test in tests.items() if isinstance(test, Or) and test.parts]
        own, count = len(tree.feature), len(tree.feature) + len(twice)
        self._action = np.append(tree.action, np.zeros(len(twice))).astype(np.int64)
        self._leaf: Bool = np.append(np.array(tree.feature) == NO_FEATURE, np.zeros(len(twice), dtype=np.bool_))
        self._left = np.append(tree.left, [tree.left[node] for node in twice]).astype(np.int64)
        self._right = np.append(tree.right, [tree.right[node] for node in twice]).astype(np.int64)
        self._weights = np.zeros((count, len(columns)))
        self._ends = np.zeros((count, 2, 2))  # [node, side, last and up]
        for node, test in tests.items():
            if node not in twice:
                self._test(node, test, columns)
        for behind, node in enumerate(twice, own):
            self._right[node] = behind
            test = tests[node]
            if not isinstance(test, Or) or len(test.parts) != 2:  # equality has two parts
                raise RejectedError("a test that forms do not know")
            for at, part in zip((node, behind), test.parts, strict=True):
                self._test(at, part, columns)

    def _test(self, node: int, test: Formula, columns: Mapping[str, int]) -> None:
        if isinstance(test, Linear):
            self._weights[node] = weights(test, columns)
            for place, each in enumerate((test, opposite(test))):
                self._ends[node, place] = end_of(each.bound, each.strict)
        elif test in (TRUE, FALSE):
            self._ends[node] = ((inf, inf), (-inf, -inf)) if test == TRUE else ((-inf, -inf), (inf, inf))
        else:
            raise RejectedError("a test that forms do not know")

    def split_at_tests(self, forms: FormList) -> FormList:
        """The forms, cut at the tests, each with this agent's action as one more digit of its joint action."""
        at_leaves, node = [forms.take(np.zeros(forms.size, dtype=np.bool_))], np.zeros(forms.size, dtype=np.int64)
        while len(node):
            done = self._leaf[node]
            leaves = forms.take(done)
            at_leaves.append(leaves._replace(joint=leaves.joint * self.actions + self._action[node[done]]))
            forms, node = self._below(forms.take(~done), node[~done])
        return together(at_leaves)

    def _below(self, forms: FormList, node: Int64) -> tuple[FormList, Int64]:
        """One level further down."""
        of = sums(forms, self._weights[node])
        below: list[FormList] = []
        nodes: list[Int64] = []
        for place, (to, each) in enumerate(((self._left, of), (self._right, of.negative()))):
            last, up = self._ends[node, place].T
            whole, crossing = sides(each, last, up)
            below += [forms.take(whole), narrow_forms(forms.take(crossing), each.take(crossing), up[crossing])]
            nodes += [to[node[whole]], to[node[crossing]]]
        return together(below), np.concatenate(nodes)


ZERO = (Fraction(0), Fraction(0))
JOINED = 2.0  # times the error of a piece alone: so large may one be that has room for others
MAX_COMPARED = 1 << 25  # bounds of pieces that are compared with bounds of forms at once


class _Known(NamedTuple):
    """Effects of a piece and a joint action: factors [.., d, d], and bounds of constants and errors, [.., d] each."""

    matrix: Float64
    low: Float64
    high: Float64


class _Pairs(NamedTuple):
    """A form and a piece that it meets, by their places; `first`: the piece that is to move it."""

    form: Int64
    piece: Int64
    first: Int64


class FormPieces:
    """All pieces. `actions`: how many each agent has."""

    def __init__(self, system: System, policies: Sequence[AgentPolicy]) -> None:
        self._names = [one.name for one in system.variables]
        self._columns = {name: column for column, name in enumerate(self._names)}
        self._pieces, self._policies = system.pieces, policies
        self._ends = np.full((len(system.pieces), len(self._names), 2), (-np.inf, np.inf))
        for piece, ends in zip(system.pieces, self._ends, strict=True):
            for name, (low, high) in piece.where.items():
                ends[self._columns[name]] = floor(low), ceiling(high)
        self._cut = [self._columns[name] for name in self._names if any(name in each.where for each in system.pieces)]
        self._when = [[cut_of(linear(half), self._columns) for half in piece.when] for piece in system.pieces]
        # the variables for which a piece has an error, or does otherwise than another one
        moves = [{(p.move.get(name, Affine()), p.error.get(name, ZERO)) for p in system.pieces} for name in self._names]
        kept = [
            at for at, each in enumerate(moves) if len({form for form, _ in each}) > 1 or {e for _, e in each} - {ZERO}
        ]
        self._kept = np.array(kept, dtype=np.int64)
        size, self._numbers = len(self._names), PairNumbers(len(system.pieces))
        self._known = _Known(np.zeros((0, size, size)), np.zeros((0, size)), np.zeros((0, size)))

    def move_forms(self, forms: FormList) -> FormList:
        """Forms around all next states."""
        low, high = forms.bounds()
        pairs = self._find_pairs(forms, low, high)
        moves = self._of(forms.joint[pairs.form], pairs.first)
        one = np.bincount(pairs.form, minlength=forms.size)[pairs.form] == 1
        alone = Moves(moves.matrix[one], *_with_error(moves.low[one], moves.high[one]), self._kept)
        images = [alone.of(forms.take(pairs.form[one]))]
        if not one.all():
            # The forms that meet several pieces have a row for every such piece.
            pairs = _Pairs(*(each[~one] for each in pairs))
            least, most = self._room(forms.joint[pairs.form], pairs, low, high)
            rows, begins, back = np.unique(pairs.form, return_index=True, return_inverse=True)
            first = self._of(forms.joint[rows], pairs.first[begins])
            least, most = np.minimum.reduceat(least, begins), np.maximum.reduceat(most, begins)
            shift, error = _with_error(least, most)
            own = first.high - first.low
            fits = 2.0 * error <= JOINED * own + LOST * np.abs(shift)  # else the form is cut by the boxes of pieces
            small = np.asarray(fits.all(axis=1), dtype=np.bool_)
            joined = Moves(first.matrix[small], shift[small], error[small], self._kept).of(forms.take(rows[small]))
            cut = ~small[back.reshape(-1)]
            images += [joined, self._cut_and_moved(forms.take(pairs.form[cut]), pairs.piece[cut])]
        return together(images)

    def _cut_and_moved(self, forms: FormList, piece: Int64) -> FormList:
        """After a step, forms cut by the box of a piece each."""
        for column in self._cut:
            for side, sign in ((1, 1.0), (0, -1.0)):
                weights = np.zeros(len(self._names))
                weights[column] = sign
                of, end = sums(forms, weights), sign * self._ends[piece, column, side]
                whole, crossing = sides(of, end, end)
                if not whole.all():
                    kept = [forms.take(whole), narrow_forms(forms.take(crossing), of.take(crossing), end[crossing])]
                    forms, piece = together(kept), np.concatenate([piece[whole], piece[crossing]])
        for number, cuts in enumerate(self._when):
            if cuts and (piece == number).any():
                met, others = forms.take(piece == number), piece != number
                for cut in cuts:
                    met = cut.within(met)
                forms = together([forms.take(others), met])
                piece = np.concatenate([piece[others], np.full(met.size, number)])
        moves = self._of(forms.joint, piece)
        return Moves(moves.matrix, *_with_error(moves.low, moves.high), self._kept).of(forms)

    def _find_pairs(self, forms: FormList, low: Float64, high: Float64) -> _Pairs:
        """All forms with the pieces that they meet, form by form; first the piece that holds its middle."""
        count = len(self._ends)
        at_once = max(MAX_COMPARED // (count * max(len(self._cut), 1)), 1)
        pairs: list[_Pairs] = []
        for begin in range(0, forms.size, at_once):
            some = slice(begin, begin + at_once)
            met = self._meets(low[some], high[some])
            for number, cuts in enumerate(self._when):
                for cut in cuts if met[:, number].any() else ():
                    met[:, number] &= cut.may_meet(forms.take(np.arange(forms.size)[some]))
            if not met.any(axis=1).all():
                raise RejectedError("a form meets no piece")
            middle = met & self._meets(forms.middle[some], forms.middle[some])
            first = np.asarray(np.where(middle.any(axis=1), middle.argmax(axis=1), met.argmax(axis=1)), dtype=np.int64)
            form, piece = np.nonzero(met)
            pairs.append(_Pairs(form + begin, piece, first[form]))
        if not pairs:
            none = np.zeros(0, dtype=np.int64)
            return _Pairs(none, none, none)
        return pairs[0] if len(pairs) == 1 else _Pairs(*map(np.concatenate, zip(*pairs, strict=True)))

    def _meets(self, low: Float64, high: Float64) -> Bool:
        met = np.ones((len(low), len(self._ends)), dtype=np.bool_)
        for column in self._cut:
            met &= ~(high[:, column, None] < self._ends[:, column, 0])
            met &= ~(low[:, column, None] > self._ends[:, column, 1])
        return met

    def _room(self, joint: Int64, pairs: _Pairs, low: Float64, high: Float64) -> tuple[Float64, Float64]:
        """Bounds of what is to be added to the factors of the first piece, that each other piece may do its own."""
        first, other = self._of(joint, pairs.first), self._of(joint, pairs.piece)
        least = np.maximum(low[pairs.form], self._ends[pairs.piece, :, 0])
        most = np.maximum(np.minimum(high[pairs.form], self._ends[pairs.piece, :, 1]), least)
        middle, half = 0.5 * least + 0.5 * most, 0.5 * (most - least)
        off = other.matrix - first.matrix
        value = np.einsum("nij,nj->ni", off, middle)
        reach = np.einsum("nij,nj->ni", np.abs(off), half)
        size = np.abs(other.matrix) + np.abs(first.matrix)
        reach += np.einsum("nij,nj->ni", size, np.abs(middle) + half) * (len(self._names) + 8) * LOST
        reach += (np.abs(value) + np.abs(other.low) + np.abs(other.high)) * 8 * LOST
        return other.low + value - reach, other.high + value + reach

    def _of(self, joint: Int64, piece: Int64) -> _Known:
        """Returns the effects of pieces and joint actions, one row for each."""
        pairs = self._numbers.find(piece, joint, self._add)
        return _Known(*(each.take(pairs, axis=0) for each in self._known))

    def _add(self, pairs: Sequence[tuple[int, int]]) -> None:
        """Notes the effects of pieces and joint actions."""
        count, size = len(pairs), len(self._names)
        matrix, low, high = np.zeros((count, size, size)), np.zeros((count, size)), np.zeros((count, size))
        for at, (number, joint) in enumerate(pairs):
            choices, piece = choices_of(joint, self._policies), self._pieces[number]
            for row, name in enumerate(self._names):
                form, (least, most) = piece.total(name, choices), piece.error.get(name, ZERO)
                for read, factor in form.terms:
                    matrix[at, row, self._columns[read]] = weight(factor)
                low[at, row], high[at, row] = floor(form.constant + least), ceiling(form.constant + most)
        new = _Known(matrix, low, high)
        self._known = _Known(*(np.concatenate(each) for each in zip(self._known, new, strict=True)))


def _with_error(low: Float64, high: Float64) -> tuple[Float64, Float64]:
    """Numbers and errors that hold all between two bounds."""
    middle = 0.5 * low + 0.5 * high
    return middle, np.maximum(high - middle, middle - low) * (1 + 4 * LOST)
