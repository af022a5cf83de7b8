"""Environments by name: `module:function,option=value`, `gymnasium:ID`, `vmas:SCENARIO` or `system:FILE`.

Does: reads such a name; asks an environment for its spaces and attributes; turns what it raises into an InputError.
Assumes: whoever names an environment means to run its code.
Does not: import or make one (making.py), play one, or know what a world is.
"""

import re
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

from codegen.errors import InputError, MaviperError
from codegen.process.unwarned import silence_warnings

GYMNASIUM = "gymnasium"  # the module whose functions are the ids of its registered environments
SYSTEM = "system"  # the module whose functions are paths of world files
VMAS = "vmas"  # the module whose functions are the names of its scenarios
MAX_STEPS, WRAP = "max_steps", "wrap"  # the options that are ours: how long an episode may be, and wrappers
INSTALLED = {"site-packages", "dist-packages"}  # folders of packages, which are not what a user would fix
NUMBER = re.compile(r"-?[0-9]{1,18}")
OURS = Path(__file__).parents[2]
CHECK = "fix it there, then run `maviper worlds check`"
MAX_MESSAGE = 300  # characters of what an environment says when it raises
MAX_ACTIONS = 1 << 16  # of an agent: beyond it, they are numbers rather than choices


@dataclass(frozen=True)
class Source:
    """Where an environment comes from: `module:function,option=value`."""

    module: str
    function: str
    options: Mapping[str, int | str]

    @property
    def reference(self) -> str:
        """`module:function`; of a world file without its folder."""
        return f"{self.module}:{Path(self.function).name if self.module == SYSTEM else self.function}"

    @property
    def called(self) -> str:
        """A name for the world: the module's and the function's, or that of a world file."""
        return Path(self.function).stem if self.module == SYSTEM else f"{self.module}-{self.function}"

    @property
    def text(self) -> str:
        """The whole, as the command line reads it; options in alphabetical order."""
        return ",".join(
            [f"{self.module}:{self.function}", *(f"{key}={value}" for key, value in sorted(self.options.items()))]
        )


def is_named_by_user(name: str) -> bool:
    """Whether a world's name is a `module:function`, not that of one of our games."""
    return ":" in name.split(",")[0]


def parse_source(text: str) -> Source:
    """The parts of `module:function,option=value`; InputError when it has another form."""
    reference, *choices = text.split(",")
    module, _, function = reference.partition(":")
    if module not in (GYMNASIUM, SYSTEM) and not all(part.isidentifier() for part in (*module.split("."), function)):
        raise InputError("not of the form module:function", text, "write it as in `import`: package.module:function")
    options: dict[str, int | str] = {}
    for choice in choices:
        key, _, value = choice.partition("=")
        if not key.isidentifier() or not value:
            raise InputError(f"cannot read the option '{choice}'", text, f"write {reference},OPTION=VALUE")
        options[key] = int(value) if NUMBER.fullmatch(value) else value
    return Source(module, function, options)


def value_of(text: int | str) -> Any:
    """An option's value: True, False and numbers are that, anything else is text."""
    if text in ("True", "False"):
        return text == "True"
    try:
        return float(text) if isinstance(text, str) else text
    except ValueError:
        return text


def fault(error: BaseException, source: Source, doing: str, advice: str = CHECK) -> MaviperError:
    """What a user's code raised, with the last place in that code, or in what it calls where it is in none."""
    if isinstance(error, MaviperError):
        return error
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if OURS not in Path(frame.filename).parents]
    frames = [frame for frame in frames if not frame.filename.startswith("<frozen importlib")]
    frames = [frame for frame in frames if not INSTALLED.intersection(Path(frame.filename).parts)] or frames
    place = f": {frames[-1].filename}:{frames[-1].lineno}, in {frames[-1].name}" if frames else ""
    message = " ".join(str(error).split())[:MAX_MESSAGE]
    said = f"{type(error).__name__}: {message}" if message else type(error).__name__
    return InputError(f"{doing} raised {said}", source.text + place, advice)


def attribute(env: Any, name: str, source: Source) -> Any:
    """An attribute of the environment or of the one that it wraps, or None; InputError when it raises."""
    try:
        given = (getattr(place, name, None) for place in (env, getattr(env, "unwrapped", None)))
        return next((value for value in given if value is not None), None)
    except (Exception, SystemExit) as error:
        raise fault(error, source, f"the environment's {name}") from error


def table(env: Any, name: str, source: Source) -> Mapping[Any, Any]:
    """Such an attribute by agents or teams; empty where there is none, or one that means something else."""
    given = attribute(env, name, source)
    return given if is_mapping(given) else {}


def action_names(env: Any, agent: Any, source: Source) -> tuple[str, ...]:
    """A name for each of an agent's actions; () where they are not numbered. InputError for too many actions, and for
    an environment's names that are not as many texts.
    """
    n = int(getattr(space(env, "action", agent), "n", 0))
    if n > MAX_ACTIONS:
        what = f"{agent} has {n:,} actions, of at most {MAX_ACTIONS:,}"
        raise InputError(what, source.text, "let agents choose among fewer, such as a few values of each number")
    given = table(env, "action_names", source).get(agent)
    if not n or given is None:
        return tuple(f"action_{k}" for k in range(n))
    names = _texts(given)
    if names is None or len(names) != n:
        what = f"the action names of {agent} are not {n} texts, one for each action"
        raise InputError(what, source.text, "fix the environment's `action_names`, or leave this agent out of it")
    return names


def read_legal_features(env: Any, agent: Any, source: Source) -> tuple[str, ...]:
    """The feature that says whether each action is legal, by the attribute `legal`; () where there are none."""
    names = _texts(table(env, "legal", source).get(agent, ()))
    if names is None:
        what = f"`legal` does not name features for the actions of {agent}"
        raise InputError(what, source.text, 'name one for each action, "" where it is always legal')
    return names


def _texts(given: Any) -> tuple[str, ...] | None:
    """What is given as texts in a row; None: it is something else."""
    parts = tuple(given) if is_row(given) else ()
    texts = tuple(part for part in parts if isinstance(part, str))
    return texts if is_row(given) and len(texts) == len(parts) else None


def is_mapping(given: object) -> TypeGuard[Mapping[Any, Any]]:
    """Whether it has values by keys, which are the environment's own."""
    return isinstance(given, Mapping)


def is_row(given: object) -> TypeGuard[Sequence[object]]:
    """Whether it has parts in a row, and is no text."""
    return isinstance(given, Sequence) and not isinstance(given, str)


def space(env: Any, kind: str, agent: Any) -> Any:
    """An agent's `action` or `observation` space, by method or, as older environments have it, from a mapping."""
    with silence_warnings():
        return getattr(env, f"{kind}_space")(agent)
