"""From options and property files to questions: what is claimed where, and the command that asks it again.

Does: built-in properties by name, property files, the list of properties, the starter file of a world.
Assumes: options as the command line gives them; None where a user said nothing.
Does not: decide or print.
"""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from codegen import ir
from codegen.errors import InputError
from codegen.render import render
from maviper import runs
from maviper.claims import find_region
from maviper.worlds import find
from verify import closed_loop
from verify.claim import Claim, find_claim, parameters, stated
from verify.closed_loop import CLOSED_LOOP
from verify.engine import DEFAULT_BUDGET
from verify.episodes import KEEPS_APART, ClosedLoop
from verify.properties import BUILT_IN, EPS, LEAVES, STEADY, Property
from verify.property_file import read_properties
from verify.spec import MACHINE, SEMANTICS, Region
from verify.spec import text as decimal

MOST_FILE_BYTES = 2**20
DEFAULT = "distinct_targets"
PARAMETERS = ("margin", "radius", "kappa", "eps", "landmarks", "of", "steps", "zones", "others")


class Asked(NamedTuple):
    """One question: a claim, its region, and the command line that repeats it."""

    claim: Claim
    region: Region
    command: str


def questions(profile: ir.PolicyProfile, profile_name: str, options: Mapping[str, Any]) -> list[Asked]:
    """The questions of the options of `maviper verify`: first those of the property file, then the named ones."""
    if options["semantics"] not in SEMANTICS:
        raise InputError("the semantics are machine or real", "--semantics")
    region = find_region(options["region"], profile)
    budget = DEFAULT_BUDGET if options["budget"] is None else options["budget"]
    found: list[Asked] = []
    if options["properties"] is not None:
        asked = from_file(options["properties"], profile, region)
        words = ["maviper", "verify", profile_name, "--properties", options["properties"].name]
        words += [] if region.name == "start" else ["--region", region.name]
        found += [Asked(claim, where, _line(words, claim, budget, options["semantics"])) for claim, where in asked]
    names = options["names"] or (() if found else (DEFAULT,))
    for name, given in zip(names, _given(names, options), strict=True):
        with with_option_names():
            claim = find_claim(name, profile, options["team"], **given)
        found.append(Asked(claim, region, command(profile_name, claim, region.name, budget, options["semantics"])))
    _check_episodes([one.claim for one in found], options)
    return found


@contextmanager
def with_option_names() -> Iterator[None]:
    """Errors about a parameter name the option that it came from."""
    try:
        yield
    except InputError as error:
        error.where = f"--{error.where}" if error.where in PARAMETERS else error.where
        raise


def _check_episodes(claims: Sequence[Claim], options: Mapping[str, Any]) -> None:
    """InputError for options that a claim about episodes cannot follow."""
    episodes = [claim for claim in claims if isinstance(claim, ClosedLoop)]
    if options["semantics"] != MACHINE and any(claim.name == LEAVES for claim in claims):
        raise InputError(f"{LEAVES} is decided for the deployed arithmetic only", "--semantics", "leave it out")
    if episodes and options["semantics"] != MACHINE:
        what = f"{episodes[0].name} is decided for the deployed arithmetic only"
        raise InputError(what, "--semantics", "leave it out, or ask the other properties alone")
    if len(episodes) == len(claims):
        if options["budget"] is not None:
            raise InputError("none of the properties asked reads budget", "--budget", "zones is what limits episodes")
        if options["where"]:
            what = f"{' and '.join(CLOSED_LOOP)} are about episodes, and the zones of --where are of single decisions"
            raise InputError(what, "--where", "leave it out, or ask a smaller --region")
        if options["smt"] is not None:
            what = "no property asked is a question for a solver"
            raise InputError(what, "--smt", f"{', '.join(CLOSED_LOOP)} are decided by zones")


def _given(names: Sequence[str], options: Mapping[str, Any]) -> list[dict[str, Any]]:
    """For each property the parameters that a user gave and that it reads. InputError for one that none reads."""
    given = {key: options[key] for key in PARAMETERS if options[key] is not None}
    if options["team"] is not None and not names:
        raise InputError("properties of a file name their own teams", "--team", "write team into the file")
    found, used = [], set[str]()
    for name in names:
        of = (given.get("of") or DEFAULT) if name == STEADY else ""
        read = parameters(name, of)
        # an unknown name is left to those who know its closest match
        found.append({key: value for key, value in given.items() if read is None or key in read})
        used |= set(found[-1])
    for key in given:
        if key not in used:
            what = f"none of the properties asked reads {key}"
            raise InputError(what, f"--{key}", "see `maviper properties list`; in a file, write it into the file")
    return found


def from_file(path: Path, profile: ir.PolicyProfile, default: Region) -> list[tuple[Claim, Region]]:
    """The claims of a property file; it names region files as seen from its own folder."""
    try:
        source = runs.read(path, MOST_FILE_BYTES).decode()
    except UnicodeDecodeError:
        raise InputError("not a readable property file", f"{path}: not UTF-8 text", "is this the right file?") from None

    def region(name: str) -> Region:
        return find_region(name if name == "start" else str(path.parent / name), profile)

    return read_properties(source, profile, path.name, region, default)


def command(profile: str, claim: Claim, region: str, budget: int = DEFAULT_BUDGET, semantics: str = MACHINE) -> str:
    """The command line that asks about a built-in property again, run beside the profile and the region file."""
    words = ["maviper", "verify", profile, "--property", claim.name, "--team", claim.team, "--region", region]
    for key, value in stated(claim).items():
        words += [f"--{key}", _written(value)]
    return _line(words, claim, budget, semantics)


def _line(words: Sequence[str], claim: Claim, budget: int, semantics: str) -> str:
    words = [*words, *(["--semantics", semantics] if semantics != MACHINE else [])]
    words += ["--budget", str(budget)] if isinstance(claim, Property) and budget != DEFAULT_BUDGET else []
    return shlex.join(word.encode(errors="replace").decode() for word in words)


def listed() -> list[dict[str, Any]]:
    """The built-in properties as plain data: name, sentence, parameters with their defaults as texts.

    A text is empty where the default depends on the world.
    """
    found = []
    for name, built in BUILT_IN.items():
        claim = Property(name, "", eps=EPS, of=DEFAULT) if name == STEADY else Property(name, "")
        defaults = {key: _written(getattr(claim, key)) for key in built.parameters}
        sentence = built.sentence.format(team="team", of="what the property named by `of` says")
        found.append({"name": name, "sentence": sentence, "parameters": defaults})
    for name in CLOSED_LOOP:
        usual = ClosedLoop("", "", -1)
        defaults = {key: _written(getattr(usual, key)) for key in parameters(name) or ()} | {"steps": ""}
        defaults |= {"radius": ""} if name == KEEPS_APART else {}
        found.append({"name": name, "sentence": closed_loop.in_general(name), "parameters": defaults})
    return found


def _written(value: Fraction | int | str | Sequence[str]) -> str:
    """A parameter as an option is written."""
    if isinstance(value, Fraction):
        return decimal(value).strip('"')
    if isinstance(value, int):
        return str(value)
    return value if isinstance(value, str) else ",".join(value)


def starter(world: str) -> str:
    """A commented property file for a world, with its own agents, landmarks and actions."""
    found = find(world)
    teams = {team: list(members) for team, members in found.teams.items()}
    marks = [mark.name for mark in found.spec.landmarks]
    fitting = [team for team, members in teams.items() if len(members) == len(marks)]
    team = fitting[0] if fitting else max(teams, key=lambda name: len(teams[name]))
    actions = [action.name for action in found.actions[found.agents.index(teams[team][0])]]
    meanings = [one.meaning for features in found.features for one in features]
    seen = {name for meaning in meanings if meaning is not None for _, name in meaning.terms}
    return render(
        "properties/starter.toml.j2",
        world=world,
        teams=teams,
        team=team,
        fits=bool(fitting),
        episodes=bool(fitting) and not any(entity.collides for entity in found.spec.landmarks),
        colliding=[name for name, entity in zip(found.agents, found.spec.agents, strict=True) if entity.collides],
        steps=found.spec.episode_steps,
        agents=teams[team],
        everybody=found.agents,
        landmarks=marks,
        goals=list(found.spec.goals),
        actions=actions,
        velocities=[name for name in found.spec.coordinates() if name in seen and name.endswith((".vx", ".vy"))],
    )
