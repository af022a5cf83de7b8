"""The options of `maviper extract` and of `maviper.extract`.

Does: says each option once: its name, type, default, heading and help; None: as the preset or the world says.
Assumes: an option is a setting of the algorithms where `maviper.extraction.settings.Settings` has a field of its name,
  or of `setting`; the others are fields of `maviper.extraction.run.Request`.
Does not: check values beyond their types.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, TypedDict

from maviper.options.table import Option

# named here, so that --help imports nothing else; a test compares them with the ones that there are
PAPERS = "maviper, maviper-no-prediction, maviper-iviper-resampling, iviper, viper, imitation, fitted-q"
ALGORITHMS = f"{PAPERS}, best-response, rgmdt"
FEATURES = "velocity, goal, differences, signs, ahead, coasting (several with +)"
WHAT, EPISODES, LEARNS, HOW = "What is extracted", "Episodes", "What it learns from", "How it runs"
PARTS = "What the algorithm's name sets"


class ExtractOptions(TypedDict, total=False):
    """What an extraction is asked for."""

    algorithm: Annotated[str, Option("maviper", WHAT, f"One of {ALGORITHMS} (after the description).", "NAME")]
    preset: Annotated[
        str, Option("default", WHAT, "default; paper: exactly as published; released: as in the authors' code.", "NAME")
    ]
    max_depth: Annotated[int, Option(4, WHAT, "Splits on the longest path.")]
    max_leaves: Annotated[
        int | None, Option(None, WHAT, "Leaves of each tree, grown best first; not where members vote.")
    ]
    share: Annotated[
        str | None, Option(None, WHAT, "team: one tree for all agents of a team, whose spaces must be equal.", "WHO")
    ]
    agent: Annotated[str | None, Option(None, WHAT, "The agent to extract, for viper.", "NAME")]
    splits: Annotated[
        str | None,
        Option(
            None,
            WHAT,
            "exact or histogram (default: the preset's); differences: of two features too; sums: of a few.",
            "NAME",
        ),
    ]
    leaves: Annotated[
        str | None,
        Option(
            None,
            WHAT,
            "Of continuous actions: constant (the default) or linear, a sum of features for each output.",
            "NAME",
            setting="leaf",
        ),
    ]
    labels: Annotated[
        str | None,
        Option(
            None,
            PARTS,
            "What trees are taught: expert (its actions) or response (the best reply to the mates' trees).",
            "NAME",
        ),
    ]
    rollouts_by: Annotated[
        str | None,
        Option(None, PARTS, "Whose trees play together among experts: agent, team or all; or experts alone.", "NAME"),
    ]
    weights: Annotated[
        str | None,
        Option(
            None,
            PARTS,
            "What states weigh: own, averaged (over what others could do) or equal; regret: what each action costs.",
            "NAME",
        ),
    ]
    least_right: Annotated[
        str | None,
        Option(
            None,
            PARTS,
            "Members that must be predicted right, of a team of N: N, N-1, 2, or a share such as 0.5; 0: no votes.",
            "VOTES",
        ),
    ]
    selection_by: Annotated[
        str | None, Option(None, PARTS, "For whom one round is chosen: agent, member, team or all.", "NAME")
    ]
    undo: Annotated[
        str,
        Option(
            "",
            PARTS,
            "Accidents of preset released to leave out: leaves, restarts, warm-up (several with +).",
            "NAMES",
        ),
    ]
    features: Annotated[str, Option("", WHAT, f"Additional features: {FEATURES}, or auto.", "NAMES")]
    features_file: Annotated[
        str | Path | None, Option(None, WHAT, "Names and units of what agents observe in your own game (TOML).")
    ]
    max_episodes: Annotated[
        int | None,
        Option(
            None,
            EPISODES,
            "Total number of episodes, instead of the counts below; in games of your own, held-out ones included.",
            setting="budget",
        ),
    ]
    held_out: Annotated[
        int | None,
        Option(
            None, EPISODES, "Held-out episodes of each line-up that is measured (default: 1000; in your own games 200)."
        ),
    ]
    iterations: Annotated[
        int | None, Option(None, EPISODES, "Rounds of rollouts and tree growth (default: the paper's).")
    ]
    rollouts: Annotated[int | None, Option(None, EPISODES, "Episodes per round (default: the paper's).")]
    patience: Annotated[
        int | None,
        Option(None, EPISODES, "Stop after so many rounds without a gain (default: 10; in paper and released: never)."),
    ]
    enough: Annotated[
        float, Option(0.0, EPISODES, "Stop at this ratio to the expert, by the lower end of its interval; 0: never.")
    ]
    selection: Annotated[str | None, Option(None, EPISODES, "uniform, return or race (default: the preset's).", "NAME")]
    selection_episodes: Annotated[int | None, Option(None, EPISODES, "Episodes per candidate and team (default: 100).")]
    refinement_episodes: Annotated[
        int | None,
        Option(
            None,
            EPISODES,
            "Episodes per team to refine the trees with (default: the preset's).",
            setting="refinement",
        ),
    ]
    measure: Annotated[
        str | None,
        Option(
            None,
            EPISODES,
            "The measure that teams are judged by (default: the world's first; preset paper: the paper's).",
            "NAME",
        ),
    ]
    explore: Annotated[float, Option(0.0, LEARNS, "fitted-q: share of uniform actions while it collects.")]
    critic: Annotated[str, Option("learned", LEARNS, "The Q that weights the states: learned, measured or none.")]
    max_samples: Annotated[
        int | None,
        Option(None, LEARNS, "Points drawn by weight for each tree, at most (default: 300000)."),
    ]
    world: Annotated[str | None, Option(None, LEARNS, "The expert's world, where its file cannot say it.")]
    counterexamples: Annotated[
        Iterable[str | Path],
        Option((), LEARNS, "A file that `maviper verify -o` wrote, or its folder (repeatable).", "PATH"),
    ]
    seed: Annotated[int, Option(0, HOW, "The random seed.")]
    seeds: Annotated[int, Option(1, HOW, "Extract this many seeds; keep the best.")]
    jobs: Annotated[int, Option(1, HOW, "Parallel processes, for seeds, IVIPER's agents or refinement.")]
    resume: Annotated[bool, Option(False, HOW, "Continue the run in the folder.")]
