"""A team of trees as an object: it acts, is saved, drawn and printed.

Does: maps agents' names to policies; takes observations as an environment gives them and returns what its step takes;
  writes profile, rules, SVG and LaTeX.
Assumes: a checked profile; an environment of its world, where observations or actions have a form that vectors lack.
Does not: learn, prove or measure.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir, policy_json
from codegen.deciding import decide
from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy, Int64, PolicyProfile
from codegen.memory import initial_memory, step_memory
from codegen.wording import format_count
from maviper.evaluation.show import tell_rules
from maviper.files import runs
from maviper.importing.edits import change_threshold
from maviper.page.latex import draw_forest
from maviper.worlds.outside.sources import is_mapping, legal_names, space
from maviper.worlds.outside.spaces import MASK, taking
from maviper.worlds.remembering import hide_remembered

OBSERVATION = "observation"  # the key beside a mask, by PettingZoo's convention
NAMED = 4  # agents that a line names
GIVE = "give observations as the environment does; where they are dictionaries or pictures: load(PATH, world=...)"


class NoAgentError(UnknownNameError, KeyError):
    """A team has no agent of that name."""


@dataclass(frozen=True, eq=False, repr=False)
class Team(PolicyProfile, Mapping[str, AgentPolicy]):
    """The trees of all agents: a profile that acts. It maps agents' names to policies.

        team = maviper.load("team.json")
        rows = team["agent_0"].act([[0.5] * 10])     # rows of features [n, n_features] -> [n]
        actions = team.act({"agent_0": seen})        # what env.step takes, by the environment's names
        team.save("again.json")

    Whatever takes a profile takes a team.
    """

    #: its world, found when it is first needed; None where nobody said it
    played: Callable[[], Any] | None = field(default=None, kw_only=True)
    __eq__, __hash__ = object.__eq__, object.__hash__

    @staticmethod
    def of(profile: PolicyProfile, played: Callable[[], Any] | None = None) -> "Team":
        """Makes a team of a profile.

            team = Team.of(profile)

        Args:
            profile: The profile.
            played: Returns the team's world.
        """
        parts = {each.name: getattr(profile, each.name) for each in fields(PolicyProfile)}
        return Team(**parts, played=played or getattr(profile, "played", None))

    def __getitem__(self, agent: str) -> AgentPolicy:
        """The policy of an agent; UnknownNameError, which is a KeyError here, where there is none."""
        for policy in self.agents:
            if policy.agent == agent:
                return policy
        raise NoAgentError("agent", str(agent), list(self))

    def __iter__(self) -> Iterator[str]:
        return iter(policy.agent for policy in self.agents)

    def __len__(self) -> int:
        return len(self.agents)

    def __contains__(self, agent: object) -> bool:
        return any(policy.agent == agent for policy in self.agents)

    def __repr__(self) -> str:
        sizes = [f"{each.agent} {format_count(len(ir.leaves(each.tree)), 'leaf')}" for each in self.agents[:NAMED]]
        more = [f"{len(self) - NAMED} more"] if len(self) > NAMED else []
        deepest = max(int(ir.depth(each.tree).max()) for each in self.agents)
        return f"Team('{self.world.name}': {', '.join([*sizes, *more])}, depth {deepest})"

    def _repr_html_(self) -> str:
        """The trees, drawn, for notebooks; the line alone where they are too large to be drawn."""
        try:
            return f"<div>{self.to_svg()}</div>"
        except InputError:
            return f"<code>{self!r}</code>"

    def act(self, observations: Any, infos: Mapping[Any, Any] | None = None, agents: Any = None) -> Any:
        """Returns what `env.step` takes: for each agent that observes, an action of its action space.

            while env.agents:
                seen, rewards, ended, cut, infos = env.step(team.act(seen, agents=env.agents))

        Agents that remember something go on from their own last decision, since `reset`.

        Args:
            observations: Agent -> observation, by the names and in the form that the environment has. Of a single agent
                the observation alone is taken too, and its action returned.
            infos: The environment's, where masks are in them.
            agents: The agents that act; default: all that observe. PettingZoo shows agents that have just left their
                last observation, so a loop says `agents=env.agents`.

        Raises:
            InputError: An observation has another size.
        """
        given = infos or {}
        if len(self) == 1 and not self._names_agents(observations):
            (only,) = self._seats
            return self._decide(only, observations, given)
        if not is_mapping(observations):
            what = f"observations of {format_count(len(self), 'agent')} are a {type(observations).__name__}"
            raise InputError(what, self.world.name, "give agent -> observation, as the environment does")
        among: set[Any] = set(observations if agents is None else agents)
        acting: list[Any] = [agent for agent in observations if agent in among]
        return {agent: self._decide(agent, observations[agent], given.get(agent, {})) for agent in acting}

    def reset(self) -> None:
        """Has all agents forget what they remember, as at the start of an episode; of others, it does nothing.

        Example::

            observations, infos = env.reset(seed=1)
            team.reset()
        """
        self._remembered.clear()

    @cached_property
    def _remembered(self) -> dict[Any, Int64]:
        """What each agent that decided since the reset remembers."""
        return {}

    def _names_agents(self, observations: Any) -> bool:
        if not is_mapping(observations):
            return False
        return all(agent in self._seats or str(agent) in self for agent in observations)

    @cached_property
    def _world(self) -> Any:
        world = None if self.played is None else self.played()
        return world if hasattr(world, "reference_env") else None

    @cached_property
    def _env(self) -> Any:
        return None if self._world is None else self._world.reference_env()

    @cached_property
    def _seats(self) -> dict[Any, AgentPolicy]:
        """The policies by the environment's own names of agents."""
        names = self if self._world is None else self._world.env_agents
        return dict(zip(names, self.agents, strict=True))

    def _decide(self, agent: Any, seen: Any, info: Mapping[str, Any]) -> Any:
        policy = self._seats.get(agent)
        if policy is None:
            policy = self[str(agent) if str(agent) in self else legal_names([str(agent)], "agent")[0]]
        read = getattr(self._env, "read", None)
        try:
            row = _flatten(policy, seen) if read is None else np.ravel(read(agent, seen, info))
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            what = f"what {policy.agent} is said to observe cannot be read: {type(error).__name__}: {error}"
            raise InputError(what[:300], self.world.name, GIVE) from None
        if policy.memory and self._world is not None:
            row = hide_remembered(self._world, policy, row)
        width = len(policy.features) - len(policy.memory)
        if row.size != width:
            what = f"{policy.agent} observes {format_count(width, 'number')}, and {row.size} are given"
            raise InputError(what, self.world.name, GIVE)
        if policy.memory:
            before = self._remembered.get(agent, initial_memory(policy))
            (chosen,), (self._remembered[agent],) = step_memory(policy, before[None], row[None])
        else:
            (chosen,) = decide(policy, row[None])
        if self._env is not None:
            return taking(space(self._env, "action", agent))(chosen)
        if policy.outputs:
            return np.array(chosen)
        first = int(self.provenance.training.get(f"{policy.agent} {ir.COUNTED}", 0))
        return first + int(chosen) if first else policy.actions[int(chosen)].known_as(int(chosen))

    def save(self, path: str | Path) -> Path:
        """Writes the profile, which `maviper.load` reads again; equal teams give equal bytes. Returns the path.

            again = maviper.load(team.save("team.json"))

        Raises:
            InputError: The file cannot be written.
            MissingToolError: There is no room for it.
        """
        return runs.write(Path(path), policy_json.dumps(self))

    def to_text(self) -> str:
        """Returns the trees as rules, one line for each leaf; `maviper show` prints them.

            print(team.to_text())

        A line has the tests on the way to the leaf, and what the leaf decides.
        """
        return "\n".join(tell_rules(self, self.agents))

    def to_svg(self) -> str:
        """Draws the trees as one SVG.

            Path("team.svg").write_text(team.to_svg())

        Raises:
            InputError: There are trees of thousands of nodes.
        """
        from maviper.page.page import svg

        return svg(self, list(self))

    def to_latex(self) -> str:
        r"""Draws the trees in LaTeX, by the package forest: `\usepackage{forest}`, then the text as it is.

            Path("team.tex").write_text(team.to_latex())

        Raises:
            InputError: There are trees of thousands of nodes.
        """
        return draw_forest(self)

    def with_threshold(self, agent: str, node: int, value: float) -> "Team":
        """Returns the team with another threshold at one node, which its provenance says.

            team = team.with_threshold("agent_0", node=3, value=0.3)

        Args:
            agent: Whose tree it is.
            node: The node, in preorder from 0.
            value: The threshold, in the feature's unit. The tree compares with the largest number of its type that is
                not above it.

        Raises:
            InputError: The node tests nothing, or the value is no finite number.
        """
        return Team.of(change_threshold(self, self[agent], node, value))


def _flatten(policy: AgentPolicy, seen: Any) -> Any:
    """An observation as its numbers in a row; of a dictionary with a mask, the mask behind them."""
    if is_mapping(seen):
        if set(seen) != {OBSERVATION, MASK}:
            what = f"{policy.agent} observes a dictionary of {', '.join(map(str, seen))}"
            raise InputError(what, "", "say how it is flattened, by the environment: load(PATH, world=...)")
        return np.concatenate([np.ravel(seen[OBSERVATION]), np.ravel(seen[MASK])])
    return np.ravel(np.asarray(seen))
