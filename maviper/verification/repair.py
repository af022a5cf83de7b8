"""Repair: guard leaves until a claim, or each claim of a world file, is proved, and measure what that costs.

Does: hands verify/repair.py the states that the team meets, has both engines decide about the result, measures
  the team before and after in the same held-out episodes; in a stated system has the claims asked after each
  counterexample (verify/reach/guards.py chooses guards there); renders profile, certificates, report and costs.
Assumes: a game that is one of ours; otherwise play is not measured, and said so. Of a system claims about regions in
  which episodes stay; play is not measured.
Does not: choose guards, decide verdicts, print or write files.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Any, cast

from codegen import ir, policy_json
from codegen.deciding import VERIFIER, ensure_plain
from codegen.errors import InputError
from codegen.form import layout
from codegen.policy_json import content_hash
from codegen.profiles import ensure
from codegen.rows import Shown
from codegen.wording import visible
from maviper.claims import Claim, complete_parameters, name_of, parameters_of
from maviper.compilation.compile import BEFORE_REPAIR
from maviper.evaluation.comparison import Cost, measure_cost, sizes_document
from maviper.evaluation.held_out import evaluation
from maviper.evaluation.players import Player, find_shipped
from maviper.evaluation.run import MAX_EPISODES
from maviper.files import kinds, outputs, runs
from maviper.files.profiles import find_region
from maviper.options import RepairOptions, complete_options, make_request, table_of
from maviper.verification.ask import VerifyOptions, command, number
from maviper.verification.diff import collect_states
from maviper.verification.run import Verified, certificate_files, digests, report_files, verify_claims
from maviper.verification.stated import StatedWorld
from maviper.worlds import ParticleWorld
from maviper.worlds.matching import UNREPAIRED, ensure_places, matching_places
from verify.claims.catalogue import find_property, read_call
from verify.claims.decisions import DecisionClaim
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.region import Region
from verify.claims.region_files import region_toml
from verify.question import Budgets, Question
from verify.reach.guards import Answer, Guard, hold, insert
from verify.repair import Repair, refuse_repair, repair
from verify.reports import report
from verify.result import AnyResult, Verdict
from verify.subjects import Game
from verify.systems.claims import SystemClaim
from verify.systems.files import MAX_BYTES
from verify.systems.system import ensure_in_steps

COST_FILE = "repair.json"
PARAMETERS = ("margin", "radius", "landmarks")


def request(claim: str | Claim, given: RepairOptions) -> Any:
    """The options of a repair, those that the claim says among them, with exact numbers. InputError for one that cannot
    be used, and for an object of a claim that cannot be repaired.
    """
    options = complete_parameters(claim, given)
    if name_of(claim) in EPISODE_CLAIMS or not parameters_of(claim).keys() <= table_of(RepairOptions).keys():
        raise refuse_repair(name_of(claim))
    exact = {name: number(options.get(name), name) for name in ("margin", "radius")}
    asked = make_request(RepairOptions, {**options, **exact})
    episodes, most = asked.episodes, asked.max_depth
    if not 1 <= episodes <= MAX_EPISODES:
        raise InputError(f"the number of episodes must be from 1 to {MAX_EPISODES}, not {episodes}", "--episodes")
    if most is not None and not 1 <= most <= ir.MAX_DEPTH:
        raise InputError(f"the depth must be from 1 to {ir.MAX_DEPTH}, not {most}", "--max-depth")
    return asked


def request_call(written: str, given: RepairOptions) -> tuple[str, Any]:
    """The name of the claim of a call such as `own_target(radius=0.2)`, and the options of its repair."""
    call = read_call(written)
    name = call.pop("name")
    for key in call:
        if key not in (*PARAMETERS, "team"):
            what = f"a repair reads no {key} of a claim"
            raise InputError(what, "--claim", f"leave it out; {name} is repaired alone")
    said = {key: value for key, value in given.items() if value is not None}
    return name, request(name, cast("RepairOptions", said | call))


@dataclass(frozen=True, repr=False)
class Repaired(Shown):
    """A repair: what it was to prove, and, where it ended, the profile after it with its cost, results and files.

    For example:

        maviper.repair(team, claims.OwnTarget()).after
    """

    before: ir.PolicyProfile
    claim: DecisionClaim
    region: Region
    repair: Repair
    after: ir.PolicyProfile | None = None  #: None: no repair was found
    cost: Cost | None = None
    results: tuple[AnyResult, ...] = ()
    files: Mapping[str, str | bytes] = field(default_factory=dict[str, str | bytes])  #: name -> text

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each claim that was proved again."""
        return [row for result in self.results for row in result.rows]

    @property
    def told(self) -> list[str]:
        """One line, on whether a repair was found."""
        return [f"Repaired: {self.claim.shown}, region {self.region.name}: {'found' if self.after else 'not found'}"]

    @property
    def certificates(self) -> dict[str, str]:
        """The certificates among the files."""
        return certificate_files(self.results)


def repair_profile(
    before: ir.PolicyProfile, claimed: str | Claim, region_name: str, asked: Any, name: str = runs.PROFILE_FILE
) -> Repaired:
    """The repair of a profile, which a user calls `name`, by the property `claimed`, see `request`. InputError where it
    cannot be asked for.
    """
    ensure_plain(before, VERIFIER)
    ensure_places(before.world, chain.from_iterable(policy.features for policy in before.agents), UNREPAIRED)
    region = find_region(region_name, before)
    given = {name: getattr(asked, name) for name in PARAMETERS if getattr(asked, name) is not None}
    claim = find_property(name_of(claimed), before, asked.team, **given)
    if Path(region_name).name == runs.PROFILE_FILE or outputs.is_named(Path(region_name).name, outputs.REPAIR):
        raise InputError("the region file would be overwritten by a result", "--region", "give it another name")
    world, question = matching_places(before), Question(Game(before), claim, region, budgets=Budgets(option=""))
    outcome = repair(question, None if world is None else collect_states(before, world), asked.max_depth)
    unmeasured = Repaired(before, claim, region, outcome)
    if not outcome.ended:
        return unmeasured
    expert = None if world is None else find_shipped(before.provenance.expert, world)
    after = _with_provenance(unmeasured, world, expert)
    cost = measure_cost(before, after, claim.team, region, world, expert, asked.episodes)
    done = replace(unmeasured, after=after, cost=cost, results=tuple(verify_claims([question.of(after)])))
    verified = command(runs.PROFILE_FILE, Question(Game(after), claim, region))
    made = ["maviper", "repair", name, *shlex.split(verified)[3:], "--episodes", str(asked.episodes)]
    made += ["--max-depth", str(asked.max_depth)] if asked.max_depth is not None else []
    files: dict[str, str | bytes] = {
        runs.PROFILE_FILE: policy_json.dumps(after),
        COST_FILE: layout(document(done, shlex.join(made))) + "\n",
    }
    files |= region_text(region_name, before)
    facts = report.document(after, done.results, [verified], digests(files))
    return replace(done, files=files | report_files(facts) | done.certificates)


def region_text(name: str, profile: ir.PolicyProfile) -> dict[str, str]:
    """The region's file as results have it, name -> text: none where it is the start region."""
    return {} if name == "start" else {Path(name).name: region_toml(find_region(name, profile))}


def _with_provenance(done: Repaired, world: ParticleWorld | None, expert: Player | None) -> ir.PolicyProfile:
    """The repaired profile, which says what was done to which, with measures of its own."""
    before, repaired = done.before, done.repair
    if not repaired.guards:
        return before
    training = {
        **before.provenance.training,
        "repair": visible(f"{done.claim.name} of the {done.claim.team}, region {done.region.name}"),
        BEFORE_REPAIR: content_hash(before),
    }
    known = world is not None and expert is not None
    rows = evaluation(world, repaired.profile.agents, expert.controller) if known else {}  # type: ignore[union-attr, arg-type]
    return ensure(replace(repaired.profile, provenance=replace(before.provenance, training=training, evaluation=rows)))


def document(done: Repaired, made: str) -> dict[str, Any]:
    """The repair and its cost as plain data; `made`: the command that made it."""
    before, after, repaired = done.before, done.after, done.repair
    assert after is not None and done.cost is not None
    return {
        "command": made,
        "profile_before": content_hash(before),
        "profile": content_hash(after),
        "property": done.claim.name,
        "team": done.claim.team,
        "region": done.region.name,
        "roles": dict(repaired.roles),
        "counterexamples": repaired.rounds,
        "guards": [
            {"agent": one.agent, "node": one.node, "landmark": one.landmark, "leaves": len(ir.leaves(one.tree))}
            for one in repaired.guards
        ],
        "trees": sizes_document(before, after, list(repaired.roles)),
        **done.cost.document(),
    }


SAMPLES = 16  # random episodes that may refute a claim before it is proved


@dataclass(frozen=True, repr=False)
class Guarded(Shown):
    """A repair in a stated system: guards, and, where all claims are proved, the team with them and its files.

    For example:

        maviper.repair(team, "world.toml").after
    """

    before: ir.PolicyProfile
    guards: tuple[Guard, ...]
    reason: str  #: why no repair was found; "": one was
    after: ir.PolicyProfile | None = None  #: None: no repair was found
    results: tuple[AnyResult, ...] = ()
    files: Mapping[str, str | bytes] = field(default_factory=dict[str, str | bytes])  #: name -> text
    certificates: Mapping[str, str] = field(default_factory=dict[str, str])  #: those among the files

    @property
    def guarded(self) -> list[str]:
        """The agents that got guards."""
        return list(dict.fromkeys(guard.agent for guard in self.guards))

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each claim that was proved."""
        return [row for result in self.results for row in result.rows]

    @property
    def told(self) -> list[str]:
        """The guards as rules, or why there is no repair."""
        return [f"Guarded: {self.reason or 'each claim is proved'}", *(guard.words for guard in self.guards)]


class _Asking:
    """Asks the claims of a world file; `results`: of the claims proved since the team last changed, by number."""

    def __init__(self, before: ir.PolicyProfile, options: VerifyOptions) -> None:
        self.options, self.stated = options, StatedWorld.of(before, options)
        self.results, self.first = dict[int, AnyResult](), -1
        self._origin, self._marked = self.stated.origin, _mark(before)

    def __call__(self, after: ir.PolicyProfile) -> Answer | None:
        """The first claim that is not proved, the one that failed last before others."""
        changed = after.agents != self._origin.agents
        self.stated = StatedWorld.of(replace(after, provenance=self._marked) if changed else after, self.options)
        self.results = dict[int, AnyResult]()
        asked = self.stated.asked
        last_ones_first = reversed(range(len(asked)))  # files tend to begin with what any tree keeps
        for place in sorted(last_ones_first, key=lambda place: place != self.first):
            question = asked[place].question
            sparing = cast("Question[SystemClaim]", question.spending(samples=SAMPLES))
            result = self.stated.answer(sparing, beside=False)
            if result.verdict is not Verdict.PROVED:
                self.first = place
                return Answer(result.claim, result.evidence.counterexample, result.reason)
            self.results[place] = replace(result, question=question)
        return None


def _mark(before: ir.PolicyProfile) -> Any:
    """The provenance of what is repaired: the same after each repair of a team, so that certificates stay valid."""
    first = before.provenance.training.get(BEFORE_REPAIR, content_hash(before))
    training = {**before.provenance.training, "repair": "guards in stated systems", BEFORE_REPAIR: first}
    return replace(before.provenance, training=training, evaluation={})


def ensure_unasked(region: str | Path, options: Mapping[str, Any]) -> None:
    """InputError for a region, or an option of `maviper repair`, that a repair by a world file does not read."""
    usual = {"region": "start", **complete_options(RepairOptions, {})}
    for name, value in {"region": str(region), **options}.items():
        if value is not None and value != usual[name]:
            flag = f"--{name.replace('_', '-')}"
            raise InputError(f"{flag} has no effect with a world file", flag, "leave it out; the file states regions")


def repair_stated(before: ir.PolicyProfile, world: Path, name: str = runs.PROFILE_FILE) -> Guarded:
    """The repair of a team, which a user calls `name`, by the claims of a world file. InputError for a team that tests
    sums, a file that cannot be used, and a system in continuous time.
    """
    ensure_plain(before, VERIFIER)
    if kinds.kind_of(runs.read(world, MAX_BYTES)) is kinds.CLAIMS:
        advice = "name one claim, such as distinct_targets; claims about a system stand in its world file"
        raise InputError("a repair takes no file of claims", str(world), advice)
    asking = _Asking(before, VerifyOptions(world=world))
    system = asking.stated.statement.system
    ensure_in_steps(system, "a repair")
    held = hold(asking.stated.origin, system, asking)
    if held.reason:
        return Guarded(before, held.guards, held.reason)
    marked = replace(before, provenance=_mark(before)) if held.guards else before
    after = ensure(insert(marked, held.guards))
    results = tuple(result for _, result in sorted(asking.results.items()))
    verified = Verified(after, tuple(asking.stated.asked), results, None, asking.stated)
    made = shlex.join(["maviper", "repair", name, "--claim", world.name])
    told = {
        "command": made,
        "profile_before": content_hash(before),
        "profile": content_hash(after),
        "counterexamples": held.rounds,
        "guards": [guard._asdict() for guard in held.guards],
        "trees": sizes_document(before, after, list(dict.fromkeys(guard.agent for guard in held.guards))),
    }
    files = {**verified.files, COST_FILE: layout(told) + "\n"}
    return Guarded(before, held.guards, "", after, results, files, verified.certificates)
