"""Environments of other people by name, `module:function,option=value` or `gymnasium:ID`: found, imported and made.

Does: imports and calls the function, or makes the registered environment; turns what it raises into an InputError.
Assumes: whoever names an environment means to run its code.
Does not: play one, or know what a world is.
"""

import importlib
import inspect
import re
import sys
import traceback
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any
from warnings import catch_warnings, simplefilter

from codegen.errors import InputError, MaviperError, UnknownNameError

GYMNASIUM = "gymnasium"  # the module whose functions are the ids of its registered environments
VMAS = "vmas"  # the module whose functions are the names of its scenarios
MAX_STEPS, WRAP = "max_steps", "wrap"  # the options that are ours: how long an episode may be, and wrappers
NUMBER = re.compile(r"-?[0-9]{1,18}")
OURS = Path(__file__).parent.parent
MAX_MESSAGE = 300  # characters of what an environment says when it raises


@dataclass(frozen=True)
class Source:
    """Where an environment comes from: `module:function,option=value`."""

    module: str
    function: str
    options: Mapping[str, int | str]

    @property
    def reference(self) -> str:
        """`module:function`."""
        return f"{self.module}:{self.function}"

    @property
    def text(self) -> str:
        """The whole, as the command line reads it; options in alphabetical order."""
        return ",".join([self.reference, *(f"{key}={value}" for key, value in sorted(self.options.items()))])


def named_by_user(name: str) -> bool:
    """Whether a world's name is a `module:function`, not that of one of our games."""
    return ":" in name.split(",")[0]


def parsed(text: str) -> Source:
    """The parts of `module:function,option=value`; InputError when it has another form."""
    reference, *choices = text.split(",")
    module, _, function = reference.partition(":")
    if module != GYMNASIUM and not all(part.isidentifier() for part in (*module.split("."), function)):
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


def imported(source: Source) -> Callable[..., Any]:
    """The function, or what makes a registered environment of Gymnasium. InputError when it cannot be imported.

    The current folder comes first, as for `python -m`.
    """
    folder = str(Path.cwd())
    if source.module == GYMNASIUM:
        from maviper.worlds.outside.single_agent import registered

        return registered(source.function)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    importlib.invalidate_caches()
    module = _module(source)
    known = [name for name, value in vars(module).items() if callable(value) and not name.startswith("_")]
    if not callable(getattr(module, source.function, None)):
        raise UnknownNameError(f"function in {source.module}", source.function, known, source.text)
    return getattr(module, source.function)


def _module(source: Source) -> ModuleType:
    try:
        with redirect_stdout(sys.stderr):  # ours is for results
            return importlib.import_module(source.module)
    except ModuleNotFoundError as error:
        if error.name is not None and f"{source.module}.".startswith(f"{error.name}."):
            advice = "install it, or run maviper in the folder that contains it"
            raise InputError(f"no module '{error.name}'", source.text, advice) from None
        raise fault(error, source, f"importing {source.module}") from error
    except (Exception, SystemExit) as error:
        raise fault(error, source, f"importing {source.module}") from error


def made(function: Callable[..., Any], source: Source) -> Any:
    """A fresh environment; InputError when the function raises or returns something else."""
    known = _parameters(function)
    mine = [key for key in (MAX_STEPS, WRAP) if key not in (known or ())]
    options = {key: value for key, value in source.options.items() if key not in mine}
    unknown = [] if known is None else sorted(set(options) - set(known))
    if unknown:
        raise UnknownNameError("option", unknown[0], [*(known or ()), *mine], source.text)
    try:
        with redirect_stdout(sys.stderr):
            env = function(**options)
    except (Exception, SystemExit) as error:
        raise fault(error, source, source.function) from error
    from maviper.worlds.outside.wrappers import wrapped

    return wrapped(env, source.options.get(WRAP, "") if WRAP in mine else "", source)


def _parameters(function: Callable[..., Any]) -> list[str] | None:
    """The names of a function's keyword arguments, or None where it takes any, or Python cannot tell."""
    try:
        found = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # not written in Python
        return None
    if any(each.kind is each.VAR_KEYWORD for each in found):
        return None
    return [each.name for each in found if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]


def fault(error: BaseException, source: Source, doing: str) -> MaviperError:
    """What an environment raised, with its place in the environment's own code."""
    if isinstance(error, MaviperError):
        return error
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if OURS not in Path(frame.filename).parents]
    frames = [frame for frame in frames if not frame.filename.startswith("<frozen importlib")]
    place = f": {frames[-1].filename}:{frames[-1].lineno}, in {frames[-1].name}" if frames else ""
    message = " ".join(str(error).split())[:MAX_MESSAGE]
    said = f"{type(error).__name__}: {message}" if message else type(error).__name__
    return InputError(f"{doing} raised {said}", source.text + place, "fix it there, then run `maviper worlds check`")


def attribute(env: Any, name: str, source: Source) -> Any:
    """An attribute of the environment or of the one that it wraps, or None; InputError when it raises."""
    try:
        given = (getattr(place, name, None) for place in (env, getattr(env, "unwrapped", None)))
        return next((value for value in given if value is not None), None)
    except (Exception, SystemExit) as error:
        raise fault(error, source, f"the environment's {name}") from error


def space(env: Any, kind: str, agent: Any) -> Any:
    """An agent's `action` or `observation` space, by method or, as older environments have it, from a mapping."""
    with catch_warnings():
        simplefilter("ignore")
        return getattr(env, f"{kind}_space")(agent)
