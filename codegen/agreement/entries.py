"""What generated code says beside decisions from observations: world states, input checks, constants, memory, refusals.

Does: asks about states, observations and memory at which a wrong entry shows, and compares every answer with the
  profile's; makes what is no observation of an agent, and finds what is not refused.
Assumes: a language hands its answers over as `Told`, whatever made them (readback.py); a refusal is a ValueError or a
  TypeError, which says what was wanted and what was given.
Does not: run any language, or know how a template writes an entry.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice, product
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.agreement import probes
from codegen.boxes import is_inside
from codegen.check import identifier
from codegen.deciding import decide, list_bounds
from codegen.ir import Bool, Float64, Floats, Int32, Int64
from codegen.memory import initial_memory, step_memory
from codegen.numbers import at_most
from codegen.observe import observe

SEED = 20_220_526  # of the random probes
CONSTANTS, OBSERVE, INPUT_CHECK = "constants", "observe", "input check"
TEAM = "team from world states"
WALKS, STEPS = 500, 200  # 10^5 decisions
PAIRS, MOST_VALUES = 4_096, 64  # memories together; values of one that are asked where no threshold is
ROWS = 50_000


@dataclass(frozen=True)
class Agreement:
    """The result of one target for one agent: `differences` of `observations` decisions differ from the reference."""

    target: str
    agent: str
    observations: int
    differences: int
    first: str = ""  # the first difference, in words


@dataclass(frozen=True)
class Told:
    """The answers of one language to `Asked`. What a profile without meanings or region has not is empty."""

    checks: Mapping[str, Int32]  # by agent, [n]: 1 for finite, 2 for within the ranges, their sum for both
    constants: list[float | str] | None = None  # as `constants_of`
    observed: Mapping[str, Float64] = field(default_factory=dict[str, Float64])  # by agent, [n, n_features]
    acted: Mapping[str, Any] = field(default_factory=dict[str, Any])  # by agent, [n], or [n, n_outputs]
    team: Int32 | None = None  # [n, n_agents]
    within: Int32 | None = None  # [n] 1 within the region, else 0
    remembered: Mapping[str, Any] = field(default_factory=dict[str, Any])  # by agent, [n, 1 + n_memories]
    misused: int = 0  # wrong inputs that were given
    accepted: tuple[str, ...] = ()  # those that were not refused, in words


class Questions(NamedTuple):
    """Observations in order: `rows` [n, n_features], where a memory is NaN the machine goes on from its own, which is
    `known` [n, n_memories]. Before the first one it is asked for its memory alone.
    """

    rows: Float64
    known: Int64

    @property
    def shown(self) -> Float64:
        """The rows as messages name them, one for each answer."""
        return np.concatenate([self.rows[:1], self.rows])


@dataclass(frozen=True)
class Asked:
    """The questions about a profile that every language is asked."""

    profile: ir.PolicyProfile
    finite: bool = False  # whether infinite and NaN coordinates are left out

    @cached_property
    def states(self) -> Float64:
        """World states in which features tie, overflow, are no numbers, or are anything, [n, n_coordinates]."""
        rng = np.random.default_rng(SEED)
        parts = [probes.worlds(self.profile, rng), probes.wild(len(self.profile.world.coordinates()), rng)]
        states = np.concatenate(parts)
        return states[np.isfinite(states).all(axis=1)] if self.finite else states

    @cached_property
    def bordering(self) -> Float64:
        """World states in the profile's region, at its borders and anywhere; none where there is no region."""
        if self.profile.region is None:
            return np.zeros((0, len(self.profile.world.coordinates())))
        return probes.bordering(self.profile.region, self.profile.world, np.random.default_rng(SEED))

    @cached_property
    def rows(self) -> dict[str, Floats]:
        """By agent, observations at special values and at the ends of the ranges."""
        rng = np.random.default_rng(SEED)
        by_agent: dict[str, Floats] = {}
        for policy in self.profile.agents:
            features, numbers = policy.features, policy.numbers
            rows = [probes.special(features, rng, numbers), probes.ends(features, rng, numbers)]
            by_agent[policy.agent] = probes.in_type(np.concatenate(rows), policy)
        return by_agent

    @cached_property
    def near(self) -> dict[str, Float64]:
        """By agent, double observations that must act as the agent's numbers say. [n, n_features]"""
        by_agent: dict[str, Float64] = {}
        for policy in self.profile.agents:
            rng = np.random.default_rng(SEED)
            rows = probes.in_type(probes.telling_doubles(policy, rng), policy)
            by_agent[policy.agent] = rows.astype(np.float64, copy=False)
        return by_agent

    @cached_property
    def sequences(self) -> dict[str, Questions]:
        """By agent that remembers, what its machine is asked."""
        return {policy.agent: ask_sequences(policy) for policy in self.profile.agents if policy.memory}

    @cached_property
    def typed(self) -> dict[str, list[Any]]:
        """By agent, some of `near` in numbers of other types, an array for each type; none where there is none."""
        return {agent: probes.cast_rows(near) if len(near) else [] for agent, near in self.near.items()}


def constants_of(profile: ir.PolicyProfile) -> list[float | str]:
    """Time of a step, damping, coordinates; then of each agent force, effects (NaN: none), ranges in its numbers,
    meanings ("": none), actions with their numbers, and outputs with their bounds (NaN: none).
    """
    force = {entity.name: entity.force for entity in profile.world.agents}
    expected: list[float | str] = [profile.world.dt, profile.world.damping, *profile.world.coordinates()]
    for policy in profile.agents:
        expected.append(force[policy.agent])
        expected += [value for action in policy.actions for value in action.effect or (np.nan, np.nan)]
        ends = [(at_most(each.low, policy.numbers), -at_most(-each.high, policy.numbers)) for each in policy.features]
        expected += [float(end) for both in ends for end in both]
        expected += [str(feature.meaning) if feature.meaning else "" for feature in policy.features]
        expected += [f"{identifier(action.name).upper()}={place}" for place, action in enumerate(policy.actions)]
        for name, *bounds in list_bounds(policy):
            expected += [name, *(np.nan if bound is None else bound for bound in bounds)]
    return expected


def checks(policy: ir.AgentPolicy, rows: Floats) -> Int32:
    """Returns what the input checks should say of observations [n, n_features]: 1 for finite, 2 for in the ranges."""
    low, high = (np.array([getattr(feature, end) for feature in policy.features]) for end in ("low", "high"))
    low, high = at_most(low, policy.numbers), -at_most(-high, policy.numbers)
    within = ((rows >= low) & (rows <= high)).all(axis=1)
    return (np.isfinite(rows).all(axis=1) + 2 * within).astype(np.int32)


def constants(target: str, wanted: Sequence[float | str], given: Sequence[float | str]) -> Agreement:
    """Every constant in its order, exactly; one too many or too few is a difference too."""
    wrong = [f"{a} for {b}" for a, b in zip(given, wanted, strict=False) if repr(a) != repr(b)]
    wrong += ["too many or too few"] * (len(given) != len(wanted))
    return Agreement(f"{target} {CONSTANTS}", "all", len(wanted), len(wrong), *wrong[:1])


def differing(wanted: Any, answers: Any) -> Bool:
    """Where answers differ, [batch]; numbers differ unless their bits are equal, or both are NaN."""
    if np.ndim(wanted) == 1:
        return np.asarray(answers) != wanted
    return np.any(~same(np.asarray(answers, np.float64).reshape(wanted.shape), wanted), axis=1)


def compare_entries(target: str, asked: Asked, told: Told) -> list[Agreement]:
    """Compares a language's answers with the reference: an agreement for each kind of entry and agent."""
    profile = asked.profile
    agreements: list[Agreement] = []
    if told.constants is not None:
        agreements.append(constants(target, constants_of(profile), told.constants))
    for policy in profile.agents:
        rows = asked.rows[policy.agent]
        wrong = told.checks[policy.agent] != checks(policy, rows)
        agreements.append(_agreement(f"{target} range {INPUT_CHECK}", policy.agent, wrong, rows))
        if policy.agent in told.remembered:
            questions = asked.sequences[policy.agent]
            wrong = differing(expected_answers(policy, questions), told.remembered[policy.agent])
            agreements.append(_agreement(f"{target} machine", policy.agent, wrong, questions.shown))
        if policy.agent in told.observed:
            agreements += compare_observations(target, policy, asked, told.observed[policy.agent])
            seen = _observe_states(policy, asked)
            acted, team = decide(policy, seen), told.team
            wrong = differing(acted, told.acted[policy.agent])
            agreements.append(_agreement(f"{target} world", policy.agent, wrong, asked.states))
            if team is not None:
                wrong = team[:, profile.agents.index(policy)] != acted
                agreements.append(_agreement(f"{target} {TEAM}", policy.agent, wrong, asked.states))
    if profile.region is not None and told.within is not None:
        within = is_inside(profile.region, asked.bordering, profile.world.coordinates())
        agreements.append(_agreement(f"{target} region {INPUT_CHECK}", "all", told.within != within, asked.bordering))
    if told.misused:
        let = told.accepted
        agreements.append(Agreement(f"{target} world {INPUT_CHECK}", "all", told.misused, len(let), *let[:1]))
    return agreements


def compare_observations(target: str, policy: ir.AgentPolicy, asked: Asked, given: Float64) -> list[Agreement]:
    """Compares an agent's observations [n, n_features] of the states with the reference's numbers, bit by bit."""
    wrong = np.asarray(~same(given, _observe_states(policy, asked)).all(axis=1))
    return [_agreement(f"{target} {OBSERVE}", policy.agent, wrong, asked.states)]


def same(a: Float64, b: Floats) -> Bool:
    """Compares numbers for equality, as doubles, zeros with their signs; every NaN is the same."""
    bits = [np.ascontiguousarray(each, dtype=np.float64).view(np.uint64) for each in (a, b)]
    return (bits[0] == bits[1]) | (np.isnan(a) & np.isnan(b))


def _observe_states(policy: ir.AgentPolicy, asked: Asked) -> Floats:
    with np.errstate(over="ignore", invalid="ignore"):  # infinite coordinates have no differences
        return observe(policy.features, asked.states, asked.profile.world, policy.numbers)


def _agreement(target: str, agent: str, wrong: Bool, rows: Floats) -> Agreement:
    places = np.flatnonzero(wrong)
    first = f"for ({', '.join(repr(float(value)) for value in rows[places[0]])})" if places.size else ""
    return Agreement(target, agent, len(wrong), int(places.size), first)


def single(n: int, asks: bool) -> list[Any]:
    """Lists values that are no observation of n numbers. `asks`: whether a decision asks for any; others go unread."""
    zeros = [0.0] * n
    lengths: list[Any] = [[], zeros[1:], [*zeros, 0.0], tuple(zeros[1:]), np.zeros(n - 1), np.zeros(2 * n)]
    shapes: list[Any] = [np.zeros((1, n)), np.zeros((n, 1)), np.zeros((n, n)), np.zeros(())]
    texts: list[Any] = [None, 0.0, "0" * n, bytes(n), np.zeros(n, dtype="U3")]
    others: list[Any] = [["0.0"] * n, [b"0.0"] * n, [None] * n, [0j] * n, np.zeros(n, dtype=complex), [[0.0]] * n]
    return [*lengths, *shapes, *texts, *(others if asks else [])]


def many(n: int) -> list[Any]:
    """Lists values that are no array of observations of n numbers."""
    widths: list[Any] = [np.zeros((2, width), dtype=np.float32) for width in (n - 1, n + 1, 2 * n)]
    shapes: list[Any] = [np.zeros(n), np.zeros((2, n, n)), [[0.0] * n, [0.0] * (n + 1)], None]
    return [
        *widths,
        *shapes,
        [["0.0"] * n],
        [[None] * n],
        np.zeros((2, n), dtype="U3"),
        np.zeros((2, n), dtype=complex),
    ]


def find_accepted(function: Callable[[Any], Any], given: Sequence[Any]) -> list[str]:
    """Describes, in words, each given value that the function does not refuse."""
    descriptions: list[str] = []
    for each in given:
        try:
            said = f"is answered by {function(each)!r:.20}"
        except (TypeError, ValueError):
            continue
        except Exception as error:  # an accident further on, which tells the caller nothing
            said = f"ends in {type(error).__name__}"
        descriptions.append(f"{type(each).__name__} {each!r:.60} {said}")
    return descriptions


# --- code that remembers: each memory beside each threshold, then walks, in which the machine's own memory is used


def ask_sequences(policy: ir.AgentPolicy, among: Floats | None = None) -> Questions:
    """The questions of an agent that remembers: first walks from a reset on, then pairs. `among`: observations
    [n, n_observed] from which each number is drawn, or each whole observation where sums are tested, which would be
    others of mixed ones; default those at its thresholds.
    """
    rng, width = np.random.default_rng(0), len(policy.features) - len(policy.memory)
    told = among if among is not None else np.concatenate(list(probes.telling(policy, rng)))[:, :width]
    if not len(told):
        told = probes.special(policy.features, rng, policy.numbers)[:, :width]
    told = probes.in_type(told, policy)
    if policy.tree.arithmetic:
        walked = told[rng.integers(len(told), size=(WALKS, STEPS))]
    else:
        walked = np.stack([rng.choice(told[:, place], (WALKS, STEPS)) for place in range(width)], axis=2)
    held = rng.random((WALKS, STEPS)) < rng.random((WALKS, 1))  # as inputs that stay, so that counters get far
    for step in range(1, STEPS):
        walked[held[:, step], step] = walked[held[:, step], step - 1]
    memory = np.empty((WALKS, STEPS, len(policy.memory)), np.int64)
    now, ends = initial_memory(policy)[None].repeat(WALKS, axis=0), _values(policy)
    for place, values in enumerate(ends):
        now[1:, place] = rng.choice(values, WALKS - 1)
    for step in range(STEPS):
        memory[:, step] = now
        now = step_memory(policy, now, walked[:, step])[1]
    given = np.full(memory.shape, np.nan)
    given[1:, 0] = memory[1:, 0]
    walks = np.concatenate([walked.reshape(-1, width), given.reshape(-1, len(ends))], axis=1)
    states = np.array(list(islice(product(*ends), PAIRS)), np.int64)
    beside = told[rng.permutation(len(told))[: max(1, ROWS // len(states))]]
    known = np.repeat(states, len(beside), axis=0)
    pairs = np.concatenate([np.tile(beside, (len(states), 1)), known], axis=1)
    return Questions(
        np.concatenate([walks, pairs]).astype(np.float64), np.concatenate([memory.reshape(-1, len(ends)), known])
    )


def _values(policy: ir.AgentPolicy) -> list[Int64]:
    """The values of each memory that are asked: all of a few, else its ends, and those beside thresholds."""
    tree, width = policy.tree, len(policy.features) - len(policy.memory)
    values: list[Int64] = []
    for place, spec in enumerate(policy.memory, width):
        at = np.floor(tree.threshold[tree.feature == place].astype(np.float64))
        chosen = np.concatenate([at, at + 1, [spec.low, spec.high, spec.initial or 0]])
        if spec.high - spec.low < MOST_VALUES:
            chosen = np.arange(spec.low, spec.high + 1)
        values.append(np.unique(chosen[(spec.low <= chosen) & (chosen <= spec.high)]).astype(np.int64))
    return values


def expected_answers(policy: ir.AgentPolicy, asked: Questions) -> Int64:
    """A reset, then the action taken and the memory after it, by the reference, [1 + n, 1 + n_memories]."""
    width = len(policy.features) - len(policy.memory)
    actions, after = step_memory(policy, asked.known, asked.rows[:, :width])
    return np.concatenate([[[0, *initial_memory(policy)]], np.column_stack([actions, after])]).astype(np.int64)


def drive_machine(step: Callable[[list[float]], int], memory: dict[str, int], rows: Float64) -> Int64:
    """The same of a machine in Python. `memory`: where it keeps what it remembers, after a reset."""
    width, told = rows.shape[1] - len(memory), [[0, *memory.values()]]
    for row in probes.iterate_rows(rows):
        if row[width] == row[width]:  # no NaN
            memory.update(zip(memory, map(int, row[width:]), strict=True))
        told.append([step(row[:width]), *memory.values()])
    return np.array(told, np.int64)
