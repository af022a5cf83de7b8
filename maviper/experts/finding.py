"""Which expert a text on the command line means.

Does: finds shipped experts, files and run folders, other libraries' files, a user's own by `module:function`, scripts
  for worlds without a shipped network; puts a measured critic in place of the expert's own where that is asked for.
Assumes: a user who names a module wants its code to run.
Does not: take such a name from a file.
"""

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PHYSICS
from maviper.experts import store
from maviper.experts.expert import Expert
from maviper.experts.foreign import named
from maviper.experts.given import import_expert
from maviper.experts.measured import Measured
from maviper.experts.scripted import build_script, is_script
from maviper.experts.wrapped import Narrowed, Unweighted, lawful_expert
from maviper.worlds import WORLDS, ParticleWorld, World, find, find_built_in
from maviper.worlds.outside.acting import refuse_numbers
from maviper.worlds.outside.sources import is_named_by_user, parse_source
from maviper.worlds.world import FEATURES, plain_name

LEARNED, MEASURED, NONE = "learned", "measured", "none"
CRITICS = (LEARNED, MEASURED, NONE)


def find_expert(
    text: str, critic: str = LEARNED, world: str | None = None, features: str = "", giving: bool = False
) -> tuple[Expert, World]:
    """The expert and the world that it plays. `critic`: `learned`, the expert's own where it has one, or `measured`.
    `world`: where the expert's file cannot say it, a user's environment. `features`: groups that agents shall observe
    beyond what the expert does. `giving`: as for `find`.
    """
    if critic not in CRITICS:
        raise UnknownNameError("critic", critic, CRITICS, "--critic")
    expert, played = _resolve_expert(text, None if world is None else find(world, giving))
    if played.outputs and not giving:
        raise refuse_numbers(played.name)
    if features:
        expert, played = seeing(expert, played, features)
    if critic == MEASURED and played.outputs:
        what = "Q cannot be measured where agents give numbers: there is no end of actions to play"
        raise InputError(what, played.name, "leave --critic out: all states weigh the same")
    if critic == MEASURED and played.masked:
        what = "Q cannot be measured where actions may be illegal: every action would be played"
        raise InputError(what, played.name, "choose --critic learned or none")
    expert = lawful_expert(expert, played)
    if critic == NONE:
        return Unweighted(expert), played
    measured = critic == MEASURED and not isinstance(expert, Measured)
    return (Measured.for_world(played, expert) if measured else expert), played


def seeing(expert: Expert, world: World, features: str) -> tuple[Expert, World]:
    """An expert in its world with further groups of features, which it does not look at."""
    if not isinstance(world, ParticleWorld):
        raise InputError("this world has no additional features", f"--features {features}", "leave them out")
    if FEATURES in world.spec.options:
        raise InputError("the expert's world already has additional features", world.name, "leave --features out")
    wide = find_built_in(f"{world.name},{FEATURES}={features}")
    return Narrowed(expert, world), wide


def moving(world: World, physics: str) -> World:
    """One of our games, which moves by the other physics; an expert of the game plays there as it is."""
    return find_built_in(f"{world.name},{PHYSICS}={physics}")


def _resolve_expert(text: str, world: World | None) -> tuple[Expert, World]:
    if named.is_file(text):
        expert = named.from_name(text, world)
        return expert, expert.world
    name, _, script = text.partition("@")
    if is_script(script) and name.partition(",")[0] in WORLDS:
        game = find_built_in(name)
        return Measured(game, build_script(game, script)), game
    plain, features = plain_name(text) if name.partition(",")[0] in WORLDS else (text, "")
    if features:  # no expert is shipped for it: the one of the plain world
        find_built_in(text)
        return seeing(*_resolve_expert(plain, None), features)
    still, physics = plain_name(name, PHYSICS) if name.partition(",")[0] in WORLDS else (name, "")
    learned = text.replace(name, still, 1)
    if physics and learned in store.SHIPPED:
        return store.load(learned)[0], find_built_in(name)
    if "@" not in text and text not in store.SHIPPED and text.partition(",")[0] in WORLDS:
        game = find_built_in(text)
        return (Measured(game, build_script(game)), game) if game.name not in store.SHIPPED else store.load(game.name)
    if is_named_by_user(text):
        expert = import_expert(parse_source(text))
        return expert, expert.world
    return store.load(text, world)
