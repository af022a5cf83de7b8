"""The manual's page on Python: every public function and the objects that users hold, a line each, from docstrings.

Does: lists the functions and the objects by group: each name, and its docstring's first sentence.
Assumes: `help()` and the docstrings themselves have parameters, fields and errors.
Does not: describe any of them in words of its own.
"""

import inspect
import re
import textwrap

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
    """All lists, in Markdown."""
    sections = ["## Functions", _list({name: getattr(maviper, name) for name in maviper.__all__})]
    for title, (module, objects) in GROUPS.items():
        sections += [f"## {title}", f"In `{module.__name__}`:", _list({each.__name__: each for each in objects})]
    return "\n\n".join(sections) + "\n"


def _list(objects: dict[str, object]) -> str:
    """An item for each object, wrapped."""
    items = (f"- `{name}`: {_first_sentence(each)}" for name, each in objects.items())
    fit = {"subsequent_indent": "  ", "break_long_words": False, "break_on_hyphens": False}
    return "\n".join("\n".join(textwrap.wrap(item, WIDTH, **fit)) for item in items)


def _first_sentence(each: object) -> str:
    """That of a docstring, on one line."""
    text = (inspect.getdoc(each) or "").partition("\n\n")[0]
    return re.split(r"(?<=[.;])\s", " ".join(text.split()), maxsplit=1)[0].rstrip(";")
