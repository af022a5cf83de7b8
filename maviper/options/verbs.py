"""The options of the verbs other than extract, and of the functions of these names.

Does: says each option once: its name, type, default, heading and help; None: as usual.
Assumes: parameters of claims have their forms and texts in `verify.claims.parameters`; what runs a verb has a
  field or a parameter for each other option.
Does not: check values beyond their types.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypedDict

from maviper.options.table import PARAMETERS, Option, of_claims
from verify.claims.parameters import Names, Number, Parameters

QUESTION, EXTENT, BUDGETS, RARER = "What is asked", "How far it goes", "Budgets", "More"
Count = int | None
Word = str | None
Words = Sequence[str] | None
World = str | Callable[..., Any] | None
Someone = str | object | None

EFFORT = "How much is tried before the answer is UNKNOWN; each is ten times the one before."
Effort = Annotated[Literal["low", "normal", "high"], Option("normal", EXTENT, EFFORT)]
CLAIMS_AT_ONCE = "Claims at the same time; dask: on the cluster of DASK_SCHEDULER_ADDRESS."
Jobs = Annotated[int | Literal["dask"], Option(1, EXTENT, CLAIMS_AT_ONCE, "N|dask", words=("dask",))]
SEMANTICS = "machine: as deployed; real: exact arithmetic, for comparison."
Semantics = Annotated[str, Option("machine", QUESTION, SEMANTICS, "NAME")]


class TeamOptions(TypedDict, total=False):
    """Whose decisions a claim is about."""

    team: Annotated[
        Word, Option(None, QUESTION, "The team (default: the one with an agent for each landmark).", "NAME")
    ]


class QuestionOptions(TypedDict, total=False):
    """What is asked, whatever the claim."""

    observations: Annotated[
        bool, Option(False, QUESTION, "Claims are about what agents observe, not about states of the world.")
    ]
    shared: Annotated[
        Names | None,
        Option(None, RARER, "With --observations: features that agents observe alike.", "A,B|all", commas=True),
    ]
    semantics: Semantics


class LimitOptions(TypedDict, total=False):
    """Where a claim holds, and what may be spent on that."""

    where: Annotated[bool, Option(False, EXTENT, "List the cells where a claim fails, and their share of the region.")]
    effort: Effort
    jobs: Jobs
    max_cells: Annotated[Count, Option(None, EXTENT, "Limit on failing cells to find (default: 50000).")]
    solver_units: Annotated[Count, Option(None, BUDGETS, "Z3's resource units for a query (default: 200000000).")]
    max_zones: Annotated[
        Count, Option(None, BUDGETS, "Zones of a claim about episodes, and of its certificate (default: 5000000).")
    ]


VERIFY_SETTINGS = ("max_cells", "solver_units", "max_zones", "max_boxes", "semantics", "smt")  # given by --set


class VerifyOptions(TeamOptions, QuestionOptions, Parameters, LimitOptions, total=False):
    """What is asked of a claim."""


class FileOptions(QuestionOptions, LimitOptions, total=False):
    """What is asked of the claims of a file, which says what each is about."""


class SystemOptions(TypedDict, total=False):
    """What is asked of the system that a world file defines."""

    run_reference: Annotated[
        bool, Option(False, RARER, "With --system: run the environment that it names, and compare.", needs="world")
    ]
    effort: Effort
    jobs: Jobs
    since: Annotated[
        str | Path | None,
        Option(None, EXTENT, "Keep what still holds of a certificate, or of those in a folder.", "PATH", needs="world"),
    ]
    max_boxes: Annotated[
        Count, Option(None, BUDGETS, "Boxes of a claim about a system, about a million a second (default: 60000000).")
    ]


WRITTEN, TREES, CHECKS = "What is written", "The trees", "What is proved"
IMPORTED, NAMES = "What is imported", "Names"
LIMITS = "Limits"
TARGETS = ("c", "python", "json")  # of compile, where nobody says others


class ImportOptions(TypedDict, total=False):
    """What is said of a file that it does not say itself, or says otherwise."""

    feature_names: Annotated[
        Words, Option(None, NAMES, "Names of the features.", "NAMES", called="features", commas=True)
    ]
    action_names: Annotated[Words, Option(None, NAMES, "Names of the actions.", "NAMES", called="actions", commas=True)]
    name: Annotated[
        str,
        Option(
            "imported", NAMES, "The agents' game, such as gymnasium:CartPole-v1, or a name.", "NAME", called="world"
        ),
    ]
    numbers: Annotated[
        Literal["float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32"] | None,
        Option(None, IMPORTED, "What is observed: floats, or whole numbers of a type. Thresholds are rounded down."),
    ]
    arrays: Annotated[
        Literal["floats", "float32", "float64"] | None,
        Option(None, IMPORTED, "What if/else Python is given, where it matters: floats, or arrays of NumPy."),
    ]
    output_names: Annotated[
        Words,
        Option(None, IMPORTED, "FILE returns numbers to give, of these names.", "NAMES", called="outputs", commas=True),
    ]
    prefer: Annotated[
        Words,
        Option(None, IMPORTED, "Of several actions that dtControl permits, the first of these.", "LABELS", commas=True),
    ]
    scores: Annotated[bool, Option(False, IMPORTED, "FILE returns a score for each action: the largest acts.")]
    run: Annotated[bool, Option(True, IMPORTED, "Do not run FILE: nothing compares its answers with the tree.")]


class CompileOptions(TypedDict, total=False):
    """What a compilation is asked for."""

    prefix: Annotated[Word, Option(None, WRITTEN, "Prefix of every public name (default: the world's name).", "NAME")]
    style: Annotated[
        str, Option("auto", WRITTEN, "Style of the C code: nested, ordered, freestanding, walk or auto.", "NAME")
    ]
    test_vectors: Annotated[bool, Option(False, WRITTEN, "Also write observations with expected actions, and a test.")]
    passes: Annotated[
        Iterable[str],
        Option((), TREES, "Passes over the trees: any of drop,merge,reorder.", "NAMES", called="pass", commas=True),
    ]
    region: Annotated[str | Path | None, Option(None, TREES, "For the pass drop: `start` or a region file.", "REGION")]
    prove: Annotated[bool, Option(False, CHECKS, "Prove with Z3 that C and Python equal the trees everywhere.")]
    effort: Annotated[
        Literal["low", "normal", "high"], Option("normal", CHECKS, "How much --prove tries, as of verify.")
    ]
    solver_units: Annotated[
        Count, Option(None, CHECKS, "Limit per proof, in Z3's resource units (default: 200000000).")
    ]
    certificate: Annotated[
        Path | None, Option(None, WRITTEN, "For the target monitor: the certificate of the claim to watch.", "FILE")
    ]
    noise: Annotated[
        Number | None, Option(None, WRITTEN, "For monitors of episodes: how far off measured numbers may be.", "NUMBER")
    ]
    contracts: Annotated[bool, Option(False, CHECKS, "Also write the C's contracts in ACSL, which Frama-C can prove.")]
    frama_c: Annotated[bool, Option(False, CHECKS, "Write contracts of the C, and prove them with Frama-C and Z3.")]


class RepairOptions(TeamOptions, total=False):
    """What a repair is asked for besides its claim and region."""

    margin: Annotated[Number | None, of_claims("margin")]
    radius: Annotated[
        Number | None,
        Option(None, PARAMETERS, "How near to a landmark is at it, along each axis (default: 1/10).", "NUMBER"),
    ]
    landmarks: Annotated[
        Names | None, Option(None, PARAMETERS, "own_target: one landmark per agent of the team.", "A,B", commas=True)
    ]
    max_depth: Annotated[Count, Option(None, LIMITS, "Prefer repairs within this depth (default: any).")]
    episodes: Annotated[int, Option(1_000, LIMITS, "Held-out episodes, before and after.")]


class DiffOptions(TypedDict, total=False):
    """What is compared, besides the region."""

    agents: Annotated[
        Sequence[str],
        Option((), QUESTION, "Compare this agent only (repeatable; default: all).", "NAME", called="agent"),
    ]
    semantics: Semantics
    effort: Effort
    max_nodes: Annotated[Count, Option(None, BUDGETS, "Limit on nodes of each search (default: 4000000).")]
    max_cells: Annotated[Count, Option(None, BUDGETS, "Limit on zones per agent (default: 50000).")]


WHO, MEASURED = "Who plays", "What is measured"
ANSWERS, HOW_MEASURING = "Who answers", "How it is measured"


class EvaluateOptions(TypedDict, total=False):
    """What is measured besides the subject."""

    replaced: Annotated[
        Mapping[str, str | object],
        Option({}, WHO, "Let another SUBJECT play an agent or a team (repeatable).", "NAME=SUBJECT", called="with"),
    ]
    against: Annotated[
        Iterable[str | object],
        Option((), WHO, "Opponents: another SUBJECT, scripted or random (repeatable).", "OPPONENT"),
    ]
    expert: Annotated[Someone, Option(None, WHO, "Whom to compare with (default: the profile's own expert).", "EXPERT")]
    world: Annotated[World, Option(None, WHO, "The world, where a file cannot say it: module:function, gymnasium:ID.")]
    team: Annotated[Word, Option(None, MEASURED, "Measure one team only.", "NAME")]
    episodes: Annotated[int, Option(1_000, MEASURED, "Held-out episodes, at most 100,000.")]
    why: Annotated[
        bool, Option(False, MEASURED, "Split each gap to the expert into causes (`maviper guide measuring`).")
    ]


class ExploitOptions(TypedDict, total=False):
    """What answers a team, and what is spent on it."""

    against: Annotated[
        Iterable[str | object],
        Option((), ANSWERS, "A further responder: another SUBJECT, scripted or random (repeatable).", "RESPONDER"),
    ]
    expert: Annotated[Someone, Option(None, ANSWERS, "The expert (default: the profile's own).", "EXPERT")]
    networks: Annotated[
        str | Path | None,
        Option(None, ANSWERS, "Also train two networks against the team, in this folder (maviper[train]).", "FOLDER"),
    ]
    steps: Annotated[int, Option(1_024_000, ANSWERS, "Steps of play for each network.")]
    refinement_episodes: Annotated[
        int, Option(100_000, ANSWERS, "Episodes to refine an answering tree with; 0: no tree.")
    ]
    world: Annotated[World, Option(None, ANSWERS, "module:function of the environment, if it is yours.")]
    episodes: Annotated[int, Option(1_000, HOW_MEASURING, "To choose on, and as many to report on.")]
    seed: Annotated[int, Option(0, HOW_MEASURING, "The random seed of what learns.")]


WHAT_TRAINING, HOW = "What is trained", "How it runs"


class TrainOptions(TypedDict, total=False):
    """What a training is asked for."""

    algorithm: Annotated[str, Option("", WHAT_TRAINING, "mappo, maddpg or vdn (default: the recipe's).", "NAME")]
    recipe: Annotated[
        str, Option("default", WHAT_TRAINING, "default, clone (of a script), or paper: MADDPG as released.")
    ]
    steps: Annotated[Count, Option(None, WHAT_TRAINING, "Joint environment steps (default: the recipe's).")]
    settings: Annotated[
        Mapping[str, float], Option({}, WHAT_TRAINING, "Another setting of the algorithm.", "NAME=VALUE", called="set")
    ]
    against: Annotated[Sequence[str], Option((), WHAT_TRAINING, "Also meet this expert (mappo); repeatable.", "EXPERT")]
    seed: Annotated[int, Option(0, WHAT_TRAINING, "The random seed.")]
    seeds: Annotated[int, Option(1, WHAT_TRAINING, "Train this many seeds; keep the best.")]
    device: Annotated[str, Option("cpu", HOW, "A torch device, such as cpu or cuda.")]
    jobs: Annotated[int, Option(1, HOW, "Seeds to train in parallel.")]
    resume: Annotated[bool, Option(False, HOW, "Continue the run in the folder.")]


WHAT_COMPARING = "What is compared"
Backend = Annotated[str, Option("local", HOW, "local or dask (maviper[scale]).", "NAME")]
Scheduler = Annotated[Word, Option(None, HOW, "Of Dask's scheduler (default: DASK_SCHEDULER_ADDRESS).", "ADDRESS")]


class CompareOptions(TypedDict, total=False):
    """What a comparison is asked for."""

    world: Annotated[World, Option(None, WHAT_COMPARING, "The world of experts that name none.", "WORLD")]
    experts: Annotated[
        Sequence[str | object],
        Option(
            (), WHAT_COMPARING, "Further experts: intervals are then over experts, not seeds.", "NAMES", commas=True
        ),
    ]
    algorithms: Annotated[
        Sequence[str],
        Option(
            ("maviper", "iviper", "imitation"),
            WHAT_COMPARING,
            "As for `maviper extract`; the first is compared with each other one.",
            "NAMES",
            commas=True,
        ),
    ]
    depths: Annotated[Sequence[int], Option((2, 3, 4), WHAT_COMPARING, "Depths of trees.", "NUMBERS", commas=True)]
    seeds: Annotated[int, Option(10, WHAT_COMPARING, "Extraction seeds.")]
    max_episodes: Annotated[
        int, Option(1_000, WHAT_COMPARING, "Episodes of each extraction, as for `maviper extract`.")
    ]
    settings: Annotated[
        Mapping[str, str | float],
        Option({}, RARER, "A rarer setting (`maviper extract --set help` lists them).", "NAME=VALUE", called="set"),
    ]
    jobs: Annotated[int, Option(1, HOW, "Cells at the same time.")]
    backend: Backend
    scheduler: Scheduler


WHAT_REPRODUCING = "What is reproduced"


class ReproduceOptions(TypedDict, total=False):
    """What a reproduction is asked for."""

    quick: Annotated[bool, Option(False, WHAT_REPRODUCING, "Physical deception, depth 4, one seed: a minute.")]
    experts: Annotated[
        Sequence[str],
        Option(
            ("mappo",), WHAT_REPRODUCING, "mappo, maddpg, an expert of yours, or NAME=EXPERT.", "NAMES", commas=True
        ),
    ]
    games: Annotated[Words, Option(None, WHAT_REPRODUCING, "Some of the three games.", "NAMES", commas=True)]
    depths: Annotated[Sequence[int] | None, Option(None, WHAT_REPRODUCING, "Default: 2,4,6.", "NUMBERS", commas=True)]
    algorithms: Annotated[
        Words, Option(None, WHAT_REPRODUCING, "As of extract, or rungs (default: the paper's).", "NAMES", commas=True)
    ]
    presets: Annotated[
        Sequence[str], Option(("paper",), WHAT_REPRODUCING, "paper, released, default.", "NAMES", commas=True)
    ]
    seeds: Annotated[Count, Option(None, WHAT_REPRODUCING, "Extraction seeds (default: 10, with --quick 1).")]
    first_seed: Annotated[int, Option(0, WHAT_REPRODUCING, "The first of the extraction seeds.")]
    exploit_depths: Annotated[
        Sequence[int] | None,
        Option(None, WHAT_REPRODUCING, "Depths at which trees are exploited (default: 4).", "NUMBERS", commas=True),
    ]
    plan: Annotated[bool, Option(False, HOW, "Print the cells and their CPU time; make nothing.")]
    report_only: Annotated[bool, Option(False, HOW, "Write table and report from what is finished.")]
    shard: Annotated[Word, Option(None, HOW, "Make part I of N, beside other calls on the folder.", "I/N")]
    jobs: Annotated[int, Option(1, HOW, "Cells at the same time.")]
    backend: Backend
    scheduler: Scheduler
