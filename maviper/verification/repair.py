"""Repair: guard leaves until a claim, or all claims of a file, are proved, and measure what that costs.

Does: hands verify/repair.py the states that the team meets, and what else is to hold; has both engines decide about the
  result, measures the team before and after in the same held-out episodes, renders profile, certificates, report and
  costs.
Assumes: the profile's world is one of ours; otherwise play is not measured, and said so.
Does not: choose guards, decide verdicts, print or write files.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
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
from maviper.options import RepairOptions, make_request, table_of
from maviper.verification.ask import Asked, VerifyOptions, command, number, questions
from maviper.verification.diff import collect_states
from maviper.verification.run import certificate_files, digests, report_files, verdicts, verify_claims
from maviper.worlds import ParticleWorld
from maviper.worlds.matching import UNREPAIRED, ensure_places, matching_places
from verify.claims.catalogue import find_property, read_call
from verify.claims.decisions import DecisionClaim
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.region import Region
from verify.claims.region_files import region_toml
from verify.question import Budgets, DecisionQuestion, Question
from verify.repair import REPAIRABLE, Repair, is_repairable, refuse_repair, repair
from verify.reports import report
from verify.result import AnyResult, Verdict
from verify.subjects import Game

COST_FILE = "repair.json"
PARAMETERS = ("margin", "radius", "landmarks")
MAX_BYTES = 2**20  # of a file of claims, or a world file


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
    claim: DecisionClaim  #: of a file the first one that guards are for
    region: Region  #: in which the cost is measured: the claim's, or that of a file's claims which name none
    repair: Repair
    after: ir.PolicyProfile | None = None  #: None: no repair was found
    cost: Cost | None = None
    results: tuple[AnyResult, ...] = ()
    files: Mapping[str, str | bytes] = field(default_factory=dict[str, str | bytes])  #: name -> text
    file: str = ""  #: the name of the file of claims; "": one claim was asked for

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each claim that was proved again."""
        return [row for result in self.results for row in result.rows]

    @property
    def subject(self) -> str:
        """The claims to prove, in words."""
        of_one = f"{self.claim.name} of the {self.claim.team}, region {self.region.name}"
        return f"the claims of {self.file}" if self.file else of_one

    @property
    def told(self) -> list[str]:
        """One line, on whether a repair was found."""
        return [f"Repaired: {self.subject}: {'found' if self.after else 'not found'}"]

    @property
    def certificates(self) -> dict[str, str]:
        """The certificates among the files."""
        return certificate_files(self.results)


def ensure_of_file(asked: Any) -> None:
    """InputError for parameters of a claim, and for a team, where a file states the claims."""
    for name in (*PARAMETERS, "team"):
        if getattr(asked, name) is not None:
            raise InputError(f"--{name} has no effect with a file of claims", f"--{name}", "leave it out")


def find_claims(claim: str | Path | Claim) -> Path | None:
    """The file of claims that is named so; None: it is no file, or one of another kind, such as a world file."""
    path = Path(claim) if isinstance(claim, Path) or (isinstance(claim, str) and claim.endswith(".toml")) else None
    return path if path is not None and kinds.kind_of(runs.read(path, MAX_BYTES)) is kinds.CLAIMS else None


def repair_profile(
    before: ir.PolicyProfile, claimed: str | Claim | Path, region_name: str, asked: Any, name: str = runs.PROFILE_FILE
) -> Repaired:
    """The repair of a profile, which a user calls `name`, by the property `claimed`, see `request`, or by all claims of
    a file. InputError where it cannot be asked for.
    """
    ensure_plain(before, VERIFIER)
    ensure_places(before.world, chain.from_iterable(policy.features for policy in before.agents), UNREPAIRED)
    region = find_region(region_name, before)
    if Path(region_name).name == runs.PROFILE_FILE or outputs.is_named(Path(region_name).name, outputs.REPAIR):
        raise InputError("the region file would be overwritten by a result", "--region", "give it another name")
    if isinstance(claimed, Path):
        ensure_of_file(asked)
        posed, file = (
            questions(before, runs.PROFILE_FILE, VerifyOptions(file=claimed, region=region_name)),
            claimed.name,
        )
    else:
        given = {name: getattr(asked, name) for name in PARAMETERS if getattr(asked, name) is not None}
        claim = find_property(name_of(claimed), before, asked.team, **given)
        question = Question(Game(before), claim, region, budgets=Budgets(option=""))
        posed, file = [Asked(question, command(runs.PROFILE_FILE, question))], ""
    mended = [_sparing(each) for each in posed if is_repairable(each.claim)]
    if not mended:
        raise refuse_repair(", ".join(dict.fromkeys(each.claim.shown for each in posed)))
    held = [each for each in posed if not is_repairable(each.claim)]
    world = matching_places(before)
    visited = None if world is None else collect_states(before, world)
    outcome = repair(mended[0], visited, asked.max_depth, mended[1:], lambda after: _tell_broken(held, after))
    unmeasured = Repaired(before, mended[0].claim, region, outcome, file=file)
    if not outcome.ended:
        return unmeasured
    expert = None if world is None else find_shipped(before.provenance.expert, world)
    after = _with_provenance(unmeasured, world, expert)
    teams = list(dict.fromkeys(each.claim.team for each in mended))
    cost = measure_cost(before, after, teams, region, world, expert, asked.episodes)
    results = verify_claims([each.question.of(after) for each in posed])
    done = replace(unmeasured, after=after, cost=cost, results=tuple(results))
    verified = [each.command for each in posed]
    made = ["maviper", "repair", name]
    made += ["--claim", file, "--region", region.name] if file else shlex.split(verified[0])[3:]
    made += ["--episodes", str(asked.episodes)]
    made += ["--max-depth", str(asked.max_depth)] if asked.max_depth is not None else []
    files: dict[str, str | bytes] = {
        runs.PROFILE_FILE: policy_json.dumps(after),
        COST_FILE: layout(document(done, shlex.join(made))) + "\n",
    }
    files |= region_text(region_name, before)
    facts = report.document(after, done.results, verified, digests(files))
    return replace(done, files=files | report_files(facts) | done.certificates)


def _sparing(asked: Asked) -> DecisionQuestion:
    """A question whose hints name no option, since a repair has none for its limits."""
    question = cast("DecisionQuestion", asked.question)
    return replace(question, budgets=replace(question.budgets, option=""))


def _tell_broken(held: Sequence[Asked], after: ir.PolicyProfile) -> str:
    """Which of the claims that guards are not for is not proved of a repaired team, and why; "": all are."""
    for each in held:
        ((verdict, reason),) = verdicts([each.question.of(after)])
        if verdict is Verdict.PROVED:
            continue
        ((first, _),) = verdicts([each.question])
        said = f"{each.claim.shown} is {first.value} without guards and {verdict.value} with them"
        beyond = "" if first is Verdict.PROVED else f"; only {' and '.join(REPAIRABLE)} can be repaired"
        return f"{said}{f' ({reason})' if reason else ''}{beyond}"
    return ""


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
        "repair": visible(done.subject),
        BEFORE_REPAIR: content_hash(before),
    }
    known = world is not None and expert is not None
    rows = evaluation(world, repaired.profile.agents, expert.controller) if known else {}  # type: ignore[union-attr, arg-type]
    return ensure(replace(repaired.profile, provenance=replace(before.provenance, training=training, evaluation=rows)))


def _told(result: AnyResult) -> dict[str, Any]:
    """A claim that was proved again, as plain data."""
    return {"property": result.claim.name, "team": result.claim.team, "region": result.region.name}


def document(done: Repaired, made: str) -> dict[str, Any]:
    """The repair and its cost as plain data; `made`: the command that made it."""
    before, after, repaired = done.before, done.after, done.repair
    assert after is not None and done.cost is not None
    return {
        "command": made,
        "profile_before": content_hash(before),
        "profile": content_hash(after),
        **({"claims": [_told(result) for result in done.results]} if done.file else _told(done.results[0])),
        "roles": dict(repaired.roles),
        "counterexamples": repaired.rounds,
        "guards": [
            {"agent": one.agent, "node": one.node, "landmark": one.landmark, "leaves": len(ir.leaves(one.tree))}
            for one in repaired.guards
        ],
        "trees": sizes_document(before, after, list(repaired.roles)),
        **done.cost.document(),
    }
