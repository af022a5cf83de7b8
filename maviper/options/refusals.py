"""Options of an extraction that do not go together: which, beside what, why, and what to do instead.

Does: the table of refusals; raises the first that applies.
Assumes: settings whose names and ranges are checked, filled with what the algorithm's name stands for.
Does not: check names, ranges, or what a world allows.
"""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from codegen.errors import InputError
from maviper.options.extraction import PARTS, ExtractOptions
from maviper.options.table import table_of

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
        "--selection return and race compare the iterates of one agent or of one team",
        "choose team or agent, or --selection uniform",
        ("all",),
    ),
    Refusal(
        ("selection_by",),
        {"selection": ("uniform", "return")},
        "rounds of single members are raced",
        "choose --selection race, or --selection-by team",
        ("member",),
    ),
    Refusal(
        ("least_right",),
        {"labels": (RESPONSE,)},
        "votes count predictions of the expert's actions, and replies are others",
        "choose --least-right 0 or --labels expert",
        VOTES,
    ),
    Refusal(
        ("rollouts_by",),
        {"labels": (RESPONSE,)},
        "a reply is to mates that are extracted in the same rounds",
        "choose --rollouts-by team or all",
        ("agent",),
    ),
    Refusal(
        ("weights",),
        {"labels": (RESPONSE,)},
        "a reply is to what mates do, so it is not averaged over what others could do",
        "choose --weights own or equal",
        ("averaged",),
    ),
    Refusal(
        ("weights",),
        {"labels": ("expert",)},
        "a regret is what an action costs beside the best reply",
        "choose --labels response, which is --algorithm best-response",
        ("regret",),
    ),
    Refusal(
        ("splits",),
        {"weights": ("regret",)},
        "sums are fitted to labels, and regrets are none",
        "choose --splits exact, histogram or differences",
        ("sums",),
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
        "choose --least-right 0, --algorithm viper or iviper, or --max-depth",
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
    return flags.get(setting, f"--{setting.replace('_', '-')}")


def ensure_together(said: Mapping[str, Any], changed: Collection[str]) -> None:
    """InputError for settings that do not go together. `said`: all by name; `changed`: those that an algorithm's name
    sets, and that are not as it says.
    """
    for refusal in REFUSALS:
        asked = refusal.find_refused(said, changed)
        if asked:
            who = AUTHORS if said["preset"] in refusal.beside.get("preset", ()) else said["algorithm"]
            one = refusal.values and not isinstance(refusal.values, AllBut)
            where = [f"{option_of(name)} {said[name]}" if one else option_of(name) for name in asked]
            raise InputError(refusal.reason.format(who=who), ", ".join(where), refusal.advice)
