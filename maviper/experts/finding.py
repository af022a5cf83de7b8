"""Which expert a text on the command line means.

Does: finds shipped experts, files and run folders, a user's own by `module:function`, scripts for worlds without a
  shipped network; puts a measured critic in place of the expert's own where that is asked for.
Assumes: a user who names a module wants its code to run.
Does not: take such a name from a file.
"""

from codegen.errors import InputError, UnknownNameError
from maviper.experts import store
from maviper.experts.expert import Expert
from maviper.experts.measured import Measured
from maviper.experts.scripted import scripted
from maviper.worlds import WORLDS, World, built_in, find
from maviper.worlds.copies import imported, named_by_user, parsed

LEARNED, MEASURED = "learned", "measured"
CRITICS = (LEARNED, MEASURED)


def find_expert(text: str, critic: str = LEARNED, world: str | None = None) -> tuple[Expert, World]:
    """The expert and the world that it plays. `critic`: `learned`, the expert's own where it has one, or `measured`.
    `world`: where the expert's file cannot say it, a user's environment.
    """
    if critic not in CRITICS:
        raise UnknownNameError("critic", critic, CRITICS, "--critic")
    expert, played = _found(text, None if world is None else find(world))
    measured = critic == MEASURED and not isinstance(expert, Measured)
    return (Measured(played, expert) if measured else expert), played


def _found(text: str, world: World | None) -> tuple[Expert, World]:
    if "@" not in text and text not in store.SHIPPED and text.partition(",")[0] in WORLDS:
        game = built_in(text)
        return (Measured(game, scripted(game)), game) if game.name not in store.SHIPPED else store.load(game.name)
    if named_by_user(text):
        source = parsed(text)
        expert = imported(source)(**source.options)
        missing = [name for name in ("world", "agents", "act", "q") if not hasattr(expert, name)]
        if missing:
            what = f"what it returns is no expert: it has no {', '.join(missing)}"
            raise InputError(what, text, "return a maviper.experts.adapter.TorchExpert, or anything that has them")
        return expert, expert.world
    return store.load(text, world)
