"""Environments of other kinds as parallel ones with vectors, by the option `wrap`: `mygame:make,wrap=turns+flatten`.

Does: turns AEC environments into parallel ones by PettingZoo's own wrappers, says who has the turn; flattens
  observations; takes masks of legal actions from dictionaries or infos; makes each agent a team of its own.
Assumes: PettingZoo's interfaces.
Does not: choose wrappers for people: an environment that needs one is refused with the text that asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Space
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils.conversions import aec_to_parallel_wrapper, turn_based_aec_to_parallel_wrapper

from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import FeatureSpec
from maviper.worlds.outside.described import FLAG
from maviper.worlds.outside.flattening import (
    MASK,
    as_numbers,
    ensure_small,
    legal_names,
    names_of,
    parts_of,
    specs_of,
    unreadable,
    vector,
    vector_space,
)
from maviper.worlds.outside.single_agent import SingleAgent
from maviper.worlds.outside.sources import (
    WRAP,
    Source,
    action_names,
    attribute,
    is_mapping,
    is_row,
    read_legal_features,
    space,
    table,
)

PARALLEL, TURNS, FLATTEN, NUMBERS, MASKS, RIVALS = "parallel", "turns", "flatten", "numbers", "masks", "rivals"
WRAPPERS = (PARALLEL, TURNS, FLATTEN, NUMBERS, MASKS, RIVALS)
FLATTENING = {FLATTEN, NUMBERS, MASKS}
SEPARATOR = "+"


def parse_wrappers(text: int | str) -> tuple[str, ...]:
    """The wrappers that an option's value names; UnknownNameError for another."""
    names = tuple(part for part in str(text).split(SEPARATOR) if part)
    for name in names:
        if name not in WRAPPERS:
            raise UnknownNameError("wrapper", name, WRAPPERS, f"wrap={text}")
    return names


def wrap_environment(env: Any, text: int | str, source: Source) -> ParallelEnv:
    """Makes a parallel environment of what a function made, by the wrappers that `text` names. InputError where another
    one is needed, or where no wrapper helps.
    """
    wrappers = parse_wrappers(text)
    parallel = _parallel(env, wrappers, source)
    if FLATTENING & set(wrappers):
        parallel = Flattened(parallel, MASKS in wrappers, source, NUMBERS in wrappers)
    if RIVALS in wrappers:
        parallel.teams = {agent: [agent] for agent in parallel.possible_agents}  # type: ignore[attr-defined]
    return parallel


def _parallel(env: Any, wrappers: Sequence[str], source: Source) -> ParallelEnv:
    if isinstance(env, gymnasium.Env):
        return SingleAgent(env, source, bool(FLATTENING & set(wrappers)))
    if isinstance(env, AECEnv):
        return in_parallel(env, wrappers, source)
    if isinstance(env, ParallelEnv):
        return cast("ParallelEnv", env)
    what = f"the function returns a {type(env).__name__}, not a PettingZoo environment"
    advice = "return a pettingzoo.ParallelEnv or a gymnasium.Env"
    old = any(kind.__module__.partition(".")[0] == "gym" for kind in type(env).__mro__)
    advice = "it is of the old package gym: shimmy.GymV26CompatibilityV0 makes it a new one" if old else advice
    raise InputError(what, source.text, advice)


def in_parallel(env: AECEnv, wrappers: Sequence[str], source: Source) -> ParallelEnv:
    """An AEC environment as a parallel one; InputError where nobody said in which way, or it is not of that kind."""
    together = bool(env.metadata.get("is_parallelizable", False))
    if PARALLEL in wrappers and together:
        return aec_to_parallel_wrapper(env)
    if TURNS in wrappers:
        return Turns(env)
    way, by = (PARALLEL, "aec_to_parallel") if together else (TURNS, "turn_based_aec_to_parallel")
    what = "the environment is an AEC one, in which agents take turns"
    if PARALLEL in wrappers:
        what += ", and it does not say that they may act at once (is_parallelizable)"
    raise InputError(what, source.text, f"write {_with(source, way)} (pettingzoo's {by})")


def _with(source: Source, way: str) -> str:
    """The text that asks for the environment, its agents acting in that way."""
    asked = {part for part in parse_wrappers(source.options.get(WRAP, "")) if part not in (PARALLEL, TURNS)}
    options = {**source.options, WRAP: SEPARATOR.join([way, *sorted(asked)])}
    return Source(source.module, source.function, options).text


class Turns(turn_based_aec_to_parallel_wrapper):  # type: ignore[misc]
    """An AEC environment in whose steps one agent acts: the one that has the turn."""

    plays_here = True  # many copies in one process: a step of one agent is short beside ours

    @property
    def acting(self) -> tuple[Any, ...]:
        """The agents that act in the next step."""
        return (self.aec_env.agent_selection,) if self.aec_env.agents else ()


class Flattened(ParallelEnv[Any, Any, Any]):
    """A parallel environment whose agents observe vectors, at their end the mask of their actions where there is one.

    `masks`: masks are in infos; `whole`: whole numbers are shown as they are. It says about itself what `pettingzoo.py`
    reads.
    """

    def __init__(self, env: ParallelEnv, masks: bool, source: Source, whole: bool = False) -> None:
        self.env, self.source, self.in_infos, self.whole = env, source, masks, whole
        self.metadata, self.possible_agents = env.metadata, env.possible_agents
        self.agents: list[Any] = []
        self._spaces: dict[Any, Space] = {}
        self._boxes: dict[Any, Box] = {}
        self._legal: dict[Any, int] = {}
        self.action_names: dict[Any, Sequence[str]] = {}
        self.counted_from = env.counted_from if isinstance(env, SingleAgent) else {}
        self.legal: dict[Any, tuple[str, ...]] = {}  # agent -> the feature that says whether an action is legal
        self.features: dict[Any, list[FeatureSpec]] = {}
        for agent in self.possible_agents:
            self._add(agent)

    def _add(self, agent: Any) -> None:
        whole, actions = space(self.env, "observation", agent), action_names(self.env, agent, self.source)
        inner, masked = parts_of(whole, len(actions))
        wrong = unreadable(inner)
        if wrong:
            what = f"{agent}'s observations are a {wrong}, or hold one: it has no vector of a fixed length"
            raise InputError(what, self.source.text, "observe numbers in a row")
        if self.whole:
            inner = as_numbers(inner, self.source.text)
        ensure_small(inner, self.source.text)
        masked = masked or self.in_infos
        box = vector_space(inner)
        names = names_of(inner)
        legal = legal_names([*(name for name, _ in names), *(f"legal_{each}" for each in actions)], "feature")
        flags = legal[len(names) :] if masked else ()
        self.legal[agent] = flags or read_legal_features(self.env, agent, self.source)
        self._spaces[agent], self._legal[agent] = inner, (len(actions) if masked else 0)
        self._boxes[agent] = _widen_box(box, self._legal[agent])
        self.action_names[agent] = actions
        self.features[agent] = self._own(agent, box, names) + [
            FeatureSpec(name, FLAG, 0.0, 1.0, None) for name in flags
        ]

    def _own(self, agent: Any, box: Box, names: Sequence[tuple[str, str]]) -> list[FeatureSpec]:
        """Returns the features as the environment states them, or those that follow from their space."""
        if isinstance(self.env, SingleAgent) and len(self.env.described) == len(names):
            names = self.env.described
        given = table(self.env, "features", self.source).get(agent)
        if is_row(given) and len(given) == box.shape[0]:
            return list(cast("Sequence[FeatureSpec]", given))  # whether they are is judged where the world is made
        return specs_of(names, box)

    @property
    def unwrapped(self) -> Any:
        """The innermost environment, as the wrapped one gives it."""
        return self.env.unwrapped

    @property
    def plays_here(self) -> bool:
        """True if the environment says that it plays in this process."""
        return bool(attribute(self.env, "plays_here", self.source))

    @property
    def acting(self) -> tuple[Any, ...]:
        """The agents that act in the next step: those that have the turn, and a legal action."""
        turn = getattr(self.env, "acting", None)
        return tuple(agent for agent in self.agents if (turn is None or agent in turn) and agent not in self._stuck)

    def observation_space(self, agent: Any) -> Any:
        """The flattened space, [n_features]."""
        return self._boxes[agent]

    def action_space(self, agent: Any) -> Any:
        """Returns the environment's own action space."""
        return space(self.env, "action", agent)

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[Any, Any], Any]:
        """Starts an episode."""
        seen, infos = self.env.reset(seed=seed, options=options)
        self.agents = list(self.env.agents)
        return self._vectors(seen, infos), infos

    def step(self, actions: Mapping[Any, int]) -> tuple[Any, ...]:
        """One step: observations, rewards, terminations, truncations and infos."""
        seen, *others, infos = self.env.step(actions)  # type: ignore[arg-type]
        self.agents = list(self.env.agents)
        return self._vectors(seen, infos), *others, infos

    def _vectors(self, seen: Mapping[Any, Any], infos: Mapping[Any, Any]) -> dict[Any, Any]:
        self._stuck: set[Any] = set()
        return {agent: self._vector(agent, each, infos.get(agent, {})) for agent, each in seen.items()}

    def _vector(self, agent: Any, seen: Any, info: Mapping[str, Any]) -> Any:
        wanted = self._legal[agent]
        given = seen
        if is_mapping(seen):
            given = {key: part for key, part in seen.items() if key != MASK or not wanted or self.in_infos}
        numbers = np.asarray(vector(self._spaces[agent], given), np.float32)
        if not wanted:
            return numbers
        mask = (info if self.in_infos else seen).get(MASK)
        if mask is None and agent not in self.agents:  # its last observation
            mask = np.zeros(wanted)
        if mask is None or np.size(mask) != wanted:
            what = f"{agent} has no {MASK} of {wanted} numbers in its {'infos' if self.in_infos else 'observation'}"
            raise InputError(what, self.source.text, "give one in every reset and step, 1 where an action is legal")
        flags = np.ravel(mask)
        if flags.dtype.kind not in "biuf" or not np.isin(flags, (0, 1)).all():
            what = f"{agent}'s {MASK} is {escape_text(flags.tolist())[:60]}"
            raise InputError(what, self.source.text, "give 1 where an action is legal, else 0")
        if not flags.any():
            self._stuck.add(agent)
        return np.concatenate([numbers, flags], dtype=np.float32)

    def render(self) -> Any:
        """Returns the environment's own rendering."""
        return self.env.render()

    def close(self) -> None:
        """Closes the environment."""
        self.env.close()


def _widen_box(box: Box, n_flags: int) -> Box:
    ends = np.zeros(n_flags, np.float32), np.ones(n_flags, np.float32)
    low, high = (np.concatenate([end, flags]) for end, flags in zip((box.low, box.high), ends, strict=True))
    return Box(low, high, dtype=np.float32)
