"""Extraction with counterexamples: what it learns from them, and what the new team costs beside the one before.

Does: makes labelled examples of the world states in which a team failed a claim; says in how many of them, and in which
  share of the region, it fails afterwards; compares play, actions and leaves with the policy before, where it is there.
Assumes: a world of ours, whose states the counterexamples are.
Does not: extract (extract/), or decide verdicts: `maviper verify` does.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from codegen.form import layout
from codegen.intervals import Share
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from codegen.wording import format_count
from maviper.console import Console
from maviper.evaluation import comparison, held_out
from maviper.evaluation.players import EXPERT, Player
from maviper.experts.expert import Expert
from maviper.extraction.extraction import NO_EXAMPLES, Examples, Lesson, lesson_of
from maviper.files import runs
from maviper.worlds import ParticleWorld, World
from maviper.worlds.matching import plays
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.question import Question
from verify.states.shares import SAMPLE_SEED, SAMPLES, fails, find_unbounded, violating
from verify.states.state import observe_state, sample
from verify.subjects import Game

if TYPE_CHECKING:  # it imports the solver, which an extraction without counterexamples does not need
    from maviper.verification.files.states import Failing

COST_FILE = "refit.json"
NO_POLICY = "profile.json beside the counterexamples is another policy, or there is none"
OTHER_AGENTS = "the policy before observes or decides something else than this one"
SOME_AGENTS = "only some agents of the team have trees"


@dataclass(frozen=True)
class Task:
    """The task of an extraction beside its expert: nothing, where there are no examples."""

    examples: Examples = NO_EXAMPLES
    failing: tuple[Failing, ...] = ()

    @property
    def digests(self) -> list[str] | None:
        """The digests by which a run is known as the same run."""
        return [one.digest for one in self.failing] or None


NOTHING = Task()


def task_of(paths: Sequence[Path], world: World, expert: Expert, console: Console) -> Task:
    """Examples from the counterexamples in files and folders; says what they are. InputError as `read_failing`."""
    if not paths:
        return NOTHING
    if not isinstance(world, ParticleWorld):
        what = "counterexamples are states, and this environment does not declare its states"
        raise InputError(what, "--counterexamples", "leave them out")
    from maviper.verification.bench import states_of
    from maviper.verification.files.states import blank, read_failing

    failing, skipped = read_failing(paths, world)
    for said in skipped:
        console.line("", said)
    lessons = list[Lesson]()
    for one in failing:
        world_state, policies = states_of(world.spec, one.states), blank(world)
        columns = dict(zip(world.spec.coordinates(), world.coordinates(world_state).T, strict=True))
        seen = [rows.copy() for rows in world.observe(world_state)]
        for row, state in enumerate(one.states):
            if state.errors:
                for rows, policy in zip(seen, policies.agents, strict=True):
                    rows[row] = observe_state(policies, policy, state)[0]
        lesson = lesson_of(world, expert, one.claim.team, one.claim.statement, columns, tuple(seen), world_state)
        left_out = len(one.states) - len(lesson)
        lost = (
            f"; {left_out} left out, since no joint action of the {one.claim.team} fulfils the claim there"
            if left_out
            else ""
        )
        told = f"{format_count(len(one.states), 'state')} violating {one.claim.shown} of the {one.claim.team}{lost}"
        console.line("examples", told)
        lessons.append(lesson)
    if not any(map(len, lessons)):
        what = "the claim cannot be fulfilled in any of the states"
        raise InputError(
            what, "--counterexamples", "the claim asks too much there: verify with a larger --radius or another region"
        )
    digest = sha256("".join(one.digest for one in failing).encode()).hexdigest()
    return Task(Examples(tuple(filter(len, lessons)), digest=digest), tuple(failing))


def report(task: Task, after: PolicyProfile, place: Path, expert: str, played: Expert, world: World) -> list[Outcome]:
    """Reports the fate of the claims, and what that costs. `place`: where the profile lies."""
    assert isinstance(world, ParticleWorld)
    player = Player(Path(expert).name, EXPERT, played.hash, played)
    return [_outcome(one, after, place, player, world) for one in task.failing]


def report_text(outcomes: Sequence[Outcome], command: str) -> str:
    """Returns the outcomes of all claims as a file's text."""
    return layout({"command": command, "claims": [outcome.document() for outcome in outcomes]}) + "\n"


@dataclass(frozen=True)
class Outcome:
    """The outcome for one claim. Shares are of uniform states of the region; what could not be told is None."""

    failing: Failing
    region: Region
    after: PolicyProfile
    before: PolicyProfile | None
    reason: str  # why there is nothing to compare with
    learned: Share | None  # of the states given: the claim is fulfilled
    violating: tuple[Share | None, Share | None]  # before, after
    cost: comparison.Cost | None
    command: str  # that asks for the verdict

    @property
    def agents(self) -> list[str]:
        """The team's."""
        return [policy.agent for policy in self.after.team(self.failing.claim.team)]

    def document(self) -> dict[str, Any]:
        """Returns the outcome as plain data."""
        names, given = ("before", "after"), self.failing
        facts: dict[str, Any] = {
            "property": given.claim.shown,
            "team": given.claim.team,
            "region": self.region.name,
            "counterexamples": len(given.states),
            "profile_before": None if self.before is None else content_hash(self.before),
            "profile": content_hash(self.after),
            "not_compared": self.reason or None,
            "fulfilled": None if self.learned is None else self.learned.document(),
            "violating": {
                name: None if share is None else share.document()
                for name, share in zip(names, self.violating, strict=True)
            },
            "verify": self.command,
        }
        if self.before is not None and self.cost is not None:
            facts |= {"trees": comparison.sizes_document(self.before, self.after, self.agents), **self.cost.document()}
        return facts

    def say(self, console: Console) -> None:
        """Prints the outcome as lines."""
        claim = self.failing.claim
        console.line("learned", f"{claim.shown} of the {claim.team}, region {self.region.name}")
        if self.learned is not None:
            console.line("", f"fulfilled in {self.learned.hits} of the {self.learned.count} counterexamples")
        old, new = self.violating
        if new is not None:
            was = "" if old is None else f"{old} to "
            console.line("violating", f"{was}{new} of the region's states")
        if self.before is None or self.cost is None:
            console.line("cost", f"not measured: {self.reason}")
        else:
            console.line("trees", comparison.say_sizes(self.before, self.after, self.agents))
            self.cost.say(console)
        console.line("next", self.command)


def _outcome(given: Failing, after: PolicyProfile, place: Path, expert: Player, world: ParticleWorld) -> Outcome:
    claim, whole = given.claim, plays(after, world)
    region = given.region or everywhere(after)
    before = given.before() if whole else None
    reason = SOME_AGENTS if not whole else NO_POLICY if before is None else ""
    if before is not None and not plays(before, world):
        before, reason = None, OTHER_AGENTS
    uniform = sample(region, world.spec, SAMPLES, SAMPLE_SEED)[0]

    def failures(profile: PolicyProfile | None) -> Share | None:
        if profile is None or find_unbounded(region):
            return None
        return Share(int(violating(Question(Game(profile), claim, region), uniform).sum()), len(uniform))

    learned = None
    if whole:
        learned = Share(int((~fails(Question(Game(after), claim, region), given.states)).sum()), len(given.states))
    cost = None
    if before is not None:
        cost = comparison.measure_cost(before, after, [claim.team], region, world, expert, held_out.EVALUATION_EPISODES)
    words = shlex.split(given.command) or ["maviper", "verify", runs.PROFILE_FILE]
    command = shlex.join([*words[:2], str(place), *words[3:]])
    shares = failures(before), failures(after if whole else None)
    return Outcome(given, region, after, before, reason, learned, shares, cost, command)


def report_file(profile: Path) -> Path:
    """Where the report of a profile lies: beside it, under its name where that is the user's."""
    return profile.with_name(COST_FILE if profile.name == runs.PROFILE_FILE else f"{profile.stem}.{COST_FILE}")
