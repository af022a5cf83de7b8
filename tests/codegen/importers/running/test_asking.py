"""Python asked about a source: what is said of the answers, and of a source that nobody was asked about."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from codegen.errors import DisagreementError, InputError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from codegen.importers.running.child import only_compares
from codegen.importers.running.gate import gate_source
from maviper.cli import main


def imported(source, said):
    return profile_of(from_python(source.encode(), "policy.py", said), Names())


def facts_of(source, said=None):
    return imported(source, said or Said()).provenance.training


PLAIN = """
LIMIT = 0.2 * 3
def act(x):
    return "a" if x[0] > LIMIT else "b"
"""


def test_python_itself_is_named_with_the_count():
    facts = facts_of(PLAIN)
    assert facts["act replayed"] > 1_000 and re.fullmatch(r"Python 3\.\d+ itself", facts["act replayed by"])


@pytest.mark.parametrize("other", ["0", "-0.0", "N.UP", "x[0]"])
def test_python_tells_a_member_from_what_may_be_taken_for_it(other, monkeypatch):
    """Also where the reader does not: a wrong reader is planted."""
    monkeypatch.setattr("codegen.importers.python.source._Follower._ensure_alike", lambda *_: None)
    text = "from enum import Enum\nclass M(Enum):\n    GO = 0\nclass N(Enum):\n    UP = 0\n"
    with pytest.raises(DisagreementError, match="where its origin"):
        imported(f"{text}def act(x):\n    return M.GO if x[0] > 1 else {other}\n", Said())


def test_no_run_says_that_nothing_was_compared(monkeypatch):
    monkeypatch.setattr("codegen.importers.running.asking.programs.start", None)
    facts = facts_of(PLAIN, Said(run=False))
    assert facts["act replayed"] == 0 and facts["act replayed by"] == "nobody: the source was not compared"


def test_the_gate_is_asked_where_nothing_is_run():
    for run in (True, False):
        with pytest.raises(InputError, match="Python does not run it: the name hash is not defined") as caught:
            imported("def act(x):\n    return 1 if x[0] > 2 else 0\n    return hash(x)\n", Said(run=run))
        assert caught.value.where.endswith("line 3") and "importing.md" in caught.value.next_step


def test_every_word_about_a_profile_says_that_nothing_was_compared(tmp_path, capsys):
    file, made, page = (tmp_path / name for name in ("act.py", "act.json", "page.html"))
    file.write_text(PLAIN)
    claim = ["--observations", "--claim", "ignores(agent=act, feature=x0)", "--json"]
    for options, told in (([], False), (["--no-run"], True)):
        assert main.run(["import", str(file), "-o", str(made), *options]) == 0
        assert ("compared    none, nobody" in capsys.readouterr().err) == told
        assert main.run(["show", str(made)]) == 0
        assert ("its source was not compared" in capsys.readouterr().out) == told
        assert main.run(["show", str(made), "--format", "html", "-o", str(page)]) == 0
        assert ("The source of act was not compared." in page.read_text()) == told
        main.run(["verify", str(made), *claim])
        assert ("act was read as its language means it" in "".join(capsys.readouterr())) == told


def test_a_difference_names_the_observation_and_both_answers():
    origin = from_python(PLAIN.encode(), "policy.py")["act"]
    shifted = replace(origin.grown, threshold=origin.grown.threshold * 2)
    with pytest.raises(DisagreementError, match="takes action 1 where its origin takes 'a'") as caught:
        profile_of({"act": replace(origin, grown=shifted)}, Names())
    assert "[" in caught.value.where


def test_what_the_source_takes_is_what_is_given():
    source = "import numpy as np\ndef act(x):\n    assert len(x) == 1\n    return 1 if np.asarray(x)[0] > 3 else 2\n"
    assert facts_of(source)["act given"] == "Python's floats, or float64 arrays"


def test_observations_that_an_assertion_leaves_out_are_not_counted():
    source = "def act(x):\n    assert x[0] < 3\n    return 1 if x[0] > 2 else 0\n"
    fewer, all_of = (facts_of(each)["act replayed"] for each in (source, source.replace("assert x[0] < 3", "pass")))
    assert 0 < fewer < all_of


def test_an_assertion_that_never_holds_is_refused():
    with pytest.raises(InputError, match="assertions of the source hold at none"):
        imported("def act(x):\n    assert x[0] > 3 and x[0] < 2\n    return 1 if x[0] > 2 else 0\n", Said())


def test_floats_alone_are_asked_where_no_arrays_are_given():
    source = "def act(x):\n    return 'both' if (x[0] > 0.5) + (x[1] > 0.5) == 2 else 'not'\n"
    assert facts_of(source, Said(arrays="floats"))["act given"] == "Python's floats"


COMPARED = "return 1 if x[0] > 2 else 0"
ARRAYS_TELL = (  # of which lists and arrays are, or may be, answered differently
    "if x: return 1", "y = x\n    return y == 1", "a, b = y = x\n    return y", "return x[True]", "return x[not 0]",
    "return (x[0] > 1) + (x[1] > 1)", "return -(x[0] > 1)", "return x[0] == 9007199254740993", "return x[0] is x[0]",
    "return x[0] in (1, 2)", "return x[0] + x[1]", "return [x[0]] == [x[0]]", "return (x[0], 1) == (x[0], 1)",
    "return x[0:1]", "return f(x)", "return x.size", "return x", "return x == 1", "return x[0] // 2 == 1",
    "x[0] = 1\n    return 1", "return x[y[0]]", "return round(x[0]) == 1", "return str(x[0])",
)  # fmt: skip
ALIKE = (
    COMPARED, "a, b = x\n    return 'up' if 0 < a < b and not b >= 2 else 'down'", "return LIMIT < x[1] or x[0] == -1",
    "hot = x[0] > 1\n    if hot and x['y'] != 2:\n        return None\n    return hot", "return x[0]",
)  # fmt: skip


@pytest.mark.parametrize("body", [*ARRAYS_TELL, *ALIKE])
def test_arrays_are_asked_unless_a_source_only_compares(body):
    _, _, nodes = gate_source(f"LIMIT = 3\ny = 1\ndef f(x):\n    return 1\ndef act(x):\n    {body}\n", "act")
    assert only_compares(nodes, ["row"]) == (body in ALIKE)


def test_numbers_that_are_given_one_by_one_may_be_compared_by_name():
    _, _, nodes = gate_source("def act(a, b):\n    return 1 if a < b else 0\n", "act")
    assert only_compares(nodes, [0, 1]) and not only_compares(nodes, ["row", 1])


def test_the_gate_is_short():
    gate = Path(__file__).parents[4] / "codegen/importers/running/gate.py"
    assert len(gate.read_text().splitlines()) <= 200
