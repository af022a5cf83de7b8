"""Verification: the answers to questions, and all files that belong to them.

Does: has the claims decided; renders report, certificates, counterexamples, regions found and failing states.
Assumes: `join` joins verifier and simulator.
Does not: decide verdicts, print, or write files.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from codegen import ir
from codegen.check import ensure
from codegen.policy_json import dumps
from maviper.files import runs
from maviper.verification.ask import Asked, VerifyOptions, questions
from maviper.verification.files.places import repeated
from maviper.verification.files.states import states_files
from maviper.verification.join import (
    certificate_files,
    counterexample_files,
    one_by_one,
    report_files,
    where_files,
)
from verify.reports import report
from verify.result import AnyResult


@dataclass(frozen=True)
class Verified:
    """The questions about a profile with their results. Files are name -> text."""

    profile: ir.PolicyProfile
    asked: tuple[Asked, ...]
    results: tuple[AnyResult, ...]
    cells: int | None = None  # that --where looked for at most

    @cached_property
    def reports(self) -> dict[str, str]:
        """report.html, report.json and report.txt."""
        return report_files(self.profile, self.results, self._commands, {})

    def printed(self, as_json: bool) -> str:
        """The report for standard output alone: as JSON or as text."""
        facts = report.document(self.profile, self.results, self._commands, {})
        return report.as_json(facts) if as_json else report.as_text(facts)

    @property
    def _commands(self) -> list[str]:
        return [repeated(one, self.cells) for one in self.asked]

    @cached_property
    def certificates(self) -> dict[str, str]:
        """A certificate for each claim proved by zones, and for each region found."""
        return certificate_files(self.results)

    @cached_property
    def counterexamples(self) -> dict[str, str]:
        """For each violated claim a counterexample and a test of it."""
        return counterexample_files(self.profile, self.results)

    @cached_property
    def places(self) -> dict[str, str]:
        """Failing cells and regions found."""
        return where_files(self.profile, self.results)

    @cached_property
    def states(self) -> dict[str, str]:
        """States in which claims fail, to learn from."""
        return states_files(self.profile, self.asked, self.results)

    @property
    def files(self) -> dict[str, str]:
        """All of them; the profile too, where a counterexample is to be replayed with it."""
        beside = {runs.PROFILE_FILE: dumps(self.profile)} if self.counterexamples else {}
        return self.reports | self.certificates | self.counterexamples | self.places | self.states | beside


def verified(
    profile: ir.PolicyProfile,
    asked: Sequence[Asked],
    options: VerifyOptions,
    told: Callable[[AnyResult], None] | None = None,
) -> Verified:
    """The results of questions, see `maviper.verification.ask.questions`. `told` gets each as soon as it is known.

    Interrupted after the first result, it gives those that are known, and so fewer than were asked for.
    """
    found: list[AnyResult] = []
    try:
        for result in one_by_one([one.question for one in asked], options.where):
            found.append(result)
            if told is not None:
                told(result)
    except KeyboardInterrupt:
        if not found:
            raise
    return Verified(profile, tuple(asked[: len(found)]), tuple(found), options.cells)


def results(profile: ir.PolicyProfile, options: VerifyOptions) -> list[AnyResult]:
    """The results alone. InputError for options that cannot be used."""
    asked = questions(ensure(profile), runs.PROFILE_FILE, options.checked())
    return list(verified(profile, asked, options).results)
