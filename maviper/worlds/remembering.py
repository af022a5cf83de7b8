"""Worlds in which agents remember their last action: it is a feature, and each leaf of their trees sets it.

Does: shows each agent, as its last feature, the place of the action that it took last, instead of any feature of this
  name that it observed; lists the actions that change what is remembered, and has grown trees take these; finds such a
  world by the feature in its name, and for a profile that remembers.
Assumes: agents that choose among actions without masks.
Does not: remember for a profile that is used elsewhere, such as compiled: that does so itself (codegen/memory.py).

At the start of an episode an agent remembers the first of its actions. In steps in which it does not act, it keeps what
it remembers. Whoever plays the world without memory observes what that shows (experts/finding.py).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import AgentPolicy, FeatureSpec
from maviper.worlds.games.features import SEPARATOR
from maviper.worlds.outside.sources import legal_names
from maviper.worlds.world import FEATURES, Int, World, plain_name

LAST_ACTION = "last_action"  # the feature, and the group of features that asks for it
SAME = ("spec", "teams", "outputs", "counted_from", "measures", "beside", "return_first", "main", "features_from")


def split_memory(name: str) -> tuple[str, bool]:
    """A world's name without the feature LAST_ACTION, and whether that was in it."""
    plain, features = plain_name(name)
    groups = features.split(SEPARATOR)
    if LAST_ACTION not in groups:
        return name, False
    others = SEPARATOR.join(group for group in groups if group != LAST_ACTION)
    return f"{plain},{FEATURES}={others}" if others else plain, True


@dataclass(frozen=True)
class RememberedStates:
    """A batch of states of the world without memory, and what is remembered in them."""

    plain: Any
    last: Int  # [batch, n_agents] places of the actions that were taken last

    def __len__(self) -> int:
        return len(self.plain)

    def __getitem__(self, rows: Any) -> "RememberedStates":
        return RememberedStates(self.plain[rows], self.last[rows])

    @staticmethod
    def concatenate(states: Sequence["RememberedStates"]) -> "RememberedStates":
        """Several batches as one, in their order."""
        plain: list[Any] = [state.plain for state in states]
        return RememberedStates(plain[0].concatenate(plain), np.concatenate([state.last for state in states]))


def _ask_plain(name: str) -> Any:
    """A method that asks the world without memory about its part of a state."""

    def ask(self: "Remembering", state: RememberedStates, *more: Any) -> Any:
        return getattr(self.plain, name)(state.plain, *more)

    return ask


class Remembering(World):
    """The world `plain`, whose agents remember their last action. InputError where they give numbers or have masks, and
    in play where they observe a LAST_ACTION that is something else.
    """

    def __init__(self, plain: World) -> None:
        unfit = "give numbers" if plain.continuous else "have masks of legal actions" if plain.masked else ""
        if unfit:
            what = f"a last action cannot be remembered where agents {unfit}"
            raise InputError(what, plain.name, f"leave the feature {LAST_ACTION} out")
        for name in SAME:
            setattr(self, name, getattr(plain, name))
        self.plain, self.games, self.length_stated = plain, plain.games, plain.length_stated
        memory = (FeatureSpec(LAST_ACTION, "none", 0.0, len(of) - 1.0, None, initial=0) for of in plain.actions)
        self._observed = tuple(_find_observed(features, (LAST_ACTION,)) for features in plain.features)
        self.features = tuple(
            (*(features[place] for place in observed), last)
            for features, observed, last in zip(plain.features, self._observed, memory, strict=True)
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
        return f"{plain},{FEATURES}={SEPARATOR.join(filter(None, (features, LAST_ACTION)))}"

    games_measured: Any = property(attrgetter("plain.games_measured"))
    rewards_lag: Any = property(attrgetter("plain.rewards_lag"))
    shaped: Any = property(attrgetter("plain.shaped"))

    # --- what its trees do

    @property
    def policy_actions(self) -> tuple[tuple[ir.ActionSpec, ...], ...]:
        """Per agent the actions that are taken, and behind them each again, remembered."""
        return tuple((*of, *_remember(of)) for of in self.actions)

    def deploy(self, agent: int, tree: ir.GrownTree) -> ir.GrownTree:
        """The tree with leaves that take actions and remember them."""
        remembered = tree.action + len(self.actions[agent])
        return replace(tree, action=np.where(tree.action == ir.NO_ACTION, ir.NO_ACTION, remembered))

    def remembers_alike(self, policy: AgentPolicy) -> bool:
        """Returns True if each leaf of a policy with `policy_actions` remembers its action."""
        leaf = policy.tree.action
        return bool(((leaf == ir.NO_ACTION) | (leaf >= len(policy.actions) // 2)).all())

    # --- play

    def _begin(self, plain: Any) -> RememberedStates:
        return RememberedStates(plain, np.zeros((len(plain), len(self.agents)), np.int64))

    def start(self, n: int, rng: np.random.Generator) -> RememberedStates:
        """Returns random start states; see `World.start`."""
        return self._begin(self.plain.start(n, rng))

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> RememberedStates:
        """Returns one start state for each seed; see `World.start_from_seeds`."""
        return self._begin(self.plain.start_from_seeds(seeds))

    def step(self, state: RememberedStates, actions: Int) -> RememberedStates:
        """The next states, in which those that acted remember it; see `World.step`."""
        last = np.where(self.plain.alive(state.plain), actions, state.last)
        return RememberedStates(self.plain.step(state.plain, actions), last)

    def observe(self, state: RememberedStates) -> tuple[ir.Float32, ...]:
        """Returns each agent's observation, and what it remembers; see `World.observe`."""
        last, wide = state.last.astype(np.float32), list[ir.Float32]()
        for agent, (rows, observed) in enumerate(zip(self.plain.observe(state.plain), self._observed, strict=True)):
            if len(observed) < rows.shape[1]:
                self._ensure_last(agent, np.delete(rows, observed, axis=1)[:, 0], last[:, agent], state)
                rows = rows[:, observed]
            wide.append(np.concatenate([rows, last[:, agent, None]], axis=1))
        return tuple(wide)

    def _ensure_last(self, agent: int, shown: ir.Float32, last: ir.Float32, state: RememberedStates) -> None:
        """InputError where the world shows an agent that acts another last action than it took."""
        wrong = np.flatnonzero((shown != last) & self.plain.alive(state.plain)[:, agent])
        if len(wrong):
            told = f"{shown[wrong[0]]:g}, and its last action has place {last[wrong[0]]:g}"
            advice = f"show its place, from 0, and 0 at the start; or rename the feature, or leave {LAST_ACTION} out"
            raise InputError(f"{self.agents[agent]} observes a {LAST_ACTION} of {told}", self.plain.name, advice)

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
        return RememberedStates(self.plain.branch_states(state.plain), state.last)

    def values(self, states: Sequence[RememberedStates]) -> ir.Float64:
        """Returns the measures of whole episodes; see `World.values`."""
        return self.plain.values([state.plain for state in states])

    def values_beside(self, states: Sequence[RememberedStates]) -> ir.Float64:
        """Returns the measures beside these; see `World.values_beside`."""
        return self.plain.values_beside([state.plain for state in states])

    def reference_env(self) -> Any:
        """The environment without memory, in which teams remember themselves."""
        return self.plain.reference_env()


def _remember(actions: Sequence[ir.ActionSpec]) -> Iterator[ir.ActionSpec]:
    """The actions again, each of which sets what is remembered."""
    taken = [action.name for action in actions]
    names = legal_names([*taken, *(f"{name}_remembered" for name in taken)], "action")[len(taken) :]
    for place, (name, called) in enumerate(zip(taken, names, strict=True)):
        yield ir.ActionSpec(called, None, acts=name, updates=(ir.Update(LAST_ACTION, adds=False, value=place),))


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
    if isinstance(world, Remembering) or not any(policy.memory for policy in profile.agents):
        return world
    return Remembering(world)
