"""Worlds in which agents remember their last action, and for how long: features, which each leaf of their trees sets.

Does: shows each agent, behind its features, the place of the action that it took last, and where asked the steps since
  that changed, instead of any features of these names that it observed; lists the actions that change what is
  remembered, and has grown trees take these; finds such a world by the features in its name, and for a profile that
  remembers.
Assumes: agents that choose among actions without masks.
Does not: remember for a profile that is used elsewhere, such as compiled: that does so itself (codegen/memory.py).

At the start of an episode an agent remembers the first of its actions, and 0 steps. A step in which it takes another
action than the last one sets the steps to 0; one that repeats it adds 1, up to a bound. So where steps are counted, a
tree has to know whether it repeats, and whether the bound is reached: a leaf that does not becomes up to four, by tests
of what is remembered. In steps in which an agent does not act, it keeps what it remembers. Whoever plays the world
without memory observes what that shows (experts/finding.py).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError, escape_text
from codegen.ir import AgentPolicy, FeatureSpec
from maviper.worlds.games.features import SEPARATOR
from maviper.worlds.outside.sources import legal_names
from maviper.worlds.world import FEATURES, Int, World, plain_name

LAST_ACTION = "last_action"  # the feature, and the group of features that asks for it
SINCE_CHANGE = "time_since_change"  # likewise, with its bound where that is not the usual one; it comes with the other
BETWEEN = ":"  # the feature and its bound
USUAL_BOUND, MAX_BOUND = 60, 1_000_000  # steps
SAME = ("spec", "teams", "outputs", "counted_from", "measures", "beside", "return_first", "main", "features_from")


def split_memory(name: str) -> tuple[str, str]:
    """A world's name without the features that agents remember, and the group of these that was in it; "" for none.
    InputError for a bound that is none.
    """
    plain, features = plain_name(name)
    groups = features.split(SEPARATOR)
    remembered = [group for group in groups if group.partition(BETWEEN)[0] in (LAST_ACTION, SINCE_CHANGE)]
    if not remembered:
        return name, ""
    others = SEPARATOR.join(group for group in groups if group not in remembered)
    group = max(remembered, key=lambda each: each.startswith(SINCE_CHANGE))
    find_bound(group)
    return f"{plain},{FEATURES}={others}" if others else plain, group


def find_bound(group: str) -> int:
    """The most steps that are counted by a group of remembered features; 0 where none are. InputError for no number."""
    feature, between, said = group.partition(BETWEEN)
    usual = USUAL_BOUND if feature == SINCE_CHANGE else 0
    if not between:
        return usual
    if not usual or not said.isascii() or not said.isdecimal() or not 1 <= int(said[:9]) <= MAX_BOUND:
        advice = f"write {SINCE_CHANGE}{BETWEEN}{USUAL_BOUND}, or another whole number from 1 to {MAX_BOUND:,}"
        raise InputError(f"'{escape_text(group)}' names no feature with a bound", "--features", advice)
    return int(said)


@dataclass(frozen=True)
class RememberedStates:
    """A batch of states of the world without memory, and what is remembered in them."""

    plain: Any
    last: Int  # [batch, n_agents] places of the actions that were taken last
    since: Int  # [batch, n_agents] steps since these changed, up to the bound

    def __len__(self) -> int:
        return len(self.plain)

    def __getitem__(self, rows: Any) -> "RememberedStates":
        return RememberedStates(self.plain[rows], self.last[rows], self.since[rows])

    @staticmethod
    def concatenate(states: Sequence["RememberedStates"]) -> "RememberedStates":
        """Several batches as one, in their order."""
        plain: list[Any] = [state.plain for state in states]
        last, since = ([getattr(state, name) for state in states] for name in ("last", "since"))
        return RememberedStates(plain[0].concatenate(plain), np.concatenate(last), np.concatenate(since))


def _ask_plain(name: str) -> Any:
    """A method that asks the world without memory about its part of a state."""

    def ask(self: "Remembering", state: RememberedStates, *more: Any) -> Any:
        return getattr(self.plain, name)(state.plain, *more)

    return ask


class Remembering(World):
    """The world `plain`, whose agents remember a group of features: their last action, and perhaps for how long.
    InputError where they give numbers or have masks, and in play where they observe another number by one of the names.
    """

    def __init__(self, plain: World, group: str = LAST_ACTION) -> None:
        unfit = "give numbers" if plain.continuous else "have masks of legal actions" if plain.masked else ""
        if unfit:
            what = f"a last action cannot be remembered where agents {unfit}"
            raise InputError(what, plain.name, f"leave the feature {group.partition(BETWEEN)[0]} out")
        for name in SAME:
            setattr(self, name, getattr(plain, name))
        self.plain, self.games, self.length_stated = plain, plain.games, plain.length_stated
        self.group, self.bound = group, find_bound(group)
        names = (LAST_ACTION, SINCE_CHANGE) if self.bound else (LAST_ACTION,)
        self._names, self._observed = names, tuple(_find_observed(features, names) for features in plain.features)
        self.features = tuple(
            (
                *(features[place] for place in observed),
                *(
                    FeatureSpec(name, "none", 0.0, float(most), None, initial=0)
                    for name, most in zip(names, (len(actions) - 1, self.bound), strict=False)
                ),
            )
            for features, observed, actions in zip(plain.features, self._observed, plain.actions, strict=True)
        )
        # effects are of games whose episodes are proved by places, and nobody proves them of agents that remember
        self.actions = tuple(tuple(replace(action, effect=None) for action in of) for of in plain.actions)

    def __getattr__(self, name: str) -> Any:
        if name == "plain" or name.startswith("__"):  # of a copy that is being made
            raise AttributeError(name)
        return getattr(self.plain, name)

    @property
    def name(self) -> str:
        """The name of the world without memory, with the feature."""
        plain, features = plain_name(self.plain.name)
        return f"{plain},{FEATURES}={SEPARATOR.join(filter(None, (features, self.group)))}"

    games_measured: Any = property(attrgetter("plain.games_measured"))
    rewards_lag: Any = property(attrgetter("plain.rewards_lag"))
    shaped: Any = property(attrgetter("plain.shaped"))

    # --- what its trees do

    @property
    def policy_actions(self) -> tuple[tuple[ir.ActionSpec, ...], ...]:
        """Per agent the actions that are taken, and behind them each again, remembered; then each once more, repeated,
        where steps are counted.
        """
        return tuple((*of, *_remember(of, counts=bool(self.bound))) for of in self.actions)

    def deploy(self, agent: int, tree: ir.GrownTree) -> ir.GrownTree:
        """The tree with leaves that take actions and remember them."""
        count = len(self.actions[agent])
        if self.bound:
            return _tell_repeats(tree, len(self.features[agent]) - len(self._names), count, self.bound)
        return replace(tree, action=np.where(tree.action == ir.NO_ACTION, ir.NO_ACTION, tree.action + count))

    def remembers_alike(self, policy: AgentPolicy) -> bool:
        """Returns True if each leaf of a policy with `policy_actions` remembers its action, and where steps are counted
        knows if it repeats.
        """
        tree, leaf = policy.tree, policy.tree.action
        count = len(policy.actions) // (3 if self.bound else 2)
        if not self.bound:
            return bool(((leaf == ir.NO_ACTION) | (leaf >= count)).all())
        taken = np.where(leaf == ir.NO_ACTION, ir.NO_ACTION, leaf % count)
        grown = ir.GrownTree(tree.feature, tree.threshold.astype(np.float64), tree.left, tree.right, taken)
        told = _tell_repeats(grown, len(policy.features) - len(self._names), count, self.bound)
        return len(told.action) == len(leaf) and bool((told.action == leaf).all())

    # --- play

    def _begin(self, plain: Any) -> RememberedStates:
        nothing = np.zeros((len(plain), len(self.agents)), np.int64)
        return RememberedStates(plain, nothing, nothing)

    def start(self, n: int, rng: np.random.Generator) -> RememberedStates:
        """Returns random start states; see `World.start`."""
        return self._begin(self.plain.start(n, rng))

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> RememberedStates:
        """Returns one start state for each seed; see `World.start_from_seeds`."""
        return self._begin(self.plain.start_from_seeds(seeds))

    def step(self, state: RememberedStates, actions: Int) -> RememberedStates:
        """The next states, in which those that acted remember it; see `World.step`."""
        acting = self.plain.alive(state.plain)
        since = np.where(actions == state.last, np.minimum(state.since + 1, self.bound), 0)
        last, since = np.where(acting, actions, state.last), np.where(acting, since, state.since)
        return RememberedStates(self.plain.step(state.plain, actions), last, since)

    def observe(self, state: RememberedStates) -> tuple[ir.Float32, ...]:
        """Returns each agent's observation, and what it remembers; see `World.observe`."""
        wide = list[ir.Float32]()
        for agent, (rows, observed) in enumerate(zip(self.plain.observe(state.plain), self._observed, strict=True)):
            both = (state.last, state.since)[: len(self._names)]
            remembered = np.stack([each[:, agent] for each in both], axis=1).astype(np.float32)
            for place, name in enumerate(each.name for each in self.plain.features[agent]):
                if place not in observed:
                    self._ensure_same(agent, name, rows[:, place], remembered[:, self._names.index(name)], state)
            wide.append(np.concatenate([rows[:, observed], remembered], axis=1))
        return tuple(wide)

    def _ensure_same(self, agent: int, name: str, shown: ir.Float32, own: ir.Float32, state: RememberedStates) -> None:
        """InputError where the world shows an agent that acts something else by a name than what it remembers."""
        wrong = np.flatnonzero((shown != own) & self.plain.alive(state.plain)[:, agent])
        if len(wrong):
            remembered, steps = f"{own[wrong[0]]:g}", f"show the steps, up to {self.bound}"
            told = f"its last action has place {remembered}" if name == LAST_ACTION else f"it repeats for {remembered}"
            meant = "show its place, from 0" if name == LAST_ACTION else steps
            advice = f"{meant}, and 0 at the start; or rename the feature, or leave {name} out"
            raise InputError(
                f"{self.agents[agent]} observes a {name} of {shown[wrong[0]]:g}, and {told}", self.plain.name, advice
            )

    rewards, reward, alive, playing, terminated, shaping = map(
        _ask_plain, ("rewards", "reward", "alive", "playing", "terminated", "shaping")
    )

    def close(self) -> None:
        """Ends the copies; see `World.close`."""
        self.plain.close()

    def branch(self) -> None:
        """Lets states be branched; see `World.branch`."""
        self.plain.branch()

    def branch_states(self, state: RememberedStates) -> RememberedStates:
        """Returns states that can be stepped once; see `World.branch_states`."""
        return RememberedStates(self.plain.branch_states(state.plain), state.last, state.since)

    def values(self, states: Sequence[RememberedStates]) -> ir.Float64:
        """Returns the measures of whole episodes; see `World.values`."""
        return self.plain.values([state.plain for state in states])

    def values_beside(self, states: Sequence[RememberedStates]) -> ir.Float64:
        """Returns the measures beside these; see `World.values_beside`."""
        return self.plain.values_beside([state.plain for state in states])

    def reference_env(self) -> Any:
        """The environment without memory, in which teams remember themselves."""
        return self.plain.reference_env()


def _remember(actions: Sequence[ir.ActionSpec], counts: bool) -> Iterator[ir.ActionSpec]:
    """The actions again, each of which sets what is remembered; where that `counts`, first those that are another one
    than the last, then those that repeat it.
    """
    taken = [action.name for action in actions]
    ways = ("remembered", "repeated")[: 1 + counts]
    names = legal_names([*taken, *(f"{name}_{way}" for way in ways for name in taken)], "action")[len(taken) :]
    changed = (ir.Update(SINCE_CHANGE, adds=False, value=0),) if counts else ()
    for place, name in enumerate(taken):
        updates = (ir.Update(LAST_ACTION, adds=False, value=place), *changed)
        yield ir.ActionSpec(names[place], None, acts=name, updates=updates)
    for name, called in zip(taken, names[len(taken) :], strict=False):
        yield ir.ActionSpec(called, None, acts=name, updates=(ir.Update(SINCE_CHANGE, adds=True, value=1),))


def _tell_repeats(tree: ir.GrownTree, last: int, count: int, bound: int) -> ir.GrownTree:
    """A tree of `count` actions whose leaves know whether they repeat the last action, which the feature `last` tells,
    and whether the steps, which the next feature tells, are below their bound: where the tests above a leaf leave that
    open, it is asked there.
    """
    feature, threshold, left, right, action = (
        list(each.tolist()) for each in (tree.feature, tree.threshold, tree.left, tree.right, tree.action)
    )

    def add() -> int:
        for column, value in ((feature, ir.NO_FEATURE), (threshold, 0.0), (left, ir.NO_CHILD), (right, ir.NO_CHILD)):
            column.append(value)
        action.append(taken)
        return len(action) - 1

    # a node, and between which ends, (low, high], both are there
    waiting = [(ir.ROOT, {last: (-1.0, count - 1.0), last + 1: (-1.0, float(bound))})]
    while waiting:
        node, ends = waiting.pop()
        taken = action[node]
        if feature[node] == ir.NO_FEATURE:
            (low, high), (least, most) = ends[last], ends[last + 1]
            places = [place for place in range(count) if low < place <= high]
            if taken not in places:
                action[node] = count + taken
                continue
            if places != [taken]:
                asked, line = last, taken + (0.5 if places[0] == taken else -0.5)
            elif least < bound - 1 and most >= bound:
                asked, line = last + 1, bound - 0.5
            else:
                action[node] = taken if most >= bound else 2 * count + taken
                continue
            feature[node], threshold[node], left[node], right[node] = asked, line, add(), add()
            action[node] = ir.NO_ACTION
        inner, line = ends.get(feature[node]), threshold[node]
        below = ends if inner is None else {**ends, feature[node]: (inner[0], min(inner[1], line))}
        above = ends if inner is None else {**ends, feature[node]: (max(inner[0], line), inner[1])}
        waiting += [(left[node], below), (right[node], above)]
    return ir.GrownTree(*map(np.array, (feature, threshold, left, right, action)))


def _find_observed(features: Sequence[FeatureSpec], remembered: Sequence[str]) -> list[int]:
    """The places of features that are not remembered."""
    return [place for place, each in enumerate(features) if each.name not in remembered]


def hide_remembered(world: World, policy: AgentPolicy, row: Any) -> Any:
    """An observation of a policy's agent in a world [n_features], without what the policy remembers itself."""
    plain = world.plain if isinstance(world, Remembering) else world
    features, remembered = plain.features[plain.agents.index(policy.agent)], [each.name for each in policy.memory]
    return row[_find_observed(features, remembered)] if len(row) == len(features) else row


def remembering(world: World, profile: ir.PolicyProfile) -> World:
    """The world, with memory where a profile's agents remember."""
    remembered = {each.name: each for policy in profile.agents for each in policy.memory}
    if isinstance(world, Remembering) or not remembered:
        return world
    counted = remembered.get(SINCE_CHANGE)
    group = LAST_ACTION if counted is None else f"{SINCE_CHANGE}{BETWEEN}{max(1, min(int(counted.high), MAX_BOUND))}"
    return Remembering(world, group)
