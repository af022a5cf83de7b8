"""Exploitability cells: who answers the trees of one profile, and what that gains.

Does: has each team of a profile answered by the expert, the other algorithms' trees, a refined tree and networks.
Assumes: the profiles of one seed; networks need the extra `maviper[train]`.
Does not: know how an answer is made or chosen (extraction/exploiting.py, evaluation/exploitability.py).
"""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from codegen import policy_json
from codegen.ir import PolicyProfile
from maviper.episodes.play import Controller
from maviper.episodes.trees import among
from maviper.evaluation.exploitability import CHOSEN_ON as CHOICE
from maviper.evaluation.exploitability import exploitability
from maviper.experts.expert import Expert
from maviper.extraction.exploiting import Effort, Frozen, Learning, responders
from maviper.reproduction.cells.cell import ID_LETTERS, Cell
from maviper.worlds import Measure, World
from maviper.worlds.world import RETURN

# joint steps of each network, episodes of the refined tree; of the quick, the default and the full tier
UNTRAINED: Mapping[str, int] = {"steps": 0, "refinement": 0}
USUAL: Mapping[str, int] = {"steps": 256_000, "refinement": 100_000}
MORE: Mapping[str, int] = {**USUAL, "steps": 1_024_000}
CHOSEN_ON = ":chosen-on"


def explain_untrainable() -> str:
    """Why no network can be trained; "" where one can."""
    return "" if find_spec("torch") else "torch is not installed: pip install 'maviper[train]'"


@dataclass(frozen=True)
class Asked:
    """Whose trees are answered, and what is spent on it. `profiles`: the cell's own and other algorithms'."""

    cell: Cell
    world: World
    expert: Expert
    profiles: Mapping[str, PolicyProfile]
    effort: Mapping[str, int]

    @property
    def own(self) -> PolicyProfile:
        """The profile that is answered."""
        return self.profiles[self.cell.algorithm]


def exploit_teams(asked: Asked) -> tuple[list[str], dict[str, Any]]:
    """Rows of episodes, and what is told of each team."""
    rows: list[str] = []
    told: dict[str, Any] = {}
    for team in asked.world.teams:
        with tempfile.TemporaryDirectory() as scratch:
            outcome, chosen_on = _exploit_team(asked, team, Path(scratch))
        (measure,) = outcome.responding
        for answer in outcome.tried:
            rows += _rows(f"{team}:{answer.name}{CHOSEN_ON}", measure, answer, chosen_on)
        for answer in {outcome.usual.name: outcome.usual, outcome.chosen.name: outcome.chosen}.values():
            rows += _rows(f"{team}:{answer.name}", measure, answer, asked.cell.episodes)
        told[team] = outcome.document()
    return rows, {"exploitability": told}


def _exploit_team(asked: Asked, team: str, scratch: Path) -> tuple[Any, range]:
    """The `Exploitability` of a team, and the episodes that its responder was chosen on."""
    # here, since not every version has them
    world, seed = asked.world, asked.cell.seed
    experts: list[Controller] = [asked.expert] * len(world.agents)
    players = {name: among(world, profile.agents, experts) for name, profile in asked.profiles.items()}
    policies = players.pop(asked.cell.algorithm)
    frozen = Frozen(world, policies, team, policy_json.content_hash(asked.own)[:ID_LETTERS])
    others = [profile for name, profile in asked.profiles.items() if name != asked.cell.algorithm]
    trees = [policy for profile in (asked.own, *others) for policy in profile.agents]
    learning = Learning(scratch, asked.effort["steps"], seed) if asked.effort["steps"] else None
    effort = Effort(learning, asked.effort["refinement"], seed=seed)
    candidates = responders(frozen, asked.expert, players, trees, effort)
    return exploitability(world, policies, team, candidates, CHOICE, asked.cell.episodes), CHOICE


def _rows(lineup: str, measure: Measure, answer: Any, episodes: range) -> list[str]:
    """Returns the rows of a responder's results: the measure by which it is judged, and its return."""
    rows: list[str] = []
    worth = -answer.worth if measure.lower_is_better else answer.worth
    for label, values in ((measure.label, worth), (f"{measure.team} {RETURN}", answer.returns)):
        pairs = zip(episodes, values.tolist(), strict=True)
        rows += [f"{lineup},{label},{episode},{value!r}\n" for episode, value in pairs]
    return rows
