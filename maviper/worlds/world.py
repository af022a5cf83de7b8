"""What a world is: agents in teams that observe, act and are measured, many games at once.

Does: states what extraction, training and evaluation may ask of a game, ours or a user's.
Assumes: vector observations; numbered actions, or numbers within bounds from every agent; episodes of a fixed length at
  most; an agent whose episode has ended before takes no part in the rest.
Does not: know any game.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from inspect import signature
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError, UnknownNameError
from codegen.ir import ActionSpec, Bool, FeatureSpec, Float32, Float64, GrownTree, OutputSpec, WorldSpec
from codegen.paths import LEGAL, Mask, mask_of

Int = npt.NDArray[np.integer[Any]]
Options = Mapping[str, int | str]
FEATURES = "features"  # the option of our worlds
CONTINUOUS = "continuous"  # with what the options begin by which agents give numbers: ours, mpe2's and VMAS's
RETURN = "return"  # the measure of summed rewards, a team's being its agents' mean


@dataclass(frozen=True)
class Measure:
    """One number of an episode for a team, such as `success r=0.316`."""

    team: str
    name: str
    share: bool = False  # 0 or 1 in each episode, so that its mean is a share
    lower_is_better: bool = False
    partial: bool = False  # NaN in episodes that it says nothing of

    @property
    def label(self) -> str:
        """The measure's name with its team's, as in tables and files."""
        return f"{self.team} {self.name}"


class Outcome(NamedTuple):
    """The outcome of a step or a reset of one game, agent by agent."""

    observations: list[Float32]  # each [n_features]
    rewards: list[float]
    done: list[bool]  # the agent's episode has ended
    terminated: list[bool]  # ... by itself; it was not just cut
    acting: list[bool]  # the agent acts in the next step
    told: list[list[float]]  # by agent what its infos tell of each measure, NaN where they do not

    @property
    def bytes(self) -> tuple[list[bytes], bytes, bytes, list[list[bool]]]:
        """All of it, to compare: NaN is like itself."""
        vectors = [vector.tobytes() for vector in self.observations]
        paid, told = np.array(self.rewards).tobytes(), np.array(self.told).tobytes()
        return vectors, paid, told, [self.done, self.terminated, self.acting]


def legal_in(mask: Mask, obs: Float32) -> Bool:
    """Returns True for the legal actions in each observation, [batch, n_actions]. `obs`: [batch, n_features]."""
    columns = [np.ones(len(obs), bool) if place is None else obs[:, place] > LEGAL for place in mask]
    return np.stack(columns, axis=1)


def draw_legal(mask: Mask, obs: Float32, uniform: Float64) -> Int:
    """A legal action in each observation, [batch], all of them as likely as one another; any where none is legal.
    `obs`: [batch, n_features]; `uniform`: [batch] in [0, 1), the draws.
    """
    legal = legal_in(mask, obs)
    legal |= ~legal.any(axis=1, keepdims=True)
    order = np.argsort(~legal, axis=1, kind="stable")  # the legal ones first
    return order[np.arange(len(obs)), (uniform * legal.sum(axis=1)).astype(np.int64)]


def bounds(outputs: Sequence[OutputSpec]) -> tuple[Float64, Float64]:
    """The low and the high ends of an agent's outputs, each [n_outputs]. Assumes that they have both."""
    return np.array([each.low for each in outputs], np.float64), np.array([each.high for each in outputs], np.float64)


def find_misplaced(known: Sequence[str], names: Sequence[str]) -> int | None:
    """The first place at which names have one that a world has for something else; None where there is none."""
    places = enumerate(zip(names, known, strict=False))
    return next((place for place, (name, own) in places if name != own and name in known), None)


def world_name(spec: WorldSpec) -> str:
    """The game's name with its options, as the command line reads it."""
    return ",".join([spec.name, *(f"{key}={value}" for key, value in sorted(spec.options.items()))])


def plain_name(name: str, option: str = FEATURES) -> tuple[str, str]:
    """A world's name without an option, and what the option said; "" where it is not there."""
    parts = name.split(",")
    said = [part.partition("=")[2] for part in parts[1:] if part.startswith(f"{option}=")]
    return ",".join(part for part in parts if not part.startswith(f"{option}=")), said[0] if said else ""


def unusual(game: Callable[..., "World"], options: Options) -> dict[str, int | str]:
    """The options that differ from a game's defaults."""
    return {key: value for key, value in options.items() if value != signature(game).parameters[key].default}


class World(ABC):
    """A game. `State` stands for whatever a game's batch of states is; it knows its length."""

    ranges: ClassVar[Mapping[str, tuple[int, int]]] = {}  # option -> least and most, where they are the game's own
    spec: WorldSpec
    teams: Mapping[str, tuple[str, ...]]  # team -> its agents, in the order of `agents`
    features: tuple[tuple[FeatureSpec, ...], ...]  # per agent
    actions: tuple[tuple[ActionSpec, ...], ...]  # per agent; each () where agents give numbers
    outputs: tuple[tuple[OutputSpec, ...], ...] = ()  # per agent, the numbers that it gives; (): agents have actions
    counted_from: tuple[int, ...] = ()  # per agent, the environment's own number of its first action; (): 0
    measures: tuple[Measure, ...]  # the first of each team is its primary one, if `judge_by` names no other
    beside: tuple[Measure, ...] = ()  # told beside these where teams are evaluated; nothing is chosen by them
    return_first: tuple[str, ...] = ()  # teams that are to be read by their return first
    main = ""  # the name of the primary measures; "": the first of each team
    features_from = ""  # the hash of a file that names its features, if there is one
    length_stated = True  # whether somebody says how many steps an episode has; otherwise `spec` holds a cap of ours
    games: int | None = None  # how many games are played at once; None: as many as asked

    @property
    def games_measured(self) -> int | None:
        """The number of games that may play at once where only each one's result matters, not the order of the data."""
        return self.games

    @property
    def name(self) -> str:
        """The game's name with the options that differ from its defaults, as the command line reads it."""
        return world_name(self.spec)

    @property
    def agents(self) -> tuple[str, ...]:
        """Agents' names, in the order of every per-agent array."""
        return tuple(entity.name for entity in self.spec.agents)

    def team_of(self, agent: str) -> str:
        """The team that an agent plays for."""
        return next(team for team, members in self.teams.items() if agent in members)

    def members(self, team: str) -> list[int]:
        """Indices of a team's agents."""
        return [self.agents.index(agent) for agent in self.teams[team]]

    def mask(self, agent: int) -> Mask | None:
        """The features that tell which actions of an agent are legal; None: all are, always."""
        return mask_of(self.features[agent], self.actions[agent])

    @property
    def continuous(self) -> bool:
        """True if agents give numbers, and choose among no actions."""
        return bool(self.outputs)

    @property
    def bounds(self) -> tuple[tuple[Float64, Float64], ...]:
        """By agent the low and the high ends of the numbers that it gives, each [n_outputs]; () where agents act."""
        return tuple(map(bounds, self.outputs))

    @property
    def given(self) -> tuple[tuple[OutputSpec, ...], ...]:
        """By agent the numbers that it gives; () of one that takes actions."""
        return tuple(self.outputs) or ((),) * len(self.agents)

    @property
    def decided(self) -> tuple[tuple[ActionSpec, ...] | tuple[OutputSpec, ...], ...]:
        """By agent what it decides: the actions of which it takes one, or the numbers that it gives."""
        return tuple(self.outputs) or tuple(self.actions)

    @property
    def policy_actions(self) -> tuple[tuple[ActionSpec, ...], ...]:
        """By agent the actions that policies have: those of the world, and any that change what agents remember."""
        return self.actions

    def deploy(self, agent: int, tree: GrownTree) -> GrownTree:
        """A tree that chooses among an agent's `actions` as one that chooses among its `policy_actions`."""
        del agent
        return tree

    @property
    def acting_shape(self) -> tuple[int, ...]:
        """The shape of everybody's actions in one state: (n_agents,), or (n_agents, most outputs of an agent)."""
        return (len(self.agents), *((max(map(len, self.outputs)),) if self.outputs else ()))

    def draw_actions(self, agents: Sequence[int], observations: Sequence[Float32], uniform: Float64) -> Any:
        """Random actions of some agents, [batch, len(agents)], legal ones where they have masks; or numbers within
        bounds, [batch, len(agents), n_outputs]. `uniform`: the draws, of the same shape, in [0, 1).
        """
        if self.outputs:
            numbers = np.zeros(uniform.shape, np.float32)  # which stays 0 for outputs that an agent has not
            for place, agent in enumerate(agents):
                low, high = self.bounds[agent]
                numbers[:, place, : len(low)] = low + uniform[:, place, : len(low)] * (high - low)
            return numbers
        columns: list[Int] = []
        for agent, draws in zip(agents, uniform.T, strict=True):
            mask = self.mask(agent)
            free = (draws * len(self.actions[agent])).astype(np.int64)
            columns.append(free if mask is None else draw_legal(mask, observations[agent], draws))
        return np.stack(columns, axis=1)

    @property
    def masked(self) -> bool:
        """True if some agent's actions may be illegal."""
        return any(self.mask(agent) is not None for agent in range(len(self.agents)))

    def primary(self, team: str) -> Measure:
        """The measure that a team is judged by."""
        mine = [measure for measure in self.measures if measure.team == team]
        return next((measure for measure in mine if measure.name == self.main), mine[0])

    def judge_by(self, name: str) -> "World":
        """The world with the measure of that name as the primary one of every team that has it; "": as it is.
        UnknownNameError where no team has it.
        """
        if not name or all(self.primary(team).name == name for team in self.teams):
            return self
        names = list(dict.fromkeys(measure.name for measure in self.measures))
        if name not in names:
            raise UnknownNameError("measure", name, names, "--measure")
        world = copy(self)
        world.main = name
        return world

    @abstractmethod
    def start(self, n: int, rng: np.random.Generator) -> Any:
        """`n` random start states from one generator."""

    @abstractmethod
    def start_from_seeds(self, seeds: Sequence[int] | Int) -> Any:
        """The start states of the reference environment after `reset(seed=...)`, one for each seed."""

    @abstractmethod
    def step(self, state: Any, actions: Int) -> Any:
        """The next states. `actions`: [batch, n_agents] indices, or numbers [batch, n_agents, n_outputs]."""

    @abstractmethod
    def observe(self, state: Any) -> tuple[Float32, ...]:
        """Each agent's observation, [batch, n_features] float32."""

    @abstractmethod
    def rewards(self, state: Any) -> Float64:
        """The environment's rewards on entering `state`, [batch, n_agents]; 0 for whom the episode had ended before."""

    def reward(self, state: Any, agent: int) -> Float64:
        """One agent's part of `rewards`, [batch]."""
        return self.rewards(state)[:, agent]

    @property
    def rewards_lag(self) -> bool:
        """True if a step's own actions change no reward on entering the next state, nor its shaping."""
        return False

    def alive(self, state: Any) -> Bool:
        """Returns True for agents that act in `state`, [batch, n_agents]: episode not ended, and their turn."""
        return np.ones((len(state), len(self.agents)), dtype=bool)

    def playing(self, state: Any) -> Bool:
        """Whose episode goes on, [batch, n_agents]: those who act, and those who wait for their turn."""
        return self.alive(state)

    def terminated(self, state: Any) -> Bool:
        """Whose episode has ended by itself, [batch, n_agents]: nothing follows, unlike after a cut."""
        return np.zeros((len(state), len(self.agents)), dtype=bool)

    def close(self) -> None:  # noqa: B027 - most worlds have no copies
        """Ends the copies of a user's environment; a later start makes fresh ones."""

    def branch(self) -> None:
        """Lets states be branched from now on; InputError where they cannot be.

        Nothing is to be done where any state can be stepped as often as one likes.
        """
        if self.games is not None:
            advice = "play cannot be branched from its states: use --critic none"
            raise InputError("Q cannot be measured in this world", self.name, advice)

    def branch_states(self, state: Any) -> Any:
        """States that can be stepped like the newest ones, once."""
        return state

    def shaping(self, state: Any) -> Float64:
        """A training aid that may be added to the rewards, [batch, n_agents]; never part of a measure."""
        return np.zeros((len(state), len(self.agents)))

    @property
    def shaped(self) -> bool:
        """True if the world has such an aid."""
        return type(self).shaping is not World.shaping

    @abstractmethod
    def values(self, states: Sequence[Any]) -> Float64:
        """The measures of whole episodes, [n_measures, batch], from the states after each step."""

    def values_beside(self, states: Sequence[Any]) -> Float64:
        """Returns the measures `beside`, like `values`; NaN in an episode that a partial one says nothing of."""
        return np.empty((0, len(states[0])))

    @abstractmethod
    def reference_env(self) -> Any:
        """The reference environment (a PettingZoo parallel environment)."""
