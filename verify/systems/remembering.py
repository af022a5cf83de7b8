"""Memory of agents as variables of the system that a file states.

Does: adds a variable AGENT.MEMORY for each thing that an agent of a profile remembers, a mode where it has few values;
  the rules that an agent's actions change it by, all at once, in steps or at samples.
Assumes: a file that states the agent's other features, and all actions that are taken.
Does not: say how the rest of the system moves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product

from codegen.errors import InputError
from codegen.ir import AgentPolicy, PolicyProfile
from codegen.memory import tabulate_updates
from verify.language.units import PURE
from verify.systems.enclosures import pieces
from verify.systems.expressions import Expression, Name, Number, Product, Sum
from verify.systems.statement import Agent, Rule, Statement, set_modes
from verify.systems.system import Affine, Feature, Flow, Interval, System, Variable, box_of

MAX_MODES = 1_024  # values of a memory that is a mode; of more, it is a number with a range
KEPT, PLUS = "kept", "plus"  # inputs that an action sets: a factor of what was, and what is added


def with_memory(statement: Statement, profile: PolicyProfile) -> Statement:
    """The statement with what agents remember; as it is where none does. InputError for names that are taken, and for
    actions that the file does not state.
    """
    policies = {policy.agent: policy for policy in profile.agents if policy.memory}
    own = {each.name: policies[each.name] for each in statement.agents if each.name in policies}
    if not own:
        return statement
    steps = statement.system.flow is None
    added = tuple(each for policy in own.values() for each in _list_variables(policy, steps))
    for each in added:
        if each.name in statement.names.known:
            raise InputError(f"the file has {each.name}, which is remembered", statement.place, "give it another name")
    variables = (*statement.system.variables, *added)
    parts = {each.name: _cut_range(each, statement, own) for each in added}
    agents = tuple(
        _with_updates(each, own[each.name], parts, statement) if each.name in own else each
        for each in set_modes(statement.agents, statement.system.variables)
    )
    rules = tuple(moved for each in statement.rules for moved in _move_rule(each, agents, parts))
    start: dict[str, Interval] = {}
    features = {agent: dict(stated) for agent, stated in statement.system.features.items()}
    for policy in own.values():
        for each in policy.memory:
            name, begun = f"{policy.agent}.{each.name}", Fraction(each.initial or 0) - Fraction(each.low)
            start[name] = begun, begun
            features[policy.agent][each.name] = Feature(Affine.of({name: Fraction(1)}, Fraction(each.low)))
    system: System = replace(
        statement.system,
        variables=variables,
        features=features,
        start=(*statement.system.start, *box_of(start)),
        pieces=pieces(rules, variables, statement.place / "dynamics"),
        flow=None if statement.system.flow is None else _move_flow(statement.system.flow, agents, own),
    )
    known = {**statement.names.known, **dict.fromkeys(start, PURE)}
    return replace(statement, system=system, agents=agents, rules=rules, names=replace(statement.names, known=known))


def _list_variables(policy: AgentPolicy, steps: bool) -> list[Variable]:
    """A variable for each memory, from 0 on; of a flow, whose jumps only set modes, what is added to is a number."""
    made: list[Variable] = []
    for each in policy.memory:
        count = int(each.high - each.low) + 1
        few = 2 <= count <= MAX_MODES and (steps or not _list_added(policy, each.name))
        modes = tuple(str(int(each.low) + k) for k in range(count)) if few else ()
        made.append(Variable(f"{policy.agent}.{each.name}", "1", (Fraction(0), Fraction(count - 1)), modes))
    return made


def _list_added(policy: AgentPolicy, memory: str) -> set[int]:
    """The numbers that actions add to a memory."""
    return {u.value for action in policy.actions for u in action.updates if u.memory == memory and u.adds}


def _cut_range(variable: Variable, statement: Statement, own: Mapping[str, AgentPolicy]) -> list[Interval]:
    """The parts of a counter's range in which each addition leads to a value everywhere, or nowhere: the agent's tests
    rule out the latter.
    """
    agent, _, memory = variable.name.partition(".")
    last = int(variable.range[1])
    if not variable.modes:
        return [variable.range]
    added = _list_added(own[agent], memory)
    starts = sorted({0, *(last + 1 - each if each > 0 else -each for each in added)} & {*range(last + 1)})
    return [(Fraction(low), Fraction(end - 1)) for low, end in pairwise([*starts, last + 1])]


def _with_updates(
    agent: Agent, policy: AgentPolicy, parts: Mapping[str, list[Interval]], statement: Statement
) -> Agent:
    """The agent with the actions that change its memory, each of which sets what the action that is taken does."""
    keeps, adds = tabulate_updates(policy)
    actions = dict(agent.actions)
    for action in policy.actions:
        taken = action.acts or action.name
        if taken not in agent.actions:
            raise InputError(f"the file states no action {taken} of {agent.name}", statement.place, "add it")
        actions[action.name] = agent.actions[taken]
    numbers = {action.name: row for row, action in enumerate(policy.actions)}
    whole: dict[str, Mapping[str, Expression]] = {}
    for name, settings in actions.items():
        more: dict[str, Expression] = {}
        for column, each in enumerate(policy.memory):
            kept, plus = (
                int(of[numbers[name], column]) if name in numbers else 1 - k for k, of in enumerate((keeps, adds))
            )
            variable, count = f"{policy.agent}.{each.name}", int(each.high - each.low)
            more[f"{variable}.{KEPT}"] = Number(Fraction(kept))
            for part, (low, high) in enumerate(parts[variable]):
                leaves = kept and not 0 <= low + plus <= high + plus <= count
                value = 0 if leaves and len(parts[variable]) > 1 else plus if kept else plus - int(each.low)
                more[f"{variable}.{PLUS}{part}"] = Number(Fraction(value))
        whole[name] = {**settings, **more}
    return replace(agent, actions=whole)


def _next(variable: str, part: int = 0) -> Expression:
    return Sum(Product(Name(f"{variable}.{KEPT}"), Name(variable)), Name(f"{variable}.{PLUS}{part}"))


def _move_rule(rule: Rule, agents: tuple[Agent, ...], parts: Mapping[str, list[Interval]]) -> Iterator[Rule]:
    """A rule of steps that moves memory, too, for all parts of ranges. InputError for matrices, which say nothing of
    it.
    """
    if not rule.next:
        advice = "write [dynamics.next] in place of matrices"
        raise InputError("an agent remembers something, and rules are matrices", rule.place, advice)
    for chosen in product(*(range(len(each)) for each in parts.values())):
        at = dict(zip(parts, chosen, strict=True))
        where = {name: parts[name][part] for name, part in at.items() if len(parts[name]) > 1}
        moved = {name: _next(name, part) for name, part in at.items()}
        yield replace(rule, where={**rule.where, **where}, next={**rule.next, **moved}).of_actions(agents)


def _move_flow(flow: Flow, agents: tuple[Agent, ...], own: Mapping[str, AgentPolicy]) -> Flow:
    """A flow at whose samples memory changes, too."""
    held, moved = dict(flow.held), dict[str, Expression]()
    for agent in agents:
        policy = own.get(agent.name)
        if policy is None:
            continue
        moved |= {name: _next(name) for name in (f"{agent.name}.{each.name}" for each in policy.memory)}
        taken = {action.name: action.acts or action.name for action in policy.actions}
        for name, settings in agent.actions.items():
            numbers = {one: each.value for one, each in settings.items() if isinstance(each, Number)}
            held[agent.name, name] = {**numbers, **flow.held.get((agent.name, taken.get(name, name)), {})}
    still: dict[str, Expression] = dict.fromkeys(moved, Number(Fraction(0)))
    cases = tuple(replace(each, rates={**each.rates, **still}, jumps={**each.jumps, **moved}) for each in flow.cases)
    return replace(flow, held=held, cases=cases, rates={**flow.rates, **still}, jumps={**flow.jumps, **moved})
