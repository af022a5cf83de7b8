"""A table of options: a TypedDict whose fields have a type, a default, a section and a help text.

Does: reads the table; completes what was given; gives a function the signature and the text that the table says.
Assumes: each field of the TypedDict is `Annotated[type, Option(...)]`, or a parameter of claims
  (`verify.claims.parameters`); a help text is one sentence.
Does not: make options of the command line (`maviper.cli.options`), or check what a value means.
"""

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, make_dataclass, replace
from fractions import Fraction
from functools import cache, wraps
from numbers import Integral, Real
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

from codegen.errors import InputError, MaviperError, UnknownNameError, escape_text, suggestion
from verify.claims.parameters import PARAMETERS as CLAIMED
from verify.claims.parameters import Form
from verify.kinds import ALWAYS

Verb = TypeVar("Verb", bound=Callable[..., Any])
MANY = (Iterable, Sequence, Mapping)  # of a mapping, each is a text NAME=VALUE
PARAMETERS = "Parameters of claims"  # their heading
NUMBERS = {int: Integral, float: Real}
CALLED = {
    bool: "yes or no",
    int: "a whole number",
    float: "a number",
    Fraction: "a number",
    str: "a text",
    Path: "a path",
}


@dataclass(frozen=True)
class Option:
    """An option of a verb. What stands behind `form` is read from its type."""

    default: Any
    section: str  # the heading under which the command's help shows it
    help: str
    form: str = ""  # of its value, in the help
    setting: str = ""  # what the code calls it, where that is another name
    called: str = ""  # on the command line, where that is another name
    commas: bool = False  # several values stand in one word on the command line
    needs: str = ""  # the option without which nothing reads it
    name: str = ""
    hint: Any = None
    base: type = str  # of one value
    several: bool = False
    choices: tuple[str, ...] = ()  # all values that there are; (): others too
    words: tuple[str, ...] = ()  # values beside those of its type
    objects: bool = False  # in Python a function, a team or an expert itself stands for its name, too

    @property
    def flag(self) -> str:
        """As it is given on the command line."""
        return f"--{'no-' * (self.default is True)}{self.called or self.name.replace('_', '-')}"

    def read(self, value: Any) -> Any:
        """A value as the code has it: paths as Path, several in a tuple. InputError for one of another type."""
        if value is None:
            return None
        if not self.several:
            return self._one(value)
        if self.objects and is_object(value):
            return (value,)
        if isinstance(value, Mapping):
            pairs = cast("Mapping[Any, Any]", value).items()
            value = [(name, each) if is_object(each) else f"{name}={each}" for name, each in pairs]
        if isinstance(value, str) or not isinstance(value, Iterable):
            what = f"{self.name} takes several values, not {escape_text(repr(value)[:40])}"
            raise InputError(what, self.flag, "give a list")
        return tuple(map(self._one, cast("Iterable[Any]", value)))

    def _one(self, value: Any) -> Any:
        if self.objects and (is_object(value) or _is_pair(value)):
            return value
        if value in self.words:
            return value
        if self.base is Fraction and not isinstance(value, bool) and isinstance(value, Real | str):
            return value  # which whoever computes with it reads exactly: that takes NumPy
        if self.choices and value not in self.choices:
            raise UnknownNameError(self.name, escape_text(str(value)[:40]), self.choices, self.flag)
        if self.base is Path and isinstance(value, str | Path):
            return Path(value)
        if self.base in NUMBERS and not isinstance(value, bool) and isinstance(value, NUMBERS[self.base]):
            return self.base(cast("Any", value))
        if not isinstance(value, self.base) or self.base in NUMBERS:
            called = "a name or a function" if self.objects else CALLED[self.base]
            what = f"{self.name} is {called}, not {escape_text(repr(value)[:40])}"
            made = self.objects and hasattr(value, "reset")  # an environment
            advice = f"give the function that makes it: {self.name}=make, not {self.name}=make()" if made else ""
            raise InputError(what, self.flag, advice)
        return value


def _is_pair(value: Any) -> bool:
    return isinstance(value, tuple)  # a name, and an object of that name


def is_object(value: Any) -> bool:
    """Returns True for a function, a team, an expert, or a vector environment: what has no name, or needs none."""
    return callable(value) or any(hasattr(value, name) for name in ("act", "provenance", "single_observation_space"))


@cache
def table_of(options: type) -> Mapping[str, Option]:
    """The options of a TypedDict by name, in its order."""
    table: dict[str, Option] = {}
    for name, hint in get_type_hints(options, include_extras=True).items():
        written, option = get_args(hint)
        option = option if isinstance(option, Option) else of_claims(name)
        table[name] = replace(option, name=name, hint=written, **_type(written))
    return MappingProxyType(table)


def of_claims(name: str) -> Option:
    """A parameter that some claims read; without it, as the claim says."""
    (spec,) = (each for each in CLAIMED if each.name == name)
    words = (ALWAYS,) if spec.form is Form.STEPS else ()
    return Option(None, PARAMETERS, spec.help, spec.form.value, commas=spec.form is Form.NAMES, words=words)


def _type(hint: Any) -> dict[str, Any]:
    """What one value is, and whether there are several, of a type such as `Sequence[str | Path] | None`."""
    if get_origin(hint) in (Union, UnionType):
        parts = [part for part in get_args(hint) if part is not type(None)]
        objects = {"objects": True} if object in parts or any(get_origin(part) is Callable for part in parts) else {}
        return ({"base": Path} if Path in parts else _type(parts[0])) | objects
    if get_origin(hint) is Literal:
        return {"choices": get_args(hint)}
    if get_origin(hint) not in MANY:
        return {"base": hint}
    inner = [_type(part) for part in get_args(hint)]  # of a mapping: names and values
    return {**inner[0], "several": True} | ({"objects": True} if "objects" in inner[-1] else {})


def complete_options(options: type, given: Mapping[str, Any]) -> dict[str, Any]:
    """Every option of a table by name, as given; where it is not, or is None, its default. TypeError for a name that is
    not in it, as of any function; InputError for a value of another type.
    """
    table = table_of(options)
    for name in given:
        if name not in table:
            raise TypeError(f"there is no option {name}; {suggestion(name, list(table))}")
    said = {name: option.default if given.get(name) is None else given[name] for name, option in table.items()}
    return {name: option.read(said[name]) for name, option in table.items()}


def make_request(options: type, given: Mapping[str, Any]) -> Any:
    """As `complete_options`, each option as an attribute that stays as it is."""
    return _request(options)(**complete_options(options, given))


@cache
def _request(options: type) -> type:
    return make_dataclass(options.__name__, list(table_of(options)), frozen=True)


def spell_out(options: type) -> Callable[[Verb], Verb]:
    """For a function that takes `**options: Unpack[...]`: its signature and its docstring say each of them."""

    def spell(verb: Verb) -> Verb:
        table, signature = table_of(options), inspect.signature(verb)
        own = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
        named = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=option.default, annotation=option.hint)
            for name, option in table.items()
        ]
        verb.__signature__ = signature.replace(parameters=[*own, *named])  # type: ignore[attr-defined]
        lines = [f"    `{name}`: {option.help}" for name, option in table.items()]
        verb.__doc__ = "\n".join([inspect.cleandoc(verb.__doc__ or ""), "", "Options:", *lines])
        return speak_python(verb, table)

    return spell


FLAG = re.compile(r"(?<![\w-])--([a-z][a-z-]*)(?:[ =]([A-Za-z0-9_.:/+-]*[A-Za-z0-9_]))?")
SET = re.compile(r"--set (\w+)(?:=(\S*\w))?")  # an option that the command takes by --set
CALLED_IN_PYTHON = {"system": "world"}
LISTED = "`maviper verify --list`"


def speak_python(verb: Verb, table: Mapping[str, Option] = MappingProxyType({})) -> Verb:
    """The function, whose errors name its parameters where those of the command name options."""
    known = {option.flag.removeprefix("--"): option for option in table.values()}

    def spell(found: re.Match[str]) -> str:
        flag, value = found.groups()
        option = known.get(flag)
        name = option.name if option else CALLED_IN_PYTHON.get(flag, flag.replace("-", "_"))
        if found[0] == found.string:
            return name
        if option and option.default is True and flag.startswith("no-"):
            return f"{name}=False" + found[0][len(flag) + 2 :]
        if option and option.base is bool:
            return f"{name}=True" + found[0][len(flag) + 2 :]
        if value is None:
            return name
        if value.isupper() or value.replace(".", "").isdigit():
            return f"{name}={value}"
        said = option is not None and re.search(rf"\b{re.escape(value)}\b", f"{option.help} {option.choices}")
        return f'{name}="{value}"' if said or not value.isalpha() else name + found[0][len(flag) + 2 :]

    @wraps(verb)
    def run(*given: Any, **named: Any) -> Any:
        try:
            return verb(*given, **named)
        except MaviperError as error:
            for part in ("what", "where", "next_step"):
                text = getattr(error, part).replace(LISTED, "maviper.claims")
                text = SET.sub(lambda one: f"--{one[1].replace('_', '-')} {one[2] or ''}".strip(), text)
                setattr(error, part, FLAG.sub(spell, text))
            error.args = (error.what,)
            raise

    return cast("Verb", run)


def split_setting(written: str, known: Sequence[str]) -> tuple[str, str]:
    """Splits `NAME=VALUE`, as --set takes it. UnknownNameError for another name, InputError without a value."""
    name, _, value = written.partition("=")
    if name not in known:
        raise UnknownNameError("setting", escape_text(name), list(known), "--set")
    if not value:
        raise InputError(f"{name} has no value", f"--set {name}", f"write --set {name}=VALUE")
    return name, value
