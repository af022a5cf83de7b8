"""Names that are words of a language: agents, features and actions may have them, files may not."""

import ast
import keyword
import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from codegen.agreement import selfcheck
from codegen.errors import InputError
from codegen.profiles import ensure
from codegen.targets import TARGETS, emit

TEXTS = [target for target in TARGETS if not target.startswith("onnx")]
FEW = 1_000  # random observations; the boundary ones are what counts

WORDS = {
    *keyword.kwlist, "case", "auto", "double", "int", "register", "class", "template", "std", "nullptr", "var",
    "function", "new", "export", "arguments", "eval", "abstract", "box", "crate", "dyn", "fn", "gen", "impl", "let",
    "loop", "macro", "match", "mod", "move", "mut", "priv", "ref", "self", "str", "struct", "super", "trait", "type",
    "unsafe", "usize", "where", "virtual", "core", "main", "act", "finite", "rows", "batch", "sum", "bits", "errno",
}  # fmt: skip


def called(profile, name, place=1):
    """The profile with one of its agents, and one of its features and actions, called by another name."""
    agents, old = list(profile.agents), profile.agents[place].agent
    for number, policy in enumerate(agents):
        agents[number] = replace(policy, features=tuple(_about(name, old, feature) for feature in policy.features))
    first, *features = agents[place].features
    action, *actions = agents[place].actions
    own = {"features": (replace(first, name=name), *features), "actions": (replace(action, name=name), *actions)}
    agents[place] = replace(agents[place], agent=name, **own)
    entities = tuple(replace(each, name=name) if each.name == old else each for each in profile.world.agents)
    return ensure(replace(profile, world=replace(profile.world, agents=entities), agents=tuple(agents)))


def _about(name, old, feature):
    terms = tuple((weight, re.sub(rf"^{old}\.", f"{name}.", place)) for weight, place in feature.meaning.terms)
    return replace(feature, meaning=replace(feature.meaning, terms=terms))


@pytest.mark.compile
@pytest.mark.parametrize(
    "words",
    [("match", "self", "std"), ("type", "str", "Self"), ("int", "class", "None"), ("x", "np", "A" * 64)],
    ids=" ".join,
)
@pytest.mark.usefixtures("unoptimised", "few_completions")
def test_agents_may_be_called_like_words_of_a_language(profile, words):
    for place, name in enumerate(words):
        profile = called(profile, name, place)
    report = selfcheck.check_files(profile, emit(profile, TEXTS), random=FEW).ensure()
    for name in words:
        assert {item.target for item in report.agreements if item.agent == name} >= {"c", "python", "json"}


@pytest.mark.compile
def test_no_agent_of_a_word_of_a_language_stops_a_compiler(profile, tmp_path):
    """Headers and Rust modules, each of a profile with a word for every agent, read by the compilers that are there."""
    modules, words, together = [], sorted(WORDS), len(profile.agents)
    for place, first in enumerate(range(0, len(words), together)):
        renamed = profile
        for number, name in enumerate(words[first : first + together]):
            renamed = called(renamed, name, number)
        files = emit(renamed, ["c", "rust", "python"], prefix=f"p{place}")
        for file, text in files.items():
            (tmp_path / file).write_text(text)
        ast.parse(files[f"p{place}.py"])
        modules.append(f"pub mod p{place};\n")
    (tmp_path / "all.c").write_text("".join(f'#include "p{place}.h"\n' for place in range(len(modules))))
    (tmp_path / "all.rs").write_text("".join(modules))
    commands = ["gcc -std=c99 -Werror -fsyntax-only all.c", "g++ -x c++ -std=c++17 -Werror -fsyntax-only all.c"]
    for command in [*commands, "rustc --edition=2021 --crate-type=lib --emit=metadata all.rs"]:
        if shutil.which(command.split()[0]) is not None:
            done = subprocess.run(command.split(), cwd=tmp_path, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr[:2_000]


def test_words_that_no_file_can_be_called_are_refused_with_the_word(profile):
    for prefix in ("match", "self", "class", "float", "std", "numpy", "sys"):
        with pytest.raises(InputError, match=f"'{prefix}'"):
            emit(profile, ["c"], prefix=prefix)
