"""Verification: the answers to questions, and all files that belong to them.

Does: one table of what is done with each kind of claim; joins the verifier with simulator, compiled code and reference
  environment; makes the report's files.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: decide verdicts, print or write files.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Any, overload

from codegen import ir
from codegen.deciding import only_acts, sums_in
from codegen.errors import InputError
from codegen.form import layout
from codegen.lowering.render import render
from codegen.policy_json import content_hash, dumps
from codegen.profiles import ensure
from codegen.rows import Shown
from maviper.files import jobs as processes
from maviper.files import runs
from maviper.verification.ask import DASK, Asked, Jobs, VerifyOptions, make_world_error, questions
from maviper.verification.bench import Bench, rollouts, state_replays
from maviper.verification.files.counterexamples import document, episode_document
from maviper.verification.files.states import region_file, repeat_command, states_files, zones_and_region
from verify.certificates.games import to_json
from verify.claims.region_files import name_region
from verify.claims.wording import spell_decisions
from verify.kinds import MACHINE, Kind
from verify.question import AnyClaim, DecisionQuestion, EpisodeQuestion, Question
from verify.reports import report
from verify.reports.courses import tables
from verify.result import AnyResult, Verdict
from verify.solver.encode import Query, query, reaching
from verify.solver.solve import smt_lib
from verify.spending import tell
from verify.verdicts import decisions
from verify.verdicts.decisions import DecisionResult

if TYPE_CHECKING:
    from maviper.verification.stated import StatedWorld
    from verify.verdicts.episodes import EpisodeResult


def _nothing(*_: object) -> dict[str, str]:
    return {}


@dataclass(frozen=True)
class Procedure:
    """The functions that handle one kind of claim."""

    answer: Callable[[Any, Any, str | None], AnyResult]  # a question, by its bench; where it holds, for the file named
    verdict: Callable[[Any, Any], tuple[Verdict, str]]  # of a question, by its bench, with the reason
    counterexample: Callable[[ir.PolicyProfile, Any], tuple[dict[str, Any], str] | None]  # and where it is, in words
    # files of where a result holds, which has a number; and what the solver is asked of a question, which has one
    places: Callable[[ir.PolicyProfile, int, Any], dict[str, str]] = _nothing
    solver_files: Callable[[int, Any], dict[str, str]] = _nothing


def _answer_decision(question: DecisionQuestion, bench: Bench, found_in: str | None) -> DecisionResult:
    replays = state_replays(bench.made, question.profile, question.claim.team, bench.world)

    def decide(asked: DecisionQuestion) -> DecisionResult:
        return decisions.verify(asked, replays, bench.count_visited(asked.region), bench.skipped)

    result = decide(question)
    if found_in is None:
        return result
    from verify.extent.largest import where as located  # imported here, as few ask where

    where = located(question, result.verdict, found_in)
    inner = decide(question.within(where.part.region)) if where.part else None
    return replace(result, evidence=replace(result.evidence, where=where, verdict_in_largest_region=inner))


def _decision_counterexample(profile: ir.PolicyProfile, result: DecisionResult) -> tuple[dict[str, Any], str] | None:
    if result.evidence.counterexample is None:
        return None
    where = "in its world state" if result.viewed is None else "at its observation"
    return document(profile, result, result.evidence.counterexample), where


def _queries(question: DecisionQuestion, goal: str | None) -> Iterator[tuple[str, Query]]:
    """Yields the queries to the solver for one goal, each with a name that suits a file."""
    team = question.team
    if question.claim.per_state:
        yield question.claim.name, query(question, goal, however_large=True)
        return
    for policy in team:
        for leaf in map(int, ir.leaves(policy.tree)):
            asked = reaching(policy, leaf, question.region, goal, semantics=question.semantics)
            yield f"{question.claim.name}-{policy.agent}-{leaf}", asked


def _solver_files(number: int, question: DecisionQuestion) -> dict[str, str]:
    claim = question.claim
    return {
        f"{number:02d}-{name}-{goal or 'no-goal'}.smt2": render(
            "smt/question.smt2.j2",
            profile=content_hash(question.origin),
            claim=f"{claim.shown}: {claim.written or spell_decisions(claim)}",
            assume=claim.assumption,
            leaf=not claim.per_state,
            region=name_region(question.profile, question.region) or "given",
            goal=goal,
            semantics=question.semantics,
            exact=made.exact,
            text=smt_lib(made),
        )
        for goal in question.goals
        for name, made in _queries(question, goal)
    }


def _judge_decision(question: DecisionQuestion, bench: object) -> tuple[Verdict, str]:
    return decisions.verdict(question)


DECISIONS = Procedure(_answer_decision, _judge_decision, _decision_counterexample, zones_and_region, _solver_files)


def _answer_episodes(question: EpisodeQuestion, bench: Bench, found_in: str | None) -> EpisodeResult:
    from verify.verdicts import episodes  # here, as most claims are about decisions

    return episodes.verify_episodes(question.by(MACHINE), rollouts(bench.made, bench.world), bench.skipped)


def _judge_episodes(question: EpisodeQuestion, bench: object) -> tuple[Verdict, str]:
    from verify.verdicts import episodes

    return episodes.verdict(question.by(MACHINE))


def _episode_counterexample(profile: ir.PolicyProfile, result: EpisodeResult) -> tuple[dict[str, Any], str] | None:
    return None if result.evidence.state is None else (episode_document(profile, result), "from its start")


EPISODES = Procedure(_answer_episodes, _judge_episodes, _episode_counterexample)


def _systems() -> Procedure:
    from maviper.verification.stated import answer_question, judge_question, tell_counterexample

    return Procedure(answer_question, judge_question, tell_counterexample)  # the solver gives a second opinion alone


PROCEDURES: Mapping[Kind, Callable[[], Procedure]] = {  # beside TELLINGS of verify/reports/report.py
    Kind.DECISIONS: lambda: DECISIONS,
    Kind.LEAVES: lambda: DECISIONS,
    Kind.EPISODES: lambda: EPISODES,
    Kind.SYSTEMS: _systems,
}


def procedure(claim: AnyClaim) -> Procedure:
    """Returns the procedure for a claim."""
    return PROCEDURES[claim.kind]()


def verify_claims(questions: Sequence[Question[AnyClaim]], where: bool = False) -> list[AnyResult]:
    """A result for each question; all are about one profile. Those about episodes are of the deployed arithmetic.

    `where`: also where claims about single decisions hold, and from how many starts those about episodes fail.
    """
    return [result for _, result in one_by_one(dict(enumerate(questions)), where)]


def one_by_one(
    questions: Mapping[int, Question[AnyClaim]], where: bool = False, stated: StatedWorld | None = None
) -> Iterator[tuple[int, AnyResult]]:
    """Yields each result of `verify_claims` as soon as it is known, with the number of its question, from 0. `stated`:
    the world file that they are about.
    """
    asked = [*questions.values()]
    observing = any(question.viewed is not None for question in asked)
    with Bench.of(_profile_of(asked), observing) if stated is None else nullcontext(stated) as bench:
        for number, question in questions.items():
            found_in = region_file(number + 1, question.claim) if where else None
            yield number, procedure(question.claim).answer(question, bench, found_in)


def verdicts(
    questions: Sequence[Question[AnyClaim]], stated: StatedWorld | None = None, jobs: Jobs = 1
) -> Iterator[tuple[Verdict, str]]:
    """The verdict on each question and its reason: those of `verify_claims`, without what a report says beside them."""
    if stated is None:
        _profile_of(questions)
    calls = [(number, question, stated) for number, question in enumerate(questions)]
    told = (_judge(*each) for each in calls) if jobs == 1 else iter(sorted(_spread(_judge, calls, jobs)))
    yield from (answer for _, answer in told)


def _judge(number: int, question: Question[AnyClaim], stated: StatedWorld | None) -> tuple[int, tuple[Verdict, str]]:
    return number, procedure(question.claim).verdict(question, stated)


def _answer(
    number: int, question: Question[AnyClaim], where: bool, stated: StatedWorld | None
) -> tuple[int, AnyResult]:
    return next(one_by_one({number: question}, where, stated))


def _spread(
    function: Callable[..., tuple[int, Any]], calls: Sequence[tuple[Any, ...]], jobs: Jobs
) -> Iterator[tuple[int, Any]]:
    """Yields the numbers of questions with what a function says of each, as they come: from so many processes, or from
    a cluster's.
    """
    answers = (
        processes.on_dask(function, calls, None) if jobs == DASK else processes.as_they_come(function, calls, int(jobs))
    )
    for done, answer in enumerate(answers, 1):
        tell(done, len(calls), "claims decided")
        yield answer


def _profile_of(questions: Sequence[Question[AnyClaim]]) -> ir.PolicyProfile:
    """The one profile that questions are about."""
    profile = ensure(questions[0].origin)
    assert all(question.origin is profile for question in questions)
    return profile


def digests(files: Mapping[str, str | bytes]) -> dict[str, str]:
    """SHA-256 of each text in hexadecimal, by name."""
    encoded = {name: item.encode() if isinstance(item, str) else item for name, item in sorted(files.items())}
    return {name: hashlib.sha256(item).hexdigest() for name, item in encoded.items()}


def question_files(questions: Sequence[Question[AnyClaim]]) -> dict[str, str]:
    """The very questions, one per property and goal (of alive_leaves: one per leaf and goal), as SMT-LIB, name -> text.

    Claims about episodes have none: no solver is asked about them.
    """
    files: dict[str, str] = {}
    for number, question in enumerate(questions, 1):
        files |= procedure(question.claim).solver_files(number, question)
    return files


def report_files(facts: Mapping[str, Any], form: ModuleType = report) -> dict[str, str]:
    """report.html, report.json and report.txt of a document, name -> text. `form`: of games, or of stated systems."""
    return {"report.json": form.as_json(facts), "report.txt": form.as_text(facts), "report.html": form.as_html(facts)}


def certificate_files(results: Sequence[AnyResult]) -> dict[str, str]:
    """Certificates of proved results, and of regions found in others, file name -> text; numbered as in the report."""
    return {
        f"certificate-{place}-{result.claim.name}{ending}.json": to_json(certificate)
        for place, result in enumerate(results, 1)
        for ending, certificate in result.evidence.certificates
    }


@dataclass(frozen=True, repr=False)
class Verified(Shown, Sequence[AnyResult]):
    """The questions about a profile with their results, of which it is a sequence. Files are name -> text.

    For example:

        maviper.verify_file(team, "claims.toml")[0].verdict
    """

    profile: ir.PolicyProfile
    asked: tuple[Asked, ...]
    results: tuple[AnyResult, ...]
    cells: int | None = None  #: the most failing cells that `where` looked for
    stated: StatedWorld | None = None  #: the world file that they are about

    @overload
    def __getitem__(self, index: int) -> AnyResult: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[AnyResult, ...]: ...
    def __getitem__(self, index: int | slice) -> AnyResult | tuple[AnyResult, ...]:
        """The result of the claim at a place, or those of a slice."""
        return self.results[index]

    def __len__(self) -> int:
        return len(self.results)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each claim."""
        return [row for result in self.results for row in result.rows]

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
        commands = [repeat_command(one, self.cells) for one in self.asked]
        return report.document(self.profile, self.results, commands, {})

    @cached_property
    def certificates(self) -> dict[str, str]:
        """A certificate for each claim proved by zones or linear programs, and for each region found."""
        return certificate_files(self.results)

    @cached_property
    def counterexamples(self) -> dict[str, str]:
        """For each violated claim a counterexample, and a test that fails until a policy holds there."""
        files: dict[str, str] = {}
        for place, result in enumerate(self.results, 1):
            failure = procedure(result.claim).counterexample(self.profile, result)
            if failure is None:
                continue
            written, where = failure
            stem = f"counterexample-{place}-{result.claim.name}"
            files[f"{stem}.json"] = layout(written) + "\n"
            named = {"name": f"{stem}.json", "place": place, "where": where}
            files[f"test_{stem.replace('-', '_')}.py"] = render("tests/counterexample.py.j2", **named)
        return files

    @cached_property
    def places(self) -> dict[str, str]:
        """Failing cells and regions found."""
        files: dict[str, str] = {}
        for place, result in enumerate(self.results, 1):
            files |= procedure(result.claim).places(self.profile, place, result)
        return files

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
    if options.world is None and not sums_in(profile):
        if options.max_boxes is not None:
            raise make_world_error("--set max_boxes")
        return questions(profile, profile_name, options, aside), None
    from maviper.verification.stated import StatedWorld

    # whether agents observe what world states say
    located = all(feature.meaning is not None for policy in profile.agents for feature in policy.features)
    if options.world is not None:
        stated = StatedWorld.of(profile, options)
    elif only_acts(profile) and located and not options.observations and not options.shared:
        stated = StatedWorld.of_game(profile, options)
    else:
        stated = StatedWorld.of_observations(profile, options)
    return stated.asked, stated


def verify_questions(
    profile: ir.PolicyProfile,
    asked: Sequence[Asked],
    options: VerifyOptions,
    told: Callable[[AnyResult], None] | None = None,
    stated: StatedWorld | None = None,
    is_over: Callable[[], bool] = lambda: False,
) -> Verified:
    """The results of questions, see `maviper.verification.ask.questions`. `told` gets each as soon as it is known.

    Interrupted after the first result, or because the time is over, it gives those that are known, and so fewer than
    were asked for.
    """
    outcomes: dict[int, AnyResult] = {}
    questions = {number: one.question for number, one in enumerate(asked)}
    if stated is not None:  # claims about single decisions take least
        quick = sorted(questions, key=lambda number: not stated.claims[number].about_decisions)
        questions = {number: questions[number] for number in quick}
    calls = [(*each, options.where, stated) for each in questions.items()]
    alone, waiting = options.jobs == 1 or len(calls) == 1, list(questions)
    try:
        for number, result in one_by_one(questions, *calls[0][2:]) if alone else _spread(_answer, calls, options.jobs):
            outcomes[number] = replace(result, question=questions[number])
            while told is not None and waiting and waiting[0] in outcomes:  # in the same order, whoever was first
                told(outcomes[waiting.pop(0)])
    except KeyboardInterrupt:
        if not outcomes and not is_over():
            raise
    for number in waiting:
        if told is not None and number in outcomes:
            told(outcomes[number])
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
