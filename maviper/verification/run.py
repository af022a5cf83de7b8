"""Verification: the answers to questions, and all files that belong to them.

Does: has the claims decided; renders report, certificates, counterexamples, regions found and failing states.
Assumes: `join` joins verifier and simulator.
Does not: decide verdicts, print, or write files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Any

from codegen import ir
from codegen.errors import InputError
from codegen.policy_json import dumps
from codegen.profiles import ensure
from maviper.files import runs
from maviper.verification.ask import Asked, VerifyOptions, make_world_error, questions
from maviper.verification.files.places import repeat_command
from maviper.verification.files.states import states_files
from maviper.verification.join import (
    certificate_files,
    counterexample_files,
    one_by_one,
    report_files,
    where_files,
)
from verify.reports import report
from verify.reports.courses import tables
from verify.result import AnyResult

if TYPE_CHECKING:
    from maviper.verification.stated import StatedWorld


@dataclass(frozen=True)
class Verified:
    """The questions about a profile with their results. Files are name -> text."""

    profile: ir.PolicyProfile
    asked: tuple[Asked, ...]
    results: tuple[AnyResult, ...]
    cells: int | None = None  # that --where looked for at most
    stated: StatedWorld | None = None  # the world file that they are about

    @cached_property
    def reports(self) -> dict[str, str]:
        """report.html, report.json and report.txt; of a stated system also tables of trajectories."""
        reports = report_files(self.document, self._form)
        return reports if self.stated is None else reports | tables(self.document)

    def printed(self, as_json: bool) -> str:
        """The report for standard output alone: as JSON or as text."""
        return self._form.as_json(self.document) if as_json else self._form.as_text(self.document)

    @property
    def _form(self) -> ModuleType:
        """The module that writes the report."""
        return report if self.stated is None else self.stated.form

    @cached_property
    def document(self) -> dict[str, Any]:
        """The report as plain data."""
        if self.stated is not None:
            return self.stated.document(self.results)
        return report.document(self.profile, self.results, self._commands, {})

    @property
    def _commands(self) -> list[str]:
        return [repeat_command(one, self.cells) for one in self.asked]

    @cached_property
    def certificates(self) -> dict[str, str]:
        """A certificate for each claim proved by zones or linear programs, and for each region found."""
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
        beside: Mapping[str, str] = {} if self.stated is None else self.stated.beside
        if self.counterexamples or self.stated is not None:
            beside = {**beside, runs.PROFILE_FILE: dumps(self.profile)}
        return {**self.reports, **self.certificates, **self.counterexamples, **self.places, **self.states, **beside}


def pose_questions(
    profile: ir.PolicyProfile,
    profile_name: str,
    options: VerifyOptions,
    aside: Callable[[InputError], None] | None = None,
) -> tuple[list[Asked], StatedWorld | None]:
    """The questions of checked options, and the world file that they are about, where one is named or agents give
    numbers or test sums. `aside`: as for `questions`.
    """
    summing = any(policy.tree.arithmetic for policy in profile.agents)
    if options.world is None and not summing:
        if options.max_boxes is not None:
            raise make_world_error("--max-boxes")
        return questions(profile, profile_name, options, aside), None
    from maviper.verification.stated import StatedWorld

    if options.world is not None:
        stated = StatedWorld.of(profile, options)
    elif _plays_in_places(profile) and not options.observations and not options.shared:
        stated = StatedWorld.of_game(profile, options)
    else:
        stated = StatedWorld.of_observations(profile, options)
    return stated.asked, stated


def _plays_in_places(profile: ir.PolicyProfile) -> bool:
    """Returns True if agents take actions, and observe what world states say."""
    return all(
        not policy.outputs and all(feature.meaning is not None for feature in policy.features)
        for policy in profile.agents
    )


def verify_questions(
    profile: ir.PolicyProfile,
    asked: Sequence[Asked],
    options: VerifyOptions,
    told: Callable[[AnyResult], None] | None = None,
    stated: StatedWorld | None = None,
) -> Verified:
    """The results of questions, see `maviper.verification.ask.questions`. `told` gets each as soon as it is known.

    Interrupted after the first result, it gives those that are known, and so fewer than were asked for.
    """
    outcomes: dict[int, AnyResult] = {}
    order = list(range(len(asked)))
    if stated is not None:  # claims about single decisions take least
        order = sorted(order, key=lambda number: not stated.claims[number].about_decisions)
    try:
        for number, result in zip(
            order, one_by_one([asked[each].question for each in order], options.where, stated), strict=False
        ):
            outcomes[number] = result
            if told is not None:
                told(result)
    except KeyboardInterrupt:
        if not outcomes:
            raise
    known = sorted(outcomes)
    answers = tuple(outcomes[number] for number in known)
    return Verified(profile, tuple(asked[number] for number in known), answers, options.cells, stated)


def results(profile: ir.PolicyProfile, options: VerifyOptions) -> list[AnyResult]:
    """The results alone. InputError for options that cannot be used."""
    return list(verify_world(ensure(profile), options).results)


def verify_world(profile: ir.PolicyProfile, options: VerifyOptions) -> Verified:
    """The verdicts on the claims of options, of a world file among them, as `verify_questions`."""
    asked, stated = pose_questions(profile, runs.PROFILE_FILE, options.ensure_usable())
    return verify_questions(profile, asked, options, stated=stated)
