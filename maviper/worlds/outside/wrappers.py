"""Environments of other kinds as parallel ones with vectors, by the option `wrap`: `mygame:make,wrap=turns+flatten`.

Does: turns AEC environments into parallel ones by PettingZoo's own wrappers, says who has the turn; makes single-agent
  environments of Gymnasium, `gymnasium:CartPole-v1`, PettingZoo ones with one agent, named `agent`; flattens
  observations; takes masks of legal actions from dictionaries or infos; makes each agent a team of its own.
Assumes: PettingZoo's interfaces, and Gymnasium's, in which an episode's end is told apart from a cut.
Does not: choose wrappers or actions for people: an environment that needs a wrapper is refused with the text that asks
  for it.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, MultiBinary, Space
from gymnasium.vector import VectorEnv, VectorWrapper
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils.conversions import aec_to_parallel_wrapper, turn_based_aec_to_parallel_wrapper

from codegen.errors import InputError, MissingToolError, UnknownNameError, escape_text
from codegen.ir import FeatureSpec, OutputSpec
from maviper.worlds.outside import sources, spaces
from maviper.worlds.outside.sources import Source

BATCHING = ("num_envs", "vectorization_mode", "vector_kwargs")  # of gymnasium.make_vec, not of a game


AGENT = "agent"
REMEMBERED = 1_000  # numbers of actions
ID = re.compile(r"(?:[A-Za-z_][\w.]*:)?(?:[\w.-]+/)?[\w.-]+")  # MODULE:NAMESPACE/NAME-v1
ELSEWHERE = (  # environments that left Gymnasium or were never in it: how their names begin, and who has them
    (
        r"ALE/|.*(NoFrameskip|Deterministic)-v|(Pong|Breakout|SpaceInvaders|Seaquest|Qbert|MsPacman)-",
        "ale-py",
        "ale_py",
    ),
    (r"MiniGrid-|BabyAI-", "minigrid", "minigrid"),
    (r"Fetch|HandReach|HandManipulate|PointMaze|AntMaze|FrankaKitchen", "gymnasium-robotics", "gymnasium_robotics"),
    (r"highway|merge-v|roundabout-v|parking-v|intersection-v", "highway-env", "highway_env"),
    (r"procgen", "procgen", "procgen"),
)


def find_registered(name: str) -> Callable[..., gymnasium.Env]:
    """Returns the maker of the environment with a Gymnasium id, `[MODULE:][NAMESPACE/]NAME-v1`; passes options on.

    InputError for what is no id. What it makes raises InputError too where there is no such environment, or an old one,
    or where the name leaves the version open, and MissingToolError where it needs a package that is not installed.
    """
    if not ID.fullmatch(name):
        raise InputError("not a Gymnasium id", f"gymnasium:{name}", "write it as in gymnasium:CartPole-v1")

    def make(**options: int | str) -> gymnasium.Env:
        given = {key: sources.value_of(value) for key, value in options.items()}
        _ensure_version(name)
        try:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", ".*Using the latest versioned environment")  # it is refused below
                env = gymnasium.make(name, disable_env_checker=True, **given)
        except (gymnasium.error.Error, ImportError) as error:
            raise _make_name_error(name, error) from error
        _ensure_version(name)  # of a package that was imported by now
        return env

    return make


def _ensure_version(name: str) -> None:
    """InputError for a name that says no version although there are some: Gymnasium would take the latest that is
    installed, and a profile would be of another game elsewhere.
    """
    from gymnasium import registry

    module, _, own = name.rpartition(":")
    versions = [int(each.rpartition("-v")[2]) for each in registry if re.fullmatch(rf"{re.escape(own)}-v[0-9]+", each)]
    if versions and own not in registry:
        latest = ":".join(filter(None, ("gymnasium", module, f"{own}-v{max(versions)}")))
        raise InputError("the name of the environment says no version", f"gymnasium:{name}", f"write {latest}")


def _make_name_error(name: str, error: Exception) -> InputError | MissingToolError:
    """Why there is no such environment, and where it is to be found."""
    from gymnasium import error as errors

    where, said = f"gymnasium:{name}", " ".join(str(error).split()).rstrip(".")
    if isinstance(error, errors.DeprecatedEnv | errors.VersionNotFound):
        return InputError(said, where, "name a version that there is: an expert of the old one may play it differently")
    if isinstance(error, errors.DependencyNotInstalled):
        return MissingToolError(said, where, "install what it names")
    for begins, package, module in ELSEWHERE:
        if re.match(begins, name):
            advice = f"pip install {package}, then write gymnasium:{module}:{name}"
            return InputError("the environment belongs to another package", where, advice)
    if isinstance(error, errors.UnregisteredEnv):
        near = get_close_matches(name, [each for each in gymnasium.registry if "/" not in each], n=1)
        advice = (
            f"did you mean {near[0]}?"
            if near
            else "write gymnasium:MODULE:ID where a package registers it; shimmy wraps those of the old gym"
        )
        return InputError(said, where, advice)
    return InputError(said, where, "install what it names, or name another version")


class SingleAgent(ParallelEnv[str, Any, Any]):
    """`env` with its one agent. `source`: how it was named, for errors.

    `as_it_is`: somebody else flattens what it observes. It says about itself what `pettingzoo.py` reads.
    InputError for spaces that no tree can read or play.
    """

    metadata: dict[str, Any]
    plays_here = True  # many copies in one process: its steps are short beside ours

    def __init__(self, env: gymnasium.Env, source: Source, as_it_is: bool = False) -> None:
        text = source.text
        self.env, self.metadata, self.as_it_is = env, {"name": text}, as_it_is
        self.possible_agents, self.agents = [AGENT], []
        self._choices = _ensure_numbered(env.action_space, text)
        self._taken = spaces.taking(self._choices)
        self._advance, self._limit = _quick(env)
        self._elapsed = 0
        limit = getattr(env.spec, "max_episode_steps", None)
        self.max_cycles = limit if limit is None or limit > 0 else None
        self.alone = getattr(env.unwrapped, "alone", None)
        entry = str(getattr(env.spec, "entry_point", ""))
        ours = entry.startswith("gymnasium.envs.")  # one of Gymnasium's own environments
        called = spaces.DESCRIBED.get(str(getattr(env.spec, "name", ""))) if ours else None
        choices = getattr(self._choices, "n", 0)
        self.action_names = {AGENT: called.actions} if called and len(called.actions) == choices else {}
        self.outputs: dict[str, list[OutputSpec]] = {}
        if called and spaces.width(self._choices) and len(called.outputs) == spaces.width(self._choices):
            named = zip(called.outputs.items(), spaces.bounds_of(self._choices), strict=True)
            self.outputs = {AGENT: [OutputSpec(name, unit, low, high) for (name, unit), (low, high) in named]}
        self.features: dict[str, list[FeatureSpec]] = {}
        self.described = tuple(called.features.items()) if called else ()  # names and units, where as many are seen
        own = env.observation_space
        if as_it_is:
            self._seen: Space = own
            return
        self._plain = type(own).__name__ in ("Box", "MultiBinary")  # vectors are what `vector` leaves
        if not isinstance(own, Box | Discrete | MultiBinary):
            what = f"the environment's observations are a {type(own).__name__}; trees read numbers in a row"
            ways = f"{text},wrap=numbers, or wrap=flatten for one number per value (gymnasium's FlattenObservation)"
            raise InputError(what, text, f"write {ways}; or {spaces.OWN}")
        spaces.ensure_small(own, text)
        flat = self._seen = spaces.vector_space(own)
        names = called.features.items() if called and len(called.features) == flat.shape[0] else ()
        self.features = {AGENT: spaces.specs_of(names or spaces.names_of(own), flat)}

    def observation_space(self, agent: str) -> Space:
        """The flattened space, [n_features], or the environment's own."""
        return self._seen

    def action_space(self, agent: str) -> Space:
        """Returns the environment's own action space."""
        return self._choices

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], Any]:
        """Starts an episode."""
        seen, info = self.env.reset(seed=seed, options=options)
        self.agents, self._elapsed = [AGENT], 0
        return {AGENT: self._vector(seen)}, {AGENT: info}

    def step(self, actions: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
        """One step: observations, rewards, terminations, truncations and infos."""
        return tuple({AGENT: each} for each in self._after(actions[AGENT]))

    def step_alone(self, action: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Steps without dictionaries; see `step`. `action`: a number from 0, or the numbers that the agent gives."""
        return self._after(self._taken(action))

    def _after(self, acted: Any) -> tuple[Any, Any, Any, Any, Any]:
        seen, reward, ended, cut, info = self._advance(acted)
        self._elapsed += 1
        cut = cut or self._elapsed == self._limit
        if ended or cut:
            self.agents = []
        return self._vector(seen), reward, ended, cut, info

    def render(self) -> Any:
        """Returns the environment's own rendering."""
        return self.env.render()

    def close(self) -> None:
        """Closes the environment."""
        self.env.close()

    def read(self, agent: Any, seen: Any, info: Mapping[str, Any]) -> Any:
        """Returns an observation of the environment as the vector that is shown here."""
        del agent, info
        return self._vector(seen)

    def _vector(self, seen: Any) -> Any:
        if self.as_it_is or (self._plain and type(seen) is np.ndarray and seen.ndim == 1):
            return seen
        return spaces.vector(self.env.observation_space, seen)


def _quick(env: gymnasium.Env) -> tuple[Callable[[Any], tuple[Any, Any, Any, Any, Any]], int | None]:
    """The step of an environment, and after how many of them an episode is cut.

    `gymnasium.make` puts two wrappers around an environment, which ask in each step whether it was reset and count it,
    and most environments ask their space whether there is such an action. In a small game that takes as long as the
    step. Here games are reset first, steps are counted anyway, and the space's own answers are remembered.
    """
    from gymnasium.wrappers import OrderEnforcing, TimeLimit

    space = env.unwrapped.action_space
    if type(space) is Discrete and space.n <= REMEMBERED:
        known = frozenset(range(int(space.start), int(space.start + space.n)))
        contains = space.contains
        space.contains = lambda x: (type(x) is int and x in known) or contains(x)
    if type(env) is TimeLimit and type(env.env) is OrderEnforcing:
        return env.env.env.step, env._max_episode_steps
    return env.step, None


def _ensure_numbered(space: Space, text: str) -> Space:
    """The space itself; InputError where its actions are neither numbered nor bounded numbers."""
    if isinstance(space, Discrete | Box):
        return space
    if type(space).__module__.partition(".")[0] == "gym":
        advice = "shimmy.GymV26CompatibilityV0 makes such an environment a new one"
        raise InputError("the environment has spaces of the old package gym", text, advice)
    what = f"the environment has actions in a {type(space).__name__}; trees choose among numbered ones"
    raise InputError(what, text, f"{spaces.NUMBERED}; {spaces.OWN}")


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


def of_batch(games: Any) -> Callable[[], gymnasium.Env]:
    """Returns a function that makes one environment of those that a vector environment of Gymnasium steps together.
    InputError where they are not alike, or something is around all of them, which one alone would not have.
    """
    functions, spec = list(getattr(games, "env_fns", ())), games.spec
    kinds = {_parts_of(function) for function in functions}
    if isinstance(games, VectorWrapper) or len(kinds) > 1 or not (kinds or spec):
        what = "its games are not alike" if len(kinds) > 1 else "a wrapper is around all of its games together"
        raise InputError(what, f"{games}", "give a function that makes one game, with the wrappers that it needs")

    def make() -> gymnasium.Env:
        chosen = {key: value for key, value in spec.kwargs.items() if key not in BATCHING} if spec else {}
        return functions[0]() if functions else gymnasium.make(spec.id, **chosen)

    make.__module__, make.__qualname__ = "__main__", re.sub(r"\W+", "_", getattr(spec, "id", "")) or "game"
    return make


def _parts_of(function: Any) -> Any:
    """Returns what decides which environment a function makes: equal for `[lambda: make()] * 2`, and for two of one
    line.
    """
    cells = tuple(repr(cell.cell_contents) for cell in getattr(function, "__closure__", None) or ())
    return getattr(function, "__code__", function), repr(getattr(function, "__defaults__", None)), cells


def _parallel(env: Any, wrappers: Sequence[str], source: Source) -> ParallelEnv:
    if isinstance(env, cast("type[Any]", VectorEnv)):
        make = of_batch(env)
        env.close()
        env = make()
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
    asked = {part for part in parse_wrappers(source.options.get(sources.WRAP, "")) if part not in (PARALLEL, TURNS)}
    options = {**source.options, sources.WRAP: SEPARATOR.join([way, *sorted(asked)])}
    named = Source(source.module, source.function, options).text
    raise InputError(what, source.text, f"write {named} (pettingzoo's {by})")


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
        self._stuck: set[Any] = set()
        self.action_names: dict[Any, Sequence[str]] = {}
        self.legal: dict[Any, tuple[str, ...]] = {}  # agent -> the feature that says whether an action is legal
        self.features: dict[Any, list[FeatureSpec]] = {}
        for agent in self.possible_agents:
            self._add(agent)

    def _add(self, agent: Any) -> None:
        whole = sources.space(self.env, "observation", agent)
        actions = sources.action_names(self.env, agent, self.source)
        inner, masked = spaces.parts_of(whole, len(actions))
        wrong = spaces.unreadable(inner)
        if wrong:
            what = f"{agent}'s observations are a {wrong}, or hold one: it has no vector of a fixed length"
            raise InputError(what, self.source.text, "observe numbers in a row")
        if self.whole:
            inner = spaces.as_numbers(inner, self.source.text)
        spaces.ensure_small(inner, self.source.text)
        masked = masked or self.in_infos
        box = spaces.vector_space(inner)
        names = spaces.names_of(inner)
        legal = sources.legal_names([*(name for name, _ in names), *(f"legal_{each}" for each in actions)], "feature")
        flags = legal[len(names) :] if masked else ()
        self.legal[agent] = flags or sources.read_legal_features(self.env, agent, self.source)
        self._spaces[agent], self._legal[agent] = inner, (len(actions) if masked else 0)
        more = (0, self._legal[agent])
        low, high = np.pad(box.low, more), np.pad(box.high, more, constant_values=1)
        self._boxes[agent] = Box(low, high, dtype=np.float32)
        self.action_names[agent] = actions
        told = [FeatureSpec(name, spaces.FLAG, 0.0, 1.0, None) for name in flags]
        self.features[agent] = self._own(agent, box, names) + told

    def _own(self, agent: Any, box: Box, names: Sequence[tuple[str, str]]) -> list[FeatureSpec]:
        """Returns the features as the environment states them, or those that follow from their space."""
        if isinstance(self.env, SingleAgent) and len(self.env.described) == len(names):
            names = self.env.described
        given = sources.table(self.env, "features", self.source).get(agent)
        if sources.is_row(given) and len(given) == box.shape[0]:
            return list(cast("Sequence[FeatureSpec]", given))  # whether they are is judged where the world is made
        return spaces.specs_of(names, box)

    @property
    def unwrapped(self) -> Any:
        """The innermost environment, as the wrapped one gives it."""
        return self.env.unwrapped

    @property
    def plays_here(self) -> bool:
        """True if the environment says that it plays in this process."""
        return bool(sources.attribute(self.env, "plays_here", self.source))

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
        return sources.space(self.env, "action", agent)

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

    def read(self, agent: Any, seen: Any, info: Mapping[str, Any]) -> Any:
        """Returns an agent's observation in the environment as the vector that is shown here."""
        return self._vector(agent, seen, info)

    def _vectors(self, seen: Mapping[Any, Any], infos: Mapping[Any, Any]) -> dict[Any, Any]:
        self._stuck.clear()
        return {agent: self._vector(agent, each, infos.get(agent, {})) for agent, each in seen.items()}

    def _vector(self, agent: Any, seen: Any, info: Mapping[str, Any]) -> Any:
        wanted = self._legal[agent]
        given = seen
        if sources.is_mapping(seen):
            given = {key: part for key, part in seen.items() if key != spaces.MASK or not wanted or self.in_infos}
        numbers = np.asarray(spaces.vector(self._spaces[agent], given), np.float32)
        if not wanted:
            return numbers
        mask = (info if self.in_infos else seen).get(spaces.MASK)
        if mask is None and agent not in self.agents:  # its last observation
            mask = np.zeros(wanted)
        if mask is None or np.size(mask) != wanted:
            place = "infos" if self.in_infos else "observation"
            what = f"{agent} has no {spaces.MASK} of {wanted} numbers in its {place}"
            raise InputError(what, self.source.text, "give one in every reset and step, 1 where an action is legal")
        flags = np.ravel(mask)
        if flags.dtype.kind not in "biuf" or not np.isin(flags, (0, 1)).all():
            what = f"{agent}'s {spaces.MASK} is {escape_text(flags.tolist())[:60]}"
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
