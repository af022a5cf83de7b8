"""Planted faults in all readings of stated systems: the checker's, the solver's, and the replay's of single episodes.

A fault plants itself by pytest's monkeypatch, and names the guard that catches it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction as F
from inspect import getsource, getsourcefile
from textwrap import dedent

import numpy as np

from tests.support.system_cases import form
from tests.support.system_guards import ANSWERED, BROKEN, FORGED, HELD, JUDGED, OPINED, POINTS
from verify.checker.systems import branch_proofs, reading
from verify.checker.systems.branch_proofs import Proof, SystemQuestions
from verify.checker.systems.reading import ALWAYS, Branch, Every, Inequality, Leap, Motion, Row, Some, SystemReading
from verify.claims.formula import FALSE, TRUE, Acts, Linear, negate
from verify.reach import replay
from verify.solver import terms, unrolled
from verify.systems import observing
from verify.systems.system import FREE, Affine, Measure, Piece


@dataclass(frozen=True)
class SystemFault:
    """What goes wrong, where, and what catches it."""

    owner: object
    attribute: str
    name: str
    guard: str
    change: Callable[[Callable], Callable]

    def plant(self, patch):
        patch.setattr(self.owner, self.attribute, self.change(getattr(self.owner, self.attribute)))

    @property
    def place(self):
        return f"{getattr(self.owner, '__name__', '').rpartition('.')[2]}.{self.attribute}"


def fault(owner, attribute, name, guard, change):
    return SystemFault(owner, attribute, name, guard, change)


def changed(change):
    """A function whose answer is changed."""
    return lambda f: lambda *given: change(f(*given))


def of(result):
    """A function that always gives the same."""
    return lambda f: lambda *given: result


def built(change):
    """A constructor after which something is changed."""

    def planted(init):
        def construct(self, *given):
            init(self, *given)
            change(self)

        return construct

    return planted


def line(old, new):
    """A function in which one piece of its source is another."""

    def written(f):
        source, made = dedent(getsource(f)), {}
        assert source.count(old) == 1, f"{f.__qualname__} has no single {old!r}"
        exec(
            compile(source.replace(old, new), getsourcefile(f), "exec", annotations.compiler_flag), f.__globals__, made
        )
        return made[f.__name__]

    return written


def first(f):
    """The first of what a generator yields."""

    def alone(*given):
        yield from list(f(*given))[:1]

    return alone


def attribute(name, value):
    return built(lambda self: setattr(self, name, value(self)))


def strictly(strict):
    """A row or an inequality that is strict, or that is not."""
    return changed(
        lambda found: (
            found if isinstance(found, bool) or not hasattr(found, "strict") else found._replace(strict=strict)
        )
    )


def narrower(bounds):
    low, high = bounds
    return low + (high - low) / 4, high - (high - low) / 4


def turned(self, condition):
    """What holds where an inequality does not."""
    if not isinstance(condition, Inequality):
        return condition
    terms = tuple((-weight, name) for weight, name in condition.sum.terms)
    return Inequality(self.sum(terms), -condition.most, not condition.strict)


def unscaled(self, row, branch, asked):
    return row if isinstance(row, bool) else row._replace(end=row.end * self.direction(branch.motion, asked.sum)[1])


def rounded_down(near, exact):
    return near if F(float(near)) <= exact else np.nextafter(near, np.float32(-np.inf))


def together(branch):
    """A branch whose variables depend on one unknown alone."""
    branch.motion.weights = {name: dict.fromkeys(each and (0,), F(1)) for name, each in branch.motion.weights.items()}
    return branch


NEVER = Some(())
READING = [
    fault(SystemReading, "condition", "one part is enough for all", HELD, changed(lambda found: Some(found.parts) if isinstance(found, Every) and found.parts else found)),
    fault(SystemReading, "condition", "all parts are needed for some", BROKEN, changed(lambda found: Every(found.parts) if isinstance(found, Some) and found.parts else found)),
    fault(SystemReading, "condition", "nothing is strict", HELD, strictly(False)),
    fault(SystemReading, "condition", "everything is strict", BROKEN, strictly(True)),
    fault(SystemReading, "condition", "what is not followed never holds", BROKEN, changed(lambda found: NEVER if found is ALWAYS else found)),
    fault(SystemReading, "condition", "bounds are of the other sign", BROKEN, changed(lambda found: found._replace(most=-found.most) if isinstance(found, Inequality) else found)),
    fault(SystemReading, "start", "no start", HELD, of(None)),
    fault(SystemReading, "start", "half spaces of the start are left out but for bounds", HELD, lambda f: lambda self, region: f(self, [half for half in region if len(half.form.terms) == 1])),
    fault(SystemReading, "_assume_condition", "half spaces of the start are forgotten", HELD, lambda f: lambda self, branch, condition: branch),
    fault(SystemReading, "_assume_condition", "half spaces of the start the other way round", HELD, lambda f: (lambda self, branch, condition: f(self, branch, turned(self, condition)))),
    fault(SystemReading, "row", "rows are not moved by what is added", BROKEN, lambda f: (lambda self, branch, asked: f(self, branch, asked._replace(most=asked.most + sum(weight * branch.at[name] for weight, name in asked.sum.terms))))),
    fault(SystemReading, "row", "rows are strict", BROKEN, strictly(True)),
    fault(SystemReading, "row", "rows are never strict", HELD, strictly(False)),
    fault(SystemReading, "row", "numbers are compared the other way round", HELD, changed(lambda found: not found if isinstance(found, bool) else found)),
    fault(SystemReading, "row", "the end is not scaled", BROKEN, lambda f: lambda self, branch, asked: unscaled(self, f(self, branch, asked), branch, asked)),
    fault(SystemReading, "direction", "the sign of a direction is lost", BROKEN, line("Fraction(divisor, common)", "abs(Fraction(divisor, common))")),
    fault(SystemReading, "direction", "multiples are forgotten", BROKEN, line("if weights:", "if weights := {unknown: Fraction(1 if weight > 0 else -1) for unknown, weight in weights.items()}:")),
    fault(SystemReading, "condition", "true and false are swapped", HELD, changed(lambda found: ALWAYS if found == NEVER else NEVER if found == ALWAYS else found)),
    fault(SystemReading, "hull", "hulls are empty", FORGED, of(None)),
    fault(SystemReading, "_states", "all that may vary varies together", BROKEN, changed(lambda branch: branch and together(branch))),
    fault(SystemReading, "direction", "sums are their first member", BROKEN, lambda f: lambda self, motion, asked: f(self, motion, self.sum(asked.terms[:1]))),
    fault(Leap, "after", "nothing is unknown after a step", BROKEN, changed(lambda motion: Motion({name: {} for name in motion.weights}, motion.unknowns))),
    fault(SystemReading, "move_branch", "every step by the first piece", BROKEN, lambda f: lambda self, branch, number, effects: f(self, branch, 0, effects)),
    fault(SystemReading, "move_branch", "a step is counted twice", BROKEN, changed(lambda after: setattr(after, "step", after.step + 1) or after)),
    fault(Leap, "__init__", "errors are forgotten", BROKEN, lambda f: lambda self, forms, piece: f(self, forms, replace(piece, error={}))),
    fault(Leap, "__init__", "errors begin at 0", BROKEN, attribute("least", lambda leap: dict.fromkeys(leap.forms, F(0)))),
    fault(Leap, "__init__", "errors are half as wide", BROKEN, attribute("errors", lambda leap: {name: (low, (low + high) / 2) for name, (low, high) in leap.errors.items()})),
    fault(SystemReading, "move_branch", "leaps with other errors are alike", BROKEN, line(", *leap.errors[name]", "")),
    fault(SystemReading, "move_branch", "leaps with other forms are alike", BROKEN, line("form.terms, *", "*")),
    fault(reading, "bounds_of", "starts are narrower", BROKEN, changed(lambda bounds: {name: narrower(ends) for name, ends in bounds.items()})),
    fault(reading, "bounds_of", "a start is one state", BROKEN, changed(lambda bounds: {name: (low, low) for name, (low, _) in bounds.items()})),
    fault(reading, "bounds_of", "what a polytope bounds is forgotten", ANSWERED, lambda f: lambda region, ranges: f(region if FREE in ranges.values() else (), ranges)),
    fault(reading, "_total", "actions have no effect", BROKEN, lambda f: lambda name, piece, effects, number: f(name, piece, (), number)),
    fault(reading, "_total", "the first agent alone acts", BROKEN, lambda f: lambda name, piece, effects, number: f(name, piece, effects[:1], number)),
    fault(reading, "_total", "a variable moves by itself alone", BROKEN, lambda f: (lambda name, *given: ((form := f(name, *given)) and Affine.of({each: factor for each, factor in form.terms if each == name}, form.constant)))),
    fault(reading, "_total", "constants are forgotten", BROKEN, changed(lambda form: Affine(form.terms))),
    fault(reading, "_add", "the last of equal unknowns counts", BROKEN, lambda f: (lambda weights, more, times: weights.update({unknown: times * weight for unknown, weight in more.items()}))),
]  # fmt: skip
ROWS = [
    fault(Row, "opposite", "an opposite is always strict", POINTS, strictly(True)),
    fault(Row, "opposite", "an opposite is never strict", POINTS, strictly(False)),
    fault(Branch, "with_row", "rows are forgotten", HELD, lambda f: lambda self, row: self.copy()),
    fault(Branch, "with_row", "the opposite is kept", BROKEN, lambda f: lambda self, row: f(self, row.opposite())),
    fault(Branch, "decide_row", "an end that is met counts as beyond", BROKEN, lambda f: lambda self, row: f(self, row._replace(strict=True))),
    fault(Branch, "decide_row", "an end that is met counts as within", POINTS, lambda f: lambda self, row: f(self, row._replace(strict=False))),
    fault(Branch, "decide_row", "nothing is settled", HELD, of(None)),
    fault(Branch, "span", "bounds are narrower", BROKEN, changed(lambda span: span._replace(low=narrower((span.low, span.high))[0], high=narrower((span.low, span.high))[1]))),
    fault(Branch, "span", "no bound is met", BROKEN, changed(lambda span: span._replace(low_open=True, high_open=True))),
    fault(Branch, "is_contradicted", "every sum contradicts", FORGED, of(True)),
    fault(Branch, "is_contradicted", "no sum contradicts", HELD, of(False)),
    fault(Branch, "is_contradicted", "no bound is reached", FORGED, line("== 0 and strict", "== 0")),
    fault(Branch, "is_contradicted", "the least is one more", FORGED, line("whole = 0", "whole = 1")),
    fault(Branch, "is_contradicted", "the box is forgotten", POINTS, line("self.box.get(unknown)", "None")),
    fault(Branch, "copy", "rows are lost", HELD, changed(lambda branch: setattr(branch, "rows", ()) or branch)),
    fault(Branch, "_by_box", "boxes are narrower", BROKEN, changed(lambda span: span._replace(low=narrower((span.low, span.high))[0], high=narrower((span.low, span.high))[1]))),
    fault(reading, "_narrow_span", "an end is left out", BROKEN, lambda f: lambda span, row: f(span, row._replace(strict=True))),
    fault(reading, "_narrow_span", "an end is kept", HELD, lambda f: lambda span, row: f(span, row._replace(strict=False))),
    fault(reading, "_narrow_span", "the other end", BROKEN, lambda f: lambda span, row: f(span, row._replace(upper=not row.upper))),
    fault(reading.Direction, "__init__", "no direction is below 0", BROKEN, attribute("low", lambda _: F(0))),
    fault(reading.Direction, "__init__", "no direction is above 1", BROKEN, attribute("high", lambda direction: min(direction.high, F(1)))),
]  # fmt: skip
TREES = [
    fault(reading, "goes_left", "sides are swapped", BROKEN, changed(negate)),
    fault(reading, "goes_left", "thresholds are real numbers", BROKEN, lambda f: lambda feature, threshold, numbers: f(feature, threshold, "float64")),
    fault(reading, "goes_left", "no sign below 0", BROKEN, lambda f: (lambda feature, *given: f(replace(feature, measure=Measure.POSITIVE) if feature.measure is Measure.SIGN else feature, *given))),
    fault(reading, "goes_left", "a positive number has a sign", HELD, lambda f: (lambda feature, *given: f(replace(feature, measure=Measure.SIGN) if feature.measure is Measure.POSITIVE else feature, *given))),
    fault(reading, "goes_left", "nothing is clipped", BROKEN, lambda f: (lambda feature, *given: f(replace(feature, measure=Measure.VALUE, bounds=None) if feature.measure is Measure.CLIP else feature, *given))),
    fault(reading, "goes_left", "every test goes left", BROKEN, of(TRUE)),
    fault(reading, "goes_left", "no test goes left", BROKEN, of(FALSE)),
    fault(reading, "_effects", "all actions do what the first does", BROKEN, changed(lambda effects: effects[:1] * len(effects))),
    fault(reading, "_effects", "the effects of the first piece", HELD, changed(lambda effects: [setattr(each, "by_piece", each.by_piece[:1] * len(each.by_piece)) or each for each in effects])),
    fault(reading, "sides_of", "all splits are the first one", HELD, changed(lambda sides: dict.fromkeys(sides, next(iter(sides.values()))) if sides else sides)),
    fault(reading, "_build_split", "every test goes left", BROKEN, lambda f: lambda reading, side, left, right: left),
    fault(reading, "_decision", "the first test always goes left", BROKEN, changed(lambda decision: decision.left if isinstance(decision, reading.Split) else decision)),
    fault(branch_proofs, "decisions", "everybody decides as the first", BROKEN, changed(lambda each: each[:1] * len(each))),
    fault(reading, "either", "the first of two decisions", BROKEN, lambda f: lambda first, second: first),
    fault(reading, "prune_decision", "the other side of a known test", HELD, lambda f: lambda decision, known, holds: f(decision, known, not holds)),
    fault(reading, "prune_decision", "another test goes right", BROKEN, line("left, right = prune_decision(decision.left", "left, right = prune_decision(decision.right")),
    fault(reading, "either", "an action alone, where the other side tests", BROKEN, line("return either(second, first)", "return first")),
]  # fmt: skip
WALK = [
    fault(branch_proofs, "alternatives", "of a union the first", BROKEN, changed(lambda parts: parts[:1])),
    fault(branch_proofs, "ways", "a claim is broken in one way", FORGED, of(1)),
    fault(branch_proofs, "ensure_closed", "what a variable depends on is not followed", FORGED, of(None)),
    fault(branch_proofs, "_is_state", "any state shows that a claim is about some", FORGED, of(True)),
    fault(branch_proofs, "check_certificate", "ways are not asked for", FORGED, line("if missing:", "if False:")),
    fault(Proof, "ensure_read", "a proof may go on", FORGED, of(None)),
    fault(Proof, "side", "no answer is shown", FORGED, lambda f: lambda self, branch, row: branch_proofs.SideAnswer(self._number() % 4)),
    fault(Proof, "_ensure_empty", "what is closed is not shown", FORGED, of(None)),
    fault(Proof, "leave_open", "branches may be left open", FORGED, of(None)),
    fault(SystemQuestions, "__init__", "leaving what is stated is not asked", BROKEN, attribute("_unstated", lambda self: self.reading.condition(FALSE))),
    fault(SystemQuestions, "__init__", "only the first piece moves", BROKEN, attribute("_pieces", lambda self: self._pieces[:1])),
    fault(SystemQuestions, "roots", "hulls are not gone on from", FORGED, first),
    fault(SystemQuestions, "ensure_within", "hulls need not hold what is put into them", FORGED, of(None)),
    fault(SystemQuestions, "root", "hulls are empty", FORGED, of(None)),
    fault(SystemQuestions, "run", "nothing is asked", HELD, of(None)),
    fault(SystemQuestions, "follow_branch", "an episode ends with its start", BROKEN, lambda f: lambda self, branch: f(self, branch) and []),
    fault(SystemQuestions, "_decide", "decisions are not asked", BROKEN, lambda f: lambda *given: iter(())),
    fault(SystemQuestions, "_follow", "states are not asked", BROKEN, lambda f: lambda *given: iter(())),
    fault(SystemQuestions, "_within", "nothing is within", BROKEN, lambda f: lambda *given: iter(())),
    fault(SystemQuestions, "_build_exclusion", "the start is not asked", BROKEN, lambda f: lambda self, step: f(self, step) if step else NEVER),
    fault(SystemQuestions, "_build_exclusion", "the last step is not asked", BROKEN, lambda f: lambda self, step: f(self, step) if step < self.claim.steps else NEVER),
    fault(SystemQuestions, "_exclude", "nothing is excluded", BROKEN, lambda f: lambda self, branch, condition, stated=True: None),
    fault(SystemQuestions, "_iterate_unfulfilled", "all is fulfilled", BROKEN, lambda f: lambda *given: iter(())),
    fault(SystemQuestions, "_iterate_unfulfilled", "nothing is fulfilled", HELD, lambda f: lambda self, branch: iter((branch,))),
    fault(SystemQuestions, "_iterate_choices", "the first joint action", BROKEN, first),
    fault(SystemQuestions, "_leaves", "the first leaf", BROKEN, first),
    fault(SystemQuestions, "_within_all", "the first part of all", HELD, lambda f: lambda self, branch, parts: f(self, branch, parts[:1])),
    fault(SystemQuestions, "_within_some", "the first part of some", BROKEN, lambda f: lambda self, branch, parts: f(self, branch, parts[:1])),
    fault(SystemQuestions, "_sides", "sides are swapped", BROKEN, changed(lambda sides: sides[::-1])),
    fault(branch_proofs, "box_of", "boxes without upper ends", HELD, changed(lambda box: box[::2])),
    fault(branch_proofs, "box_of", "boxes are nowhere", HELD, changed(lambda box: tuple(replace(half, form=half.form.plus(form(99))) for half in box))),
]  # fmt: skip
REPLAY = [
    fault(Piece, "step", "actions have no effect", ANSWERED, lambda f: lambda self, state, actions, error: f(self, state, {}, error)),
    fault(Piece, "step", "errors are forgotten", ANSWERED, lambda f: lambda self, state, actions, error: f(self, state, actions, {})),
    fault(Piece, "step", "errors count twice", ANSWERED, lambda f: lambda self, state, actions, error: f(self, state, actions, {name: 2 * each for name, each in error.items()})),
    fault(replay, "is_start", "an episode may start anywhere", JUDGED, of(True)),
    fault(replay, "piece_of", "always the first piece", ANSWERED, of(0)),
    fault(replay, "piece_of", "nothing is stated", ANSWERED, of(None)),
    fault(replay, "within", "errors are 0", ANSWERED, changed(lambda errors: dict.fromkeys(errors, F(0)))),
    fault(replay, "within", "errors are not cut to their bounds", JUDGED, lambda f: lambda piece, given: {name: given.get(name, F(0)) for name in piece.error}),
    fault(replay, "choose_actions", "all take their first action", ANSWERED, changed(lambda actions: dict.fromkeys(actions, 0))),
    fault(observing, "nearest_number", "numbers are rounded down", JUDGED, lambda f: lambda exact, numbers: rounded_down(np.dtype(numbers).type(f(exact, numbers)), exact)),
    fault(observing, "measure_feature", "no sign below 0", ANSWERED, lambda f: lambda feature, state: max(f(feature, state), F(0)) if feature.measure is Measure.SIGN else f(feature, state)),
    fault(observing, "measure_feature", "0 is positive", ANSWERED, lambda f: lambda feature, state: F(feature.form.at(state) >= 0) if feature.measure is Measure.POSITIVE else f(feature, state)),
    fault(observing, "measure_feature", "nothing is clipped", ANSWERED, lambda f: lambda feature, state: feature.form.at(state) if feature.measure is Measure.CLIP else f(feature, state)),
]  # fmt: skip
UNROLLED = [
    fault(unrolled, "encode_claim", "leaving what is stated is not asked", OPINED, changed(lambda tests: (tests[0], tests[0]))),
    fault(unrolled, "encode_claim", "breaking the claim is not asked", OPINED, changed(lambda tests: (tests[1], tests[1]))),
    fault(unrolled, "_encode_decisions", "the regions of decisions are forgotten", OPINED, lambda f: lambda profile, system, claim: f(profile, system, replace(claim, regions=()))),
    fault(unrolled, "_encode_formula", "inequalities are of the other sign", OPINED, lambda f: lambda formula, *given: f(Linear(formula.terms, -formula.bound, formula.strict) if isinstance(formula, Linear) else formula, *given)),
    fault(unrolled, "_encode_formula", "another action is meant", OPINED, lambda f: lambda formula, *given: f(replace(formula, action=1 - min(formula.action, 1)) if isinstance(formula, Acts) else formula, *given)),
    fault(unrolled, "choices", "everybody takes the first action", OPINED, changed(lambda chosen: {key: terms.constant(key[1] == 0) for key in chosen})),
    fault(unrolled, "_paths", "the first leaf alone", OPINED, first),
    fault(unrolled, "_goes_left", "sides are swapped", OPINED, changed(terms.negation)),
    fault(unrolled, "_goes_left", "no sign below 0", OPINED, lambda f: lambda feature, *given: f(replace(feature, measure=Measure.POSITIVE) if feature.measure is Measure.SIGN else feature, *given)),
    fault(unrolled, "_goes_left", "a positive number has a sign", OPINED, lambda f: lambda feature, *given: f(replace(feature, measure=Measure.SIGN) if feature.measure is Measure.POSITIVE else feature, *given)),
    fault(unrolled, "_goes_left", "nothing is clipped", OPINED, lambda f: lambda feature, *given: f(replace(feature, measure=Measure.VALUE) if feature.measure is Measure.CLIP else feature, *given)),
    fault(unrolled, "_rounds_to_at_most", "thresholds are real numbers", OPINED, lambda f: lambda exact, threshold: exact <= terms.number(F(float(threshold)))),
    fault(unrolled, "_rounds_to_at_most", "the next threshold", OPINED, lambda f: lambda exact, threshold: f(exact, np.nextafter(threshold, threshold.dtype.type(np.inf)))),
    fault(unrolled, "_encode_step", "anything may follow", OPINED, of(terms.constant(True))),
    fault(unrolled, "_encode_move", "errors are forgotten", OPINED, lambda f: lambda profile, piece, *given: f(profile, replace(piece, error={}), *given)),
    fault(unrolled, "_encode_move", "actions have no effect", OPINED, lambda f: lambda profile, piece, *given: f(profile, replace(piece, effect={}), *given)),
    fault(unrolled, "_in_ranges", "ranges are forgotten", OPINED, of([])),
    fault(unrolled, "_in_box", "boxes are forgotten", OPINED, of([])),
    fault(unrolled, "_between", "there are no upper ends", OPINED, changed(lambda tests: tests[: len(tests) // 2])),
    fault(unrolled, "_inside", "nothing is strict", OPINED, lambda f: lambda polytope, state: f(tuple(replace(half, strict=False) for half in polytope), state)),
    fault(unrolled, "_inside", "everything is strict", OPINED, lambda f: lambda polytope, state: f(tuple(replace(half, strict=True) for half in polytope), state)),
    fault(unrolled, "_value", "constants are forgotten", OPINED, lambda f: lambda form, state: f(Affine(form.terms), state)),
    fault(unrolled, "_sum", "weights lose their sign", OPINED, lambda f: lambda parts, constant: f([(abs(weight), value) for weight, value in parts], constant)),
]  # fmt: skip
ALL = [*READING, *ROWS, *TREES, *WALK, *UNROLLED, *REPLAY]
