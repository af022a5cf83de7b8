"""Claims over observations of agents that give numbers or test sums, as a world file in which nothing moves.

Does: writes that file: a variable for each feature, over the ranges that are asked about; agents that observe them.
Assumes: a checked profile; properties as data.
Does not: decide. Whoever checks a certificate has the file beside it, and reads what it is about.

An agent of which `robust` is claimed stands twice. Its copy acts by the same tree and observes each feature with an
error, which is a variable too: `cart_off.spin` is by how much the spin that `cart_off` observes is off.
"""

from collections.abc import Iterator, Mapping
from fractions import Fraction

from codegen.errors import InputError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.language.tables import properties
from verify.claims.observed import View, over, variable
from verify.claims.region import Interval, Region
from verify.decimals import text as number_text
from verify.language.arithmetic import unit_of
from verify.systems.properties import ROBUST, copy_called, errors_of
from verify.systems.values import ADVICE, NAME, only, text
from verify.toml_places import parse

HEAD = """\
# Observations: each variable is a feature. Every combination of numbers in these ranges is a state.
name = "observations"
observed = true
"""
Errors = Mapping[str, Mapping[str, Fraction]]  # agent -> feature -> the largest error that a claim speaks of


def world_of(profile: PolicyProfile, view: View, region: Region, errors: Errors) -> str:
    """The world file. `region`: of the view's variables; `errors`: of the agents that stand twice.

    InputError for names that formulas cannot hold, and for a region that is more than bounds of single variables.
    """
    if region.differences or region.apart:
        advice = 'write them into a property: region = { where = ["angle - spin <= 1/2"] }'
        raise InputError("claims about numbers and sums take bounds of single variables", "--region", advice)
    _ensure_named(profile)
    units = {one.name: _unit(one.unit) for one in over(profile, view).world.variables}
    ranges = dict(region.box)
    for agent, features in errors.items():
        for feature, most in features.items():
            name = f"{copy_called(agent)}.{feature}"
            ranges[name], units[name] = (-most, most), units[variable(profile, view, agent, feature)]
    variables = "".join(f'"{name}" = {{ unit = "{units[name]}", range = {_ends(ranges[name])} }}\n' for name in ranges)
    agents = "".join(part for policy in profile.agents for part in _tables(profile, view, policy, errors))
    starts = ", ".join(f'"{name}" = {_ends(ends)}' for name, ends in ranges.items())
    return f"{HEAD}\n[variables]\n{variables}{agents}\n[start]\nbox = {{ {starts} }}\n"


def errors_in(source: str, profile: PolicyProfile, where: str) -> dict[str, dict[str, Fraction]]:
    """The largest errors that the claims `robust` of a property file allow, of each agent that they are about."""
    document, file = parse(source, where, "not a readable property file", ADVICE)
    agents = {policy.agent: policy for policy in profile.agents if policy.outputs}
    stated: dict[str, dict[str, Fraction]] = {}
    for described, place in properties(document, file):
        if described.get("name") != ROBUST:
            continue
        agent = text(described.get("agent", ""), place / "agent")
        only({agent: None}, agents, place / "agent", "agent that gives numbers")
        largest = stated.setdefault(agent, {})
        for name, most in errors_of(described, {each.name: each for each in agents[agent].features}, place).items():
            largest[name] = max(most, largest.get(name, most))
    return stated


def _tables(profile: PolicyProfile, view: View, policy: AgentPolicy, errors: Errors) -> Iterator[str]:
    """The tables of an agent, and of its copy."""
    observed = {each.name: variable(profile, view, policy.agent, each.name) for each in policy.features}
    yield _agent(policy, policy.agent, f'team = "{policy.team}"', observed)
    if policy.agent in errors:
        copy = copy_called(policy.agent)
        erring = errors[policy.agent]
        off = {name: f"{read} + {copy}.{name}" if name in erring else read for name, read in observed.items()}
        yield _agent(policy, copy, f'like = "{policy.agent}"', off)


def _agent(policy: AgentPolicy, name: str, head: str, observed: Mapping[str, str]) -> str:
    features = "".join(f'{feature} = "{read}"\n' for feature, read in observed.items())
    outputs = "".join(f'{each.name} = "{_unit(each.unit)}"\n' for each in policy.outputs)
    actions = "".join(f"{each.name} = {{}}\n" for each in policy.actions)
    acting = f"[agents.{name}.outputs]\n{outputs}" if outputs else f"[agents.{name}.actions]\n{actions}"
    return f"\n[agents.{name}]\n{head}\n[agents.{name}.features]\n{features}{acting}"


def _ends(ends: Interval) -> str:
    return f"[{', '.join(map(number_text, ends))}]"


def _unit(unit: str) -> str:
    """The unit as world files write it; a free text that is none counts as a pure number."""
    try:
        unit_of(unit, "")
    except InputError:
        return ""
    return unit


def _ensure_named(profile: PolicyProfile) -> None:
    """InputError for a name that formulas about numbers cannot hold."""
    for policy in profile.agents:
        names = (policy.agent, *(each.name for each in (*policy.features, *policy.outputs)))
        for name in names:
            if not NAME.fullmatch(name):
                advice = "rename it where the profile comes from: letters, digits and _, a letter first"
                raise InputError(f"formulas about numbers cannot name {name}", policy.agent, advice)
