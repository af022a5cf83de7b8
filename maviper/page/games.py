"""What a page says of a game: a paragraph about it, ranges for sliders, an episode to go through.

Does: words a profile's world; chooses ranges in which every test of a tree can be crossed; records one episode of the
  trees where the world is at hand.
Assumes: a checked profile, and a world that it plays.
Does not: write HTML or play in the browser.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from codegen import ir
from codegen.importers.reading import find_uncompared
from codegen.ir import CONSTANT, Floats
from codegen.wording import NO_UNIT, format_count
from maviper.episodes import measures
from maviper.episodes.play import play, tree_policies
from maviper.worlds import World

BOUNDED = 1e6  # a range that is wider on one side says nothing of what is seen
MARGIN = 0.5  # of the thresholds' span, beyond them
MAX_NAMED = 8  # features or actions that a paragraph names


@dataclass(frozen=True)
class Recorded:
    """An episode of the trees: what each agent observed before each step, [steps, n_features] each, and its words."""

    seen: tuple[Floats, ...]
    label: str


def record_episode(profile: ir.PolicyProfile, world: World) -> Recorded:
    """One on-policy episode, of the first seed that such episodes start from."""
    controller = tree_policies(profile.agents)
    seed = measures.ON_POLICY_SEEDS
    episodes = play(world, [controller] * len(profile.agents), world.start_from_seeds([seed]))
    steps = int(episodes.alive[:, 0].any(axis=1).sum())
    seen = tuple(rows[:steps, 0] for rows in episodes.observations)
    figures = [
        f"{measure.name} {value:.4g}"
        for measure, value in zip(world.measures, episodes.values[:, 0].tolist(), strict=True)
    ]
    return Recorded(
        seen, f"The recorded episode, of seed {seed}, took {format_count(steps, 'step')}: {', '.join(figures)}."
    )


def about(profile: ir.PolicyProfile) -> str:
    """Describes the game, in a paragraph."""
    world, teams = profile.world, list(dict.fromkeys(policy.team for policy in profile.agents))
    agents = [policy.agent for policy in profile.agents]
    who = f"{len(agents)} agents" if len(agents) > 1 else "one agent" + f", {agents[0]}" * (agents[0] != "agent")
    if len(teams) > 1:
        who += f" in {len(teams)} teams ({', '.join(teams)})"
    first = profile.agents[0]
    alike = all((each.actions, each.outputs) == (first.actions, first.outputs) for each in profile.agents)
    observed = {len(policy.features) for policy in profile.agents}
    each = "It" if len(agents) == 1 else "Each"
    sees = f"{each} observes {format_count(max(observed), 'number')}" if len(observed) == 1 else "They observe"
    sees += f" ({_list_names([feature.name for feature in first.features])})" if len(agents) == 1 else ""
    if len(observed) > 1:
        sees += f" {min(observed)} to {max(observed)} numbers"
    does = f"and {'' if len(observed) == 1 else 'each '}{_does(first, alike)}"
    moment = f"every {world.dt:g} s" if world.dt else "at each step"
    length = f", for at most {format_count(world.episode_steps, 'step')}" if world.episode_steps > 1 else ""
    places = f" and {format_count(len(world.landmarks), 'landmark')}" if world.landmarks else ""
    # another's environment is known by its own name, ours by the name that commands take
    name = world.reference if ":" in world.reference else world.name
    game = f"{name} is a game of {who}{places}"
    if profile.provenance.algorithm == "imported" and not world.reference:
        game = f"An imported tree for {who}" if len(agents) == 1 else f"Imported trees for {who}"
    trusted = [f" The source of {agent} was not compared." for agent in find_uncompared(profile)]
    return f"{game}. {sees} {does} {moment}{length}.{''.join(trusted)}"


def _does(policy: ir.AgentPolicy, alike: bool) -> str:
    """Describes what an agent chooses or gives; `alike`: as do all others."""
    if not alike:
        return "chooses an action or gives numbers" if policy.outputs else "chooses an action"
    if not policy.outputs:
        names = _list_names([action.name for action in policy.actions])
        return f"chooses one of {format_count(len(policy.actions), 'action')} ({names})"
    named = [each.name + (f" in {each.unit}" if each.unit not in NO_UNIT else "") for each in policy.outputs]
    return f"gives {format_count(len(policy.outputs), 'number')} ({_list_names(named)})"


def _list_names(names: Sequence[str]) -> str:
    shown = list(names[:MAX_NAMED])
    return ", ".join(shown) + (", ..." if len(names) > MAX_NAMED else "")


def _turning(policy: ir.AgentPolicy, place: int) -> Iterator[float]:
    """Where a feature alone, all others being 0, turns a test of a sum, or takes an output to one of its bounds."""
    tree, width = policy.tree, len(policy.features)
    tested = [
        (tree.sums[int(tree.feature[node]) - width], float(tree.threshold[node]))
        for node in ir.splits(tree)
        if tree.feature[node] >= width
    ]
    for vector in tree.vectors:
        for each, output in zip(vector, policy.outputs, strict=True):
            tested += [(each, bound) for bound in (output.low, output.high) if bound is not None]
    for each, limit in tested:
        rest = limit - sum(weight for weight, at in each.terms if at == CONSTANT)
        for weight, at in each.terms:
            if at == place and abs(rest) < BOUNDED * abs(weight):
                yield rest / weight


def bound_sliders(policy: ir.AgentPolicy, seen: Floats | None = None) -> list[tuple[float, float]]:
    """For each feature the least and the most that a slider shows: what the profile says was seen, or its stated range
    where that is bounded, else what was `seen` [n, n_features]; with the tree's thresholds, and a margin.
    """
    tree = policy.tree
    ranges: list[tuple[float, float]] = []
    for place, feature in enumerate(policy.features):
        if not policy.seen and -BOUNDED < feature.low < feature.high < BOUNDED:
            ranges.append((feature.low, feature.high))
            continue
        known = tree.threshold[tree.feature == place].astype(float).tolist() + list(_turning(policy, place))
        known += [policy.seen[place][0], policy.seen[place][-1]] if policy.seen else []
        known += [] if seen is None else seen[:, place].astype(float)[np.isfinite(seen[:, place])].tolist()
        low, high = min(known, default=0.0), max(known, default=0.0)
        margin = MARGIN * (high - low) or max(1.0, abs(high))
        ranges.append((max(feature.low, low - margin), min(feature.high, high + margin)))
    return ranges
