"""Faults in what proves and checks claims about sums and outputs, each of which the hunt must notice.

Does: patches the reading of agents, of formulas, of `robust`, or the walk of the checker.
Assumes: pytest's monkeypatch, or anything with its `setattr`. Forgotten roundings show at bounds that lie below an
  extreme by less than a rounding.
Does not: look for them.
"""

from dataclasses import replace
from fractions import Fraction

from maviper.verification import stated
from verify.checker.systems import branch_proofs, reading
from verify.claims.formula import disjunction
from verify.reach.decide import ClaimSearch
from verify.systems import lowered, properties

SMALL = Fraction(1, 1 << 200)


def _term(patch):
    """The last feature of a sum that is tested is left out."""
    form = lowered._Reading._form

    def shorter(self, each):
        tested = each in self._tree.sums and len(each.terms) > 1
        return form(self, replace(each, terms=each.terms[:-1]) if tested else each)

    patch.setattr(lowered._Reading, "_form", shorter)


def _threshold(patch):
    """Tests of sums compare with a threshold that is a little larger."""
    split = lowered._Reading._split

    def later(self, plain, threshold, left, right):
        tested = len(list(self._features.values())[plain].form.terms) > 1
        return split(self, plain, threshold + 0.125 * tested, left, right)

    patch.setattr(lowered._Reading, "_split", later)


def _sides(patch):
    """The sides of every split are swapped."""
    split = lowered._Reading._split
    patch.setattr(lowered._Reading, "_split", lambda self, plain, at, left, right: split(self, plain, at, right, left))


def _weight(patch):
    """The first weight of what a leaf gives has the opposite sign."""
    form = lowered._Reading._form

    def turned(self, each):
        given = any(each in vector for vector in self._tree.vectors) and each not in self._tree.sums
        (weight, place), *others = each.terms
        return form(self, replace(each, terms=((-weight, place), *others)) if given else each)

    patch.setattr(lowered._Reading, "_form", turned)


def _vector(patch):
    """Constants of leaves are those of the first leaf."""
    constant = lowered._Reading._constant
    patch.setattr(lowered._Reading, "_constant", lambda self, vector, output: constant(self, 0, output) + 0 * vector)


def _swapped(patch):
    """The first two features stand for each other in sums."""
    form = lowered._Reading._form

    def swapped(self, each):
        terms = tuple((weight, 1 - place if place in (0, 1) else place) for weight, place in each.terms)
        return form(self, replace(each, terms=terms))

    patch.setattr(lowered._Reading, "_form", swapped)


def _one_side(patch):
    """The right side of each split is left out: what stands on its left is on both."""
    split = lowered._Reading._split
    patch.setattr(lowered._Reading, "_split", lambda self, plain, at, left, right: split(self, plain, at, left, left))


def _cut(patch):
    """Numbers are not cut to their bounds."""
    patch.setattr(lowered._Reading, "_reach", lambda self, form: (Fraction(0), Fraction(0)))


def _sums(patch):
    """Sums are exact."""
    patch.setattr(lowered.Errors, "of", lambda self, each: SMALL)


def _observed(patch):
    """Features are observed exactly."""
    patch.setattr(lowered.Errors, "bound_feature", lambda self, place: SMALL)


def _last(patch):
    """The last rounding of a number is forgotten."""
    patch.setattr(lowered.Errors, "bound_output", lambda self, largest: SMALL)


def _beyond(patch):
    """States in which a leaf's number lies within its bounds are those of which nothing is asked."""
    beyond = properties._cut_off

    def within(*given):
        parts = list(beyond(*given))
        yield from [properties.Not(disjunction(*parts))] if parts else []

    patch.setattr(properties, "_cut_off", within)


def _inputs(patch):
    """A comparison of two outputs reads the first of them alone."""
    compared = properties._put_settings

    def alone(formula, statement, acting, where):
        inputs = [name for _, name in formula.terms if any(name in each.inputs for each in statement.agents)]
        kept = tuple(term for term in formula.terms if term[1] not in inputs[1:])
        return compared(formula._replace(terms=kept), statement, acting, where)

    patch.setattr(properties, "_put_settings", alone)


def _errors(patch):
    """None of the errors that `robust` speaks of is looked at."""
    box = properties.box_of
    patch.setattr(
        properties, "box_of", lambda ends: box({name: (0 * low, 0 * high) for name, (low, high) in ends.items()})
    )


def _ranges(patch):
    """The world of observations leaves out the upper half of every range."""
    region = stated.resolve_region

    def half(*given):
        found = region(*given)
        return replace(found, box={name: (low, (low + high) / 2) for name, (low, high) in found.box.items()})

    patch.setattr(stated, "resolve_region", half)


def _unplayed(patch):
    """Nothing is played before it is proved, so that only proofs answer."""
    patch.setattr(ClaimSearch, "_play", lambda *given, **named: None)


def _tighter(row):
    """A row of a little less: a sixteenth of what its sum may be."""
    less = (row.direction.high - row.direction.low) / 16
    return row._replace(end=row.end - less * (1 if row.upper else -1))


def _sums_of_rows(patch):
    """The checker takes any sum of rows for a contradiction."""
    patch.setattr(reading.Branch, "is_contradicted", lambda self, used: True)


def _bounds(patch):
    """The bounds of unknowns settle more rows than they should."""
    _unplayed(patch)
    settled = reading.Branch.decide_row

    patch.setattr(reading.Branch, "decide_row", lambda self, row: settled(self, _tighter(row)))


def _choices(patch):
    """Of the ways in which a claim may be broken, the walk asks about the first."""
    _unplayed(patch)
    within = branch_proofs.SystemQuestions._within_some
    patch.setattr(
        branch_proofs.SystemQuestions, "_within_some", lambda self, branch, parts: within(self, branch, parts[:1])
    )


def _leaves(patch):
    """The walk does not go down the right sides of splits."""
    _unplayed(patch)

    def left_only(self, branch, decision):
        while isinstance(decision, branch_proofs.Split):
            branch, _ = self._sides(branch, decision.left_if)
            if branch is None:
                return
            decision = decision.left
        yield branch, decision

    patch.setattr(branch_proofs.SystemQuestions, "_leaves", left_only)


FAULTS = {
    "roundings: sums are exact": _sums,
    "roundings: features are observed exactly": _observed,
    "roundings: the last one is forgotten": _last,
    "leaves: numbers are not cut": _cut,
    "sums: two features are swapped": _swapped,
    "tests: right sides are left out": _one_side,
    "tests of sums: a term is left out": _term,
    "tests of sums: the threshold is another one": _threshold,
    "tests: the sides are swapped": _sides,
    "leaves: a weight has the opposite sign": _weight,
    "leaves: constants are those of the first": _vector,
    "leaves: what is asked within bounds and beyond is swapped": _beyond,
    "formulas: the second of two outputs is left out": _inputs,
    "robust: errors are forgotten": _errors,
    "regions: half of the ranges": _ranges,
    "checker: any sum of rows is a contradiction": _sums_of_rows,
    "checker: bounds settle more than they should": _bounds,
    "checker: ways to break a claim are forgotten": _choices,
    "checker: right sides are forgotten": _leaves,
}
