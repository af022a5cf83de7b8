"""The page of a report: verdicts beside the claims, and a button for each counterexample.

Does: turns results into what a page shows.
Assumes: results of one profile, in the order of the report.
Does not: decide.
"""

from collections.abc import Sequence

from codegen import ir
from maviper.page.document import Shown, Stored
from maviper.page.page import contents_of, page
from verify.claims.uncertified.starts import START, called
from verify.result import AnyResult, Verdict
from verify.semantics import MACHINE


def page_of(profile: ir.PolicyProfile, results: Sequence[AnyResult]) -> str:
    """The page of a profile with these results; without those over observations, which are not about its states."""
    results = [one for one in results if one.viewed is None]
    states = [_stored(number, result) for number, result in enumerate(results)]
    shown = tuple(Shown(result.claim, _verdict(profile, result)) for result in results)
    return page(profile, contents_of(profile, shown, tuple(filter(None, states))))


def _verdict(profile: ir.PolicyProfile, result: AnyResult) -> str:
    name = called(profile, result.region)
    region = "the start region" if name == START else f"the region {name}" if name else "a region of its own"
    return f"{result.verdict.value} in {region}" + ("" if result.semantics == MACHINE else ", in real arithmetic")


def _stored(number: int, result: AnyResult) -> Stored | None:
    """The counterexample as a button, of the deployed arithmetic: the page decides by no other."""
    state = result.evidence.failing_state
    if result.verdict is not Verdict.VIOLATED or state is None or result.semantics != MACHINE:
        return None
    position = {name: float(value) for name, value in state.position.items()}
    return Stored(f"Counterexample: {result.claim.shown}", number, position, state.goal)
