"""Claims of either kind by name, about single decisions and about whole episodes; and as calls, `reaches(radius=0.4)`.

Does: finds a claim for a profile; tells which parameters a name reads, their usual values, and what it says in general;
  reads a call as the table that a property file would have, and writes a claim as one.
Assumes: parameters have their types; their ranges are checked here. built_in.py declares the claims. Whoever reads the
  table of a call (files.py) checks names and values.
Does not: read files, decide, or evaluate a call: a value is one of TOML, or a word, which stands for a text.
"""

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from typing import Any, cast

from codegen.dynamics import COINCIDENT, partners
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import PolicyProfile, WorldSpec
from verify.claims.built_in import CLAIMS, OfEpisodes
from verify.claims.built_in import Claim as BuiltIn
from verify.claims.claim import (
    Parameter,
    TeamClaim,
    check_landmarks,
    check_range,
    ensure_landmark_each,
    ensure_landmarks,
    ensure_team,
    teams,
)
from verify.claims.decisions import PLAIN, STEADY, DecisionClaim, ensure_askable, ensure_steady
from verify.claims.episodes import EPISODE_CLAIMS, EpisodeClaim
from verify.claims.parameters import Form, of_form
from verify.claims.relations import RELATIONS
from verify.claims.wording import ACCOUNTS, BUILT_IN, WITH_ERRORS, account_of
from verify.decimals import text

Claim = DecisionClaim | EpisodeClaim
NAMES = tuple(CLAIMS)
ZONES = "zones"  # given like a parameter of claims about episodes, though it is a budget: how many may be visited
MAX_ZONES = 10**12
LISTS = of_form(Form.NAMES)
EPS = Fraction(1, 100)  # of `steady`, where nobody says another
COINCIDING = (
    f"not about starts from which the centres of two that push each other ever come within {COINCIDENT:g} of each "
    "other, where the reference has no number"
)


def kind_named(name: str, of: str = "") -> type[DecisionClaim]:
    """The class of a property; of `steady` that of the one which it is said of. UnknownNameError for other names."""
    known = BUILT_IN | RELATIONS
    if name not in (*known, STEADY):
        raise UnknownNameError("claim", name, (*BUILT_IN, STEADY))
    if of and of not in (*PLAIN, *RELATIONS):
        raise UnknownNameError("claim", of, (*PLAIN, *RELATIONS), "of")
    return known[of or PLAIN[0]] if name == STEADY else known[name]


def find_property(
    name: str, profile: PolicyProfile, team: str | None = None, of: str = "", **parameters: Any
) -> DecisionClaim:
    """The named property for a team of `profile`: `team`, or the one team with as many agents as landmarks.

    `of`: what `steady` is said of; `parameters`: exact numbers, and `landmarks` by name. InputError for a parameter
    that the property does not read.
    """
    kind = kind_named(name, of)
    team = _team_of(profile, parameters) if team is None else team
    if team is None or kind.landmark_each:
        team = team_for(name, profile, team, any_size=not kind.landmark_each)
    given = {key: value for key, value in parameters.items() if key not in LISTS or value}
    check_read(name, [*given, *(["of"] if of else [])], readable(name, of))
    given |= {key: tuple(given[key]) for key in LISTS if key in given}
    if "agent" in kind.reads and not given.get("agent") and len(members := profile.team(team)) == 1:
        given |= {"agent": members[0].agent}
    given |= {"eps": given.get("eps", EPS)} if name == STEADY else {}
    claim = ensure_askable(profile, kind(team, **given))
    ensure_steady(name, claim)
    return claim


def _team_of(profile: PolicyProfile, parameters: Mapping[str, Any]) -> str | None:
    """The team of the first agent that parameters name; None where they name none. UnknownNameError for another."""
    for key in ("agent", "agents"):
        named = parameters.get(key) or ()
        for agent in (named,) if isinstance(named, str) else named:
            known = {policy.agent: policy.team for policy in profile.agents}
            if agent not in known:
                raise UnknownNameError("agent", agent, list(known), key)
            return known[agent]
    return None


def check_read(name: str, given: Sequence[str], read: Sequence[str]) -> None:
    """InputError for a given parameter that the named property does not read."""
    for parameter in given:
        if parameter not in read:
            raise InputError(f"{name} has no parameter {parameter}", parameter, f"it has {', '.join(read) or 'none'}")


def find_episode_claim(name: str, profile: PolicyProfile, team: str | None = None, **given: Any) -> EpisodeClaim:
    """The named claim about episodes for a team of `profile`, by default over a whole episode.

    `steps`: of an episode, or "always"; `landmarks`: one for each agent of the team, without them `reaches` takes the
    world's order, `covers` any matching; `others`: from whom the team keeps apart, without them from one another;
    `radius`: without it RADIUS, of `keeps_apart` the largest distance at which two of them touch.
    """
    if name not in EPISODE_CLAIMS:
        raise UnknownNameError("claim", name, EPISODE_CLAIMS)
    kind = EPISODE_CLAIMS[name]
    account = ACCOUNTS[kind]
    listed = {
        key: tuple(cast("Sequence[str]", value)) for key, value in given.items() if key in LISTS and value is not None
    }
    given |= listed
    given = {key: value for key, value in given.items() if value not in (None, ())}
    check_read(name, tuple(given), readable(name))
    team = team_for(name, profile, team, any_size=not account.landmark_each)
    check_landmarks(profile, team, given.get("landmarks", ()))
    claim = kind(team, **kind.resolve_steps(account.usual(profile, team, given) | given))
    claim.check_ranges()
    return claim


def check_zones(zones: int) -> int:
    """Checks how many zones may be visited, and returns it. InputError for a number out of its range."""
    check_range(ZONES, zones, MAX_ZONES, 1)
    return zones


def _defaults(kind: type[Claim], read: Sequence[str]) -> dict[str, Any]:
    defaults = {item.name: item.default for item in fields(kind)}
    return {key: defaults[key] for key in read}


def select_stated(claim: TeamClaim) -> dict[str, Parameter]:
    """The parameters of a claim that are not the usual ones; those that have no usual one are among them."""
    usual = {item.name: item.default for item in fields(claim)}
    return {key: value for key, value in claim.parameters.items() if key not in usual or value != usual[key]}


def _declared(name: str) -> type[BuiltIn]:
    """The declaration of a named claim. UnknownNameError for a name that there is not."""
    if name not in CLAIMS:
        raise UnknownNameError("claim", name, NAMES)
    return CLAIMS[name]


def find_claim(name: str, profile: PolicyProfile, team: str | None = None, **given: Any) -> Claim:
    """The named claim for a team of `profile`, see `find_property` and `find_episode_claim` for the parameters.

    InputError for one that the claim does not read, UnknownNameError for a name that there is not.
    """
    find = find_episode_claim if issubclass(_declared(name), OfEpisodes) else find_property
    return find(name, profile, team, **given)


def readable(name: str, of: str = "") -> tuple[str, ...]:
    """Returns the parameters that the named claim reads beside its team; of `steady` also what `of` reads.
    UnknownNameError for names that there are not.
    """
    kind = _declared(name)
    if name == STEADY:
        return (*kind.parameters(), *kind_named(name, of).reads)
    return (*kind.parameters(), ZONES) if issubclass(kind, OfEpisodes) else kind.parameters()


def in_general(name: str) -> str:
    """A named claim in words, without values."""
    words = _declared(name).words
    if name not in EPISODE_CLAIMS:
        return words.format(team="team") + (WITH_ERRORS.format(who=" of each of the team") if name == STEADY else "")
    kind = EPISODE_CLAIMS[name]
    own, until = ACCOUNTS[kind].describe_named(None), "up to step `steps`, or for ever" if kind.lasting else ""
    said = words.format(team="team", radius="`radius`", steps="`steps`", own=own, until=until)
    return f"{said}; where entities push each other {COINCIDING}"


def usual(name: str) -> dict[str, Parameter | None]:
    """The parameters of a named claim with their usual values; None where these depend on the world."""
    if name == STEADY:
        return {"eps": EPS, "of": PLAIN[0]}
    if name not in EPISODE_CLAIMS:
        return _defaults(kind_named(name), readable(name))
    kind, account = EPISODE_CLAIMS[name], ACCOUNTS[EPISODE_CLAIMS[name]]
    read = CLAIMS[name].parameters()
    return _defaults(kind, read) | dict.fromkeys(account.of_the_world) | dict(account.usually)


def sentence(claim: EpisodeClaim, world: WorldSpec) -> str:
    """A claim about episodes in words, and which starts of a world it is not about, if any."""
    return "; ".join(filter(None, [account_of(claim).sentence, describe_left_out(world)]))


def opponents_words(opponents: bool) -> str:
    """For what other agents a proof holds that follows, or does not follow, opponents."""
    return "for opponents as in this profile" if opponents else "whatever all others do"


def describe_left_out(world: WorldSpec) -> str:
    """Describes the starts that claims about episodes of a world leave out; "" for none."""
    return COINCIDING if partners(world) else ""


def team_for(name: str, profile: PolicyProfile, team: str | None, any_size: bool = False) -> str:
    """The team that the named property speaks of: `team`, or the one team with as many agents as landmarks.

    `any_size`: the property needs no landmark for each agent, so that of one team alone nothing is asked.
    """
    if team is not None:
        if any_size:
            ensure_team(profile, team)
        else:
            ensure_landmark_each(name, profile, team)
        return team
    known, wanted = teams(profile), len(profile.world.landmarks)
    if any_size and len(known) == 1:
        return known[0]
    if any_size and not wanted:
        raise InputError(f"{name} is about one team", "", f"name it, team=NAME: {', '.join(known)}")
    ensure_landmarks(name, profile)
    fitting = [candidate for candidate in known if len(profile.team(candidate)) == wanted]
    if len(fitting) != 1:
        what = f"{name} needs a team of {wanted} agents, one for each landmark"
        raise InputError(what, "", f"teams: {', '.join(known)}")
    return fitting[0]


CALL = re.compile(r"\s*(\w+)\s*(?:\((.*)\)\s*)?", re.DOTALL)
WORD = re.compile(r"[\w.+/:@-]+")  # a text without quotes
PIECE = re.compile(r""""(?:[^"\\]|\\.)*"|'[^']*'|[\[{]|[\]}]|,|[^"'\[\]{},]+""")
ADVICE = "write NAME or NAME(PARAMETER=VALUE, ...), such as reaches(radius=0.4, steps=25)"


def read_call(written: str) -> dict[str, Any]:
    """The table of a property file that says the same. Decimals are texts, as there. InputError for what is no call."""
    call = CALL.fullmatch(written)
    if call is None:
        raise InputError("not a claim", escape_text(written), ADVICE)
    table: dict[str, Any] = {"name": call[1]}
    for part in _split(call[2] or "", written):
        key, equals, value = (each.strip() for each in part.partition("="))
        if not (equals and key.isidentifier() and value):
            raise InputError(f"'{escape_text(part.strip())}' is no parameter", escape_text(written), ADVICE)
        if key in table:
            raise InputError(f"{key} is given twice", escape_text(written), "leave one of them out")
        table[key] = _read_value(value, written)
    return table


def _split(listed: str, written: str) -> Iterator[str]:
    """The parts between commas that stand in no quotes and no brackets."""
    pieces, depth, part = PIECE.findall(listed), 0, ""
    if "".join(pieces) != listed:
        raise InputError("a quotation mark is not closed", escape_text(written), ADVICE)
    for piece in pieces:
        depth += (piece in "[{") - (piece in "]}")
        if piece == "," and not depth:
            yield part
        part = "" if piece == "," and not depth else part + piece
    if part.strip():
        yield part


def _read_value(value: str, written: str) -> Any:
    try:
        read = tomllib.loads(f"value = {value}", parse_float=str)
    except (ValueError, RecursionError):
        read = {}
    if read.keys() == {"value"}:
        return read["value"]
    if WORD.fullmatch(value):
        return value
    if value[0] == "[" and value[-1] == "]" and value.count("[") == 1:
        return [_read_value(each.strip(), written) for each in _split(value[1:-1], written)]
    what = f"cannot read the value {escape_text(value)}"
    raise InputError(what, escape_text(written), 'texts stand in quotes: "..."')


def write_call(claim: Claim, zones: int | None = None) -> str:
    """A built-in claim as `read_call` reads it, with its team. `zones`: how many may be visited; None: as usual."""
    said: dict[str, Parameter] = {"team": claim.team, **select_stated(claim), **({ZONES: zones} if zones else {})}
    words = {"label": claim.label, "assume": getattr(claim, "assumption", "")}
    return spell_call(claim.name, said | {key: value for key, value in words.items() if value})


def spell_call(name: str, said: Mapping[str, Parameter]) -> str:
    """The call of a name with these parameters."""
    return f"{name}({', '.join(f'{key}={_write_value(value)}' for key, value in said.items())})"


def _write_value(value: Parameter) -> str:
    if isinstance(value, Fraction):
        return text(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value) if isinstance(value, int) else f"[{', '.join(map(_write_value, value))}]"
