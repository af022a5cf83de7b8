"""Guards of a claim for ever: tests above an agent's tree that act before a region is left, until the claim is proved.

Does: finds by a counterexample which bound of the region breaks, a feature that measures that variable alone, and the
  action that moves it back most; puts a guard above the tree, as late as nothing refutes.
Assumes: agents that take actions; a system that moves in steps; whoever asks about a team tells true answers.
Does not: prove or look for counterexamples. Below its guards a tree decides as before.

A guard acts where half of the region's span is left, then half as late each time it is refuted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from codegen.ir import AgentPolicy, PolicyProfile
from codegen.lowering.passes import graft_parts
from codegen.numbers import at_most, nearest_double
from codegen.paths import in_preorder
from verify.reach.results import SystemCounterexample
from verify.systems.claims import SystemClaim
from verify.systems.system import Measure, System, bounds_of

HALVINGS = 4  # of the span up to a bound
_Node: TypeAlias = "int | tuple[int, float, _Node, _Node]"  # an action, or a split as `in_preorder` reads it


class Guard(NamedTuple):
    """Above an agent's tree: `action` where `feature` is above `threshold`, or else where it is not."""

    agent: str
    feature: str
    above: bool
    threshold: float
    action: str

    @property
    def words(self) -> str:
        """The guard as a rule."""
        return f"{self.agent}: {self.feature} {'>' if self.above else '<='} {self.threshold:.6g} -> {self.action}"


class Bound(NamedTuple):
    """A side of a region: `variable` is at most `end`, or at least where `sign` is -1; of its range here `span`."""

    variable: str
    sign: int
    end: Fraction
    span: Fraction


class Answer(NamedTuple):
    """The first claim about a team that is not proved: a counterexample, or why there is no answer."""

    claim: SystemClaim
    counterexample: SystemCounterexample | None
    reason: str


@dataclass(frozen=True)
class Held:
    """The team with guards, and how many answers they rest on. `reason`: why it is not proved; "": it is."""

    profile: PolicyProfile
    guards: tuple[Guard, ...]
    rounds: int
    reason: str = ""


def hold(profile: PolicyProfile, system: System, ask: Callable[[PolicyProfile], Answer | None]) -> Held:
    """Guards a team until `ask` has nothing to say against it."""
    reactions, halved, rounds = dict[Bound, tuple[str, str]](), dict[Bound, int](), 0
    while True:
        guards = tuple(_guard(profile, system, bound, *reactions[bound], each) for bound, each in halved.items())
        after = insert(profile, guards)
        answer = ask(after)
        if answer is None:
            return Held(after, guards, rounds)
        rounds += 1
        claim, example, reason = answer
        late = list(halved) if example is None else list(broken(system, claim, example))
        if not late:
            return Held(after, guards, rounds, reason or f"{claim.shown} fails where no bound of its region does")
        for bound in late:
            reaction = reactions.get(bound) or (example and find_reaction(profile, system, bound, example))
            halved[bound] = halved.get(bound, 0) + 1
            if not reaction:
                lost = f"no action moves {bound.variable} back where a feature measures it alone"
                return Held(after, guards, rounds, lost)
            if halved[bound] > HALVINGS:
                return Held(after, guards, rounds, f"no guard of {bound.variable} is early enough")
            reactions[bound] = reaction


def broken(system: System, claim: SystemClaim, example: SystemCounterexample) -> Iterator[Bound]:
    """Sides of the claim's first region beyond which a counterexample ends; none where the claim is of another kind."""
    if claim.says.avoided or claim.says.once or claim.about_decisions or not example.step:
        return
    region, state = claim.regions[0], example.states[example.step]
    bounds = bounds_of(region, {one.name: one.range for one in system.variables})
    alone = (half.form.terms[0][0] for half in region if len(half.form.terms) == 1)
    for variable in dict.fromkeys(alone):
        low, high = bounds[variable]
        for sign, end in ((1, high), (-1, low)):
            if sign * state[variable] > sign * end:
                yield Bound(variable, sign, end, high - low)


def find_reaction(
    profile: PolicyProfile, system: System, bound: Bound, example: SystemCounterexample
) -> tuple[str, str] | None:
    """An agent that observes a variable alone, and its action that moves this back most in the last state of the
    counterexample where actions differ in that; None without.
    """
    for step in reversed(range(example.step)):
        state, joint, piece = example.states[step], example.actions[step], system.pieces[example.pieces[step]]
        for policy in profile.agents:
            if _measuring(policy, system, bound.variable) is None:
                continue
            ends = [
                bound.sign * piece.step(state, {**joint, policy.agent: each.name}, example.errors[step])[bound.variable]
                for each in policy.actions
            ]
            if len(set(ends)) > 1:
                return policy.agent, policy.actions[ends.index(min(ends))].name
    return None


def _measuring(policy: AgentPolicy, system: System, variable: str) -> str | None:
    """The feature of an agent that measures a variable alone."""
    known = system.features.get(policy.agent, {})
    for name in (each.name for each in policy.features if each.name in known):
        if known[name].measure is Measure.VALUE and [term for term, _ in known[name].form.terms] == [variable]:
            return name
    return None


def _guard(profile: PolicyProfile, system: System, bound: Bound, agent: str, action: str, halved: int) -> Guard:
    policy = profile.policy(agent)
    name = _measuring(policy, system, bound.variable)
    assert name is not None
    form = system.features[agent][name].form
    late = bound.end - bound.sign * bound.span * (1 - Fraction(1, 2**halved))
    threshold = float(at_most(nearest_double(form.at({bound.variable: late})), policy.numbers))
    return Guard(agent, name, bound.sign * form.terms[0][1] > 0, threshold, action)


def _itself(node: _Node) -> _Node:
    return node


def insert(profile: PolicyProfile, guards: Sequence[Guard]) -> PolicyProfile:
    """The profile with guards above its trees, the first one on top."""
    agents = {policy.agent: policy for policy in profile.agents}
    for guard in reversed(guards):
        policy = agents[guard.agent]
        feature = [each.name for each in policy.features].index(guard.feature)
        action = [each.name for each in policy.actions].index(guard.action)
        root: _Node = feature, guard.threshold, action, action
        test = in_preorder(root, _itself, policy.numbers)
        below = 1 if guard.above else 2  # the leaf of the test in whose place the tree goes on
        agents[guard.agent] = replace(policy, tree=graft_parts(test, {below: policy.tree}), grown=None)
    return replace(profile, agents=tuple(agents.values()))
