"""Batches of games of others: what is known of them at one step, states that can be branched, single agents in step.

Does: holds what is known of a batch of games at one step, and answers from it; resets and steps copies with one agent
  each in this process, and writes what they show and pay into arrays; remembers how each game got where it is, plays it
  there again and copies the environment, for measured Q.
Assumes: `source` names the environment; a seed and actions decide everything, as all of extraction does; for games in
  step, `step_alone` and copies that leave each other alone (`processes.is_undisturbed`).
Does not: make an environment; step in other processes, or environments of several agents (processes.py); copy what
  cannot be copied (simulators written in C): that is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.ir import Bool, Float32, Float64
from maviper.worlds.outside.processes import Copy, ensure_finite, single
from maviper.worlds.outside.sources import Source, fault, output_aside
from maviper.worlds.seeds import TRAINING
from maviper.worlds.world import World

ADVICE = "use --critic none, or an expert with Q"


@dataclass(frozen=True, slots=True)
class Past:
    """The path of a game to its state: by a seed at first, then by all agents' actions in a state before."""

    before: Past | None
    by: int | tuple[int, ...]


Pasts = npt.NDArray[np.object_]  # [batch] of Past


def start_pasts(seeds: Sequence[int]) -> Pasts:
    """The pasts of games that were just reset."""
    return _array([Past(None, int(seed)) for seed in seeds])


def continue_pasts(pasts: Pasts, actions: Sequence[Sequence[int]]) -> Pasts:
    """The pasts after one more step. `actions`: [batch][n_agents]."""
    return _array([Past(past, tuple(acted)) for past, acted in zip(pasts, actions, strict=True)])


def _array(pasts: list[Past]) -> Pasts:
    found = np.empty(len(pasts), dtype=object)
    found[:] = pasts
    return found


def copies_of(pasts: Pasts, make: Callable[[], Copy]) -> list[Copy]:
    """A copy of its own for each past. States of one episode in their order are played through only once."""
    walkers: dict[int, tuple[Copy, Past]] = {}  # by the past that an episode began with
    copies: list[Copy] = []
    for past in pasts:
        begun, missing = past, list[int | tuple[int, ...]]()
        at = walkers.get(id(_root(past)))
        while begun.before is not None and not (at and begun is at[1]):
            missing.append(begun.by)
            begun = begun.before
        if at and begun is at[1]:
            walker = at[0]
        else:
            walker = at[0] if at else make()
            walker.ask("reset", begun.by)
        for acted in reversed(missing):
            walker.ask("step", acted)
        walkers[id(_root(past))] = walker, past
        copies.append(deepcopy(walker))
    return copies


def _root(past: Past) -> Past:
    while past.before is not None:
        past = past.before
    return past


def ensure_copies(make: Callable[[], Copy], where: str) -> None:
    """InputError where an environment cannot be copied in play, or a copy goes on in another way."""
    walker = make()
    try:
        begun = walker.ask("reset", 0)
        twin = deepcopy(walker)
        stands = walker.lawful([0] * len(walker.names), begun)
        same = walker.ask("step", stands).bytes == twin.ask("step", stands).bytes
    except (InputError, TypeError, RecursionError, NotImplementedError, AttributeError, RuntimeError) as error:
        said = " ".join(str(error).split())[:120]
        raise InputError("Q cannot be measured: the environment cannot be copied", f"{where}: {said}", ADVICE) from None
    if not same:
        raise InputError("Q cannot be measured: copies of the environment go on differently", where, ADVICE)


START_EPISODES = 4  # that are played at most before anything is asked: a probe, and a trial of copies
PAST = -1  # the moment of a state that cannot be stepped: a part of one, or several joined
MOMENTS = count()  # unlike in all worlds
KNOWN = ("rewards", "done", "terminated", "acting", "told")  # of a batch of games, beside observations


@dataclass(frozen=True)
class EnvStates:
    """The known part of a batch of games at one step; the games themselves live in their copies."""

    observations: tuple[Float32, ...]  # per agent [batch, n_features]
    rewards: Float64  # [batch, n_agents] on entering the state
    done: Bool  # [batch, n_agents] whose episode has ended
    terminated: Bool  # [batch, n_agents] ... and was not just cut
    acting: Bool  # [batch, n_agents] who acts in the next step
    told: Float64  # [batch, n_agents, n_told] what infos tell, NaN where they do not
    moment: int = PAST
    pasts: Pasts | None = None  # how each game got here, where it may be branched
    copies: tuple[Copy, ...] = ()  # of its own, where it was branched

    def __len__(self) -> int:
        return len(self.rewards)

    def __getitem__(self, rows: Any) -> EnvStates:
        observations = tuple(seen[rows] for seen in self.observations)
        pasts = None if self.pasts is None else self.pasts[rows]
        return EnvStates(observations, *(getattr(self, name)[rows] for name in KNOWN), pasts=pasts)

    @staticmethod
    def concatenate(states: Sequence[EnvStates]) -> EnvStates:
        """Several batches as one, in their order."""
        observations = zip(*(state.observations for state in states), strict=True)
        others: Any = (np.concatenate([getattr(state, name) for state in states]) for name in KNOWN)
        known = [state.pasts for state in states if state.pasts is not None]
        pasts = np.concatenate(known) if len(known) == len(states) else None
        return EnvStates(tuple(map(np.concatenate, observations)), *others, pasts=pasts)


class OutsideWorld(World):
    """A world whose states are `EnvStates`. Its measures are the returns of its teams."""

    source: Source

    @property
    def name(self) -> str:
        """The name of the environment, with its options."""
        return self.source.text

    def start(self, n: int, rng: np.random.Generator) -> EnvStates:
        """`n` random start states, `n` at most `games`: each game is reset with a seed of its own."""
        return self.start_from_seeds(rng.integers(*TRAINING, size=n))

    def observe(self, state: EnvStates) -> tuple[Float32, ...]:
        """Each agent's observation, [batch, n_features] float32."""
        return state.observations

    def rewards(self, state: EnvStates) -> Float64:
        """The environment's rewards on entering `state`, [batch, n_agents]; 0 at the start and for who was done."""
        return state.rewards

    def alive(self, state: EnvStates) -> Bool:
        """Returns True for the agents that act in `state`, [batch, n_agents]."""
        return state.acting

    def terminated(self, state: EnvStates) -> Bool:
        """Whose episode has ended by itself, [batch, n_agents]: the environment did not say that it was cut."""
        return state.terminated

    def values(self, states: Sequence[EnvStates]) -> Float64:
        """Each team's return, [n_teams, batch]: the mean over its agents of all rewards of an episode."""
        total = np.sum([state.rewards for state in states], axis=0)
        return np.stack([total[:, self.members(team)].mean(axis=1) for team in self.teams])


FLOAT32 = np.dtype(np.float32)


def steps_alone(env: Any) -> bool:
    """Returns True if it tells the parts of a step of its one agent without dictionaries."""
    return callable(getattr(cast("type[object]", type(env)), "step_alone", None))


class Together:
    """Copies that `make` makes when first asked. Outcomes are those of `processes.Copy`, one by one; here a step costs
    little beside the environment's own.
    """

    def __init__(self, source: Source, make: Callable[[], Any]) -> None:
        self.source, self.make = source, make
        self._copies: list[Copy] = []
        self._steps: list[Callable[[int], tuple[Any, ...]]] = []  # theirs
        self._live: list[int] = []  # games that go on
        self._last: EnvStates | None = None

    def ask(self, verb: str, arguments: Sequence[Any]) -> EnvStates:
        """`reset` with seeds, or `step` with each game's actions; InputError when an environment raises."""
        while len(self._copies) < len(arguments):
            self._copies.append(Copy(self.make(), self.source))
            self._steps.append(self._copies[-1].env.step_alone)
        # once for all of them: to enter and leave takes as long as a small game's step
        with output_aside(f"{self.source.text}: {verb}"):
            self._last = self._start_games(arguments) if verb == "reset" else self._step_games(arguments)
        return self._last

    def _start_games(self, seeds: Sequence[int]) -> EnvStates:
        outcomes = [copy.answer("reset", seed) for copy, seed in zip(self._copies, seeds, strict=False)]
        self._live = list(range(len(seeds)))
        seen = np.array([outcome.observations[0] for outcome in outcomes])
        nobody = np.zeros((len(seeds), 1), bool)
        return EnvStates((seen,), np.zeros((len(seeds), 1)), nobody, nobody, ~nobody, np.empty((len(seeds), 1, 0)))

    def _step_games(self, actions: Sequence[Sequence[Any]]) -> EnvStates:
        last = self._last
        assert last is not None, "games are reset before they are stepped"
        seen, rewards = last.observations[0].copy(), np.zeros_like(last.rewards)
        over: list[tuple[int, bool]] = []  # games that end, and whether by themselves
        paid, shape, steps = rewards[:, 0], seen.shape[1:], self._steps
        try:
            for place in self._live:
                shown, reward, ended, cut, _ = steps[place](actions[place][0])
                if type(shown) is not np.ndarray or shown.dtype is not FLOAT32 or shown.shape != shape:
                    shown = single(shown, self._copies[place].names[0], shape, self.source)
                seen[place] = shown  # at once: copies may have one array between them
                paid[place] = float(reward)
                if ended or cut:
                    over.append((place, bool(ended)))
        except (Exception, SystemExit) as error:
            raise fault(error, self.source, "the environment's step") from error
        ensure_finite(paid, self.source)
        if np.isnan(seen).any():
            what = f"{self._copies[0].names[0]} observes NaN"
            raise InputError(what, self.source.text, "observe numbers")
        if not over:
            return replace(last, observations=(seen,), rewards=rewards)
        done, terminated = last.done.copy(), last.terminated.copy()
        for place, ended in over:
            done[place], terminated[place] = True, ended
        self._live = [place for place in self._live if not done[place]]
        return replace(last, observations=(seen,), rewards=rewards, done=done, terminated=terminated, acting=~done)

    def close(self) -> None:
        """Ends all copies; the next reset starts fresh ones."""
        copies, self._copies, self._steps, self._last = self._copies, [], [], None
        for copy in copies:
            copy.close()
