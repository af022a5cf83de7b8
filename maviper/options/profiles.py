"""The options of the verbs that make a profile of a file, or compile, repair or compare profiles.

Does: says each option once: its name, type, default, heading and help; None: as usual.
Assumes: the functions take what else there is as parameters of their own.
Does not: check values beyond their types.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Literal, TypedDict

from maviper.options.table import PARAMETERS, Option, of_claims
from maviper.options.verification import BUDGETS, QUESTION
from verify.claims.language.parameters import Names, Number

WRITTEN, TREES, CHECKS = "What is written", "The trees", "What is proved"
IMPORTED, NAMES = "What is imported", "Names"
LIMITS = "Limits"
TARGETS = ("c", "python", "json")  # of compile, where nobody says others


class ImportOptions(TypedDict, total=False):
    """What is said of a file that it does not say itself, or says otherwise."""

    feature_names: Annotated[
        Sequence[str] | None, Option(None, NAMES, "Names of the features.", "NAMES", called="features", commas=True)
    ]
    action_names: Annotated[
        Sequence[str] | None, Option(None, NAMES, "Names of the actions.", "NAMES", called="actions", commas=True)
    ]
    name: Annotated[
        str,
        Option(
            "imported",
            NAMES,
            "The game whose agents the trees become, such as gymnasium:CartPole-v1; else a name for their world.",
            "NAME",
            called="world",
        ),
    ]
    numbers: Annotated[
        Literal["float32"] | None,
        Option(
            None,
            IMPORTED,
            "Round thresholds down for float32 observations where FILE compares doubles. Default: as FILE compares.",
        ),
    ]
    arrays: Annotated[
        Literal["floats", "float32", "float64"] | None,
        Option(
            None,
            IMPORTED,
            "What if/else Python is given: Python's floats, or arrays of NumPy; asked for where they differ.",
        ),
    ]
    output_names: Annotated[
        Sequence[str] | None,
        Option(
            None,
            IMPORTED,
            "FILE returns numbers to give, and these are their names: no labels, no scores.",
            "NAMES",
            called="outputs",
            commas=True,
        ),
    ]
    prefer: Annotated[
        Sequence[str] | None,
        Option(
            None,
            IMPORTED,
            "Where a leaf of dtControl permits several actions: their labels, the most wanted first.",
            "LABELS",
            commas=True,
        ),
    ]
    scores: Annotated[
        bool,
        Option(False, IMPORTED, "A list of numbers that FILE returns holds a score for each action: the largest acts."),
    ]
    run: Annotated[
        bool,
        Option(
            True,
            IMPORTED,
            "If FILE is not run, its own answers are not compared with the tree, and the profile says so.",
        ),
    ]


class CompileOptions(TypedDict, total=False):
    """What a compilation is asked for."""

    prefix: Annotated[
        str | None, Option(None, WRITTEN, "Prefix of every public name (default: the world's name).", "NAME")
    ]
    style: Annotated[str, Option("auto", WRITTEN, "Style of the C code: nested, ordered, walk or auto.", "NAME")]
    test_vectors: Annotated[bool, Option(False, WRITTEN, "Also write observations with expected actions, and a test.")]
    passes: Annotated[
        Iterable[str],
        Option(
            (),
            TREES,
            "Passes to run on the trees first: any of drop,merge,reorder.",
            "NAMES",
            called="pass",
            commas=True,
        ),
    ]
    region: Annotated[str | Path | None, Option(None, TREES, "For the pass drop: `start` or a region file.", "REGION")]
    prove: Annotated[
        bool, Option(False, CHECKS, "Prove with Z3 that C and Python equal the trees for all observations.")
    ]
    solver_units: Annotated[
        int | None, Option(None, CHECKS, "Limit per proof, in Z3's resource units (default: 200000000).")
    ]
    certificate: Annotated[
        Path | None,
        Option(None, WRITTEN, "For the target monitor: the certificate of the claim to watch.", "FILE"),
    ]
    noise: Annotated[
        Number | None,
        Option(None, WRITTEN, "For monitors of episodes: by how much each measured number may be off.", "NUMBER"),
    ]
    contracts: Annotated[bool, Option(False, CHECKS, "Also write the C's contracts in ACSL, which Frama-C can prove.")]
    frama_c: Annotated[bool, Option(False, CHECKS, "Write the contracts, and prove them with Frama-C's WP and Z3.")]


class RepairOptions(TypedDict, total=False):
    """What a repair is asked for besides its claim and region."""

    team: Annotated[
        str | None,
        Option(None, QUESTION, "The team to repair (default: the one with as many agents as landmarks).", "NAME"),
    ]
    margin: Annotated[Number | None, of_claims("margin")]
    radius: Annotated[
        Number | None,
        Option(
            None,
            PARAMETERS,
            "An agent is at a landmark within this distance along each axis (default: 1/10).",
            "NUMBER",
        ),
    ]
    landmarks: Annotated[
        Names | None,
        Option(None, PARAMETERS, "own_target: one landmark per agent of the team.", "A,B", commas=True),
    ]
    max_depth: Annotated[int | None, Option(None, LIMITS, "Prefer repairs within this depth (default: any).")]
    episodes: Annotated[int, Option(1_000, LIMITS, "Held-out episodes, before and after.")]


class DiffOptions(TypedDict, total=False):
    """What is compared, besides the region."""

    agents: Annotated[
        Sequence[str],
        Option((), QUESTION, "Compare this agent only (repeatable; default: all).", "NAME", called="agent"),
    ]
    semantics: Annotated[
        str, Option("machine", QUESTION, "machine: as deployed; real: exact arithmetic, for comparison.", "NAME")
    ]
    max_nodes: Annotated[int | None, Option(None, BUDGETS, "Limit on nodes of each search (default: 4000000).")]
    max_cells: Annotated[int | None, Option(None, BUDGETS, "Limit on zones per agent (default: 50000).")]
