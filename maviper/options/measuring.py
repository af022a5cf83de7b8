"""The options of `maviper evaluate` and `maviper exploit`, and of the functions of these names.

Does: says each option once: its name, type, default, heading and help; None: as usual.
Assumes: `maviper.evaluation.run` and `maviper.extraction.exploiting` read them.
Does not: check values beyond their types.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, TypedDict

from maviper.options.table import Option

WHO, MEASURED = "Who plays", "What is measured"
ANSWERS, HOW = "Who answers", "How it is measured"


class EvaluateOptions(TypedDict, total=False):
    """What is measured besides the subject."""

    replaced: Annotated[
        Mapping[str, str],
        Option({}, WHO, "Let another SUBJECT play an agent or a team (repeatable).", "NAME=SUBJECT", called="with"),
    ]
    against: Annotated[
        Iterable[str], Option((), WHO, "Opponents: another SUBJECT, scripted or random (repeatable).", "OPPONENT")
    ]
    expert: Annotated[
        str | None,
        Option(None, WHO, "The expert to compare with (default: the profile's own, if it is shipped).", "EXPERT"),
    ]
    world: Annotated[
        str | None, Option(None, WHO, "The world, where a file cannot say it: module:function, gymnasium:ID.")
    ]
    team: Annotated[str | None, Option(None, MEASURED, "Measure one team only.", "NAME")]
    episodes: Annotated[int, Option(1_000, MEASURED, "Held-out episodes, at most 100,000.")]
    why: Annotated[
        bool,
        Option(False, MEASURED, "Split each team's gap to the expert: individual, shift, interaction (`theory`)."),
    ]


class ExploitOptions(TypedDict, total=False):
    """What answers a team, and what is spent on it."""

    against: Annotated[
        Iterable[str],
        Option((), ANSWERS, "A further responder: another SUBJECT, scripted or random (repeatable).", "RESPONDER"),
    ]
    expert: Annotated[str | None, Option(None, ANSWERS, "The expert (default: the profile's own).", "EXPERT")]
    networks: Annotated[
        str | Path | None,
        Option(
            None,
            ANSWERS,
            "Train two networks against the team in this folder, or go on there. Needs maviper[train].",
            "FOLDER",
        ),
    ]
    steps: Annotated[int, Option(1_024_000, ANSWERS, "Steps of play for each network.")]
    refinement_episodes: Annotated[
        int, Option(100_000, ANSWERS, "Episodes to refine an answering tree with; 0: no tree.")
    ]
    world: Annotated[str | None, Option(None, ANSWERS, "module:function of the environment, if it is yours.")]
    episodes: Annotated[int, Option(1_000, HOW, "To choose on, and as many to report on.")]
    seed: Annotated[int, Option(0, HOW, "The random seed of what learns.")]
