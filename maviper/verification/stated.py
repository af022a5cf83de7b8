"""A system that a file states, as what questions about a profile are asked in, and what is done with their claims.

Does: joins world file, property file and the reference environment; has counterexamples confirmed; writes down what
  belongs to an answer.
Assumes: a checked profile.
Does not: decide verdicts, print or write files.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from math import inf
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from codegen.deciding import list_decided, sums_in
from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.numbers import nearest_number, neighbour
from codegen.wording import visible
from maviper.files import runs
from maviper.verification import games, worlds
from maviper.verification.ask import Asked, VerifyOptions, pose_claims, resolve_region
from maviper.verification.files.states import repeat_options
from maviper.verification.files.systems import CLAIM_FILE, counterexample_document, read_earlier
from maviper.verification.games import find_by_rules, measure_reference, replay_words
from maviper.worlds.stated.certified import WORLD_FILE, ensure_plays, leave_stated
from maviper.worlds.stated.observing import ensure_observed
from maviper.worlds.stated.systems import file_of, read
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_curves, ensure_enclosed
from verify.claims.catalogue import read_call
from verify.claims.formula import Linear, atoms, below, negate, normal
from verify.claims.observed import View
from verify.claims.region import UNBOUNDED
from verify.claims.terms import last_of
from verify.claims.views import Viewed, select_features
from verify.decimals import plain
from verify.kinds import MACHINE
from verify.question import Question
from verify.reach.replay import Course, replay_course
from verify.reach.results import SystemCounterexample
from verify.reach.rounded import fails, iterate_failing, observable, truly
from verify.reports import systems as report
from verify.result import Cost, Result, Verdict
from verify.spending import tell
from verify.subjects import ClosedLoop
from verify.systems.claims import CurvedClaim, SystemClaim, SystemPremise
from verify.systems.curves import with_comparisons
from verify.systems.enclosures import list_curved
from verify.systems.files import MAX_BYTES as MAX_WORLD_BYTES
from verify.systems.observing import as_played
from verify.systems.properties import claims_in, claims_of, claims_said, find_numbers, parse_written
from verify.systems.statement import Statement
from verify.systems.system import State
from verify.verdicts.systems import BOXES, ENCLOSED, Attempt, SystemEvidence, SystemResult, verify_system

BENT = "the claim holds or fails within what the enclosures of its products and functions leave open"
ERRING = "the claim holds or fails within what the errors of next values leave open"
SMALLER = ("more `cuts` in [dynamics]", "a smaller region")
ROUNDED = (
    "the claim fails within the errors of rules and of the agents' roundings, but no violating episode of their own "
    "sums was found"
)
NO_DECISION = "the claim fails within the agents' roundings, but no state that breaks it was found"
# the options that are read
OF_OBSERVATIONS = ("effort", "jobs", "file", "region", "observations", "shared", "verdict_only")
OF_GAMES = ("claims", "names", "file", "region", "team", "parameters", "effort", "jobs", "max_boxes", "verdict_only")
NO_OBSERVATION = "the claim fails within the agents' roundings, but no observation that breaks it was found"
NO_STATE = "the claim fails within the agents' roundings, but no state of the game that does was found"
LOOSER = ("a bound that is looser by a little more than a rounding", "a smaller region")
OBSERVED = "over observations, region {region}: any combination of numbers in the ranges of world.toml"
IN_STATES = "over states of the game, roundings included: world.toml states what agents observe"
PLAYED = "over episodes of the game, roundings included: world.toml states how it moves and what agents observe"
NOT_PLAYED = "the claim fails within roundings, but no episode of the game that breaks it was found"
FINER = ("more `cuts` of the claim: cuts = { x = 40 }", "a smaller region")


@dataclass(frozen=True)
class StatedWorld:
    """A world file with the claims that are asked about, and what is measured of the environment it is about."""

    unfound: ClassVar[str] = ""  # why a claim stays open that fails in exact numbers; "": as it is about
    rounds: ClassVar[bool] = False  # whether what breaks a claim is found again in the agents' own numbers, always

    profile: PolicyProfile  # as proofs read it
    origin: PolicyProfile  # as it was given
    statement: Statement  # as proofs read it
    claims: tuple[SystemClaim, ...]
    given: Mapping[str, Path]  # the files that a user gave, by the name that a copy has
    beside: Mapping[str, str]  # their texts, for a report's folder
    options: VerifyOptions

    @staticmethod
    def of(profile: PolicyProfile, options: VerifyOptions) -> StatedWorld:
        """The world file of the options. InputError for files that cannot be used, and a profile of another world."""
        assert options.world is not None
        file = file_of(options.world)
        options = replace(options, world=file)
        given = {WORLD_FILE: file} | ({} if options.file is None else {CLAIM_FILE: options.file})
        statement = read(file)
        made = _join_parts(leave_stated(profile, statement), statement, given, _texts(given), options)
        if not options.claims:
            return made
        asked = made.beside.get(CLAIM_FILE, "") + worlds.spell_claims(map(read_call, options.claims))
        return replace(made, given={WORLD_FILE: file}, beside={**made.beside, CLAIM_FILE: asked})

    @staticmethod
    def of_observations(profile: PolicyProfile, options: VerifyOptions) -> StatedWorld:
        """The observations of a profile whose agents give numbers or test sums, as a world file. InputError for claims
        that are not about numbers.
        """
        for name, option in options.unusual.items():
            if name not in OF_OBSERVATIONS:
                what = f"{option} has no effect on claims about numbers and sums"
                raise InputError(what, option, "leave it out; claims are those of --claims FILE")
        if options.file is None:
            what = "claims about agents that give numbers or test sums are formulas of a file"
            policy, first = sums_in(profile)[0], list_decided(sums_in(profile)[0])[0]
            example = f"acts({policy.agent}) == {first}" if policy.actions else f"out({policy.agent}).{first} <= 1"
            raise InputError(what, "--claims", f'write a claim with formula = "{example}"')
        given = {CLAIM_FILE: options.file}
        beside = _texts(given)
        viewed = Viewed(profile, View(select_features(profile, options.shared or ())))
        region = resolve_region(viewed.profile, viewed, options.region)
        errors = worlds.errors_in(beside[CLAIM_FILE], profile, options.file.name)
        world = worlds.state_observations(profile, viewed.view, region, errors)
        beside = {WORLD_FILE: world.source, **beside}
        made = _join_parts(profile, world.statement, given, beside, options)
        return StatedObservations(**vars(made), region=region.name or "given")

    @staticmethod
    def of_game(profile: PolicyProfile, options: VerifyOptions) -> StatedWorld:
        """The states or the episodes of the game of a profile that tests sums, as a world file with the claims.
        InputError for options that these do not read, and for claims that neither is asked about.
        """
        for name, option in options.unusual.items():
            if name not in OF_GAMES:
                raise InputError(f"{option} has no effect on claims of agents that test sums", option, "leave it out")
        region = resolve_region(profile, None, options.region)
        posed = pose_claims(profile, None, region, options)
        if any(map(worlds.counts_steps, posed)):
            started = worlds.start_of(profile, posed)
            world = stated = worlds.state_episodes(profile, posed, started)
            if started.nowhere:  # a file states no empty start, so that of such a region is put in afterwards
                stated = worlds.state_episodes(profile, posed, started.widened)
            joined = _join_game(profile, stated.statement, world.source, options)
            made = StatedEpisodes(**vars(joined), started=started, again=repeat_options(options))
            if not made.empty:
                return made
            system = replace(made.statement.system, start=started.states)
            return replace(made, statement=replace(made.statement, system=system))
        world, places = worlds.state_decisions(profile, posed)
        made = _join_game(profile, world.statement, world.source, options)
        claims = (replace(each, region=f"of {where}") for each, where in zip(made.claims, places, strict=True))
        return StatedStates(**vars(replace(made, claims=tuple(claims))))

    @cached_property
    def reference(self) -> Mapping[str, Any]:
        """The measurements of the environment: seconds, so only once nothing else is left to refuse. InputError for a
        statement that is further from it than it says.
        """
        return {} if self.options.verdict_only else measure_reference(self.statement, self.options.run_reference)

    @property
    def command(self) -> str:
        """The command that asks all again, in the folder of the report."""
        options = self.options
        words = ["maviper", "verify", runs.PROFILE_FILE, "--system", WORLD_FILE]
        words += ["--claims", CLAIM_FILE] if CLAIM_FILE in self.beside else []
        words += [] if options.effort == "normal" else ["--effort", options.effort]
        words += [] if options.max_boxes is None else ["--set", f"max_boxes={options.max_boxes}"]
        words += ["--run-reference"] if options.run_reference else []
        return shlex.join(words)

    @property
    def asked(self) -> list[Asked]:
        """The questions, each with the command that asks them all again."""
        return [Asked(question, self.command, self.about) for question in self._questions]

    @property
    def said(self) -> list[tuple[str, str]]:
        """Lines for a terminal: the subject of the verdicts, and what was measured."""
        return [("about", self.about), *(("reference", words) for words in self.reference.get("said", []))]

    @property
    def empty(self) -> bool:
        """True if no state is what the claims are about."""
        return False

    @property
    def about(self) -> str:
        """The subject of the verdicts."""
        return report.sentence(self.statement.system)

    @property
    def form(self) -> ModuleType:
        """The module that writes the report."""
        return report

    def document(self, results: Sequence[Result[SystemClaim, Any]]) -> dict[str, Any]:
        """The report as plain data."""
        return report.document(self.origin, self.statement, results, self.reference, self.command)

    def answer(self, question: Question[SystemClaim], beside: bool = True) -> SystemResult:
        """The result of a question. InputError where an enclosure that a proof needs is not shown again."""
        if question.claim.curved is not None:
            return self._by_curves(question, question.claim.curved, beside)
        if self.empty:
            none = "the region holds no start at rest"
            return Result(question, Verdict.VACUOUS, none, SystemEvidence(), Cost(0, 0, BOXES))
        measured_steps = self.reference.get("steps")  # first, since a wrong statement is not worth a proof
        claim = question.claim
        bent = not claim.about_decisions and any(map(list_curved, self.statement.rules))
        confirm = partial(find_by_rules, self.statement, self.profile, claim) if bent else None
        rounding = self.rounds or bool(self.statement.acting)
        if rounding:
            confirm = _find_nothing if bent else partial(self.confirm, claim)
        result = verify_system(question, confirm, beside, self._attempt(claim), self._find_first(claim))
        if result.reason == ENCLOSED and rounding:
            unfound = self.unfound or (NO_DECISION if claim.about_decisions else ROUNDED)
            helps = LOOSER if self.unfound or claim.about_decisions else result.evidence.helps
            result = replace(result, reason=unfound, evidence=replace(result.evidence, helps=helps))
        if result.verdict is Verdict.PROVED:
            _ = self._shown
        said = replay_words(self.statement, self.profile, result) if measured_steps else ""
        return replace(result, evidence=replace(result.evidence, environment=said))

    def _by_curves(self, question: Question[SystemClaim], curved: CurvedClaim, beside: bool) -> SystemResult:
        """The answer about a formula with curves: PROVED where the formula that implies it is, VIOLATED where the one
        that it implies is. InputError where an enclosure is not shown again.
        """
        ranges = {one.name: one.range for one in self.statement.system.variables}
        try:
            ensure_curves(curved.enclosures, ranges)
        except RejectedError as error:
            where = f"claim {question.claim.shown}: {error}"
            raise InputError("an enclosure was not shown again", where, "cut its ranges into more parts") from None
        confirm = partial(self.confirm, question.claim) if self.statement.acting else None
        stronger = verify_system(question, confirm, beside)
        if stronger.verdict in (Verdict.PROVED, Verdict.VACUOUS):
            return stronger
        if self.statement.acting:
            confirm = partial(self.confirm, curved.weaker)
        other = verify_system(replace(question, claim=curved.weaker), confirm, beside)
        if other.verdict is Verdict.VIOLATED:
            return other
        open_ = replace(stronger.evidence, helps=FINER if curved.enclosures else SMALLER, counterexample=None)
        reason = BENT if curved.enclosures else ERRING
        return replace(stronger, verdict=Verdict.UNKNOWN, reason=reason, evidence=open_)

    @cached_property
    def _questions(self) -> list[Question[SystemClaim]]:
        subject, budgets = ClosedLoop(self.profile, self.statement.system), self.options.budgets(None)
        since, name = self.options.since, self.statement.system.name
        earlier = {} if since is None else read_earlier(since, name, self.claims)
        return [
            Question(subject, claim, UNBOUNDED, MACHINE, budgets, earlier.get(number, ()))
            for number, claim in enumerate(self.claims)
        ]

    # --- the real agents, as they compute

    def confirm(self, claim: SystemClaim, known: SystemCounterexample) -> SystemCounterexample | None:
        """A counterexample of the real agents beside another one. AssertionError where the reference, asked for what
        they give in its state, does not break the formula as it was written: that is our bug.
        """
        again = self._play_again(claim, known)
        if again is not None and claim.about_decisions:
            said = parse_written(claim, self.statement, self.profile)
            if said is not None and not fails(self.statement, self.profile, said, again.start):
                raise AssertionError(f"the reference breaks no formula at {dict(again.start)}: {claim.written}")
        return again

    def _play_again(self, claim: SystemClaim, known: SystemCounterexample) -> SystemCounterexample | None:
        """A counterexample of the real agents beside another one, not yet asked of the reference."""
        return truly(self.statement, self.profile, claim, known)

    def _find_first(self, claim: SystemClaim) -> SystemCounterexample | None:
        """A counterexample that is looked for before anything is proved."""
        return None

    def _attempt(self, claim: SystemClaim) -> Attempt | None:
        """Returns what looks for a counterexample where a proof fails; None: nothing does."""
        return partial(self._look_drawn, claim) if self.statement.acting and claim.about_decisions else None

    def _look_drawn(self, claim: SystemClaim) -> SystemCounterexample | None:
        """A counterexample of the real agents, wherever they break a claim about decisions."""
        written = parse_written(claim, self.statement, self.profile)
        drawn = () if written is None else iterate_failing(self.statement, self.profile, claim, written)
        known = (SystemCounterexample((state,), (), (), (), 0) for state in drawn)
        return next(filter(None, (self.confirm(claim, each) for each in known)), None)

    @cached_property
    def _shown(self) -> None:
        """Has the checker show again that pieces hold what the rules say: else nothing is proved."""
        try:
            ensure_enclosed(self.statement, lambda done, most: tell(done, most, "pieces shown again by the checker"))
        except RejectedError as error:
            where = f"{self.statement.system.name}: {error}"
            advice = "cut the ranges of more variables, or into more parts"
            raise InputError("an enclosure was not shown again", where, advice) from None


@dataclass(frozen=True)
class StatedObservations(StatedWorld):
    """The observations of a profile: a counterexample is one of floats."""

    unfound = NO_OBSERVATION
    region: str  # what their ranges are

    @property
    def about(self) -> str:
        """The subject of the verdicts."""
        return OBSERVED.format(region=self.region)

    def _play_again(self, claim: SystemClaim, known: SystemCounterexample) -> SystemCounterexample | None:
        return observable(self.statement, self.profile, claim, known)


@dataclass(frozen=True)
class StatedStates(StatedWorld):
    """The states of a game: a counterexample is one of them, with the roundings that the game makes there."""

    unfound, rounds = NO_STATE, True

    @property
    def about(self) -> str:
        """The subject of the verdicts."""
        return IN_STATES

    def _play_again(self, claim: SystemClaim, known: SystemCounterexample) -> SystemCounterexample | None:
        return self._find_broken(claim, games.iterate_states_near(self.origin, self.statement, claim, known.start))

    def _attempt(self, claim: SystemClaim) -> Attempt:
        return lambda: self._find_broken(claim, games.iterate_states(self.origin, self.statement, claim))

    def _find_broken(self, claim: SystemClaim, states: Iterable[State]) -> SystemCounterexample | None:
        """The first of some states that breaks a claim. AssertionError where the game shows an agent other numbers
        than its file: that is our bug.
        """
        for state in states:
            ensure_observed(self.origin, self.statement, state)
            again = truly(self.statement, self.profile, claim, SystemCounterexample((state,), (), (), (), 0))
            if again is not None:
                return again
        return None


@dataclass(frozen=True)
class StatedEpisodes(StatedWorld):
    """The episodes of a game: a counterexample is one that the game plays, in its own float64."""

    unfound, rounds = NOT_PLAYED, True
    started: worlds.Started  # from where
    again: str  # the command that asks once more, by the game

    @property
    def about(self) -> str:
        """The subject of the verdicts."""
        return PLAYED

    @property
    def empty(self) -> bool:
        """True if the region holds no start at rest."""
        return self.started.nowhere

    @property
    def command(self) -> str:
        """The command that asks all again; a file states no empty start."""
        return self.again if self.empty else super().command

    @property
    def _game(self) -> games.PlayedGame:
        return games.PlayedGame(self.origin, self.profile, self.statement, self.started.goal)

    def _play_again(self, claim: SystemClaim, known: SystemCounterexample) -> SystemCounterexample | None:
        return self._find_played(claim, games.iterate_courses_near(self._game, claim, known.start))

    def _find_first(self, claim: SystemClaim) -> SystemCounterexample | None:
        return self._find_played(claim, games.iterate_courses(self._game, claim))  # as games are quick to play

    def _attempt(self, claim: SystemClaim) -> None:
        return None

    def _find_played(self, claim: SystemClaim, courses: Iterable[Course]) -> SystemCounterexample | None:
        """The first of some episodes that breaks a claim."""
        played = (replay_course(self.profile, self.statement.system, claim, course) for course in courses)
        return next(filter(None, played), None)


def _join_game(profile: PolicyProfile, statement: Statement, source: str, options: VerifyOptions) -> StatedWorld:
    return _join_parts(profile, statement, {}, {WORLD_FILE: source}, replace(options, file=None, claims=()))


def _join_parts(
    origin: PolicyProfile,
    statement: Statement,
    given: Mapping[str, Path],
    beside: Mapping[str, str],
    options: VerifyOptions,
) -> StatedWorld:
    ensure_plays(origin, statement)
    statement, profile = as_played(statement, origin)
    claims = claims_said(options.claims, statement, profile)
    if options.file is not None:
        claims = (*claims_in(beside[CLAIM_FILE], statement, profile, options.file.name), *claims)
    elif not claims:
        claims = claims_of(statement, profile, given.get(WORLD_FILE, Path(WORLD_FILE)).name)
    return StatedWorld(profile, origin, statement, claims, given, beside, options)


def _texts(given: Mapping[str, Path]) -> dict[str, str]:
    return {name: runs.read(path, MAX_WORLD_BYTES).decode(errors="replace") for name, path in given.items()}


def _find_nothing(_: SystemCounterexample) -> None:
    """Nothing is known of the real agents' sums where rules are enclosed."""


NEVER = "no state meets the condition: {words}"
UNFOUND = "no state that meets the condition was found, and no proof that there is none: {words}"


def with_conditions(result: SystemResult, world: StatedWorld) -> SystemResult:
    """The result, unless a left side never holds, or none is known to; the certificate of a proof states what meets
    each.
    """
    if result.verdict not in (Verdict.PROVED, Verdict.UNKNOWN):
        return result
    premises, unproved = list[SystemPremise](), SystemEvidence(boxes=result.evidence.boxes)
    for denied in result.claim.conditions:
        answer, words = answer_alone(result.question, denied.claim, world), visible(" ".join(denied.words.split()))
        shown = answer.evidence.counterexample
        if answer.verdict is Verdict.PROVED:
            return replace(result, verdict=Verdict.VACUOUS, reason=NEVER.format(words=words), evidence=unproved)
        if shown is None and result.verdict is Verdict.PROVED:
            return replace(result, verdict=Verdict.UNKNOWN, reason=UNFOUND.format(words=words), evidence=unproved)
        if shown is not None:
            premises.append(SystemPremise(negate(answer.claim.formula), shown.states[0]))
    certificate = result.evidence.certificate
    if certificate is None or not premises:
        return result
    stated = replace(certificate, claim=replace(certificate.claim, premises=tuple(premises)))
    return replace(result, evidence=replace(result.evidence, certificate=stated))


def answer_alone(question: Question[SystemClaim], claim: SystemClaim, world: StatedWorld) -> SystemResult:
    """The verdict on another claim about the world of a question."""
    alone = replace(world, claims=(claim,), options=replace(world.options, verdict_only=True))
    return alone.answer(replace(question, claim=claim), beside=False)


MOST = 16  # bounds that are tried
SAID = "fails only where {name} is rounded when it is observed: proved with {moved} in place of {stated}"


def with_bound(result: SystemResult, world: StatedWorld) -> SystemResult:
    """The result, which says from which bound on its claim is proved, where only rounding makes it fail."""
    claim = result.claim
    if result.verdict is not Verdict.VIOLATED or not claim.about_decisions or claim.curved or world.statement.observed:
        return result
    numbers = find_numbers(world.statement, world.origin.agents)
    for stated, moved in list(_iterate_moved(claim, numbers))[:MOST]:

        def move(atom: Linear, stated: Linear = stated, moved: Linear = moved) -> Linear:
            return moved if atom == stated else atom

        formula = with_comparisons(normal(claim.formula), move)
        again = answer_alone(result.question, replace(claim, formula=formula), world)
        if again.verdict is Verdict.PROVED:
            left = any(stated in atoms(condition.claim.formula) for condition in claim.conditions)
            said = SAID.format(
                name=", ".join(name for _, name in stated.terms), moved=_spell(moved, left), stated=_spell(stated, left)
            )
            return replace(result, evidence=replace(result.evidence, rounding=said))
    return result


def _iterate_moved(claim: SystemClaim, numbers: Mapping[str, str]) -> Iterator[tuple[Linear, Linear]]:
    """Each bound on a variable that is observed, and the weaker one at the next float beyond what is read as it."""
    for atom in dict.fromkeys(atoms(normal(claim.formula))):
        if not isinstance(atom, Linear) or len(atom.terms) != 1:
            continue
        ((weight, name),) = atom.terms
        if not numbers.get(name):
            continue
        kind, bound = numbers[name], atom.bound / abs(weight)  # of the variable, or of its opposite
        end = bound if atom.strict else max(bound, Fraction(nearest_number(bound, kind)))
        after = float(neighbour(last_of(end, kind, below=atom.strict), inf, kind))
        moved = below({name: 1 if weight > 0 else -1}, Fraction(repr(after)), strict=True)
        if moved != atom and isinstance(moved, Linear):
            yield atom, moved


def _spell(atom: Linear, left: bool) -> str:
    """A bound in words; its opposite where it is of the left side of an implication."""
    ((weight, name),) = atom.terms
    low, strict = (weight < 0) != left, atom.strict != left
    return f"{name} {'>' if low else '<'}{'' if strict else '='} {plain(atom.bound / weight)}"


def answer_question(question: Question[SystemClaim], bench: StatedWorld, found_in: str | None) -> SystemResult:
    """The answer of a world. Where a claim holds is not said: what an answer leaves open, the report names."""
    return with_bound(with_conditions(bench.answer(question), bench), bench)


def judge_question(question: Question[SystemClaim], bench: StatedWorld) -> tuple[Verdict, str]:
    """The verdict of `answer_question` and its reason alone."""
    result = with_conditions(bench.answer(question, beside=False), bench)
    return result.verdict, result.reason


def tell_counterexample(profile: PolicyProfile, result: SystemResult) -> tuple[dict[str, Any], str] | None:
    """What the file of a violated claim says, and where that is, in words."""
    found = result.evidence.counterexample
    return None if found is None else (counterexample_document(result.question, found), "from its start, in world.toml")
