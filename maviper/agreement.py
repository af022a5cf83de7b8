"""Compiling a profile: text, then the proof by replay that text, profile and learned tree decide alike.

Does: emits the targets and joins codegen's self-check with on-policy observations and whole episodes.
Assumes: the profile's world is one of ours; otherwise on-policy checks are reported as skipped.
Does not: write files.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from codegen import ir, selfcheck
from codegen.compiled import CompiledC, find_compiler
from codegen.errors import DisagreementError, InputError
from codegen.lower import AUTO, lower
from codegen.policy_json import content_hash, layout
from codegen.selfcheck import Agreement, Report
from codegen.targets import USUAL, emit, smt
from maviper.evaluate import metrics
from maviper.evaluate.play import Controller, Episodes, Policies, play, tree_policies
from maviper.fidelity import Fidelity, fidelity
from maviper.worlds import ParticleWorld, World, built_in
from maviper.worlds.world import world_name

SOLVER_ROWS = 1_000  # an agent; a solver takes milliseconds each
BEFORE_REPAIR = "profile before repair"  # in the provenance of a repaired profile
NO_WORLD = "no world of this version has the profile's spec, agents, features and actions"
ON_POLICY_EPISODES = 4_000  # of 25 steps: 100,000 observations an agent


@dataclass(frozen=True)
class Compiled:
    """The files (name -> text; bytes of targets that are none) and what was compared before they were handed out."""

    files: Mapping[str, str | bytes]
    report: Report
    faithful: tuple[Fidelity, ...] = ()  # how far each tree acts as the expert; nothing where nobody has the expert

    @property
    def complete(self) -> bool:
        """Whether nothing had to be skipped."""
        return not self.report.skipped


def compile_profile(
    profile: ir.PolicyProfile,
    targets: Iterable[str] = USUAL,
    prefix: str | None = None,
    style: str = AUTO,
) -> Compiled:
    """Emits `targets` and replays them, tolerance zero. On any difference DisagreementError, and no files."""
    ir.ensure(profile)
    files = emit(profile, targets, prefix, style)
    stem = lower(profile, prefix).prefix
    report = selfcheck.check_files(profile, files, prefix, style=style)
    agreements, skipped = list(report.agreements), list(report.skipped)
    faithful: tuple[Fidelity, ...] = ()
    # trees that were changed after they were grown, by a repair or for a region, have no such form any more
    changed = profile.region is not None or BEFORE_REPAIR in profile.provenance.training
    missing = [policy.agent for policy in profile.agents if policy.grown is None and not changed]
    if missing:
        skipped.append(f"the tree as grown: the profile does not hold it for {', '.join(missing)}")
    world = matching_world(profile)
    if world is None:
        skipped.append(f"on-policy observations and episodes: {NO_WORLD}")
    else:
        episodes = on_policy(profile, world)
        faithful = fidelity(profile, world, episodes)
        agreements += _grown(profile, episodes)
        header = files.get(f"{stem}.h")
        if isinstance(header, str) and report.compiler:
            agreements += _driven(profile, world, header, prefix, episodes)
    definitions = files.get(f"{stem}.smt2")
    if isinstance(definitions, str):
        agreements += asked(profile, definitions, prefix)
    checked = Report(tuple(agreements), tuple(skipped), report.compiler).ensure()
    files |= {f"{stem}.agreement.json": evidence(profile, checked, faithful)}
    return Compiled(files, checked, faithful)


def asked(profile: ir.PolicyProfile, definitions: str, prefix: str | None) -> list[Agreement]:
    """What Z3 finds the functions to be at boundaries and special values."""
    from verify.solve import false_facts

    model = lower(profile, prefix)
    found = []
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        rows = selfcheck.observations(policy, random=1_000)
        rows = rows[:: 1 + len(rows) // SOLVER_ROWS]
        wanted = ir.act(policy, rows)
        wrong = false_facts(definitions, smt.facts(model, agent, rows, wanted))
        first = f"Z3 denies {smt.facts(model, agent, rows, wanted)[wrong[0]]}" if wrong else ""
        found.append(Agreement("smt", policy.agent, len(rows), len(wrong), first))
    return found


def matching_world(profile: ir.PolicyProfile) -> ParticleWorld | None:
    """Our world with exactly the profile's spec, agents, teams, features and actions, or None."""
    try:
        world = built_in(world_name(profile.world))
    except InputError:  # another's world, or options of another version
        return None
    return world if plays(profile, world) else None


def plays(profile: ir.PolicyProfile, world: World) -> bool:
    """Whether a world has exactly the profile's spec, agents, teams, features and actions."""
    ours = [
        (agent, world.team_of(agent), features, actions)
        for agent, features, actions in zip(world.agents, world.features, world.actions, strict=True)
    ]
    theirs = [(policy.agent, policy.team, policy.features, policy.actions) for policy in profile.agents]
    return world.spec == profile.world and ours == theirs


def on_policy(profile: ir.PolicyProfile, world: ParticleWorld, driver: Controller | None = None) -> Episodes:
    """Episodes of the profile's own trees, or the same episodes driven by `driver`."""
    seeds = range(metrics.ON_POLICY_SEEDS, metrics.ON_POLICY_SEEDS + ON_POLICY_EPISODES)
    controller = tree_policies(profile.agents) if driver is None else driver
    return play(world, [controller] * len(profile.agents), world.start_from_seeds(seeds))


def _grown(profile: ir.PolicyProfile, episodes: Episodes) -> list[Agreement]:
    return [
        selfcheck.check_grown(policy, seen.reshape(-1, seen.shape[-1]))
        for policy, seen in zip(profile.agents, episodes.observations, strict=True)
        if policy.grown is not None
    ]


def _driven(
    profile: ir.PolicyProfile, world: ParticleWorld, header: str, prefix: str | None, episodes: Episodes
) -> list[Agreement]:
    """The same episodes, driven by the compiled C: every action and position must be the same."""
    compiler = find_compiler()
    assert compiler is not None
    with CompiledC(header, lower(profile, prefix), compiler) as compiled:
        driver = Policies([partial(compiled.act, policy.agent) for policy in profile.agents])
        again = on_policy(profile, world, driver)
    if any(a.position.tobytes() != b.position.tobytes() for a, b in zip(again.states, episodes.states, strict=True)):
        raise DisagreementError(
            "episodes driven by the compiled C take another course", "", "this is a bug; nothing was written"
        )
    found = []
    for agent, policy in enumerate(profile.agents):
        rows = episodes.observations[agent].reshape(-1, len(policy.features))
        wanted, given = episodes.actions[..., agent].ravel(), again.actions[..., agent].ravel()
        found.append(selfcheck.compare("episodes driven by c", policy, rows, np.asarray(wanted, np.int32), given))
    return found


def evidence(profile: ir.PolicyProfile, report: Report, faithful: Sequence[Fidelity] = ()) -> str:
    """What was compared, and how far the trees act as their expert, as a JSON text to keep beside the code."""
    rows: list[dict[str, Any]] = [
        {"target": item.target, "agent": item.agent, "observations": item.observations, "differences": item.differences}
        for item in report.agreements
    ]
    document = {"profile": content_hash(profile), "agreement": rows, "skipped": list(report.skipped)}
    return layout(document | {"expert": [item.document() for item in faithful]}) + "\n"
