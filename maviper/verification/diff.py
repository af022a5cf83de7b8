"""Comparing two profiles: where they act differently, and in how many of the states met.

Does: hands `verify.verdicts.differences` the profiles, counts in sampled states and in those that the first one meets,
  renders the files.
Assumes: states met are known where the world is one of ours.
Does not: decide, print or write files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack, cast

from codegen import ir
from codegen.deciding import ensure_forgets, sums_in
from codegen.errors import InputError
from codegen.intervals import Share
from codegen.lowering.render import render
from codegen.policy_json import dumps
from codegen.profiles import ensure
from codegen.rows import Shown
from maviper.episodes.trees import ON_POLICY_EPISODES, on_policy
from maviper.evaluation.comparison import differing
from maviper.files import runs
from maviper.files.profiles import find_region
from maviper.options import DiffOptions, make_request
from maviper.verification.ask import MAX_CELLS, resolve_region
from maviper.verification.compared import OutputsCompared, compare_outputs
from maviper.verification.files.certificates import AGAINST_FILE
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.matching import ensure_places, matching_places
from verify.certificates.games import to_json
from verify.claims.observed import View
from verify.claims.region_files import START
from verify.claims.views import RANGES, Viewed, confine_region, unread
from verify.kinds import SEMANTICS
from verify.question import UNITS_A_NODE, Budgets
from verify.reports import differences as report
from verify.result import Verdict
from verify.states.shares import SAMPLE_SEED, SAMPLES
from verify.states.state import sample
from verify.verdicts.differences import (
    UNSHARED,
    Difference,
    difference,
    forget,
    make_whole,
    name_memory,
    say_alike,
    unite_actions,
)

CERTIFICATE_FILE, REPORT_FILE = "certificate.json", "difference.json"
MAX_NODES = 10**12


def request(**options: Unpack[DiffOptions]) -> Any:
    """The options of a comparison. InputError for one that cannot be used."""
    asked = make_request(DiffOptions, options)
    budgets = _budgets(asked)
    if asked.semantics not in SEMANTICS:
        raise InputError("the semantics must be machine or real", "--set semantics")
    if not 0 < budgets.max_nodes <= MAX_NODES:
        raise InputError(f"the number of nodes must be between 1 and {MAX_NODES}", "--set max_nodes")
    if not 0 < budgets.max_cells <= MAX_CELLS:
        raise InputError(f"the number of zones must be between 1 and {MAX_CELLS}", "--set max_cells")
    return asked


def _budgets(asked: Any) -> Budgets:
    """Returns what may be spent; Z3 gets as much as it does where it decides beside the zones."""
    usual = Budgets.of_effort(asked.effort)
    nodes = usual.max_nodes if asked.max_nodes is None else asked.max_nodes
    cells = min(usual.max_cells, MAX_CELLS) if asked.max_cells is None else asked.max_cells
    return Budgets(min(nodes * UNITS_A_NODE, 2**32 - 1), nodes, cells, option="--effort")


BESIDE_ZERO = (  # a bound that is the smallest normal float32 number, and the test of a rule that it comes from
    ("-1.175e-38 < ", "0 <= "),
    (" <= -1.175e-38", " < 0"),
    ("1.175e-38 <= ", "0 < "),
    (" < 1.175e-38", " <= 0"),
)


@dataclass(frozen=True, repr=False)
class Compared(Shown):
    """Two profiles compared, with what was counted.

    For example:

        maviper.diff(before, after).rows
    """

    found: Difference
    counted: report.Estimates

    @property
    def verdict(self) -> Verdict:
        """PROVED where all agents act alike, VIOLATED where some does not."""
        return self.found.verdict

    @property
    def verdicts(self) -> list[Verdict]:
        """Each agent's."""
        return [one.verdict for one in self.found.agents]

    @cached_property
    def facts(self) -> dict[str, Any]:
        """All facts as plain data."""
        return report.document(self.found, self.counted)

    @property
    def lines(self) -> list[tuple[str, str]]:
        """What a person is told: labels and texts."""
        text = render("difference/lines.txt.j2", facts=self.facts)
        for bound, beside_zero in BESIDE_ZERO:
            text = text.replace(bound, beside_zero)
        return [(label, said) for label, _, said in (row.partition("|") for row in text.splitlines() if row)]

    @property
    def told(self) -> list[str]:
        """Verdict and reasons, in few lines."""
        return [f"Compared: {self.verdict}", *(f"{label} {text}" for label, text in self.lines[:3])]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each agent: its verdict."""
        return [{"agent": one.agent, "verdict": str(one.verdict)} for one in self.found.agents]

    @property
    def files(self) -> dict[str, str]:
        """Both profiles, the report, and a certificate where agents act alike, name -> text."""
        files = {runs.PROFILE_FILE: dumps(self.found.first), AGAINST_FILE: dumps(self.found.second)}
        files[REPORT_FILE] = report.as_json(self.facts)
        if self.found.certificate is not None:
            files[CERTIFICATE_FILE] = to_json(self.found.certificate)
        return files


def compare_profiles(
    first: ir.PolicyProfile, second: ir.PolicyProfile, region: str, asked: Any
) -> Compared | OutputsCompared:
    """Where two profiles act differently, see `request`; of agents that test sums or give numbers, how far they differ.
    InputError for profiles that cannot be compared.
    """
    agents = asked.agents or _common(first, second)
    remembers = any(policy.memory for profile in (first, second) for policy in profile.agents)
    if sums_in(first) or sums_in(second):
        for profile in (first, second):
            ensure_forgets(profile, "diff of agents that test sums or give numbers")
        return compare_outputs(first, second, agents, region, _budgets(asked).max_cells)
    if unread(ensure(first)) and unread(ensure(second)) and first.world == second.world:
        return _compare_observed(first, second, agents, region, asked)
    if remembers:
        ensure_forgets(first, "diff of agents in one world with places, or of two worlds,")
    for profile in (ensure(first), ensure(second)):
        ensure_places(profile.world, [one for policy in profile.agents for one in policy.features])
    where = find_region(region, first)
    differences = difference(first, second, agents, where, asked.semantics, _budgets(asked))
    coordinates, _ = sample(where, first.world, SAMPLES, SAMPLE_SEED)
    uniform = _count_differing(first, second, agents, coordinates)
    world = matching_places(first)
    if world is None:
        return Compared(differences, report.Estimates(uniform, None))
    met = _count_differing(first, second, agents, collect_states(first, world))
    return Compared(differences, report.Estimates(uniform, met, ON_POLICY_EPISODES))


def _compare_observed(
    first: ir.PolicyProfile, second: ir.PolicyProfile, agents: Sequence[str], region: str, asked: Any
) -> Compared:
    """Two profiles of a game without places, over what their agents observe. There is no certificate: it would be about
    two views, which no file holds.
    """
    united = unite_actions(first, second)
    seen, other = Viewed(forget(*united), View()), Viewed(forget(*reversed(united)), View())
    where = resolve_region(seen.profile, seen, region)
    if where.name == START:  # nobody saw any, so that these are the ranges
        where = replace(where, name=RANGES)
    where = confine_region(where, seen.profile)
    whole = {
        policy.agent: name_memory(seen.profile.policy(policy.agent), [each.name for each in policy.memory])
        for policy in first.agents
    }
    state = say_alike(united[0], seen.profile) if any(whole.values()) else None
    where = make_whole(where, [name for names in whole.values() for name in names])
    asking = agents, where, asked.semantics, _budgets(asked), state, UNSHARED if state else ""
    differences = difference(seen.profile, other.profile, *asking)
    coordinates, _ = sample(where, seen.profile.world, SAMPLES, SAMPLE_SEED)
    uniform = _count_differing(seen.profile, other.profile, agents, coordinates)
    if state:
        differences = replace(differences, first=first, second=second)
    return Compared(replace(differences, certificate=None), report.Estimates(uniform, None))


def _common(first: ir.PolicyProfile, second: ir.PolicyProfile) -> tuple[str, ...]:
    names, others = ([policy.agent for policy in profile.agents] for profile in (first, second))
    if set(names) != set(others):
        what = f"the profiles have different agents: {', '.join(names)} and {', '.join(others)}"
        advice = f"compare profiles of one world, or import the second again: maviper import --agents {names[0]}=FILE"
        raise InputError(what, "", "name those to compare: --agent NAME" if {*names} & {*others} else advice)
    return tuple(names)


def _count_differing(
    first: ir.PolicyProfile, second: ir.PolicyProfile, agents: Sequence[str], coordinates: ir.Float64
) -> Mapping[str, Share]:
    """Of how many of the states each agent, and some agent, acts differently."""
    other = differing(first, second, agents, coordinates)
    rows: dict[str, ir.Bool] = {
        **dict(zip(agents, other, strict=True)),
        report.SOME: cast("ir.Bool", other.any(axis=0)),
    }
    return {name: Share(int(row.sum()), len(row)) for name, row in rows.items()}


def collect_states(profile: ir.PolicyProfile, world: ParticleWorld) -> ir.Float64:
    """Coordinates [n, n_coordinates] of the states in which the profile's agents decide, playing one another."""
    return world.coordinates(WorldState.concatenate(on_policy(profile, world).states[:-1]))
