"""Two profiles whose agents test sums or give numbers, compared: the largest difference of each output, and where.

Does: checks that agents can be compared, searches, puts what is found into data and lines.
Assumes: profiles that were checked.
Does not: play episodes, make certificates or a page.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.form import layout
from codegen.policy_json import content_hash, dumps
from codegen.profiles import ensure
from codegen.wording import format_count
from maviper.files import runs
from maviper.verification.files.certificates import AGAINST_FILE
from maviper.verification.outputs.cells import ranges
from maviper.verification.outputs.extremes import Apart, Found, Searched, search
from verify.result import Verdict

FORM = "maviper-difference-outputs-1"
REPORT_FILE = "difference.json"
ALIKE = ("features", "actions", "numbers")  # what two agents must share


@dataclass(frozen=True)
class Agent:
    """An agent compared. PROVED: its trees are the same, or boxes alone show that they give the same numbers."""

    agent: str
    searched: Searched
    verdict: Verdict
    reason: str  # why there is no answer


@dataclass(frozen=True)
class OutputsCompared:
    """Two profiles compared over the ranges of what agents observe."""

    first: ir.PolicyProfile
    second: ir.PolicyProfile
    agents: tuple[Agent, ...]
    unplayable: str = "a page of two profiles shows no sums yet"

    @property
    def verdict(self) -> Verdict:
        """PROVED where all agents act alike, VIOLATED where some does not."""
        verdicts = {one.verdict for one in self.agents}
        if Verdict.VIOLATED in verdicts:
            return Verdict.VIOLATED
        return Verdict.PROVED if verdicts == {Verdict.PROVED} else Verdict.UNKNOWN

    @property
    def verdicts(self) -> list[Verdict]:
        """Each agent's."""
        return [one.verdict for one in self.agents]

    @property
    def facts(self) -> dict[str, Any]:
        """All facts as plain data."""
        return {
            "difference": FORM,
            "profiles": [content_hash(self.first), content_hash(self.second)],
            "verdict": self.verdict.value,
            "agents": [_facts(one) for one in self.agents],
        }

    @property
    def lines(self) -> list[tuple[str, str]]:
        """What a person is told: labels and texts."""
        return [line for one in self.agents for line in _lines(one, self.first.policy(one.agent), self.second)]

    @property
    def files(self) -> dict[str, str]:
        """Both profiles and the report, name -> text."""
        files = {runs.PROFILE_FILE: dumps(self.first), AGAINST_FILE: dumps(self.second)}
        return {**files, REPORT_FILE: layout(self.facts) + "\n"}


def compare_outputs(
    first: ir.PolicyProfile, second: ir.PolicyProfile, agents: Sequence[str], region: str, max_cells: int
) -> OutputsCompared:
    """Compares how far apart what agents give can be. InputError for agents that cannot be compared."""
    if region != "start":
        what = "agents that test sums or give numbers are compared over the ranges of their features"
        raise InputError(what, "--region", "leave it out")
    for profile in (first, second):
        ensure(profile)
    return OutputsCompared(first, second, tuple(_agent(first, second, agent, max_cells) for agent in agents))


def _agent(first: ir.PolicyProfile, second: ir.PolicyProfile, agent: str, max_cells: int) -> Agent:
    one, other = _comparable(first, second, agent)
    comparison = search(one, other, *ranges(one), max_cells)
    if any(each.found for each in comparison.apart):
        return Agent(agent, comparison, Verdict.VIOLATED, "")
    if _same(one.tree, other.tree) and one.outputs == other.outputs:
        return Agent(agent, comparison, Verdict.PROVED, "")
    if comparison.exact and comparison.complete:
        return Agent(agent, comparison, Verdict.PROVED, "")
    why = "linear programs found no difference, which is no proof"
    if not comparison.complete:
        why = f"no difference in {max_cells:,} pairs of leaves, and there are more; a larger --max-cells may find one"
    return Agent(agent, comparison, Verdict.UNKNOWN, why)


def _comparable(first: ir.PolicyProfile, second: ir.PolicyProfile, agent: str) -> tuple[ir.AgentPolicy, ir.AgentPolicy]:
    for profile in (first, second):
        names = [policy.agent for policy in profile.agents]
        if agent not in names:
            raise UnknownNameError("agent", agent, names, "--agent")
    one, other = first.policy(agent), second.policy(agent)
    named = [[(each.name, each.unit) for each in policy.outputs] for policy in (one, other)]
    differing = [name for name in ALIKE if getattr(one, name) != getattr(other, name)]
    differing += ["outputs"] if named[0] != named[1] else []
    if differing:
        what = f"{agent} has different {differing[0]} in the two profiles"
        raise InputError(what, "", "compare policies that observe the same, and do or give the same")
    return one, other


def _same(one: ir.Tree, other: ir.Tree) -> bool:
    arrays = ("feature", "threshold", "left", "right", "action")
    texts = ("numbers", "arithmetic", "sums", "vectors", "gives")
    alike = all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in arrays)
    return alike and all(repr(getattr(one, name)) == repr(getattr(other, name)) for name in texts)


def _facts(one: Agent) -> dict[str, Any]:
    return {
        "agent": one.agent,
        "verdict": one.verdict.value,
        "reason": one.reason,
        "cells": one.searched.cells,
        "outputs": [_apart(each) for each in one.searched.apart],
    }


def _apart(each: Apart) -> dict[str, Any]:
    example = each.found
    at = None if example is None else {"observation": list(example.seen), "leaves": list(example.leaves)}
    return {
        "output": each.output,
        "unit": each.unit,
        "difference": 0.0 if example is None else example.difference,
        "bound": each.most,
        "at": at,
    }


def _lines(one: Agent, policy: ir.AgentPolicy, second: ir.PolicyProfile) -> Iterator[tuple[str, str]]:
    if one.verdict is Verdict.PROVED:
        yield "alike", f"{one.agent}: the same for every observation in the ranges of its features"
        return
    if one.verdict is Verdict.UNKNOWN:
        yield one.verdict.value, f"{one.agent}: {one.reason}"
        return
    looked = f"{format_count(one.searched.cells, 'pair')} of leaves meet{'' if one.searched.complete else ', not all'}"
    yield "different", f"{one.agent}: {looked}"
    for each in one.searched.apart:
        if each.found is None:
            yield "", f"{each.output}: no difference found"
            continue
        yield "", _largest(policy, each, each.found)
        yield "", f"  {_beside(policy, second.policy(one.agent), each.found)}"
        named = zip(policy.features, each.found.seen, strict=True)
        yield "", "  at " + ", ".join(f"{feature.name} {value:.9g}" for feature, value in named)


def _largest(policy: ir.AgentPolicy, each: Apart, largest: Found) -> str:
    if not policy.outputs:
        return "other actions:"
    unit = f" {each.unit}" if each.unit not in ("", "none") else ""
    bound = "" if each.most is None else f", and by no more than {each.most:.6g} by linear programs"
    return f"{each.output} by {largest.difference:.6g}{unit}{bound}:"


def _beside(one: ir.AgentPolicy, other: ir.AgentPolicy, largest: Found) -> str:
    said: list[str] = []
    for policy, leaf in zip((one, other), largest.leaves, strict=True):
        if policy.outputs:
            (given,) = ir.outputs(policy, [largest.seen]).tolist()
            does = ", ".join(f"{spec.name} {value:.6g}" for spec, value in zip(policy.outputs, given, strict=True))
        else:
            does = policy.actions[int(policy.tree.action[leaf])].name
        said.append(f"{does} (leaf {leaf})")
    return " or ".join(said)
