"""The manual's page on Python: every public function and the objects that users hold, from signatures and docstrings.

Does: writes signature, docstring and options of each function, and docstring, fields and public members of each object.
Assumes: a field's meaning is the comment on its line, an option's a line of the docstring.
Does not: add a word of its own about any of them.
"""

import ast
import dataclasses
import inspect
import re
import textwrap
from enum import Enum

import maviper
from codegen import ir
from maviper import claims
from maviper.compilation.compile import Compiled
from maviper.evaluation.exploitability import Exploitability
from maviper.evaluation.run import Evaluation
from maviper.reproduction.run import Reproduced
from maviper.verification.diff import Compared
from maviper.verification.files.certificates import Checked
from maviper.verification.files.counterexamples import Replayed
from maviper.verification.repair import Repaired
from maviper.verification.robust import Radii
from maviper.verification.run import Verified
from verify.question import Question
from verify.result import Cost, Evidence, Result, Verdict
from verify.verdicts.decisions import DecisionEvidence
from verify.verdicts.episodes import EpisodeEvidence
from verify.verdicts.systems import SystemEvidence

WIDTH = 100
ANSWERS = [Result, Verdict, Evidence, DecisionEvidence, EpisodeEvidence, SystemEvidence, Cost, Question]
FILES = [Compiled, Checked, Replayed, Repaired, Compared, Radii, Verified]
MEASURED = [Evaluation, Exploitability, Reproduced]
PROFILE = [ir.PolicyProfile, ir.AgentPolicy, ir.Tree, ir.FeatureSpec, ir.ActionSpec]
GROUPS = {
    "Profiles": PROFILE,
    "Answers": ANSWERS,
    "What else functions return": [*FILES, *MEASURED],
    "Claims": [each for each in vars(claims).values() if inspect.isclass(each) and issubclass(each, claims.Claim)],
}


def page() -> str:
    """All sections, in Markdown."""
    sections = ["## Functions", *map(_function, maviper.__all__)]
    for title, objects in GROUPS.items():
        sections += [f"## {title}", *(_object(each) for each in objects if not each.__name__.startswith("_"))]
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


def _object(kind: type) -> str:
    parts = [f"### {kind.__name__}", f"`{kind.__module__}.{kind.__qualname__}`", _reflowed(inspect.getdoc(kind) or "")]
    lines = [bullet(line) for line in (*_fields(kind), *_members(kind))]
    return "\n\n".join([*parts, *(["\n".join(lines)] if lines else [])])


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
