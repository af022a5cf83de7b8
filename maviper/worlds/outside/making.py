"""Environments of other people, imported and made.

Does: imports and calls the function that a name says, or makes the registered environment; wraps it as asked.
Assumes: whoever names an environment means to run its code.
Does not: read names (sources.py), or play.
"""

import importlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from codegen.errors import InputError, UnknownNameError
from maviper.worlds.outside.sources import GYMNASIUM, MAX_STEPS, WRAP, Source, fault, output_aside

Maker = Callable[[str], Callable[..., Any]]  # from what a name says behind its colon to what makes the environment
_MAKERS: dict[str, Maker] = {}


def add_maker(kind: str, maker: Maker) -> None:
    """From here on `kind:NAME` names what `maker` makes: rooms that this one does not know announce themselves."""
    _MAKERS[kind] = maker


def import_maker(source: Source) -> Callable[..., Any]:
    """The function, or what makes a registered environment of Gymnasium or that of a file. InputError when it cannot be
    imported.

    The current folder comes first, as for `python -m`.
    """
    folder = str(Path.cwd())
    if source.maker is not None:
        return source.maker
    if source.module == GYMNASIUM:
        from maviper.worlds.outside.wrappers import find_registered

        return find_registered(source.function)
    if source.module in _MAKERS:
        return _MAKERS[source.module](source.function)
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
        with output_aside(f"importing {source.module}"), np.errstate():  # what np.seterr sets there is not ours
            return importlib.import_module(source.module)
    except ModuleNotFoundError as error:
        if error.name is not None and f"{source.module}.".startswith(f"{error.name}."):
            advice = "install it, or run maviper in the folder that contains it"
            raise InputError(f"no module '{error.name}'", source.text, advice) from None
        raise fault(error, source, f"importing {source.module}") from error
    except (Exception, SystemExit) as error:
        raise fault(error, source, f"importing {source.module}") from error


def make_environment(function: Callable[..., Any], source: Source) -> Any:
    """A fresh environment; InputError when the function raises or returns something else."""
    known = _parameters(function)
    mine = [key for key in (MAX_STEPS, WRAP) if key not in (known or ())]
    options = {key: value for key, value in source.options.items() if key not in mine}
    unknown = [] if known is None else sorted(set(options) - set(known))
    if unknown:
        raise UnknownNameError("option", unknown[0], [*(known or ()), *mine], source.text)
    try:
        with output_aside(f"{source.text}: making it"):
            env = function(**options)
    except (Exception, SystemExit) as error:
        raise fault(error, source, source.function) from error
    from maviper.worlds.outside.wrappers import wrap_environment

    return wrap_environment(env, source.options.get(WRAP, "") if WRAP in mine else "", source)


def _parameters(function: Callable[..., Any]) -> list[str] | None:
    """The names of a function's keyword arguments, or None where it takes any, or Python cannot tell."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # not written in Python
        return None
    if any(each.kind is each.VAR_KEYWORD for each in parameters):
        return None
    return [each.name for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
