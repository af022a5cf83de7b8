"""What the paper's figures 2, 3, 5 to 8 and tables 1, 3, 4 show, from the records beside: python figures.py

Each row of a figure has a number of MAVIPER, IVIPER, imitation and fitted Q: the ratio to the expert, mean over ten
seeds, and what MAVIPER has more than IVIPER, with the 95 % interval of Student's t over seeds. Where less is better,
the ratio is the expert's over the team's; a reward is 1 less what is lost, in parts of the mean size of the expert's.
Tables have the measure itself; what a responder gains is in the measure of those who are exploited.
"""

import json
import lzma
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

Numbers = dict[str, Any]  # of a record, by name
ALGORITHMS = ("maviper", "iviper", "imitation", "fitted-q")
STUDENT = {9: 2.262157}  # .975 quantile by degrees of freedom: nine
TEAMS = {
    "defenders": ("physical-deception", "defenders success r=0.316"),
    "adversaries": ("physical-deception", "adversaries success r=0.316"),
    "navigation": ("cooperative-navigation", "agents D"),
    "predators": ("predator-prey", "predators touches"),
    "prey": ("predator-prey", "prey touches"),
}
MODES = {
    "value": lambda ours, _theirs, _size: ours,
    "ratio": lambda ours, theirs, _size: ours / theirs,
    "inverse": lambda ours, theirs, _size: theirs / ours,
    "reward": lambda ours, theirs, size: 1 + (ours - theirs) / size,
}


class Record:
    """The numbers of one family of experts."""

    def __init__(self, folder: Path) -> None:
        with lzma.open(folder / "cells.json.xz") as file:
            told = json.loads(file.read())
        self.family, self.cells, self.numbers = folder.name, told["cells"], told["numbers"]

    def seeds(self, name: str) -> np.ndarray:
        """A number seed by seed."""
        parts = [part["weight"] * np.array([*self._values(part)]) for part in self.numbers[name]["parts"]]
        return np.sum(parts, axis=0)

    def _values(self, part: Numbers) -> Iterator[float]:
        theirs = part["theirs"] or part["ours"]
        for ours, beside in zip(part["ours"]["places"], theirs["places"], strict=True):
            mine, expert = (
                self.cells[cell]["values"][lineup][of["measure"]]
                for (cell, lineup), of in ((ours, part["ours"]), (beside, theirs))
            )
            yield MODES[part["mode"]](mine["mean"], expert["mean"], expert.get("size", abs(expert["mean"])))

    def row(self, title: str, names: list[str]) -> str:
        """A line of means, and of the lead of the first over the second."""
        found = [self.seeds(name) for name in names if name in self.numbers]
        line = f"  {title}, {self.family.upper()}: " + " / ".join(f"{each.mean():.3f}" for each in found)
        if len(found) < 2:
            return line
        lead = found[0] - found[1]
        half = STUDENT[len(lead) - 1] * lead.std(ddof=1) / len(lead) ** 0.5
        return f"{line}, lead {lead.mean():+.3f} [{lead.mean() - half:+.3f}, {lead.mean() + half:+.3f}]"

    def figure(self, kind: str, reward: bool) -> Iterator[str]:
        """A row for each team and depth."""
        for team, (game, measure) in TEAMS.items():
            label = f"{measure.partition(' ')[0]} return" if reward else measure
            for depth in (2, 4, 6):
                place = f"{game}/{self.family}/paper/depth-{depth}/{label}"
                yield self.row(f"{team}, depth {depth}", [f"{kind}/{each}/{place}" for each in ALGORITHMS])

    def levels(self) -> Iterator[str]:
        """What teams of trees reach at depth 4, and what the expert does beside them, in the measure itself."""
        for team, (game, measure) in TEAMS.items():
            place = f"{game}/{self.family}/paper/depth-4/{measure}"
            names = [f"joint value/{each}/{place}" for each in ALGORITHMS]
            expert = self.seeds(f"expert beside/maviper/{place}").mean()
            yield f"{self.row(team, names)}, expert {expert:.4f}"

    def ablations(self) -> Iterator[str]:
        """MAVIPER, and MAVIPER without a part, at depth 4."""
        variants = ("maviper", "maviper-no-prediction", "maviper-iviper-resampling")
        for kind in ("joint", "individual"):
            place = f"physical-deception/{self.family}/paper/depth-4/defenders success r=0.316"
            for other in variants[1:]:
                names = [f"{kind}/{each}/{place}" for each in ("maviper", other)]
                yield self.row(f"{kind}, MAVIPER less {other}", names)

    def tables(self) -> Iterator[str]:
        """Each algorithm's team against all opponents, and against those of each algorithm."""
        for team, (game, measure) in TEAMS.items():
            for opponent in ("all", "expert", *ALGORITHMS):
                names = [
                    f"against/{opponent}/{each}/{game}/{self.family}/paper/depth-4/{measure}" for each in ALGORITHMS
                ]
                if names[0] in self.numbers:
                    yield self.row(f"{team} against {opponent}", names)

    def exploited(self) -> Iterator[str]:
        """What responders reach against each algorithm's trees."""
        for team in ("defenders", "adversaries"):
            for depth in (2, 4, 6):
                place = f"{team}/physical-deception/{self.family}/paper/depth-{depth}"
                yield self.row(f"{team}, depth {depth}", [f"exploitability/{each}/{place}" for each in ALGORITHMS])


def main() -> None:
    """Prints all of it for each family that is there."""
    records = [Record(path.parent) for path in sorted(Path(__file__).parent.glob("*/cells.json.xz"))]
    for title, rows in (
        ("figure 3, teams", lambda of: of.figure("joint", False)),
        ("teams of depth 4 by the measure itself", Record.levels),
        ("figure 2, single trees", lambda of: of.figure("individual", False)),
        ("figure 7, reward of teams", lambda of: of.figure("joint", True)),
        ("figure 6, reward of single trees", lambda of: of.figure("individual", True)),
        ("figure 5, ablations", Record.ablations),
        ("tables 1, 3, 4: teams against opponents", Record.tables),
        ("figure 8, exploitability", Record.exploited),
    ):
        sys.stdout.writelines([f"{title}\n", *(f"{row}\n" for record in records for row in rows(record))])


if __name__ == "__main__":
    main()
