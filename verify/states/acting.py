"""What a team does in one world state, by the arithmetic asked about and by everything that replays the state.

Does: compares the replays, and says what the deployed arithmetic does where real arithmetic was asked about.
Assumes: replays act by the deployed arithmetic, which knows float64 states only.
Does not: judge claims (state.py).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from codegen.errors import DisagreementError
from codegen.ir import PolicyProfile
from verify.claims.formula import Formula
from verify.semantics import MACHINE, REAL
from verify.states.state import State, actions_at, true_at

REFERENCE = "reference"
EXACTLY = "judged in exact arithmetic"
NO_FLOATS = "not replayed: the state is no float64 state, and the deployed arithmetic knows no others"
Replay = Callable[[State], list[int]]  # a world state -> the team's actions


@dataclass(frozen=True)
class Deployed:
    """What the deployed arithmetic does in a float64 state that real arithmetic was asked about."""

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
    """What the team does; DisagreementError when a replay acts differently from the reference."""
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
