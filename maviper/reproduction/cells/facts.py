"""What a cell tells beside its episodes: sizes, importances, the exact share of violating states, learning curves.

Does: gathers numbers that belong to an expert or a profile as plain data.
Assumes: on-policy states of the expert, the same for all of its profiles.
Does not: play the held-out episodes.
"""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from codegen import ir
from codegen.ir import Float32, PolicyProfile
from maviper.episodes import measures
from maviper.episodes.play import play, points
from maviper.evaluation.importances import importances
from maviper.experts.expert import Expert
from maviper.extraction.journal import Progress
from maviper.reproduction.cells.cell import Cell
from maviper.verification.ask import VerifyOptions, questions
from maviper.worlds import World
from verify.extent.violations import exact_share, violations
from verify.question import DecisionQuestion
from verify.zones.tables import BeyondZonesError

ON_POLICY_EPISODES = 400  # of the expert: 10,000 states in games of 25 steps
CLAIM, CLAIMED = "distinct_targets", {"physical-deception": "defenders"}  # game -> the team that it is about


def of_expert(expert: Expert, world: World) -> dict[str, Any]:
    """Where an expert comes from and how it learned, as its card says."""
    kept = ("algorithm", "recipe", "command", "learned", "steps", "critic_reward")
    card = {name: expert.card[name] for name in kept if name in expert.card}
    return {"world": world.name, "hash": expert.hash, "card": card}


def of_profile(
    cell: Cell, world: World, expert: Expert, profile: PolicyProfile, curve: Sequence[Progress]
) -> dict[str, Any]:
    """Everything that is told of a profile."""
    episodes = int(profile.provenance.training["rollouts"])
    trees = {
        policy.agent: {"leaves": len(ir.leaves(policy.tree)), "depth": int(ir.depth(policy.tree).max())}
        for policy in profile.agents
    }
    facts: dict[str, Any] = {"trees": trees, "training": dict(profile.provenance.training)}
    facts["importances"] = _importances(world, expert, profile)
    facts["curve"] = _curve(curve, episodes)
    if cell.game in CLAIMED:
        facts[CLAIM] = _violating(profile, CLAIMED[cell.game])
    return facts


def _curve(curve: Sequence[Progress], episodes: int) -> list[dict[str, Any]]:
    """Every round, with the rollout episodes up to it; `part` counts agents that are extracted one after the other."""
    rounds: list[dict[str, Any]] = []
    for each in curve:
        part = rounds[-1]["part"] + (each.done == 1) if rounds else 0
        rounds.append({"part": part, "episodes": each.done * episodes, **each.line})
    return rounds


def _violating(profile: PolicyProfile, team: str) -> dict[str, Any]:
    """The exact share of the start region in which the claim fails."""
    (asked,) = questions(profile, "", VerifyOptions(names=(CLAIM,), team=team))
    question = cast(DecisionQuestion, asked.question)
    try:
        failing = violations(question)
    except BeyondZonesError as error:
        return {"share": None, "reason": str(error)}
    if not all(one.complete for one in failing):
        return {"share": None, "reason": "not all violating zones are known"}
    share = exact_share(question, failing)
    if isinstance(share, str):
        return {"share": None, "reason": share}
    return {"share": float(share.value), "reason": "", "zones": sum(len(one.zones) for one in failing)}


def _importances(world: World, expert: Expert, profile: PolicyProfile) -> dict[str, Any]:
    """Agent -> by feature, how much a tree's splits on it part its decisions, and how often it is tested."""
    seen = _common_states(world, expert)
    by_agent: dict[str, Any] = {}
    for place, policy in enumerate(profile.agents):
        told = importances(policy, seen[place])
        names = [feature.name for feature in policy.features]
        by_agent[policy.agent] = {
            "impurity": dict(zip(names, map(float, told.decrease), strict=True)),
            "tested": dict(zip(names, map(float, told.tested), strict=True)),
        }
    return by_agent


def _common_states(world: World, expert: Expert) -> tuple[Float32, ...]:
    """Returns each agent's observations in the expert's own episodes, [n, n_features]."""
    seeds = np.arange(measures.ON_POLICY_SEEDS, measures.ON_POLICY_SEEDS + ON_POLICY_EPISODES)
    return points(play(world, [expert] * len(world.agents), world.start_from_seeds(seeds)))[0]
