"""Repair as a command: guard leaves until a claim is proved, and say what that costs.

Does: hands `verify.repair` the states that the team meets, has both engines decide about the result, measures the team
  before and after in the same held-out episodes, writes profile, certificate, report and costs.
Assumes: the profile's world is one of ours; otherwise play is not measured, and said so.
Does not: choose guards, or decide verdicts.
"""

import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir, policy_json
from codegen.errors import ExitCode, InputError
from codegen.policy_json import content_hash
from maviper import agreement, load, runs
from maviper.certifying import certificate_files
from maviper.claims import find_region, report_files, verify_claims
from maviper.console import Console
from maviper.costs import Cost, measured, say_sizes, sizes_document
from maviper.evaluate.players import Player, shipped_expert
from maviper.evaluation import MOST_EPISODES
from maviper.extract.outcome import evaluation
from maviper.questions import command, with_option_names
from maviper.verification import exit_code, say_results
from maviper.worlds import ParticleWorld, WorldState
from verify.properties import Property, find_property
from verify.repair import Repair, repair
from verify.spec import Region

COST_FILE = "repair.json"
PARAMETERS = ("margin", "radius", "landmarks")


def repair_command(path: Path, options: Mapping[str, Any], console: Console) -> int:
    """The command `maviper repair`; returns its exit code."""
    output, episodes, most = options["output"], options["episodes"], options["max_depth"]
    if not 1 <= episodes <= MOST_EPISODES:
        raise InputError(f"the number of episodes must be from 1 to {MOST_EPISODES}, not {episodes}", "--episodes")
    if most is not None and not 1 <= most <= ir.MAX_DEPTH:
        raise InputError(f"the depth must be from 1 to {ir.MAX_DEPTH}, not {most}", "--max-depth")
    before = load(path)
    region = find_region(options["region"], before)
    given = {name: options[name] for name in PARAMETERS if options[name] is not None}
    with with_option_names():
        claim = find_property(options["name"], before, options["team"], **given)
    if Path(options["region"]).name in (runs.PROFILE_FILE, COST_FILE):
        raise InputError("the region file would be overwritten by a result", "--region", "give it another name")
    world = agreement.matching_world(before)
    found = repair(before, claim, region, None if world is None else met_states(before, world), most)
    if not found.ended:
        console.line("not repaired", f"{claim.name} of the {claim.team}, region {region.name}: {found.reason}")
        console.line("", f"{len(found.guards)} leaves were guarded; nothing was written")
        return ExitCode.INCONCLUSIVE
    expert = None if world is None else shipped_expert(before.provenance.expert, world)
    after = _with_provenance(before, found, claim, region, world, expert)
    cost = measured(before, after, claim.team, region, world, expert, episodes)
    _say(before, found, cost, console)
    runs.folder(output)
    asked = command(runs.PROFILE_FILE, claim, region.name)
    results = verify_claims(after, [(claim, region)])
    say_results(results, console)
    made = ["maviper", "repair", path.name, *shlex.split(asked)[3:], "--episodes", str(episodes)]
    made += ["--max-depth", str(most)] if most is not None else []
    files: dict[str, str | bytes] = {
        runs.PROFILE_FILE: policy_json.dumps(after),
        COST_FILE: policy_json.layout(document(before, after, found, claim, region, cost, shlex.join(made))) + "\n",
    }
    files |= {} if options["region"] == "start" else {Path(options["region"]).name: region.toml()}
    files |= report_files(after, results, [asked], files) | certificate_files(results)
    for name, text in files.items():
        runs.write(output / name, text)
    console.line("wrote", f"{output / runs.PROFILE_FILE}  id {content_hash(after)[:16]}")
    for name in certificate_files(results):
        console.line("certificate", f"{output / name}; maviper check {output / name}")
    if most is not None and found.depth > most:
        console.line("too deep", f"depth {found.depth}, {most} was asked for; extract with a smaller --max-depth")
        return ExitCode.VIOLATED
    return exit_code(results)


def met_states(profile: ir.PolicyProfile, world: ParticleWorld) -> np.ndarray:
    """Coordinates [n, n_coordinates] of the states in which the profile's agents decide, playing one another."""
    return world.coordinates(WorldState.joined(agreement.on_policy(profile, world).states[:-1]))


def _with_provenance(
    before: ir.PolicyProfile,
    found: Repair,
    claim: Property,
    region: Region,
    world: ParticleWorld | None,
    expert: Player | None,
) -> ir.PolicyProfile:
    """The repaired profile, which says what was done to which, with measures of its own."""
    if not found.guards:
        return before
    training = {
        **before.provenance.training,
        "repair": f"{claim.name} of the {claim.team}, region {region.name}",
        agreement.BEFORE_REPAIR: content_hash(before),
    }
    known = world is not None and expert is not None
    rows = evaluation(world, found.profile.agents, expert.controller) if known else {}  # type: ignore[union-attr, arg-type]
    return ir.ensure(replace(found.profile, provenance=replace(before.provenance, training=training, evaluation=rows)))


def _say(before: ir.PolicyProfile, found: Repair, cost: Cost, console: Console) -> None:
    if not found.guards:
        console.line("repaired", "nothing: no state of the region violates the property")
        return
    leaves = "leaf" if len(found.guards) == 1 else "leaves"
    roles = ", ".join(f"{agent} for {landmark}" for agent, landmark in found.roles.items())
    console.line("repaired", f"{len(found.guards)} {leaves} guarded, {roles}")
    console.line("", say_sizes(before, found.profile, list(found.roles)))
    cost.say(console)


def document(
    before: ir.PolicyProfile,
    after: ir.PolicyProfile,
    found: Repair,
    claim: Property,
    region: Region,
    cost: Cost,
    made: str,
) -> dict[str, Any]:
    """The repair and its cost as plain data."""
    return {
        "command": made,
        "profile_before": content_hash(before),
        "profile": content_hash(after),
        "property": claim.name,
        "team": claim.team,
        "region": region.name,
        "roles": dict(found.roles),
        "counterexamples": found.rounds,
        "guards": [
            {"agent": one.agent, "leaf": one.leaf, "landmark": one.landmark, "leaves": len(ir.leaves(one.tree))}
            for one in found.guards
        ],
        "trees": sizes_document(before, after, list(found.roles)),
        **cost.document(),
    }
