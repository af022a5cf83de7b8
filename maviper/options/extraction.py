"""The options of `maviper extract` and of `maviper.extract`, and those that do not go together.

Does: says each option once: its name, type, default, heading and help; None: as the preset or the world says. Says
  which options do not go beside which, why, and what to do instead; raises the first refusal that applies, and says all
  of them in words, for the manual.
Assumes: an option is a setting of the algorithms where `maviper.extraction.settings.Settings` has a field of its name,
  or of `setting`; the others are fields of `maviper.extraction.run.Request`. Refusals judge settings whose names and
  ranges are checked, filled with what the algorithm's name stands for.
Does not: check values beyond their types, or what a world allows.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypedDict

from codegen.errors import InputError
from maviper.options.table import Option, table_of

# named here, so that --help imports nothing else; a test compares them with the ones that there are
PAPERS = "maviper, maviper-no-prediction, maviper-iviper-resampling, iviper, viper, imitation, fitted-q"
ALGORITHMS = f"{PAPERS}, best-response, rgmdt"
FEATURES = "velocity, goal, differences, signs, ahead, coasting, last_action, time_since_change (several with +)"
WHAT, EPISODES, LEARNS, HOW = "What is extracted", "Episodes", "What it learns from", "How it runs"
PARTS, TUNING = "What the algorithm's name sets", "How rounds are chosen and ended"  # given by --set


Count = int | None  # None: as the preset or the world says
Word = str | None


class ExtractOptions(TypedDict, total=False):
    """What an extraction is asked for."""

    algorithm: Annotated[str, Option("maviper", WHAT, f"One of {ALGORITHMS}.", "NAME")]
    preset: Annotated[
        str, Option("default", WHAT, "default, paper (as published) or released (the authors' code).", "NAME")
    ]
    max_depth: Annotated[int, Option(4, WHAT, "Splits on the longest path.")]
    max_leaves: Annotated[Count, Option(None, WHAT, "Most leaves of a tree; not with maviper, whose members vote.")]
    share: Annotated[Word, Option(None, WHAT, "team: one tree for all agents of a team.", "WHO")]
    agent: Annotated[Word, Option(None, WHAT, "The agent to extract, for viper.", "NAME")]
    splits: Annotated[
        Word,
        Option(None, WHAT, "exact or histogram (default: the preset's); differences; sums: of a few features.", "NAME"),
    ]
    leaves: Annotated[
        Word,
        Option(None, WHAT, "Outputs of a leaf: constant (the default), or linear in features.", "NAME", setting="leaf"),
    ]
    labels: Annotated[
        Word, Option(None, PARTS, "What trees are taught: the expert's actions, or the best reply.", "expert|response")
    ]
    rollouts_by: Annotated[
        Word,
        Option(None, PARTS, "Whose trees play together among experts; experts: nobody's.", "agent|team|all|experts"),
    ]
    weights: Annotated[
        Word, Option(None, PARTS, "What states weigh; averaged: over what others could do.", "own|averaged|equal")
    ]
    least_right: Annotated[
        Word,
        Option(
            None, PARTS, "Members, of a team of N, that must be predicted right; 0: no votes.", "N|N-1|NUMBER|SHARE"
        ),
    ]
    selection_by: Annotated[Word, Option(None, PARTS, "For whom one round is chosen.", "agent|member|team|all")]
    undo: Annotated[
        str, Option("", PARTS, "Accidents of preset released to leave out (several with +).", "leaves+restarts+warm-up")
    ]
    features: Annotated[str, Option("", WHAT, f"More features: {FEATURES}, or auto.", "NAMES")]
    features_file: Annotated[
        str | Path | None, Option(None, WHAT, "Names and units of what agents observe in your own game (TOML).")
    ]
    max_episodes: Annotated[
        Count,
        Option(
            None, EPISODES, "Episodes to learn and select by (in your own games held-out ones too).", setting="budget"
        ),
    ]
    held_out: Annotated[
        Count, Option(None, EPISODES, "Episodes to measure with (default: 1000; in your own games 200).")
    ]
    iterations: Annotated[Count, Option(None, EPISODES, "Rounds of rollouts and growth (default: the paper's).")]
    rollouts: Annotated[Count, Option(None, EPISODES, "Episodes of a round (default: the paper's).")]
    patience: Annotated[
        Count,
        Option(
            None,
            TUNING,
            "Stop after so many rounds without a gain (default: 10; paper, released: never).",
            "1 to 1000000",
        ),
    ]
    enough: Annotated[
        float,
        Option(
            0.0, TUNING, "Stop at this ratio to the expert, by the lower end of its interval; 0: never.", "0 to 100"
        ),
    ]
    max_seconds: Annotated[
        float, Option(0.0, EPISODES, "Stop learning in time to be done after so many seconds; 0: no limit.")
    ]
    selection: Annotated[
        Word, Option(None, TUNING, "How a round is chosen (default: the preset's).", "uniform|return|race")
    ]
    selection_episodes: Annotated[
        Count, Option(None, TUNING, "Episodes per candidate and team (default: 100).", "1 to 1000000")
    ]
    refinement_episodes: Annotated[
        Count,
        Option(None, EPISODES, "Episodes to refine a team's trees with (default: the preset's).", setting="refinement"),
    ]
    measure: Annotated[
        Word, Option(None, TUNING, "What teams are judged by (default: the world's first measure).", "NAME")
    ]
    explore: Annotated[float, Option(0.0, TUNING, "fitted-q: share of uniform actions while it collects.", "0 to 1")]
    critic: Annotated[str, Option("learned", LEARNS, "The Q that weighs states: learned, measured or none.")]
    max_samples: Annotated[
        Count, Option(None, TUNING, "Most points drawn by weight for a tree (default: 300000).", "1 to 1000000")
    ]
    world: Annotated[
        str | Callable[..., Any] | None, Option(None, LEARNS, "The expert's world, if its file names none.")
    ]
    counterexamples: Annotated[
        Iterable[str | Path],
        Option((), LEARNS, "What `maviper verify -o` wrote: a file or a folder (repeatable).", "PATH"),
    ]
    seed: Annotated[int, Option(0, HOW, "The random seed.")]
    seeds: Annotated[int, Option(1, HOW, "Extract this many seeds; keep the best.")]
    jobs: Annotated[int, Option(1, HOW, "Parallel processes, for seeds, IVIPER's agents or refinement.")]
    resume: Annotated[bool, Option(False, HOW, "Continue the run in the folder.")]


# named here, as algorithms are in the table of options
AUTHORS, RELEASED, VIPER, FITTED_Q, RGMDT = "the authors' code", "released", "viper", "fitted-q", "rgmdt"
BEST_RESPONSE, RESPONSE = "best-response", "response"
OTHER_PRESET, OTHER_ALGORITHM = "choose --preset paper or default", "choose another --algorithm, or leave it out"
DEPTH = "--max-depth limits every tree"
SHARING = "choose --algorithm maviper, iviper or imitation, and leave the other option out"


class AllBut(tuple[Any, ...]):
    """All values but these."""

    def __contains__(self, value: object) -> bool:
        return not super().__contains__(value)


VOTES = AllBut("0")


class Refusal(NamedTuple):
    """Settings of which none may be asked for beside one of some values of another."""

    settings: tuple[str, ...]
    beside: Mapping[str, tuple[Any, ...]]
    reason: str  # {who}: the algorithm, or the authors' code
    advice: str
    values: tuple[Any, ...] = ()  # of the settings; (): whatever is not as usual

    def find_refused(self, said: Mapping[str, Any], changed: Collection[str]) -> list[str]:
        """The settings that are refused beside what else is said."""
        if not any(said[name] in values for name, values in self.beside.items()):
            return []
        if self.values:
            return [name for name in self.settings if said[name] in self.values]
        return [name for name in self.settings if (name in changed if name in PART_NAMES else said[name])]


UNDO = "undo"
SETTINGS = tuple(name for name, option in table_of(ExtractOptions).items() if option.section in (PARTS, TUNING))
PART_NAMES = tuple(
    name for name, option in table_of(ExtractOptions).items() if option.section == PARTS and name != UNDO
)
REFUSALS = (
    Refusal(
        PART_NAMES,
        {"preset": (RELEASED,)},
        "preset released is the authors' code as it is, which has one way for each algorithm",
        f"leave it out, or {OTHER_PRESET}",
    ),
    Refusal(
        (UNDO,),
        {"preset": AllBut([RELEASED])},
        "only the authors' code, preset released, has accidents that can be undone",
        "leave it out, or choose --preset released",
    ),
    Refusal(
        ("labels", "rollouts_by", "least_right", "selection_by"),
        {"algorithm": (VIPER,)},
        "viper extracts one agent, alone among experts",
        "choose --algorithm iviper",
    ),
    Refusal(
        ("labels", "rollouts_by", "weights", "least_right"),
        {"algorithm": (FITTED_Q,)},
        "fitted-q learns from the rewards of expert episodes",
        OTHER_ALGORITHM,
    ),
    Refusal(
        ("labels", "rollouts_by", "weights", "least_right"),
        {"algorithm": (RGMDT,)},
        "rgmdt learns from the expert's Q, given all trees",
        OTHER_ALGORITHM,
    ),
    Refusal(
        ("selection_by",),
        {"selection": ("return", "race")},
        "--set selection=return and race compare the iterates of one agent or of one team",
        "choose team or agent, or --set selection=uniform",
        ("all",),
    ),
    Refusal(
        ("selection_by",),
        {"selection": ("uniform", "return")},
        "rounds of single members are raced",
        "choose --set selection=race, or --set selection_by=team",
        ("member",),
    ),
    Refusal(
        ("least_right",),
        {"labels": (RESPONSE,)},
        "votes count predictions of the expert's actions, and replies are others",
        "choose --set least_right=0 or --set labels=expert",
        VOTES,
    ),
    Refusal(
        ("rollouts_by",),
        {"labels": (RESPONSE,)},
        "a reply is to mates that are extracted in the same rounds",
        "choose --set rollouts_by=team or all",
        ("agent",),
    ),
    Refusal(
        ("weights",),
        {"labels": (RESPONSE,)},
        "a reply is to what mates do, so it is not averaged over what others could do",
        "choose --set weights=own or equal",
        ("averaged",),
    ),
    Refusal(("explore",), {"algorithm": AllBut([FITTED_Q])}, "only fitted-q explores", "leave it out"),
    Refusal(
        ("agent",),
        {"algorithm": AllBut([VIPER])},
        "only viper extracts one agent alone",
        "choose --algorithm viper, or leave it out",
    ),
    Refusal(
        ("preset",),
        {"algorithm": (RGMDT,)},
        "the authors' code has no RGMDT, which is built after its description",
        OTHER_PRESET,
        (RELEASED,),
    ),
    Refusal(
        ("preset",),
        {"algorithm": (BEST_RESPONSE,)},
        "best-response is ours, and the authors' code has nothing like it",
        OTHER_PRESET,
        (RELEASED,),
    ),
    Refusal(
        ("preset",),
        {"algorithm": (FITTED_Q,)},
        "the released Fitted Q always stands still, because its look-ups never hit",
        OTHER_PRESET,
        (RELEASED,),
    ),
    Refusal(
        ("max_leaves",),
        {"algorithm": (FITTED_Q,), "preset": (RELEASED,)},
        "{who} has no budget of leaves",
        f"leave it out; {DEPTH}",
    ),
    Refusal(
        ("max_leaves",),
        {"least_right": VOTES},
        "a team whose members vote grows level by level, so its trees have a depth and no budget of leaves",
        "choose --set least_right=0, --algorithm viper or iviper, or --max-depth",
    ),
    Refusal(
        ("share",),
        {"algorithm": (VIPER, FITTED_Q, RGMDT), "preset": (RELEASED,)},
        "{who} grows a tree for each agent alone",
        SHARING,
    ),
    Refusal(
        ("splits",),
        {"algorithm": (FITTED_Q, RGMDT), "preset": (RELEASED,)},
        "{who} tests single features",
        "choose --splits exact or histogram, or another algorithm",
        ("differences", "sums"),
    ),
    Refusal(("share",), {"refinement": AllBut([0])}, "refinement changes the trees of a team one by one", SHARING),
    Refusal(
        ("share",),
        {"rollouts_by": ("agent",), "selection_by": ("agent", "member")},
        "agents that share a tree play and choose together",
        SHARING,
    ),
)


def option_of(setting: str) -> str:
    """The option by which a user gives a setting of an extraction."""
    flags = {option.setting: option.flag for option in table_of(ExtractOptions).values()}
    return f"--set {setting}" if setting in SETTINGS else flags.get(setting, f"--{setting.replace('_', '-')}")


def ensure_together(said: Mapping[str, Any], changed: Collection[str]) -> None:
    """InputError for settings that do not go together. `said`: all by name; `changed`: those that an algorithm's name
    sets, and that are not as it says.
    """
    for refusal in REFUSALS:
        asked = refusal.find_refused(said, changed)
        if asked:
            who = AUTHORS if said["preset"] in refusal.beside.get("preset", ()) else said["algorithm"]
            one = refusal.values and not isinstance(refusal.values, AllBut)
            given = [(option_of(name), said[name]) for name in asked]
            where = [f"{name}{' ='[' ' in name]}{value}" if one else name for name, value in given]
            raise InputError(refusal.reason.format(who=who), ", ".join(where), refusal.advice)
