"""Which expert a text on the command line means, and what is put around one.

Does: finds shipped experts, files and run folders, other libraries' files, a user's own by `module:function`, scripts
  for worlds without a shipped network; checks every answer of a user's own; passes an expert the features that it knows
  in a world that shows more or other things; puts a measured critic in place of its own, or gives every action the same
  worth.
Assumes: a user who names a module wants its code to run; a world around an expert has the same states as the expert's.
Does not: take such a name from a file; change what a correct expert does.
"""

import inspect
import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, cast

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PHYSICS, Float32, Float64
from codegen.wording import format_count
from maviper.episodes.play import Controller, in_columns
from maviper.experts import cards, network
from maviper.experts.expert import AS_GIVEN, Expert, Measured
from maviper.experts.foreign import libraries
from maviper.experts.scripted import build_script, is_script
from maviper.worlds import WORLDS, ParticleWorld, World, find, find_built_in
from maviper.worlds.outside.making import import_maker
from maviper.worlds.outside.sources import Source, fault, is_named_by_user, output_aside, parse_source
from maviper.worlds.outside.spaces import refuse_numbers
from maviper.worlds.remembering import RememberedStates, Remembering, split_memory
from maviper.worlds.world import FEATURES, Int, bounds, legal_in, plain_name


@dataclass(frozen=True)
class Wrapped:
    """An expert as it is. `see`: what it is asked by instead of observations and state."""

    expert: Expert

    def see(self, observations: Sequence[Float32], state: Any) -> tuple[Sequence[Float32], Any]:
        """Returns the observations and the state that the expert is shown."""
        return observations, state

    @property
    def critic(self) -> str:
        """Whose Q this is."""
        return critic_of(self.expert)

    @property
    def card(self) -> Mapping[str, Any]:
        """The expert's; {} where it has none."""
        return getattr(self.expert, "card", {})

    @property
    def hash(self) -> str:
        """The expert's; "" where it has none."""
        return getattr(self.expert, "hash", "")

    @property
    def agents(self) -> tuple[str, ...]:
        """The expert's."""
        return self.expert.agents

    @property
    def centralized(self) -> bool:
        """The expert's; True where it does not say."""
        return bool(getattr(self.expert, "centralized", True))

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the wrapped expert's actions; see `Controller.act`."""
        return self.expert.act(agents, *self.see(observations, state))

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the wrapped expert's Q; see `Expert.q`."""
        return self.expert.q(agent, *self.see(observations, state), joint, given)


@dataclass(frozen=True)
class Narrowed(Wrapped):
    """An expert of `world` in a world of the same states that shows more, the first features being the expert's."""

    world: World

    def see(self, observations: Sequence[Float32], state: Any) -> tuple[Sequence[Float32], Any]:
        """Returns the features of the expert's world alone."""
        return [seen[:, : len(mine)] for seen, mine in zip(observations, self.world.features, strict=True)], state


@dataclass(frozen=True)
class Observing(Wrapped):
    """An expert of `world` in a world of the same states that shows something else: it observes for itself."""

    world: World

    def see(self, observations: Sequence[Float32], state: Any) -> tuple[Sequence[Float32], Any]:
        """Returns the world's own observations of the state."""
        return self.world.observe(state), state


@dataclass(frozen=True)
class Forgetful(Observing):
    """A controller of a `world` in which nobody remembers, where agents do."""

    def see(self, observations: Sequence[Float32], state: RememberedStates) -> tuple[Sequence[Float32], Any]:
        """Returns what the world shows of the state without memory."""
        return super().see(observations, state.plain)


@dataclass(frozen=True)
class Unweighted(Wrapped):
    """An expert to whom all actions are worth the same, so that all states weigh the same: plain DAgger."""

    @property
    def critic(self) -> str:
        """Nobody's."""
        return "none"

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns a Q of 0 for all; see `Expert.q`."""
        del agent, observations, state
        return np.zeros((len(given), len(joint)))


@dataclass(frozen=True)
class Lawful(Wrapped):
    """An expert in a world of masks: where its action is illegal, the legal one that its Q likes best."""

    world: World

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns legal actions; InputError where the expert acts illegally and its Q cannot be asked."""
        chosen, acting = np.array(super().act(agents, observations, state)), self.world.alive(state)
        for place, agent in enumerate(agents):
            mask = self.world.mask(agent)
            if mask is None:
                continue
            legal = legal_in(mask, observations[agent])
            wrong = np.flatnonzero(acting[:, agent] & ~legal[np.arange(len(legal)), chosen[:, place]])
            if len(wrong):
                worth = self._worth(agent, [seen[wrong] for seen in observations], state[wrong])
                chosen[wrong, place] = np.where(legal[wrong], worth, -np.inf).argmax(axis=1)
        return chosen

    def _worth(self, agent: int, observations: Sequence[Float32], state: Any) -> Float64:
        """Q of the agent's own actions, the others' being the expert's, [batch, n_actions]."""
        n_agents, n_actions = len(self.agents), len(self.world.actions[agent])
        joint = np.full((n_actions, n_agents), AS_GIVEN)
        joint[:, agent] = np.arange(n_actions)
        given = super().act(range(n_agents), observations, state)
        try:
            return self.expert.q(agent, observations, state, joint, given)
        except (NotImplementedError, InputError):
            what = f"the expert takes illegal actions for {self.agents[agent]}, and has no Q to choose another by"
            raise InputError(what, self.world.name, "let it read the mask, the last features it observes") from None


def lawful_expert(expert: Expert, world: World) -> Expert:
    """The expert, taking legal actions only where a world has masks."""
    inner = expert
    while isinstance(inner, Wrapped):
        if isinstance(inner, Lawful):
            return expert
        inner = inner.expert
    return Lawful(expert, world) if world.masked else expert


def critic_of(expert: Expert) -> str:
    """Whose Q an expert answers with: `learned` unless it says otherwise."""
    return str(getattr(expert, "critic", "learned"))


def reward_weighed_by(expert: Expert, world: World) -> str:
    """Returns the kind of reward that an expert's Q adds up; "" where nobody knows, or where there is no Q."""
    whose, card = critic_of(expert), expert.card
    while isinstance(expert, Wrapped):
        expert = expert.expert
    if isinstance(expert, Measured):
        return cards.reward_of({"shaping": expert.shaping}, world) if whose == expert.critic else ""
    return cards.critic_reward(card, world) if whose == "learned" else ""


def origin_of(expert: Controller) -> str:
    """Returns where a profile says that it comes from: the expert's hash; of a user's own without one, its function."""
    known = getattr(expert, "hash", "")
    while isinstance(expert, Wrapped) and not isinstance(expert, Given):
        expert = expert.expert
    return known or (expert.source.reference if isinstance(expert, Given) else "")


class Acting:
    """A function `act(agent, observations) -> actions` as an expert of a world. It has no critic.

    The agent is named as in its environment; observations [n, n_features]; actions [n], counted as the environment
    counts them, or the numbers that the agent gives, [n, n_outputs]. InputError for an answer of another shape.
    """

    critic = "none"
    card: Mapping[str, Any] = MappingProxyType({"algorithm": "function"})

    def __init__(self, function: Callable[[Any, Float32], Any], world: World) -> None:
        self.function, self.world, self.agents = function, world, world.agents
        self._names = getattr(world, "env_agents", world.agents)

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the agents' actions; see `Controller.act`."""
        del state
        return in_columns([self._ask(agent, observations[agent]) for agent in agents])

    def _ask(self, agent: int, rows: Float32) -> Any:
        given = np.asarray(self.function(self._names[agent], rows))
        wanted = (len(rows), len(self.world.outputs[agent])) if self.world.outputs else (len(rows),)
        if given.shape != wanted:
            asked = f"{format_count(len(rows), 'observation')} of {self.agents[agent]}"
            what = f"act(agent, observations) returns shape {given.shape} for {asked}, not {wanted}"
            raise InputError(what, self.world.name, "return one action for each row, such as logits.argmax(axis=1)")
        first = self.first(agent)
        return given.astype(np.int64) - first if first and given.dtype.kind in "iu" else given

    def first(self, agent: int) -> int:
        """The number of the agent's first action, as the environment counts."""
        return self.world.counted_from[agent] if self.world.counted_from else 0


MEMBERS = ("world", "agents", "act")
FIX = "fix it there"
ROWS = "return an array of action numbers [batch, len(agents)], as np.stack(columns, axis=1) of one column per agent"


@dataclass(frozen=True)
class Given(Wrapped):
    """A user's expert, whose answers are checked. InputError for those that are not what `Expert` says."""

    source: Source

    @property
    def critic(self) -> str:
        """Whose Q this is: nobody's where the expert has no `q`."""
        return critic_of(self.expert) if hasattr(self.expert, "q") else NONE

    @property
    def world(self) -> World:
        """The world that it plays."""
        return cast("Any", self.expert).world

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the agents' actions, checked; see `Controller.act`."""
        actions = self._call_expert("act", agents, observations, state)
        if self.world.continuous:
            return self._numbers(actions, len(observations[0]), agents)
        wanted = (len(observations[0]), len(agents))
        if actions.dtype.kind not in "iu":
            what = f"act of your expert returns {_kind(actions)}, not numbers of actions"
            advice = "return whole numbers, such as logits.argmax(axis=1) of each agent"
            raise InputError(what, self.source.text, advice)
        if actions.shape != wanted:
            asked = f"{format_count(wanted[0], 'observation')} of {format_count(wanted[1], 'agent')}"
            what = f"act of your expert returns shape {actions.shape} for {asked}"
            raise InputError(f"{what}, not {wanted}", self.source.text, ROWS)
        acting = self.world.alive(state)
        for place, agent in enumerate(agents):
            n = len(self.world.actions[agent])
            first = self.expert.first(agent) if isinstance(self.expert, Acting) else 0
            wrong = (actions[:, place] < 0) | (actions[:, place] >= n)
            if (wrong & acting[:, agent]).any():
                action = actions[wrong & acting[:, agent], place][0] + first
                what = f"act of your expert returns action {action} for {self.agents[agent]}, which has {n}"
                names = [each.name for each in self.world.actions[agent]]
                listed = ", ".join(names[:8]) + (", ..." if n > 8 else "")
                known = f"its actions are {first} to {first + n - 1}: {listed}"
                raise InputError(what, self.source.text, known)
            actions[wrong, place] = 0  # of who no longer acts, which means nothing
        return actions.astype(np.int64)

    def _numbers(self, given: Any, batch: int, agents: Sequence[int]) -> Any:
        """Returns its numbers, [batch, len(agents), n_outputs], as float32; InputError for anything else."""
        outputs = self.world.given
        wanted = (batch, len(agents), max(len(outputs[agent]) for agent in agents))
        fits = given.ndim == 3 and given.shape[:2] == wanted[:2] and given.shape[2] >= wanted[2]
        if given.dtype.kind not in "fiu" or not fits or not np.isfinite(given).all():
            seen = _kind(given) if fits else f"shape {given.shape}"
            what = f"act of your expert returns {seen}, not finite numbers of shape {wanted}"
            raise InputError(what, self.source.text, "return the numbers of each agent, zeros behind those of few")
        numbers = np.zeros(wanted, np.float32)
        for place, agent in enumerate(agents):
            low, high = bounds(outputs[agent])
            numbers[:, place, : len(low)] = np.clip(given[:, place, : len(low)], low, high)
        return numbers

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the agent's Q, checked; see `Expert.q`."""
        try:
            values = self._call_expert("q", agent, observations, state, joint, given)
        except InputError as error:
            if not isinstance(error.__cause__, NotImplementedError):
                raise
            what = "your expert has no critic: its q raises NotImplementedError"
            advice = "add --critic none, or --critic measured where the game can be tried out"
            raise InputError(what, self.source.text, advice) from None
        wanted = (len(given), len(joint))
        if values.dtype.kind not in "fiu" or values.shape != wanted or not np.isfinite(values).all():
            seen = _kind(values) if values.shape == wanted else f"shape {values.shape}"
            what = f"q of your expert returns {seen}, not finite numbers of shape {wanted}"
            advice = "return one worth for each state and joint action, or --critic none"
            raise InputError(what, self.source.text, advice)
        return values.astype(np.float64)

    def _call_expert(self, verb: str, *given: Any) -> np.ndarray:
        doing = f"{verb} of your expert"
        with _torch_alone(len(given[1][0])):
            return _run(lambda: np.array(getattr(self.expert, verb)(*given)), self.source, doing)


FEW = 4_096  # rows that one thread answers sooner than several, which wait for one another


@contextmanager
def _torch_alone(rows: int) -> Generator[None]:
    """Of few rows torch, where somebody has imported it, is asked with one thread."""
    if "torch" not in sys.modules or rows > FEW:
        yield
        return
    torch = sys.modules["torch"]
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


def import_expert(source: Source, world: World | None = None) -> Given:
    """The expert that the function of a module returns, or that acts by it (see `Acting`). InputError when it
    raises, or returns something else.
    """
    function = import_maker(source)
    acts = False  # a function that needs two arguments, agent and observations, acts, and makes no expert
    with suppress(TypeError, ValueError):  # not written in Python
        needed = [each for each in inspect.signature(function).parameters.values() if each.default is each.empty]
        acts = len([each for each in needed if each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD)]) == 2
    if not callable(function) or acts:
        return given_expert(function, world, source)
    if not source.options:
        _ensure_takes(function, source)
    return given_expert(_run(lambda: function(**source.options), source, source.function), world, source)


def _ensure_takes(function: Callable[..., Any], source: Source, *given: Any) -> None:
    """InputError where a function does not take so many arguments: it is no expert, and makes none."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # not written in Python
        return
    try:
        signature.bind(*given)
    except TypeError:
        called = source.function
        advice = f"write {called}(agent, observations), or {called}() that returns an expert"
        what = f"an expert takes agent and observations; {called} takes {signature}"
        raise InputError(what, source.text, advice) from None


def given_expert(given: Any, world: World | None, source: Source) -> Given:
    """A user's expert, checked: an object, or a function that acts in `world`."""
    if callable(given) and not hasattr(given, "world"):
        if world is None:
            what = "a function act(agent, observations) does not say which world it plays"
            raise InputError(what, source.text, "name it: --world module:function")
        _ensure_takes(given, source, "agent", "observations")
        return Given(cast("Expert", Acting(given, world)), source)
    expert: Any = given
    missing = [name for name in MEMBERS if not hasattr(expert, name)]
    if missing and hasattr(expert, "reset"):
        advice = "name an expert, and give this as --world"
        raise InputError("this is an environment, not an expert", source.text, advice)
    if missing:
        what = f"{type(given).__name__} is not an expert: it lacks {', '.join(missing)}"
        raise InputError(what, source.text, "write act(agent, observations), or an object with these members")
    if not isinstance(expert.world, World):
        what = f"`world` of your expert is a {type(expert.world).__name__}, not a world"
        raise InputError(what, source.text, "write self.world = maviper.worlds.find(NAME)")
    agents: Any = expert.agents
    if not isinstance(agents, Sequence) or tuple(cast("Sequence[Any]", agents)) != expert.world.agents:
        what = f"`agents` of your expert are not those of its world, {', '.join(expert.world.agents)}"
        raise InputError(what, source.text, "write self.agents = self.world.agents")
    return Given(expert, source)


def _run(function: Callable[[], Any], source: Source, doing: str) -> Any:
    """Returns the result of a user's code; InputError, with the cause, when it raises."""
    try:
        with output_aside():
            return function()
    except (Exception, SystemExit) as error:
        raise fault(error, source, doing, FIX) from error


def _kind(array: np.ndarray) -> str:
    """Describes in words the kind of values that an array holds."""
    kinds = {"f": "floats", "b": "truth values", "O": "objects", "U": "texts"} | dict.fromkeys("iu", "whole numbers")
    nan = " that are not finite" if array.dtype.kind == "f" and not np.isfinite(array).all() else ""
    return f"{kinds.get(array.dtype.kind, str(array.dtype))}{nan}"


LEARNED, MEASURED, NONE = "learned", "measured", "none"
CRITICS = (LEARNED, MEASURED, NONE)


def find_expert(
    text: Any,
    critic: str = LEARNED,
    world: str | World | Callable[..., Any] | None = None,
    features: str = "",
    giving: bool = False,
) -> tuple[Expert, World]:
    """The expert and the world that it plays. `text`: its name, a function that acts, or an object with the members of
    an expert. `critic`: `learned`, the expert's own where it has one, or `measured`. `world`: where the expert cannot
    say it. `features`: groups that agents shall observe beyond what the expert does. `giving`: as for `find`.
    """
    if critic not in CRITICS:
        raise UnknownNameError("critic", critic, CRITICS, "--critic")
    expert, played = _resolve_expert(text, None if world is None else find(world, giving))
    if played.continuous and not giving:
        raise refuse_numbers(played.name)
    if features:
        expert, played = seeing(expert, played, features)
    if critic == MEASURED and played.continuous:
        what = "Q cannot be measured where agents give numbers: there is no end of actions to play"
        raise InputError(what, played.name, "leave --critic out: all states weigh the same")
    if critic == MEASURED and played.masked:
        what = "Q cannot be measured where actions may be illegal: every action would be played"
        raise InputError(what, played.name, "choose --critic learned or none")
    expert = lawful_expert(expert, played)
    if critic == NONE or (critic == LEARNED and critic_of(expert) == NONE):
        return Unweighted(expert), played
    measured = critic == MEASURED and not isinstance(expert, Measured)
    return (Measured.for_world(played, expert) if measured else expert), played


def seeing(expert: Expert, world: World, features: str) -> tuple[Expert, World]:
    """An expert in its world with further groups of features, and memory, which it does not look at."""
    others, remembers = split_memory(f",{FEATURES}={features}")
    if remembers:
        expert, world = seeing(expert, world, plain_name(others)[1]) if others else (expert, world)
        return Forgetful(expert, world), Remembering(world, remembers)
    if not isinstance(world, ParticleWorld):
        raise InputError("this world has no additional features", f"--features {features}", "leave them out")
    if FEATURES in world.spec.options:
        raise InputError("the expert's world already has additional features", world.name, "leave --features out")
    wide = find_built_in(f"{world.name},{FEATURES}={features}")
    return Narrowed(expert, world), wide


def moving(world: World, physics: str) -> World:
    """One of our games, which moves by the other physics; an expert of the game plays there as it is."""
    return find_built_in(f"{world.name},{PHYSICS}={physics}")


def _resolve_expert(text: Any, world: World | None) -> tuple[Expert, World]:
    """The expert, and its world or, for a function, `world`; with memory where either name has it."""
    own = text.partition("@")[0] if isinstance(text, str) else ""
    plain, remembers = split_memory(own) if own.partition(",")[0] in WORLDS else (own, False)
    inner = world.plain if isinstance(world, Remembering) else world
    expert, played = _resolve_plain(text.replace(own, plain, 1) if remembers else text, inner)
    if not remembers and inner is world:
        return expert, played
    group = remembers or getattr(world, "group", "")
    return Forgetful(expert, played), world if world and played is inner else Remembering(played, group)


def _resolve_plain(text: Any, world: World | None) -> tuple[Expert, World]:
    if not isinstance(text, str):
        given = given_expert(text, world, Source.of(text))
        return given, given.world
    if libraries.is_file(text):
        expert = libraries.from_name(text, world)
        return expert, expert.world
    name, _, script = text.partition("@")
    ours = name.partition(",")[0] in WORLDS
    if is_script(script) and ours:
        game = find_built_in(name)
        return Measured(game, build_script(game, script)), game
    plain, features = plain_name(text) if ours else (text, "")
    if features:  # no expert is shipped for it: the one of the plain world
        find_built_in(text)
        return seeing(*_resolve_plain(plain, None), features)
    still, physics = plain_name(name, PHYSICS) if ours else (name, "")
    learned = text.replace(name, still, 1)
    if physics and learned in network.SHIPPED:
        return network.load(learned)[0], find_built_in(name)
    if ours and "@" not in text and text not in network.SHIPPED:
        game = find_built_in(text)
        return network.load(game.name) if game.name in network.SHIPPED else (Measured(game, build_script(game)), game)
    if is_named_by_user(text):
        expert = import_expert(parse_source(text), world)
        return expert, expert.world
    return network.load(text, world)
