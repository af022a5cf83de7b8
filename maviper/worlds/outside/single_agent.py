"""Single-agent environments of Gymnasium as PettingZoo ones with one agent, named `agent`.

Does: makes a registered environment, `gymnasium:CartPole-v1`; flattens its observations to a vector with names.
Assumes: Gymnasium's interface, in which an episode's end is told apart from a cut.
Does not: choose actions for people.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import numpy as np
from pettingzoo import ParallelEnv

from codegen.errors import InputError, MissingToolError
from codegen.ir import FeatureSpec, OutputSpec
from maviper.worlds.outside.acting import NUMBERED, bounds_of, taking, width
from maviper.worlds.outside.described import DESCRIBED
from maviper.worlds.outside.flattening import OWN, ensure_small, names_of, specs_of, spell_number, vector, vector_space
from maviper.worlds.outside.sources import MAX_ACTIONS, Source, value_of

if TYPE_CHECKING:
    import gymnasium
    from gymnasium import spaces

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
        import gymnasium

        given = {key: value_of(value) for key, value in options.items()}
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
        known = _list_ids()
        near = get_close_matches(name, known, n=1)
        advice = (
            f"did you mean {near[0]}?"
            if near
            else "write gymnasium:MODULE:ID where a package registers it; shimmy wraps those of the old gym"
        )
        return InputError(said, where, advice)
    return InputError(said, where, "install what it names, or name another version")


def _list_ids() -> list[str]:
    import gymnasium

    return [name for name in gymnasium.registry if "/" not in name]


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
        self._choices, self._first = _number_actions(env.action_space, text)
        self._taken = taking(self._choices)
        self._advance, self._limit = _quick(env)
        self._elapsed = 0
        limit = getattr(env.spec, "max_episode_steps", None)
        self.max_cycles = limit if limit is None or limit > 0 else None
        self.alone = getattr(env.unwrapped, "alone", None)
        called = _find_description(env)
        choices = getattr(self._choices, "n", 0)
        self.action_names = {AGENT: called.actions} if called and len(called.actions) == choices else {}
        self.counted_from = {AGENT: self._first}
        if self._first and not self.action_names and choices <= MAX_ACTIONS:  # its own numbers, which are not ours
            self.action_names = {AGENT: [f"action_{spell_number(self._first + k)}" for k in range(choices)]}
        self.outputs: dict[str, list[OutputSpec]] = {}
        if called and width(self._choices) and len(called.outputs) == width(self._choices):
            named = zip(called.outputs.items(), bounds_of(self._choices), strict=True)
            self.outputs = {AGENT: [OutputSpec(name, unit, low, high) for (name, unit), (low, high) in named]}
        self.features: dict[str, list[FeatureSpec]] = {}
        self.described = tuple(called.features.items()) if called else ()  # names and units, where as many are seen
        if as_it_is:
            self._seen: spaces.Space = env.observation_space
            return
        self._plain = type(env.observation_space).__name__ in ("Box", "MultiBinary")  # vectors are what `vector` leaves
        flat = self._seen = _vector_space(env.observation_space, text)
        names = called.features.items() if called and len(called.features) == flat.shape[0] else ()
        self.features = {AGENT: specs_of(names or names_of(env.observation_space), flat)}

    def observation_space(self, agent: str) -> spaces.Space:
        """The flattened space, [n_features], or the environment's own."""
        return self._seen

    def action_space(self, agent: str) -> spaces.Space:
        """The actions, counted from 0, or the numbers that the agent gives."""
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
        seen, reward, ended, cut, info = self._advance(acted + self._first if self._first else acted)
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

    def _vector(self, seen: Any) -> Any:
        if self.as_it_is or (self._plain and type(seen) is np.ndarray and seen.ndim == 1):
            return seen
        return vector(self.env.observation_space, seen)


def _quick(env: gymnasium.Env) -> tuple[Callable[[Any], tuple[Any, Any, Any, Any, Any]], int | None]:
    """The step of an environment, and after how many of them an episode is cut.

    `gymnasium.make` puts two wrappers around an environment, which ask in each step whether it was reset and count it,
    and most environments ask their space whether there is such an action. In a small game that takes as long as the
    step. Here games are reset first, steps are counted anyway, and the space's own answers are remembered.
    """
    from gymnasium.spaces import Discrete
    from gymnasium.wrappers import OrderEnforcing, TimeLimit

    space = env.unwrapped.action_space
    if type(space) is Discrete and space.n <= REMEMBERED:
        known = frozenset(range(int(space.start), int(space.start + space.n)))
        contains = space.contains
        space.contains = lambda x: (type(x) is int and x in known) or contains(x)
    if type(env) is TimeLimit and type(env.env) is OrderEnforcing:
        return env.env.env.step, env._max_episode_steps
    return env.step, None


def _find_description(env: gymnasium.Env) -> Any:
    """The words for one of Gymnasium's own environments, or None."""
    entry = str(getattr(env.spec, "entry_point", ""))
    return DESCRIBED.get(str(getattr(env.spec, "name", ""))) if entry.startswith("gymnasium.envs.") else None


def _number_actions(space: spaces.Space, text: str) -> tuple[spaces.Space, int]:
    """The actions from 0, and what the first of them is in the environment; a Box as it is."""
    from gymnasium.spaces import Box, Discrete

    if isinstance(space, Discrete):
        return Discrete(int(space.n)), int(space.start)
    if isinstance(space, Box):
        return space, 0
    if type(space).__module__.partition(".")[0] == "gym":
        advice = "shimmy.GymV26CompatibilityV0 makes such an environment a new one"
        raise InputError("the environment has spaces of the old package gym", text, advice)
    what = f"the environment has actions in a {type(space).__name__}; trees choose among numbered ones"
    raise InputError(what, text, f"{NUMBERED}; {OWN}")


def _vector_space(space: spaces.Space, text: str) -> spaces.Box:
    """The space of flattened observations, float32."""
    from gymnasium.spaces import Box, Discrete, MultiBinary

    if not isinstance(space, Box | Discrete | MultiBinary):
        what = f"the environment's observations are a {type(space).__name__}; trees read numbers in a row"
        ways = f"{text},wrap=numbers, or wrap=flatten for one number per value (gymnasium's FlattenObservation)"
        raise InputError(what, text, f"write {ways}; or {OWN}")
    ensure_small(space, text)
    return vector_space(space)
