"""From options and property files to questions: what is claimed where, and the command that asks it again.

Does: finds built-in properties by name and reads property files; finds regions by name, over observations those of what
  was seen, where a number in a formula is what the agents of a view compare.
Assumes: options with None where a user said nothing.
Does not: decide or print, or read formulas (verify/claims/written.py).
"""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, cast

from codegen import ir
from codegen.deciding import ensure_floats
from codegen.errors import InputError, PartlyReadError
from codegen.ir import Meaning, PolicyProfile
from maviper.claims import Claim as BuiltIn
from maviper.claims import complete_parameters, name_of
from maviper.files import kinds, runs
from maviper.files.profiles import find_region
from maviper.options import VERIFY_SETTINGS, SystemOptions, complete_options, table_of
from maviper.options import VerifyOptions as Options
from verify.checker.thresholds import sides
from verify.claims.catalogue import MAX_ZONES, Claim, find_claim, spell_call, write_call
from verify.claims.claim import Parameter, check_range
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.files import Reading, Stated, read_claim, read_properties
from verify.claims.formula import Formula
from verify.claims.observed import View
from verify.claims.parameters import PARAMETER_NAMES, Form, of_form
from verify.claims.region import Region
from verify.claims.region_files import START
from verify.claims.terms import Compared, read_as_compared
from verify.claims.views import (
    RANGES,
    SEEN,
    UNLIKE,
    Viewed,
    build_seen_region,
    carry_region,
    confine_region,
    find_numbers,
    select_features,
    unread,
)
from verify.decimals import exact, plain
from verify.kinds import MACHINE, SEMANTICS
from verify.question import EFFORTS, UNITS_A_NODE, AnyClaim, Budgets, Question
from verify.subjects import Game


def as_compared(view: PolicyProfile, semantics: str) -> Callable[[Formula], Formula]:
    """Returns a function that reads a view's formulas as compared. Variables observed in unlike types stay."""
    numbers, known = find_numbers(view), dict[str, Compared]()
    for policy in view.agents:
        for feature in policy.features:
            for _, variable in feature.meaning.terms if feature.meaning is not None else ():
                if numbers[variable] != UNLIKE:
                    alone = replace(feature, meaning=Meaning(((1.0, variable),)))
                    cut = partial(sides, alone, numbers=policy.numbers, semantics=semantics)
                    scale = map(Fraction, feature.scale)
                    now = Compared(numbers[variable], cut, *scale)
                    if known.get(variable, now)[2:] != now[2:]:
                        what = f"agents that share {variable} have unlike scales"
                        raise InputError(what, "--shared", "do not share it, or state the same scale")
                    known[variable] = now
    return partial(read_as_compared, known=known)


def resolve_region(about: PolicyProfile, viewed: Viewed | None, name: str) -> Region:
    """The region of that name, or in that file. Over observations `start` is what was seen, where somebody looked, and
    `ranges` what the features' ranges are.
    """
    if viewed is None or name not in (START, SEEN, RANGES):
        return find_region(name, about, () if viewed is None else (SEEN, RANGES))
    known = build_seen_region(viewed)
    if known is None and name == SEEN:
        raise InputError("the profile does not say what was seen", "--region seen", "leave it out")
    if known is None:
        return find_region(START, about)
    return known if name != RANGES else replace(find_region(START, about), name=RANGES)


DASK = "dask"  # in place of a number of jobs: as many as a cluster has
Jobs = int | str
MAX_FILE_BYTES = 2**20
DEFAULT, DEFAULT_OBSERVED = "distinct_targets", "alive_leaves"
OF_SYSTEMS = table_of(SystemOptions)  # options that claims about stated systems read
MAX_CELLS = 1_000_000  # a cell takes about 2 KB


@dataclass(frozen=True)
class VerifyOptions:
    """The question about a profile, as options; None: as usual."""

    claims: tuple[str, ...] = ()  # built-in claims, as calls
    names: tuple[str, ...] = ()  # built-in claims, by name
    file: Path | None = None  # a property file, whose claims come first
    region: str = "start"
    team: str | None = None
    semantics: str = MACHINE
    parameters: Mapping[str, Any] = field(default_factory=dict[str, Any])  # of claims, by name
    observations: bool = False  # claims speak of observations, not of world states
    shared: tuple[str, ...] | None = None  # features that agents observe alike; ("all",): all that several have
    where: bool = False  # also where claims about single decisions hold
    effort: str = "normal"
    max_cells: int | None = None
    max_zones: int | None = None
    solver_units: int | None = None
    smt: Path | None = None  # a folder for the queries to the solver
    verdict_only: bool = False  # no shares, margins, explanations or files beside the verdicts
    world: Path | None = None  # a world file: claims are about the system that it states
    run_reference: bool = False  # also run user code that the file names
    max_boxes: int | None = None
    since: Path | None = None  # a certificate, or a folder of some: what still holds of them is kept
    jobs: Jobs = 1  # claims at the same time

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> "VerifyOptions":
        """The options by name, parameters of claims among them; None: as usual."""
        stated = {key: options[key] for key in PARAMETER_NAMES if options.get(key) is not None}
        return cls(parameters=stated, **{key: value for key, value in options.items() if key not in PARAMETER_NAMES})

    @classmethod
    def about(cls, claim: str | BuiltIn, region: str, options: Mapping[str, Any]) -> "VerifyOptions":
        """Returns the options for one claim, by name or as an object, which then has the parameters itself. TypeError
        for an option that there is not, InputError for a value that it cannot have.
        """
        if isinstance(claim, type):
            what = f"{claim.__name__} is a class of claims, and no claim"
            raise InputError(what, "claim", f"write claims.{claim.__name__}(), with its parameters")
        asked = complete_options(Options, complete_parameters(claim, options))
        asked |= {key: number(asked[key], key) for key in of_form(Form.NUMBER)}
        return cls.of({"names": (name_of(claim),), "region": region, **asked})

    def ensure_usable(self) -> "VerifyOptions":
        """The options themselves; InputError for a limit that is out of its range, or that nothing reads."""
        for name, option in self.unusual.items():  # options that are about games alone, or about stated systems alone
            if self.world is None and name in OF_SYSTEMS and OF_SYSTEMS[name].needs == "world":
                raise make_world_error(option)
            if self.world is not None and name not in (*OF_SYSTEMS, "world", "file", "claims", "verdict_only"):
                advice = "leave it out; the file states claims and regions"
                raise InputError(f"{option} has no effect with --system", option, advice)
        if self.verdict_only and self.run_reference:
            what = "--run-reference has no effect with --verdict-only"
            raise InputError(what, "--run-reference", "leave one of them out")
        if self.max_boxes is not None and self.max_boxes < 1:
            what = f"--set max_boxes must be at least 1, given {self.max_boxes}"
            raise InputError(what, "--set max_boxes", "leave it out for the usual")
        if self.jobs != DASK and int(self.jobs) < 1:
            raise InputError(f"--jobs must be at least 1, given {self.jobs}", "--jobs", "leave it out for one")
        if not 0 < self.units < 2**32:
            raise InputError("the solver units must be between 1 and 2**32", "--set solver_units", "leave it out")
        if self.max_zones is not None:
            check_range("--set max_zones", self.max_zones, MAX_ZONES, 1)
        if self.max_cells is not None and not self.where:
            raise InputError("--set max_cells has no effect without --where", "--set max_cells", "add --where")
        if self.max_cells is not None and not 0 < self.max_cells <= MAX_CELLS:
            raise InputError(f"the number of cells must be between 1 and {MAX_CELLS}", "--set max_cells")
        if self.verdict_only and self.where:
            raise InputError("--where has no effect with --verdict-only", "--where", "leave one of them out")
        return self

    @property
    def unusual(self) -> dict[str, str]:
        """The options that a user gave, by name, each as it is written on the command line."""
        given = [one.name for one in fields(self) if getattr(self, one.name) != getattr(VerifyOptions(), one.name)]
        called = {"claims": "claim", "names": "claim", "world": "system", "file": "claims"}
        return {
            name: f"--set {name}" if name in VERIFY_SETTINGS else "--" + called.get(name, name).replace("_", "-")
            for name in given
        }

    @property
    def usual(self) -> Budgets:
        """The limits where none is given by itself."""
        return Budgets.of_effort(self.effort)

    @property
    def units(self) -> int:
        """Solver resource units for a query."""
        return self.usual.solver_units if self.solver_units is None else self.solver_units

    @property
    def cells(self) -> int | None:
        """The maximum number of failing cells to look for; None where nothing asks."""
        return min(self.max_cells or self.usual.max_cells, MAX_CELLS) if self.where else None

    def budgets(self, max_zones: int | None) -> Budgets:
        """Returns what may be spent on a question, with a limit on zones that is its own; None: as usual."""
        usual = self.usual
        return Budgets(
            solver_units=self.units,
            max_nodes=max(usual.max_nodes, self.units // UNITS_A_NODE),
            max_cells=self.cells or usual.max_cells,
            max_zones=max_zones or self.max_zones or usual.max_zones,
            max_boxes=self.max_boxes or usual.max_boxes,
        )


@dataclass(frozen=True)
class Asked:
    """One question, and the command line that repeats it."""

    question: Question[AnyClaim]
    command: str
    about: str = ""  # of a stated system: what its verdicts are about

    @property
    def claim(self) -> AnyClaim:
        """The claim of the question."""
        return self.question.claim

    @property
    def region(self) -> Region:
        """Where it is claimed."""
        return self.question.region

    @property
    def words(self) -> str:
        """The claim and its region, in a line."""
        claim = self.claim
        named = claim.label or f"{claim.name} of the {claim.team}" if claim.team else claim.shown
        where = self.about or f"region {self.region.name or 'given'}"
        return f"{named}, {where}"


def make_world_error(option: str) -> InputError:
    """Returns the error for an option that is about stated systems."""
    advice = "add --system FILE"
    if option == "--since":
        advice += "; of a game all is proved again: to check an earlier proof takes from a third as long as to find one"
    return InputError(f"{option} has no effect without --system", option, advice)


class Posed(NamedTuple):
    """A claim that options ask about, and where; the most zones that its file allows."""

    claim: Claim
    region: Region
    zones: int | None
    by_file: bool


def questions(
    profile: ir.PolicyProfile,
    profile_name: str,
    options: VerifyOptions,
    aside: Callable[[InputError], None] | None = None,
) -> list[Asked]:
    """The questions of the options of `maviper verify`: first those of the property file, then the named ones.

    `aside` gets what is wrong with some properties of a file, so that the others are answered; else it is raised.
    """
    if options.semantics not in SEMANTICS:
        raise InputError("the semantics must be machine or real", "--set semantics")
    viewed = None  # the view that is asked about, where options do not ask about world states
    if options.observations or unread(profile):
        viewed = Viewed(profile, View(select_features(profile, options.shared or ())))
    elif options.shared:
        raise InputError("--shared is about observations", "--shared", "add --observations")
    about = profile if viewed is None else viewed.profile
    region = resolve_region(about, viewed, options.region)
    posed = pose_claims(about, viewed, region, options, aside)
    words = ["maviper", "verify", profile_name, "--claims", options.file.name if options.file else ""]
    words += [] if region.name in (START, SEEN) else ["--region", region.name]
    asked_for: list[Asked] = []
    for claim, place, zones, by_file in posed:
        question = _question(about, viewed, claim, place, options, zones)
        asked_for.append(Asked(question, _line(words, question) if by_file else command(profile_name, question)))
    # options that a claim cannot follow, or that none of them reads
    claims = [one.claim for one in asked_for]
    fixed = [claim for claim in claims if options.semantics not in claim.arithmetics]
    if fixed:
        what = f"{fixed[0].name} is decided for the deployed arithmetic only"
        raise InputError(what, "--set semantics", "leave it out, or ask only about the other claims")
    read = {limit for claim in claims for limit in claim.limits}
    if "solver_units" not in read:
        if options.solver_units is not None:
            what = "none of these claims is decided by the solver"
            raise InputError(what, "--set solver_units", "leave it out")
        if options.smt is not None:
            what = "none of these claims gives a query to the solver"
            raise InputError(what, "--smt", f"{', '.join(EPISODE_CLAIMS)} are decided by zones")
    if "max_zones" not in read and options.max_zones is not None:
        raise InputError("none of these claims is decided by zones", "--set max_zones", "leave it out")
    if "max_cells" not in read and options.where:
        what = f"--where is about single decisions; {', '.join(EPISODE_CLAIMS)} are about episodes"
        raise InputError(what, "--where", "leave it out: the report has the share of sampled starts that fail")
    return asked_for


def pose_claims(
    about: ir.PolicyProfile,
    viewed: Viewed | None,
    region: Region,
    options: VerifyOptions,
    aside: Callable[[InputError], None] | None = None,
) -> list[Posed]:
    """The claims of options, first those of the property file, then the named ones. `region`: of those that name none;
    `aside`: as for `questions`.
    """
    posed: list[Posed] = []
    reading = None if viewed is None else as_compared(about, options.semantics)
    named = partial(resolve_region, about, viewed)
    if options.file is not None:
        try:
            asked = from_file(options.file, about, region, reading, named)
        except PartlyReadError as error:
            if aside is None:
                raise
            aside(error)
            asked = cast("tuple[Stated, ...]", error.read)
        posed = [Posed(*each, by_file=True) for each in asked]
    for written in options.claims:
        posed.append(Posed(*read_claim(written, about, "--claim", named, region, reading), by_file=False))
    names = options.names or (() if posed else (DEFAULT if viewed is None else DEFAULT_OBSERVED,))
    for name in names:
        claim = find_claim(name, about, options.team, **options.parameters)
        posed.append(Posed(claim, region, None, by_file=False))
    return posed


def _question(
    profile: ir.PolicyProfile,
    viewed: Viewed | None,
    claim: Claim,
    region: Region,
    options: VerifyOptions,
    zones: int | None,
) -> Question[Claim]:
    """The question; over observations about the view that the claim needs. InputError for episodes of observations."""
    budgets = options.budgets(zones)
    if viewed is None:
        return Question(Game(profile), claim, region, options.semantics, budgets)
    seen = Viewed(viewed.origin, claim.of_view(viewed.view))
    region = confine_region(carry_region(region, seen), seen.profile)
    beyond = {"real arithmetic": options.semantics != MACHINE, "errors of features": bool(getattr(claim, "eps", 0))}
    beyond["the claim symmetric"] = seen.view.mirrored is not None
    for who, asked in beyond.items():
        if asked:
            ensure_floats(viewed.origin, who)
    return Question(Game(seen.profile, viewed=seen), claim, region, options.semantics, budgets)


def number(value: Fraction | float | str | None, parameter: str) -> Fraction | None:
    """An exact number; of a float the decimal that Python prints for it. InputError for what is no number."""
    if value is None or isinstance(value, Fraction):
        return value
    return exact(value if isinstance(value, str) else repr(value), parameter)


def from_file(
    path: Path,
    profile: ir.PolicyProfile,
    default: Region,
    reading: Reading | None = None,
    named: Callable[[str], Region] | None = None,
) -> list[Stated]:
    """The claims of a property file; it names region files as seen from its own folder. `reading`: what its formulas
    mean; `named`: which region a name means, or the file of that path.
    """
    try:
        data = runs.read(path, MAX_FILE_BYTES)
        kinds.ensure(data, str(path), kinds.CLAIMS.called, kinds.CLAIMS)
        source = data.decode()
    except UnicodeDecodeError:
        what = "not a readable file of claims"
        raise InputError(what, f"{path}: not UTF-8 text", "is this the right file?") from None

    def region(name: str) -> Region:
        inside = name if name in (START, SEEN, RANGES) else str(path.parent / name)
        return named(inside) if named else find_region(inside, profile)

    return read_properties(source, profile, path.name, region, default, reading)


def find_effort(budgets: Budgets) -> str:
    """The effort of which a question has the solver units; "" for none."""
    return next((each for each in EFFORTS if Budgets.of_effort(each).solver_units == budgets.solver_units), "")


def usual_of(budgets: Budgets) -> Budgets:
    """The limits of the effort of a question."""
    return Budgets.of_effort(find_effort(budgets) or "normal")


def command(profile: str, question: Question[Claim]) -> str:
    """The command line that asks about a built-in property again, run beside `profile` and the region file."""
    claim, zones = question.claim, question.budgets.max_zones
    limited = "max_zones" in claim.limits and zones != usual_of(question.budgets).max_zones
    call = write_call(claim, zones if limited else None)
    return _line(["maviper", "verify", profile, "--claim", call, "--region", question.region.name], question)


def _line(words: Sequence[str], question: Question[Claim]) -> str:
    units, semantics = question.budgets.solver_units, question.semantics
    if question.viewed is not None:
        shared = question.viewed.view.shared
        words = [*words, "--observations", *(["--shared", ",".join(shared)] if shared else [])]
    words = [*words, *(["--set", f"semantics={semantics}"] if semantics != MACHINE else [])]
    effort = find_effort(question.budgets)
    words = [*words, *(["--effort", effort] if effort not in ("normal", "") else [])]
    if "solver_units" in question.claim.limits and not effort:
        words += ["--set", f"solver_units={units}"]
    return shlex.join(word.encode(errors="replace").decode() for word in words)


def list_calls(options: VerifyOptions) -> list[str]:
    """The built-in claims of options as calls, each with the parameters that it reads."""
    said = {**({} if options.team is None else {"team": options.team}), **options.parameters}
    return [*options.claims, *(spell_call(name, said) for name in options.names)]


def format_parameter(value: Parameter) -> str:
    """A parameter as tables show it."""
    if isinstance(value, Fraction):
        return plain(value)
    if isinstance(value, int):
        return str(value)
    return value if isinstance(value, str) else ",".join(value)
