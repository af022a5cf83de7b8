"""Repair as a command: guard leaves until a claim is proved, and say what that costs.

Does: hands `verify.repair` the states that the team meets, has both engines decide about the result, measures the team
  before and after in the same held-out episodes, writes profile, certificate, report and costs.
Assumes: the profile's world is one of ours; otherwise play is not measured, and said so.
Does not: choose guards, or decide verdicts.
"""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
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
from maviper.evaluate import metrics
from maviper.evaluate.metrics import Estimate, Mean, estimate, shown
from maviper.evaluate.play import Controller, rollout, tree_policies
from maviper.evaluate.players import Player, shipped_expert
from maviper.evaluation import MOST_EPISODES
from maviper.extract.outcome import evaluation
from maviper.questions import command, with_option_names
from maviper.verification import exit_code, say_results
from maviper.worlds import Measure, ParticleWorld, WorldState
from verify.properties import Property, find_property
from verify.repair import Repair, repair
from verify.shares import SAMPLE_SEED, SAMPLES, Share
from verify.spec import Region
from verify.world import chosen, sample

COST_FILE = "repair.json"
PARAMETERS = ("margin", "radius", "landmarks")


@dataclass(frozen=True)
class Compared:
    """A measure of the team in the same episodes: before, after, and the mean difference."""

    measure: Measure
    before: Estimate
    after: Estimate
    difference: Mean


@dataclass(frozen=True)
class Cost:
    """What a repair costs. States met are of whole episodes, and so not independent; None where none can be played."""

    uniform: Share  # of the region's states: some agent's action changes
    met: Share | None  # of the states that the team met before, in the held-out episodes
    opponents: str
    compared: tuple[Compared, ...] = ()


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
    cost = measured(before, after, claim, region, world, expert, episodes)
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


def measured(
    before: ir.PolicyProfile,
    after: ir.PolicyProfile,
    claim: Property,
    region: Region,
    world: ParticleWorld | None,
    expert: Player | None,
    episodes: int,
) -> Cost:
    """What a repair costs, in play against the expert where it is shipped, else against the team's own opponents."""
    uniform = _changed(before, after, claim, sample(region, before.world, SAMPLES, SAMPLE_SEED)[0])
    if world is None:
        return Cost(uniform, None, agreement.NO_WORLD)
    seeds = range(metrics.MEASUREMENT_SEEDS, metrics.MEASUREMENT_SEEDS + episodes)
    others: Controller = tree_policies(before.agents) if expert is None else expert.controller
    tables, met = [], None
    for profile in (before, after):
        own = tree_policies(profile.agents)
        lineup = [own if policy.team == claim.team else others for policy in profile.agents]
        played = rollout(world, lineup, seeds)
        parts = [metrics.table(world, each) for each in played]
        tables.append({m: np.concatenate([part[m] for part in parts]) for m in parts[0] if m.team == claim.team})
        if met is None:
            states = [WorldState.joined(each.states[:-1]) for each in played]
            met = _changed(before, after, claim, np.concatenate([world.coordinates(state) for state in states]))
    compared = [
        Compared(
            measure, estimate(measure, old), estimate(measure, tables[1][measure]), _mean(tables[1][measure] - old)
        )
        for measure, old in tables[0].items()
    ]
    return Cost(uniform, met, "the profile's own trees" if expert is None else str(expert), tuple(compared))


def _mean(values: np.ndarray) -> Mean:
    found = estimate(Measure("", "difference", share=False), values)
    assert isinstance(found, Mean), found
    return found


def _changed(before: ir.PolicyProfile, after: ir.PolicyProfile, claim: Property, coordinates: np.ndarray) -> Share:
    """In how many states some agent of the team acts otherwise."""
    other = np.zeros(len(coordinates), dtype=bool)
    for old, new in zip(before.team(claim.team), after.team(claim.team), strict=True):
        other |= chosen(old, coordinates, before.world) != chosen(new, coordinates, before.world)
    return Share(int(other.sum()), len(other))


def _sizes(profile: ir.PolicyProfile, found: Repair) -> dict[str, tuple[int, int]]:
    """Agent -> its leaves and depth."""
    trees = {agent: profile.policy(agent).tree for agent in found.roles}
    return {agent: (len(ir.leaves(tree)), int(ir.depth(tree).max())) for agent, tree in trees.items()}


def _say(before: ir.PolicyProfile, found: Repair, cost: Cost, console: Console) -> None:
    if not found.guards:
        console.line("repaired", "nothing: no state of the region violates the property")
        return
    leaves = "leaf" if len(found.guards) == 1 else "leaves"
    roles = ", ".join(f"{agent} for {landmark}" for agent, landmark in found.roles.items())
    console.line("repaired", f"{len(found.guards)} {leaves} guarded, {roles}")
    old, new = _sizes(before, found), _sizes(found.profile, found)
    parts = []
    for agent in found.roles:
        leaves, depth = (f"{was} to {now}" for was, now in zip(old[agent], new[agent], strict=True))
        parts.append(f"{agent} {leaves} leaves, depth {depth}")
    console.line("", "; ".join(parts))
    met = f"{cost.met} of the states met, " if cost.met else ""
    console.line("changed", f"some action in {met}{cost.uniform} of the region's states")
    for one in cost.compared:
        low, high = one.difference.interval
        told = (
            f"{shown(one.before)} to {shown(one.after)}, difference {one.difference.value:.3f} [{low:.3f}, {high:.3f}]"
        )
        console.line("measured", f"{one.measure.team} {one.measure.name}: {told}, {one.difference.count} episodes")


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
    sizes = _sizes(before, found), _sizes(after, found)
    names = ("leaves", "depth")
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
        "trees": {
            agent: {
                "before": dict(zip(names, sizes[0][agent], strict=True)),
                "after": dict(zip(names, sizes[1][agent], strict=True)),
            }
            for agent in found.roles
        },
        "changed": {"region": cost.uniform.document(), "met": None if cost.met is None else cost.met.document()},
        "opponents": cost.opponents,
        "measures": [
            {
                "measure": one.measure.name,
                "episodes": one.difference.count,
                "before": _interval(one.before),
                "after": _interval(one.after),
                "difference": _interval(one.difference),
            }
            for one in cost.compared
        ],
    }


def _interval(found: Estimate) -> dict[str, float]:
    low, high = found.interval
    return {"value": round(found.value, 6), "low": round(low, 6), "high": round(high, 6)}
