"""Property files: claims that a user writes down, in TOML.

Does: finds and reads the `[[claim]]` tables of a file, and tells what is wrong in all of them at once: built-in
  properties with their parameters, and formulas of the user's own.
Assumes: region files are found by the function that is handed in.
Does not: run anything that a file holds. That is why files are TOML and not Python: formulas are parsed, never
  evaluated, so a file from elsewhere is safe to read.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, TypeVar, cast

from codegen.errors import InputError, PartlyReadError, UnknownNameError, escape_text
from codegen.ir import GOAL, PolicyProfile
from verify.claims.catalogue import NAMES, ZONES, Claim, check_read, check_zones, find_claim, read_call, readable
from verify.claims.claim import teams as teams_of
from verify.claims.decisions import RADIUS, ZERO, DecisionClaim, ensure_askable
from verify.claims.formula import Formula, agents
from verify.claims.parameters import Form, of_form
from verify.claims.region import Region
from verify.claims.region_files import everywhere, find_observed_velocities, is_list, is_table, positions, region_of
from verify.claims.views import find_numbers
from verify.claims.wording import OwnFormula
from verify.claims.written import StatedFormula, Vocabulary, read_statement
from verify.decimals import number
from verify.kinds import ALWAYS
from verify.toml_places import Place, parse

NUMBERS, COUNTS = of_form(Form.NUMBER), (*of_form(Form.STEPS), ZONES)
LISTS, TEXTS = of_form(Form.NAMES), of_form(Form.NAME)
KEYS = ("name", "label", "team", *NUMBERS, *COUNTS, *TEXTS, *LISTS, "region", "formula", "assume")
OF_FORMULAS = ("margin", "radius", "eps")  # the parameters of a user's formula
ADVICE = "`maviper verify WORLD --new` writes a file to start from"
Reading = Callable[[Formula], Formula]  # what a formula of a file means
FindRegion = Callable[[str], Region]  # what a file names -> the region


class Stated(NamedTuple):
    """The statement of one table of a file."""

    claim: Claim
    region: Region
    max_zones: int | None = None  # that deciding it may visit; None: as usual


def read_properties(
    source: str,
    profile: PolicyProfile,
    where: str,
    find_region: FindRegion,
    default: Region | None = None,
    reading: Reading | None = None,
) -> list[Stated]:
    """The claims of a TOML text with their regions; `default` (else the start region) where one names none; `reading`:
    what formulas mean, unless what they say.

    InputError with the line of each table that cannot be read, and the column in a formula.
    """
    document, file = parse(source, where, "not a readable file of claims", ADVICE)
    for key in document:
        if key not in CLAIMS:
            raise UnknownNameError("key", key, CLAIMS[:1], file / key)
    tables = properties(document, file)
    return read_each(tables, lambda table, place: _Table(table, profile, place, reading).question(find_region, default))


def read_claim(
    written: str,
    profile: PolicyProfile,
    where: str,
    find_region: FindRegion,
    default: Region | None = None,
    reading: Reading | None = None,
) -> Stated:
    """The claim of a call such as `reaches(radius=0.4, steps=25)`, as if a file had it. `where`: what errors name."""
    table = read_call(written)
    if not isinstance(table.get("region", ""), str):
        raise InputError("a region is `start` or a file here", escape_text(written), "write region=near.toml")
    return _Table(table, profile, Place(f"{where} {escape_text(written)}", ""), reading).question(find_region, default)


class _Table:
    """One `[[claim]]` table."""

    def __init__(self, table: Mapping[str, Any], profile: PolicyProfile, place: Place, reading: Reading | None) -> None:
        self._table, self._profile, self._place, self._reading = table, profile, place, reading
        for key in table:
            if key not in KEYS:
                raise UnknownNameError("key", key, KEYS, place / key)

    def question(self, find_region: FindRegion, default: Region | None) -> Stated:
        """The claim, its region, and what may be spent on it."""
        table = self._table
        given: dict[str, Any] = {key: number(table[key], self._place / key) for key in NUMBERS if key in table}
        given |= {key: self._count(key) for key in COUNTS if key in table}
        claim: Claim = self._own(given) if "formula" in table else self._read_built_in(given)
        usual = default or everywhere(self._profile) if "region" not in table else None
        region = usual or self._region(find_region)
        return Stated(claim, region, given.get(ZONES))

    def _text(self, key: str, default: str = "") -> str:
        value = self._table.get(key, default)
        if not isinstance(value, str) or (key in self._table and not value.strip()):
            raise InputError(f"{key} must be a text, and not empty", self._place / key, f'write {key} = "..."')
        return value

    def _count(self, key: str) -> int | str:
        value = self._table[key]
        if value == ALWAYS and key in of_form(Form.STEPS):
            return ALWAYS
        if isinstance(value, bool) or not isinstance(value, int):
            advice = f"write {key} = 25" + (f' or {key} = "{ALWAYS}"' if key in of_form(Form.STEPS) else "")
            raise InputError(f"{key} must be a whole number", self._place / key, advice)
        return value

    def _read_built_in(self, given: dict[str, Any]) -> Claim:
        if "name" not in self._table:
            raise InputError("a claim needs a name or a formula", self._place, f"names: {', '.join(NAMES)}")
        for key in LISTS:
            names: object = self._table.get(key, [])
            if not is_list(names) or not all(isinstance(name, str) for name in names):
                raise InputError(f"{key} must be a list of names", self._place / key, 'write ["...", "..."]')
            given |= {key: names} if names else {}
        given |= {key: self._text(key) for key in TEXTS if key in self._table}
        parameters = {key: value for key, value in given.items() if key != ZONES}
        try:
            claim = find_claim(self._text("name"), self._profile, self._text("team") or None, **parameters)
            if ZONES in given:
                check_read(claim.name, (ZONES,), readable(claim.name))
                check_zones(given[ZONES])
        except InputError as error:
            key = error.where if error.where in self._table else "name"
            error.where = str(self._place / ("team" if "team" in self._table and "team" in error.what else key))
            raise
        if claim.per_state:
            return self._with_words(cast("DecisionClaim", claim))
        if "assume" in self._table:
            raise InputError(f"{claim.name} has no assumption", self._place / "assume", "restrict it by a region")
        return replace(claim, label=self._label())

    def _own(self, given: Mapping[str, Any]) -> DecisionClaim:
        """A user's formula. Its team is that of the agents whose actions it speaks of."""
        for key in ("name", *NUMBERS, *TEXTS, *LISTS, *COUNTS):
            if key in self._table and key not in OF_FORMULAS:
                what = f"a claim with a formula has no {key}"
                raise InputError(what, self._place / key, "remove it, or remove the formula")
        written = self._text("formula")
        stated = self._parse_formula("formula", given.get("margin", ZERO), given.get("radius", RADIUS))
        acting = agents(stated.formula)
        known = teams_of(self._profile)
        teams = [each for each in known if any(one.agent in acting for one in self._profile.team(each))]
        team = self._text("team") or (teams[0] if teams else known[0])
        if team not in known:
            raise UnknownNameError("team", team, known, self._place / "team")
        if any(other != team for other in teams):
            what = f"the formula is about actions of the {' and the '.join(sorted({team, *teams}))}"
            raise InputError(what, self._place / "formula", "a claim is about one team: write one claim per team")
        claim = OwnFormula(
            team,
            **given,
            statement=stated.formula,
            written=written,
            conditions=stated.conditions,
            rounded=tuple(stated.rounded.items()),
        )
        try:
            return self._with_words(ensure_askable(self._profile, claim))
        except InputError as error:
            error.where = str(self._place / error.where) if error.where in self._table else error.where
            raise

    def _with_words(self, claim: DecisionClaim) -> DecisionClaim:
        """The claim with its label and assumption."""
        if "assume" not in self._table:
            return replace(claim, label=self._label())
        assumed = self._parse_formula("assume", claim.margin, claim.radius)
        if agents(assumed.formula):
            what = "an assumption is about states, so it must not mention actions"
            raise InputError(what, self._place / "assume", 'write formula = "ASSUMPTION implies CLAIM" instead')
        rounded = tuple({**dict(claim.rounded), **assumed.rounded}.items())
        label, assumption = self._label(), self._text("assume")
        return replace(claim, assume=assumed.formula, label=label, assumption=assumption, rounded=rounded)

    def _label(self) -> str:
        label = self._text("label")
        if "\n" in label or not label.isprintable():
            raise InputError("a label must be one line", self._place / "label", "shorten it")
        return label

    def _parse_formula(self, key: str, margin: Fraction, radius: Fraction) -> StatedFormula:
        text, profile = self._text(key), self._profile
        world = profile.world
        goal = [GOAL] if world.goals else []
        bounded = (*positions(world), *find_observed_velocities(profile))
        vocabulary = Vocabulary(
            coordinates=(*bounded, *(f"{GOAL}.{axis}" for axis in "xy" if goal)),
            agents={policy.agent: policy for policy in profile.agents},
            entities=(*(entity.name for entity in world.agents + world.landmarks), *goal),
            goals=world.goals,
            margin=margin,
            radius=radius,
            observed=find_numbers(profile),
        )
        stated = read_statement(text, vocabulary, lambda place: (self._place / key).of_offset(text, place))
        return stated if self._reading is None or "eps" in self._table else stated.read_by(self._reading)

    def _region(self, find_region: FindRegion) -> Region:
        region = self._table["region"]
        if isinstance(region, str):
            try:
                return find_region(region)
            except InputError as error:
                error.where = "\n".join(filter(None, [str(self._place / "region"), str(error.where)]))
                raise
        if not is_table(region):
            raise InputError('region must be "start", a file, or a table', self._place / "region", ADVICE)
        velocities = find_observed_velocities(self._profile)
        own_region = region_of(region, self._profile.world, self._place / "region", velocities)
        return replace(own_region, name=f"of {self._place.words}")


Table = Mapping[str, object]
Read = TypeVar("Read")
MAX_CLAIMS = 200
CLAIMS = ("claim", "property")  # what their tables are called; the second for files of before


def properties(document: Table, file: Place) -> list[tuple[Table, Place]]:
    """The tables with their places. InputError for none, for too many, and for what is no table."""
    stated = [(each, file / key / i) for key in CLAIMS for i, each in enumerate(listed_in(document, key))]
    tables: list[tuple[Table, Place]] = [(each, place) for each, place in stated if is_table(each)]
    if not tables or len(tables) < len(stated):
        raise InputError("no claim in the file", file, "begin each with a line [[claim]]")
    if len(tables) > MAX_CLAIMS:
        raise InputError(f"a file may hold at most {MAX_CLAIMS} claims", file, "split the file")
    return tables


def listed_in(document: Table, key: str) -> list[object]:
    """The tables under a key of a document, which may be none."""
    listed = document.get(key, [])
    return listed if is_list(listed) else []


def read_each(tables: list[tuple[Table, Place]], read: Callable[[Table, Place], Read]) -> list[Read]:
    """Reads each table. InputError that tells every table that cannot be read; PartlyReadError where others can be."""
    claims: list[Read] = []
    faults: list[InputError] = []
    for table, place in tables:
        try:
            claims.append(read(table, place))
        except InputError as error:
            faults.append(error)
    if not faults:
        return claims
    first, several = faults[0], len(faults) > 1
    told = "\n".join(f"- {fault}".replace("\n", "\n  ") for fault in faults)
    what = f"{len(faults)} of {len(tables)} claims cannot be read" if several else first.what
    where, advice = (told, "") if several else (first.where, first.next_step)
    if claims:
        raise PartlyReadError(what, where, advice, claims)
    raise InputError(what, where, advice) if several else first
