"""A user's PettingZoo parallel environment as a world, by `module:function,option=value`. The slow path.

Does: derives spec, teams, features, actions and measures from an environment; plays one copy per core.
Assumes: numbered actions, or bounded numbers from all agents; vector observations; episodes that follow from their seed
  (`maviper worlds check` tests it).
Does not: know the dynamics, or where episodes start. What a profile must state about them says so: time step, damping,
  sizes and forces are 0, there are no landmarks or goals, and the start region is the widest that a profile may have.

Agents may leave before the others: when the environment terminates or truncates them, or drops them from `agents`. From
then on they take no part in anything: no data, no votes, no rewards. All must be there at the start.

An environment may say more about itself by attributes (its own, or its `unwrapped` environment's):
- `max_cycles`: how long episodes are; the option `max_steps` counts more.
- `alone`: True: one copy a process; "machine": one copy at all.
- `teams`: team -> its agents. Without it, a team is what agents share before the last `_`: `agent_0` is in `agent`;
  teams whose rewards are equal in a random episode are one.
- `features`: agent -> a FeatureSpec for each number that it observes, with unit, range and meaning.
- `action_names`: agent -> a name for each of its actions.
- `outputs`: agent -> an OutputSpec for each number that it gives.
- `measures`: name -> key of infos; sum, mean or last; whether lower or higher is better.
"""

import re
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen import ir
from codegen.dynamics import motionless
from codegen.errors import InputError, UnknownNameError
from codegen.floats import FLOAT32
from codegen.ir import CONSTANT, ActionSpec, Bool, FeatureSpec, Float64, OutputSpec, Sum
from codegen.profiles import check
from codegen.sums import DOUBLE_SUMS
from maviper.worlds.outside import playing, processes, sources
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.playing import PAST, EnvStates, OutsideWorld
from maviper.worlds.outside.processes import Copies, Copy, Probe
from maviper.worlds.outside.sources import Source
from maviper.worlds.outside.spaces import Fault, fault_of, first_action, outputs_of, specs_of, width
from maviper.worlds.seeds import fold_seed
from maviper.worlds.world import RETURN, Int, Measure, Outcome

GAMES_HERE = 32  # copies of an environment that says it `plays_here`
MEASURED_HERE = 128  # ... where only outcomes matter: our part of a step costs half
PROBE_STEPS = 1_000  # of an episode at most, where nobody says how long it is
KNOWN = {"gymnasium", "mpe2", "pettingzoo", "maviper"}  # packages whose environments neither end a process nor wait
MACHINE = "machine"  # value of `alone`: one copy at all
LONGEST_NAME = 40  # of a world: generated code starts with it
_ASKED: dict[tuple[Any, ...], Any] = {}  # what probes and trials of a function's environments said: ask them once


class PettingZooWorld(OutsideWorld):
    """The environment that `function` returns; `text` is its name, `module:function,option=value`, or its source.

    `games`: how many copies play at once, more than one each in a process of its own; None: one per core, or 1 where
    other processes cannot import the function, in processes of their own where that is quicker. Of an environment that
    says it `plays_here`, or whose function was given itself and cannot be imported, GAMES_HERE copies play in this
    process, if they leave each other alone.
    InputError when the environment cannot be played. `close` ends the copies; so does the end of the world.
    """

    def __init__(self, function: Callable[..., Any], text: str | Source, games: int | None = None) -> None:
        self.source = sources.parse_source(text) if isinstance(text, str) else text
        self._function = function
        env = self.reference_env()
        wrong = list(faults(env))
        if wrong:
            places = "\n".join(f"{self.source.text}: {each.what}" for each in wrong)
            raise InputError("the environment cannot be played", places, wrong[0].next_step)
        self.env_agents = tuple(env.possible_agents)  # the environment's own names, in the order of `agents`
        names = sources.legal_names([str(agent) for agent in self.env_agents], "agent")
        called = dict(zip(self.env_agents, names, strict=True))
        self.actions = tuple(_actions(env, agent, self.source) for agent in self.env_agents)
        self.counted_from = tuple(first_action(sources.space(env, "action", agent)) for agent in self.env_agents)
        outputs = tuple(outputs_of(env, agent, self.source) for agent in self.env_agents)
        self.outputs = outputs if any(outputs) else ()
        self.features = tuple(_features(env, agent, self.source) for agent in self.env_agents)
        stated = sources.read_length(env, self.source)
        given = sources.read_teams(env, called, self.source)
        alike = {} if given else sources.teams_by_name(tuple(names))
        probe = self._probe(env, stated, len(alike) > 1)
        self.length_stated, self.length_known = stated is not None, stated is not None or bool(probe and probe.cut)
        steps = stated or (probe.steps if probe and probe.cut else PROBE_STEPS)
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", self.source.called)[-LONGEST_NAME:].lstrip("-_0123456789")
        self.spec = motionless(name or "environment", self.source.reference, names, steps, self.source.options)
        self.teams = given or sources.join_equals(alike, names, probe.rewards if probe else [])
        self.joined = not given and self.teams != alike
        self._told = sources.read_told(env, self.source)
        told = [
            Measure(team, each.name, lower_is_better=each.lower_is_better) for team in self.teams for each in self._told
        ]
        self.measures = (*(Measure(team, RETURN) for team in self.teams), *told)
        self._ensure()
        at_once, apart = self._at_once(env) if games is None else (games, games > 1)
        self.games = at_once
        Copy(env, self.source).close()  # it has said what it had to
        make = partial(make_environment, function, self.source)
        alone = apart is False and playing.steps_alone(env) and not self._told
        self._copies = playing.Together(self.source, make) if alone else Copies(self.source, make, at_once, apart)
        self.plays_here = apart is False and at_once > 1
        self._moment, self.branches = PAST, False
        weakref.finalize(self, self._copies.close)

    def _at_once(self, env: Any) -> tuple[int, bool | None]:
        """Returns the number of copies that play at once, and True if each has its own process; None: to be tried."""
        at_once = processes.copies_at_once(self._function, self.source)
        alone = sources.attribute(env, "alone", self.source)
        if alone is True or alone == MACHINE:
            return (1, False) if alone == MACHINE else (at_once, True)
        given = self.source.maker is not None and not processes.is_importable(self._function, self.source)
        if (given or sources.attribute(env, "plays_here", self.source)) and self._may_share(env, given):
            return GAMES_HERE, False
        return at_once, None

    def _may_share(self, env: Any, here: bool) -> bool:
        """Returns True if copies leave each other alone. `here`: no other process can try that."""
        key = "share", self._function, self.source.text
        if key not in _ASKED:
            if here or _packages(env) <= KNOWN:
                _ASKED[key] = processes.is_undisturbed(self._copy(), Copy(env, self.source))
            else:
                _ASKED[key] = processes.is_importable(self._function, self.source) and processes.may_share(self.source)
        return _ASKED[key]

    def _probe(self, env: Any, stated: int | None, several: bool) -> Probe | None:
        """A random episode, where nobody says how long one is, or (`several`) which agents are a team. It is played
        apart: an environment may end its process, or wait for ever.
        """
        if stated is not None and not several:
            return None
        most = min(stated or PROBE_STEPS, PROBE_STEPS)
        key = "probe", self._function, self.source.text
        with suppress(*[InputError] * (stated is not None)):  # it comes up in play
            if key not in _ASKED:
                here = _packages(env) <= KNOWN or not processes.is_importable(self._function, self.source)
                copy = Copy(env, self.source)
                _ASKED[key] = processes.probe_episode(copy, most) if here else processes.probe_apart(self.source, most)
            return _ASKED[key]
        return None

    def _ensure(self) -> None:
        """InputError where a profile could not be what the environment says about itself."""
        for features, choices in zip(self.features, self.actions, strict=True):
            names = [feature.name for feature in features]
            for action in choices:
                if action.legal_if and action.legal_if not in names:
                    raise UnknownNameError("feature in `legal`", action.legal_if, names, self.source.text)
        # a leaf takes no heed of masks
        lawless = [tuple(replace(action, legal_if="") for action in choices) for choices in self.actions]
        everything = zip(self.agents, self.features, lawless, self.given, strict=True)
        policies = tuple(
            ir.AgentPolicy(agent, self.team_of(agent), features, actions, _leaf(outputs), outputs=outputs)
            for agent, features, actions, outputs in everything
        )
        profile = ir.PolicyProfile(self.spec, policies, ir.Provenance("", "", 0, "", ""))
        wrong = "\n".join(f"{self.source.text}: {each.path}: {each.message}" for each in check(profile))
        if wrong:
            advice = "fix its `features`, `action_names` or `outputs`"
            raise InputError("a profile cannot hold what the environment declares", wrong, advice)

    @property
    def games_measured(self) -> int | None:
        """More than `games` of those that are stepped here without dictionaries."""
        return max(self.games or 1, MEASURED_HERE) if isinstance(self._copies, playing.Together) else self.games

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> EnvStates:
        """The start states after `reset(seed=...)`, one for each of at most `games_measured` seeds, see `fold_seed`."""
        most = self.games_measured or 1
        assert 0 < len(seeds) <= most, f"{len(seeds)} games asked of {most} copies"
        given = [fold_seed(int(seed)) for seed in seeds]
        states = self._ask_copies("reset", given)
        return replace(states, pasts=playing.start_pasts(given)) if self.branches else states

    def step(self, state: EnvStates, actions: Int) -> EnvStates:
        """The next states; RuntimeError for any state but the newest, since the copies cannot go back. A branched state
        has copies of its own, which go on with the next one.
        """
        acted = np.asarray(actions).tolist()
        if state.copies:
            outcomes = [copy.ask("step", each) for copy, each in zip(state.copies, acted, strict=True)]
            return replace(_states(outcomes), copies=state.copies)
        if state.moment == PAST or state.moment != self._moment:
            raise RuntimeError("only the newest state of all games can be stepped: the copies have moved on")
        assert len(actions) == len(state)
        states = self._ask_copies("step", acted)
        return states if state.pasts is None else replace(states, pasts=playing.continue_pasts(state.pasts, acted))

    def _ask_copies(self, verb: str, arguments: Sequence[Any]) -> EnvStates:
        self._moment = PAST  # in case the copies fail
        states = self._copies.ask(verb, arguments)
        states = states if isinstance(states, EnvStates) else _states(states)
        self._moment = next(playing.MOMENTS)
        return replace(states, moment=self._moment)

    def branch(self) -> None:
        """Lets states be branched from now on; InputError where the environment cannot be copied."""
        if not self.plays_here:
            super().branch()
        playing.ensure_copies(self._copy, self.name)
        self.branches = True

    def branch_states(self, state: EnvStates) -> EnvStates:
        """The same states with copies of their own, so that they can be stepped, once."""
        assert state.pasts is not None, "the world was not told to branch"
        return replace(state, copies=tuple(playing.copies_of(state.pasts, self._copy)))

    def _copy(self) -> Copy:
        return Copy(self.reference_env(), self.source)

    def playing(self, state: EnvStates) -> Bool:
        """Whose episode goes on, [batch, n_agents]; nobody's where nobody can act."""
        return ~state.done & state.acting.any(axis=1, keepdims=True)

    def values(self, states: Sequence[EnvStates]) -> Float64:
        """Each team's return, then what the environment measures, [n_measures, batch]: the mean over the team's agents
        whose infos tell it. InputError where none does.
        """
        told = np.stack([state.told for state in states])
        rows = [
            sources.Told("", "", sources.MEAN, False).reduce(each.reduce(told[:, :, self.members(team), place]).T)
            for team in self.teams
            for place, each in enumerate(self._told)
        ]
        for measure, row in zip(self.measures[len(self.teams) :], rows, strict=True):
            if np.isnan(row).any():
                advice = "its infos must tell each of its `measures` once in an episode"
                raise InputError(f"no agent is told {measure.label} in an episode", self.source.text, advice)
        return np.stack([*super().values(states), *rows])

    def reference_env(self) -> Any:
        """A fresh environment."""
        return make_environment(self._function, self.source)

    def close(self) -> None:
        """Ends the copies; see `World.close`."""
        self._moment = PAST
        self._copies.close()


def _packages(env: Any) -> set[str]:
    """The packages of an environment and of those that it wraps."""
    found = set[str]()
    while env is not None:
        found |= {type(each).__module__.partition(".")[0] for each in (env, getattr(env, "unwrapped", env))}
        env = getattr(env, "env", None) or getattr(env, "aec_env", None)
    return found


def _leaf(outputs: Sequence[OutputSpec]) -> ir.Tree:
    """A tree that always takes the first action, or gives the least numbers."""
    parts = [np.array([value]) for value in (ir.NO_FEATURE, 0, ir.NO_CHILD, ir.NO_CHILD, 0)]
    least = tuple(Sum(((each.low or 0.0, CONSTANT),)) for each in outputs)
    return ir.Tree(*parts, vectors=(least,), arithmetic=DOUBLE_SUMS, gives=FLOAT32) if least else ir.Tree(*parts)


def _states(outcomes: Sequence[Outcome]) -> EnvStates:
    observations = zip(*(outcome.observations for outcome in outcomes), strict=True)
    rewards, done, terminated, acting, told = map(np.array, zip(*(outcome[1:] for outcome in outcomes), strict=True))
    return EnvStates(tuple(map(np.array, observations)), rewards, done, terminated, acting, told)


def user_world(text: str) -> PettingZooWorld:
    """The world `module:function,option=value`. It runs the user's code: never call it with a name from a data file."""
    source = sources.parse_source(text)
    return PettingZooWorld(import_maker(source), source.text)


# --- what an environment must be


def faults(env: Any) -> Iterator[Fault]:
    """Lists the faults of the agents and spaces of a parallel environment."""
    agents = list(getattr(env, "possible_agents", []))
    if not agents:
        yield Fault("agents: possible_agents is missing or empty", "list the names of all agents there")
    if len({str(agent) for agent in agents}) < len(agents):
        yield Fault("agents: a name appears twice in possible_agents", "give each agent a name of its own")
    for agent in agents:
        for kind, wrong in (("action", fault_of), ("observation", _observation_fault)):
            try:
                flaw = wrong(sources.space(env, kind, agent))
            except (Exception, SystemExit) as error:
                said = f"{type(error).__name__}: {error}"
                flaw = Fault(f"{kind}_space raised {said}", f"return the agent's space from {kind}_space(agent)")
            if flaw:
                yield Fault(f"{kind}s: {agent}: {flaw.what}", flaw.next_step)
    with suppress(Exception):  # told above
        giving = [bool(width(sources.space(env, "action", agent))) for agent in agents]
        if any(giving) and not all(giving):
            yield Fault("actions: some agents give numbers, others choose", "let all of them do the same")


def _observation_fault(space: Any) -> Fault | None:
    from gymnasium.spaces import Box

    if not isinstance(space, Box):
        return Fault(f"the space is a {type(space).__name__}, not a Box", "flatten it: the option wrap=flatten")
    if len(space.shape) != 1 or space.shape[0] < 1:
        return Fault(f"the space has shape {space.shape}, not (n,)", "flatten it: the option wrap=flatten")
    if not np.issubdtype(space.dtype, np.floating):
        return Fault(f"the space holds {space.dtype}, not floats", "make it a Box of float32")
    return None


# --- what an environment says about itself


def _features(env: Any, agent: Any, source: Source) -> tuple[FeatureSpec, ...]:
    box = sources.space(env, "observation", agent)
    given = sources.table(env, "features", source)
    if agent in given:
        features = tuple(given[agent]) if isinstance(given[agent], Iterable) else ()
        if len(features) != box.shape[0] or not all(isinstance(feature, FeatureSpec) for feature in features):
            what = f"the features of {agent} are not {box.shape[0]} FeatureSpecs, one for each number that it observes"
            raise InputError(what, source.text, "fix the environment's `features`, or leave this agent out of it")
        return features
    return tuple(specs_of([(f"feature_{k}", "none") for k in range(box.shape[0])], box))


def _actions(env: Any, agent: Any, source: Source) -> tuple[ActionSpec, ...]:
    names = sources.action_names(env, agent, source)
    legal = sources.read_legal_features(env, agent, source) or tuple("" for _ in names)
    if len(legal) != len(names):
        what = f"`legal` names {len(legal)} features for the {len(names)} actions of {agent}"
        raise InputError(what, source.text, 'name one for each action, "" where it is always legal')
    return tuple(ActionSpec(name, None, feature) for name, feature in zip(names, legal, strict=True))
