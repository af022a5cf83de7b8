"""The register of claims: what the paper says, in our words, and by which number and test each claim is decided.

Does: reads `claims.toml`, which is part of the package, checks it, and gives its hash; behind its claims come those of
  `more_claims.toml`, in families of their own; writes the `maviper reproduce` that plays what a report lacks, so that
  its cells join those that are there.
Assumes: the first file is written before any cell is played; every cell keeps its hash; labels as the plan gives them.
Does not: decide a claim (verdicts.py), or read results; know where a user's own expert lies: EXPERT stands for it.
"""

import hashlib
import re
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from codegen.errors import InputError, UnknownNameError, escape_text
from maviper.extraction.settings import ALGORITHMS, VARIANTS
from maviper.files import runs
from maviper.reproduction.cells.plan import MADDPG, MAIN_DEPTH, MAPPO, NO_CARD
from maviper.reproduction.cells.table import COLUMNS

FILE, MORE = (Path(__file__).with_name(name) for name in ("claims.toml", "more_claims.toml"))
FURTHER = "further "  # how the families of the second file begin
MAX_BYTES = 2**20
FORMAT = "maviper-claims-1"
GREATER, EQUAL, SECOND, NUMBER = "greater", "equal", "second best", "number"
ABOVE, BELOW, SOME_ABOVE = "above", "below", "some above"
TESTS = (GREATER, EQUAL, SECOND, ABOVE, BELOW, SOME_ABOVE, NUMBER)
COMPARING, BOUNDED = (GREATER, EQUAL, SECOND), (ABOVE, BELOW, SOME_ABOVE)
INDIVIDUAL, JOINT, LESS_JOINT = "individual", "joint", "individual less joint"
ROBUSTNESS, EACH, SHARE_EACH = "robustness", "robustness by opponent", "share by opponent"
APART, TO_THE_GOAL, EXPLOITABILITY = "attention apart", "attention to the goal", "exploitability"
STATISTICS = (INDIVIDUAL, JOINT, LESS_JOINT, ROBUSTNESS, EACH, SHARE_EACH, APART, TO_THE_GOAL, EXPLOITABILITY)
PLAYED = (INDIVIDUAL, JOINT, LESS_JOINT, ROBUSTNESS, EACH, SHARE_EACH)  # which a measure is needed for
AGAINST, EXPERT = (ROBUSTNESS, EACH, SHARE_EACH), "expert"
FIGURE = re.compile(r"\bfigure (\d+)")
CHOICES = ("game", "preset", "depth", "splits", "seed", "lineup", "measure", "expert")  # of cells


class Published(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The paper's statement: a number as it stands there, where, and the effect in the claim's own unit."""

    place: str
    number: str = ""
    effect: float | None = None


class Claim(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """One claim of the paper. `cells`: column of `cells.csv` -> the values that it is about."""

    id: str
    place: str
    says: str
    family: str
    statistic: str
    test: str
    first: list[str]
    cells: dict[str, int | str | list[int | str]]
    second: list[str] = []
    bound: float | None = None
    main: bool = False
    published: Published | None = None
    reason: str = ""  # why a published number is not compared

    def list_values(self, column: str) -> list[Any]:
        """The values of a column, as a list; [] where it is left open."""
        value = self.cells.get(column, [])
        return list(value) if isinstance(value, list) else [value]


class PaperExpert(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The value that the paper's expert reaches in a measure."""

    value: float
    place: str


class Rules(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What decides claims, beside themselves."""

    alpha: float
    margin: float
    power: float
    least_seeds: int
    weak_expert: float
    final_effect: float
    experts: Mapping[str, PaperExpert]  # measure -> the paper's expert
    tables: Mapping[str, Mapping[str, Any]]  # the paper's Tables 1, 3 and 4


class _File(Rules, forbid_unknown_fields=True, frozen=True):
    format: str
    claim: list[Claim]


class _More(msgspec.Struct, forbid_unknown_fields=True):
    format: str
    once: list[list[str]]
    claim: list[Claim]


Content = TypeVar("Content", _File, _More)


class Register(Rules, frozen=True):
    """The claims with what decides them; `sha256` of the file, `more` of the one that was written later, if any."""

    claims: tuple[Claim, ...]
    sha256: str
    more: str = ""
    once: tuple[tuple[str, ...], ...] = ()  # ids of claims about one number each, which count as the first of them

    @property
    def repeats(self) -> dict[str, str]:
        """The ids of claims that do not count -> that of the claim about the same number, which does."""
        return {name: group[0] for group in self.once for name in group[1:]}

    @property
    def families(self) -> list[str]:
        """Their names, in the order of the claims."""
        return list(dict.fromkeys(claim.family for claim in self.claims))


@lru_cache(maxsize=4)
def read(path: Path = FILE) -> Register:
    """The register in a file, that of the package with the claims that were written later. InputError with all faults
    where it is not one.
    """
    content, digest = _decode_file(path, _File)
    rules: dict[str, Any] = {name: getattr(content, name) for name in Rules.__struct_fields__}
    claims, more, once = tuple(map(_renumber_figures, content.claim)), "", tuple[tuple[str, ...], ...]()
    if path == FILE:
        later, more = _decode_file(MORE, _More)
        claims, once = (*claims, *later.claim), tuple(map(tuple, later.once))
    faults: list[str] = []
    names: set[str] = set()
    for claim in claims:
        faults += [f"{claim.id}: {fault}" for fault in faults_of(claim)]
        faults += [f"{claim.id}: the id stands twice"] * (claim.id in names)
        names.add(claim.id)
    faults += [f"once: no claim has the id {name}" for group in once for name in group if name not in names]
    if faults:
        raise InputError("the register of claims has faults", f"{path}: {'; '.join(faults)}", "see claims.toml")
    return Register(**rules, claims=claims, sha256=digest, more=more, once=once)


def _decode_file(path: Path, form: type[Content]) -> tuple[Content, str]:
    """A file of claims, and its hash."""
    data = runs.read(path, MAX_BYTES)
    try:
        content = msgspec.toml.decode(data, type=form)
    except (msgspec.ValidationError, msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(
            "the register of claims is damaged", f"{path}: {escape_text(error)}", "see claims.toml"
        ) from None
    if content.format != FORMAT:
        raise InputError(f"the register's format is not {FORMAT}", f"{path}: {escape_text(content.format)}")
    return content, hashlib.sha256(data).hexdigest()


def _renumber_figures(claim: Claim) -> Claim:
    """A claim whose figures have the paper's numbers. In the file all of them are one too high; it stays as it is,
    since its hash stands in every cell and record.
    """

    def correct_figure(text: str) -> str:
        return FIGURE.sub(lambda match: f"figure {int(match[1]) - 1}", text)

    paper = claim.published and msgspec.structs.replace(claim.published, place=correct_figure(claim.published.place))
    return msgspec.structs.replace(claim, place=correct_figure(claim.place), published=paper)


def faults_of(claim: Claim) -> list[str]:
    """Lists the faults of a claim, in words."""
    others = [EXPERT] if claim.statistic in AGAINST else []  # teams play against one another, and the expert's is one
    known: list[tuple[str, Iterable[str], Iterable[str]]] = [
        ("statistic", [claim.statistic], STATISTICS),
        ("test", [claim.test], TESTS),
        ("algorithm", [*claim.first, *claim.second], (*ALGORITHMS, *VARIANTS, *others)),
        ("column", claim.cells, COLUMNS),
    ]
    faults = [
        str(UnknownNameError(what, name, list(names), "claims.toml")).split("\n")[0]
        for what, given, names in known
        for name in given
        if name not in list(names)
    ]
    columns = [column for column in claim.cells if column in COLUMNS and column not in CHOICES]
    faults += [f"the column {column} does not choose cells" for column in columns]
    return faults + [text for wrong, text in _RULES if wrong(claim)]


_RULES: tuple[tuple[Callable[[Claim], bool], str], ...] = (
    (lambda claim: not claim.first, "`first` names no algorithm"),
    (lambda claim: (claim.test in COMPARING) != bool(claim.second), "`second` stands for what is compared with"),
    (lambda claim: (claim.test in BOUNDED) != (claim.bound is not None), "`bound` stands with above and below alone"),
    (lambda claim: (claim.test == NUMBER) != bool(claim.reason), "`reason` says why a number is not compared"),
    (lambda claim: claim.statistic in PLAYED and not claim.list_values("measure"), "`cells` names no measure"),
    (lambda claim: claim.statistic == EXPLOITABILITY and not claim.list_values("lineup"), "`cells` names no line-up"),
    (lambda claim: not claim.list_values("game"), "`cells` names no game"),
    (
        lambda claim: claim.main and (claim.published is None or claim.published.effect is None),
        "a main claim has no effect",
    ),
)


def command(experts: Iterable[str], options: str = "") -> str:
    """The command with some options, for experts of those labels."""
    named = [label if label in (MAPPO, MADDPG) else f"{label.removesuffix(NO_CARD)}=EXPERT" for label in experts]
    said = f"--experts {','.join(named)}" if set(named) - {MAPPO} else ""
    return " ".join(filter(None, ["maviper reproduce -o FOLDER", options, said]))


def playing(claim: Claim, expert: str) -> str:
    """The command that plays the cells of a claim, with the expert of that label."""
    depths = [str(depth) for depth in claim.list_values("depth")]
    options = f"--games {','.join(claim.list_values('game'))} --depths {','.join(depths)}"
    if claim.statistic == EXPLOITABILITY and set(claim.list_values("depth")) - {MAIN_DEPTH}:
        options += f" --exploit-depths {','.join(depths)}"  # usually teams of the main depth alone are answered
    return command([expert], options)
