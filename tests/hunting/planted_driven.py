"""Faults in how stated systems move by what agents give, each of which the hunt must notice.

Does: patches what proofs read of a world file and of its agents, and the checker of covers.
Assumes: pytest's monkeypatch, or anything with its `setattr`.
Does not: look for them.
"""

from dataclasses import replace

from maviper.verification import stated
from tests.hunting.planted_outputs import FAULTS as OF_AGENTS
from verify.checker.covers import sweep
from verify.systems.system import Affine


def _patched(patch, change):
    """What proofs read is what a change makes of it: of a system and a profile."""
    played = stated.as_played

    def changed(statement, profile):
        statement, profile = played(statement, profile)
        return replace(statement, system=change(statement.system)), profile

    patch.setattr(stated, "as_played", changed)


def _of_pieces(change):
    def of(system):
        return replace(system, pieces=tuple(map(change, system.pieces)))

    return lambda patch: _patched(patch, of)


def _ranges(patch):
    """Half of the starts are left out."""

    def half(system):
        halves = [each for each in system.start if len(each.form.terms) == 1]
        first, low = next((each, one) for each in halves for one in halves if one.form.terms[0] == _turned(each)[0])
        middle = (first.form.constant - low.form.constant) / 2
        nearer = replace(first, form=Affine(first.form.terms, middle))
        return replace(system, start=(*system.start, nearer))

    _patched(patch, half)


def _turned(half):
    return [(name, -factor) for name, factor in half.form.terms]


def forget_steps(patch):
    """The checker of covers asks about the first step alone."""
    ask = sweep.CoverSweep._ask_claim
    patch.setattr(sweep.CoverSweep, "_ask_claim", lambda self, sets, step: ask(self, sets, step) if step < 1 else sets)


def _halved(form, name):
    return Affine.of({each: factor / 2 if each == name else factor for each, factor in form.terms}, form.constant)


FAULTS = {
    "starts: half of them": _ranges,
    "motion: errors are forgotten": _of_pieces(lambda piece: replace(piece, error={})),
    "motion: the first agent moves nothing": _of_pieces(
        lambda piece: replace(piece, effect={key: forms for key, forms in piece.effect.items() if key[0] != "agent_0"})
    ),
    "motion: a variable follows half of itself": _of_pieces(
        lambda piece: replace(piece, move={name: _halved(form, name) for name, form in piece.move.items()})
    ),
    "checker: covers are asked about at first only": forget_steps,
    **{name: OF_AGENTS[name] for name in OF_AGENTS if name.startswith(("roundings", "leaves: n", "sums"))},
}
