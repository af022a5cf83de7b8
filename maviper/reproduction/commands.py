"""The commands that play what a report lacks.

Does: writes `maviper reproduce` with the experts of the report, so that cells join those that are there.
Assumes: labels as the plan gives them.
Does not: know where a user's own expert lies; EXPERT stands for it.
"""

from collections.abc import Iterable

from maviper.reproduction.cells.plan import MADDPG, MAPPO, NO_CARD


def command(experts: Iterable[str], options: str = "") -> str:
    """The command with some options, for experts of those labels."""
    words = ["maviper reproduce -o FOLDER", options, _experts(list(experts))]
    return " ".join(word for word in words if word)


def _experts(labels: list[str]) -> str:
    """The option --experts, where it is needed."""
    named = [label if label in (MAPPO, MADDPG) else f"{label.removesuffix(NO_CARD)}=EXPERT" for label in labels]
    return f"--experts {','.join(named)}" if set(named) - {MAPPO} else ""
