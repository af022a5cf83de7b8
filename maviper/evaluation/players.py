"""Who plays: the controllers that a text on the command line means.

Does: finds profiles, experts, scripts and uniform chance by name, and checks that they play the world in question.
Assumes: a user who names a module wants its code to run; a file's word is never enough for that.
Does not: play.
"""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from codegen import ir, policy_json
from codegen.errors import InputError, UnknownNameError, closest, escape_text
from codegen.floats import FLOAT32
from codegen.ir import PHYSICS
from maviper.episodes.play import Controller, tree_policies
from maviper.evaluation.crossplay import Uniform
from maviper.experts import network
from maviper.experts.expert import Expert
from maviper.experts.finding import Forgetful, find_expert, moving, seeing
from maviper.experts.foreign.libraries import is_file
from maviper.experts.scripted import build_script
from maviper.files.profiles import load
from maviper.worlds import World, find
from maviper.worlds.matching import NO_WORLD, matching_world, not_ours, plays
from maviper.worlds.outside.sources import is_named_by_user
from maviper.worlds.remembering import LAST_ACTION, Remembering, remembering
from maviper.worlds.world import FEATURES, plain_name, world_name

SCRIPTED, RANDOM = "scripted", "random"
PROFILE, EXPERT = "profile", "expert"
SHOWN_ID = 16
SUBJECT = "SUBJECT"  # the option of the first player, who says whether agents remember
_ADVICE = "all players must be made for the same world, with the same options"


@dataclass(frozen=True)
class Player:
    """A controller of all agents, with what is told of it."""

    name: str  # without folders
    kind: str  # profile, expert, scripted, random
    id: str  # hash of its content; "" when there is none
    controller: Controller
    trees: tuple[ir.AgentPolicy, ...] = ()
    origin: str = ""  # a profile's: the id of the expert that it was extracted from

    def __str__(self) -> str:
        kind = "" if self.kind == self.name else f", {self.kind}"
        return f"{self.name}{kind}{f', id {self.id[:SHOWN_ID]}' if self.id else ''}"


def find_player(text: Any, where: str, world: World | None) -> tuple[Player, World]:
    """Finds the player that `text` means, and its world: `world`, where that is known. A path that ends in .json is a
    profile, `scripted` and `random` are that, anything else is an expert; a profile, or an expert, may be given itself.
    `where`: the option, for errors.
    """
    if isinstance(text, ir.PolicyProfile):
        return _seat(text, "team", where, world)
    if not isinstance(text, str):
        expert, played = find_expert(text, world=world, giving=True)
        return Player(getattr(text, "__name__", EXPERT), EXPERT, getattr(expert, "hash", ""), expert), world or played
    if text in (SCRIPTED, RANDOM):
        if world is None:
            raise InputError(f"'{text}' does not say which world", where, "name it: --world physical-deception")
        return Player(text, text, "", _script(world) if text == SCRIPTED else Uniform(world)), world
    if text.endswith(".json") and not is_file(text):
        return _seat(load(text, sums=True), text, where, world)
    if _holds_json(Path(text)):
        raise InputError(
            "a JSON file, not an expert's file", f"{where}: {text}", "if it is a profile, let its name end in .json"
        )
    named = world if world and (is_named_by_user(world.name) or is_file(text)) else None
    try:
        expert, played = find_expert(text, world=named, giving=True)
    except UnknownNameError as error:
        if not error.where.startswith("neither"):  # a world's option, say
            raise
        known = (*network.SHIPPED, SCRIPTED, RANDOM)
        if closest(text, known) is None:
            what = f"unknown player '{escape_text(text)}'"
            raise InputError(what, where, "write scripted, random, a profile's .json or an expert") from None
        raise UnknownNameError("player", text, known, where) from None
    features, physics = ("" if world is None else str(world.spec.options.get(name, "")) for name in (FEATURES, PHYSICS))
    if features and FEATURES not in played.spec.options:
        expert, played = seeing(expert, played, features)
    if physics and PHYSICS not in played.spec.options:
        played = moving(played, physics)
    if isinstance(world, Remembering) and not isinstance(played, Remembering):
        expert, played = seeing(expert, played, world.group)
    if world and played.name != world.name:
        raise InputError("the expert plays another world", f"{where}: {text}: {played.name}, not {world.name}", _ADVICE)
    return Player(Path(text).name or text, EXPERT, getattr(expert, "hash", ""), expert), world or played


def _script(world: World) -> Controller:
    """The script of a world, which reads its states."""
    if isinstance(world, Remembering):
        return Forgetful(cast("Expert", build_script(world.plain)), world.plain)
    return build_script(world)


def _holds_json(path: Path) -> bool:
    with suppress(OSError, ValueError):
        if path.is_file():
            with path.open("rb") as file:
                return file.read(1) == b"{"
    return False


def _seat(profile: ir.PolicyProfile, text: str, where: str, world: World | None) -> tuple[Player, World]:
    known = getattr(profile, "played", None)  # of a team
    played = world or (known() if known else matching_world(profile))
    if played is None:
        if not_ours(profile.world):
            reference = profile.world.reference
            what = f"the profile is for {reference or 'no game'}, which has to be named to be played"
            raise InputError(what, f"{where}: {text}", f"add --world {reference or 'gymnasium:NAME'}")
        raise InputError("the profile's world cannot be played", f"{where}: {text}: {NO_WORLD}", "extract it again")
    played = remembering(played, profile) if where == SUBJECT else played
    name, controller = Path(text).name, tree_policies(profile.agents)
    if isinstance(played, Remembering) and not any(policy.memory for policy in profile.agents):
        _ensure_plays(profile, played.plain, f"{where}: {text}")
        controller = Forgetful(cast("Expert", controller), played.plain)
    else:
        _ensure_plays(profile, played, f"{where}: {text}")
    known = policy_json.content_hash(profile)
    return Player(name, PROFILE, known, controller, profile.agents, profile.provenance.expert), played


def playing(profile: ir.PolicyProfile, world: str, where: str) -> World:
    """The world that a user names for a profile. InputError where the profile does not play it."""
    played = remembering(find(world, giving=True), profile)
    _ensure_plays(profile, played, f"{where}: {world}")
    return played


def _ensure_plays(profile: ir.PolicyProfile, played: World, at: str) -> None:
    for policy in profile.agents:
        if policy.numbers != FLOAT32:
            what = f"{policy.agent} compares {policy.numbers}, and worlds show float32 observations"
            raise InputError(what, at, "import the tree with --world: its observations are float32 then")
    if remembering(played, profile) is not played:
        what = f"agents of the profile remember something, and in {played.name} they do not"
        raise InputError(what, at, f"name it first, or the world with features={LAST_ACTION}")
    if not plays(profile, played):
        theirs = world_name(profile.world)
        other = theirs != played.name and profile.world != played.spec
        mismatch = f"{theirs}, not {played.name}" if other else f"{played.name} in another version"
        raise InputError("the profile plays another world", f"{at}: {mismatch}", _ADVICE)


def find_shipped(origin: str, world: World) -> Player | None:
    """The shipped expert with that id, or None; one that is not installed is not looked at."""
    game = plain_name(plain_name(world.name)[0], PHYSICS)[0]
    for name, file in network.SHIPPED.items():
        if name.partition("@")[0] == game and network.is_here(file) and network.load(name)[0].hash == origin:
            return find_player(name, "", world)[0]
    return None
