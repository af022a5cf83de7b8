"""The manual's page on Python: every public function and the objects that users hold, from signatures and docstrings.

Does: writes signature, docstring and options of each function; of each object docstring, fields and public members, and
  what it has from others.
Assumes: a field's meaning is the comment on its line, an option's a line of the docstring.
Does not: describe any of them in words of its own.
"""

import ast
import dataclasses
import inspect
import re
import textwrap
from enum import Enum
from types import ModuleType

import maviper
from maviper import answers, claims, errors, profiles

WIDTH = 100
VERDICTS = (
    "Result",
    "Verdict",
    "Evidence",
    "DecisionEvidence",
    "EpisodeEvidence",
    "SystemEvidence",
    "Cost",
    "Question",
)
STATES = ("Region", "Counterexample", "AgentView", "SystemCounterexample")


def classes(module):
    """The public classes that a module defines, in its order, or else those that it hands on."""
    shown = [each for name, each in vars(module).items() if inspect.isclass(each) and not name.startswith("_")]
    return [each for each in shown if each.__module__ == module.__name__] or shown


GROUPS = {
    "Profiles": (profiles, classes(profiles)),
    "Answers": (answers, [getattr(answers, name) for name in (*VERDICTS, *STATES)]),
    "What else functions return": (
        answers,
        [each for each in classes(answers) if each.__name__ not in (*VERDICTS, *STATES)],
    ),
    "Claims": (claims, classes(claims)),
    "Errors": (errors, classes(errors)),
}


def page() -> str:
    """All sections, in Markdown."""
    sections = ["## Functions", *map(_function, maviper.__all__)]
    for title, (module, objects) in GROUPS.items():
        sections += [f"## {title}", *(_object(module, each) for each in objects)]
    return "\n\n".join(sections) + "\n"


def _function(name: str) -> str:
    function = getattr(maviper, name)
    text, _, options = (inspect.getdoc(function) or "").partition("\nOptions:\n")
    parts = [f"### {name}", _signature(name, function), _reflowed(text)]
    found = re.findall(r"^ {4}`(\w+)`: (.*(?:\n {5,}.*)*)", options, re.MULTILINE)
    return "\n\n".join([*parts, *(["\n".join(bullet(f"`{one}`: {said}") for one, said in found)] if found else [])])


def _signature(name: str, function: object) -> str:
    """The call as a block, parameters without their types; the defaults say enough of most."""
    parameters, keyword = [], False
    for one in inspect.signature(function).parameters.values():
        if one.kind is one.KEYWORD_ONLY and not keyword:
            parameters, keyword = [*parameters, "*"], True
        parameters.append(one.name if one.default is one.empty else f"{one.name}={one.default!r}")
    text = f"maviper.{name}({', '.join(parameters)})"
    lines = textwrap.wrap(text, WIDTH - 8, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return textwrap.indent("\n".join(lines), "    ")


def _object(module: ModuleType, kind: type) -> str:
    parts = [f"### {kind.__name__}", f"`{module.__name__}.{kind.__name__}`", _reflowed(inspect.getdoc(kind) or "")]
    lines = [bullet(line) for line in (*_inherited(kind), *_fields(kind), *_members(kind))]
    return "\n\n".join([*parts, *(["\n".join(lines)] if lines else [])])


def _inherited(kind: type):
    """What a class of data has from others: the name of one that has a section, the fields of one that has none."""
    for base in kind.__bases__:
        if not dataclasses.is_dataclass(base):
            continue
        if base.__name__.startswith("_"):
            yield from (*_inherited(base), *_fields(base))
        else:
            yield f"all that `{base.__name__}` has"


def _fields(kind: type):
    """Fields of the class itself, each with its type and the comment on its line; words of an enumeration."""
    if not dataclasses.is_dataclass(kind) and not issubclass(kind, Enum):
        return
    source = textwrap.dedent(inspect.getsource(kind)).splitlines()
    for node in ast.parse("\n".join(source)).body[0].body:
        comment = source[node.lineno - 1].partition("  # ")[2]
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            if not node.target.id.startswith("_") and "ClassVar" not in ast.unparse(node.annotation):
                yield f"`{node.target.id}: {ast.unparse(node.annotation)}`{': ' + comment if comment else ''}"
        elif isinstance(node, ast.Assign) and issubclass(kind, Enum):
            yield f"`{node.targets[0].id}`{': ' + comment if comment else ''}"


def _members(kind: type):
    """Public properties and methods of the class itself, by the first sentence of their docstrings."""
    for name, member in vars(kind).items():
        wrapped = getattr(member, "fget", None) or getattr(member, "func", None) or member
        if name.startswith("_") or not inspect.isfunction(wrapped) or not wrapped.__doc__:
            continue
        first = re.split(r"(?<=\.)\s", inspect.cleandoc(wrapped.__doc__), maxsplit=1)[0]
        yield f"`{name}{'()' if wrapped is member else ''}`: {' '.join(first.split())}"


def bullet(text: str) -> str:
    """A list's item, wrapped."""
    said = " ".join(text.split())
    return "\n".join(
        textwrap.wrap(f"- {said}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    )


def _reflowed(text: str) -> str:
    paragraphs = [" ".join(each.split()) for each in text.strip().split("\n\n")]
    return "\n\n".join(
        "\n".join(textwrap.wrap(each, WIDTH, break_long_words=False, break_on_hyphens=False)) for each in paragraphs
    )
