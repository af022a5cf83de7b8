"""What a team does in one world state, by the arithmetic asked about and by all that replays it; and why.

Does: compares the replays, and says what the deployed arithmetic does where real arithmetic was asked about; walks a
  tree for one observation, and puts each test on the path into words.
Assumes: a checked profile; replays act by the deployed arithmetic, which knows float64 states only.
Does not: judge claims (state.py), or say why a tree was grown so.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan

from codegen import ir
from codegen.deciding import list_operands
from codegen.errors import DisagreementError
from codegen.ir import PolicyProfile
from codegen.wording import fails, holds, is_zero, number
from verify.claims.formula import Formula
from verify.kinds import MACHINE, REAL
from verify.states.real import Value
from verify.states.state import State, actions_at, true_at


@dataclass(frozen=True)
class Step:
    """One test on a decision path: `value` of `feature` against `threshold`."""

    node: int
    feature: str
    value: Value
    threshold: float
    left: bool

    def __str__(self) -> str:
        value, near = float(self.value), is_zero(float(self.value)) and self.value != 0
        told = holds(self.threshold) if self.left else fails(self.threshold)
        if isnan(value):
            return f"{self.feature} = nan, not {holds(self.threshold)}"
        if near or (f"{value:.6g}" == number(self.threshold) and self.value not in (self.threshold, 0)):
            return f"{self.feature} = {self.value} {'<=' if self.left else '>'} {self.threshold!r}"
        return f"{self.feature} = {value:.6g} {told}"


def path(policy: ir.AgentPolicy, seen: Sequence[Value]) -> tuple[Step, ...]:
    """The tests that lead to the decision for one observation, rounded or exact: [n_features], and then the sums that
    the tree tests.
    """
    tree, node, steps = policy.tree, ir.ROOT, list[Step]()
    names = list_operands(policy)
    while tree.feature[node] != ir.NO_FEATURE:
        feature, threshold = int(tree.feature[node]), float(tree.threshold[node])
        left = seen[feature] <= threshold
        steps.append(Step(node, names[feature], seen[feature], threshold, left))
        node = int(tree.left[node] if left else tree.right[node])
    return tuple(steps)


REFERENCE = "reference"
EXACTLY = "judged in exact arithmetic"
NO_FLOATS = "not replayed: the state is no float64 state, and the deployed arithmetic knows no others"
Replay = Callable[[State], list[int]]  # a world state -> the team's actions


@dataclass(frozen=True)
class Deployed:
    """The effect of the deployed arithmetic in a float64 state that real arithmetic was asked about."""

    actions: Mapping[str, str]  # agent -> the name of its action
    violated: bool  # the claim fails by them


@dataclass(frozen=True)
class Acted:
    """A team's actions in a world state, and by what they were taken."""

    actions: Mapping[str, int]  # agent -> its action, by the arithmetic asked about
    by: tuple[str, ...]  # what replays took these
    says: str  # what judged them and who replayed them, in words
    deployed: Deployed | None = None  # of real arithmetic; None where the state is no float64 state


def confirm_actions(
    profile: PolicyProfile,
    claim: Formula,
    team: str,
    state: State,
    replays: Mapping[str, Replay],
    semantics: str = MACHINE,
) -> Acted:
    """Returns what the team does; DisagreementError when a replay acts differently from the reference."""
    actions = actions_at(profile, team, state, semantics)
    if semantics == REAL and not state.floats:
        return Acted(actions, (), f"{EXACTLY}; {NO_FLOATS}")
    machine = actions_at(profile, team, state, MACHINE)
    for name, replay in replays.items():
        repeated = list(replay(state))
        if repeated != list(machine.values()):
            what = f"the {name} does not reproduce the counterexample"
            raise DisagreementError(what, f"reference {list(machine.values())}, {name} {repeated}", "this is a bug")
    by = (REFERENCE, *replays)
    replayed = f"replayed by {', '.join(by)}"
    if semantics == MACHINE:
        return Acted(actions, by, replayed)
    names = {policy.agent: policy.actions[machine[policy.agent]].name for policy in profile.team(team)}
    deployed = Deployed(names, not true_at(profile, claim, state, machine))
    if machine == actions:
        return Acted(actions, by, f"{EXACTLY}, {replayed}", deployed)
    other = ", ".join(f"{agent} takes {name}" for agent, name in names.items() if machine[agent] != actions[agent])
    claimed = "fails there too" if deployed.violated else "holds there"
    return Acted(actions, (), f"{EXACTLY}; the deployed arithmetic differs: {other}, and the claim {claimed}", deployed)
