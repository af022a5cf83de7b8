"""The commands that play what a report lacks.

Does: writes `maviper reproduce` with the experts of the report, so that cells join those that are there.
Assumes: labels as the plan gives them.
Does not: know where a user's own expert lies; EXPERT stands for it.
"""

from collections.abc import Iterable

from maviper.reproduction.cells.plan import MADDPG, MAIN_DEPTH, MAPPO, NO_CARD
from maviper.reproduction.register import EXPLOITABILITY, Claim


def command(experts: Iterable[str], options: str = "") -> str:
    """The command with some options, for experts of those labels."""
    words = ["maviper reproduce -o FOLDER", options, _experts(list(experts))]
    return " ".join(word for word in words if word)


def playing(claim: Claim, expert: str) -> str:
    """The command that plays the cells of a claim, with the expert of that label."""
    depths = [str(depth) for depth in claim.list_values("depth")]
    everywhere = claim.statistic == EXPLOITABILITY and set(claim.list_values("depth")) - {MAIN_DEPTH}
    tier = "--full " if everywhere else ""  # others answer teams of the main depth alone
    return command([expert], f"{tier}--games {','.join(claim.list_values('game'))} --depths {','.join(depths)}")


def _experts(labels: list[str]) -> str:
    """The option --experts, where it is needed."""
    named = [label if label in (MAPPO, MADDPG) else f"{label.removesuffix(NO_CARD)}=EXPERT" for label in labels]
    return f"--experts {','.join(named)}" if set(named) - {MAPPO} else ""
