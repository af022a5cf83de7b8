"""Contracts proved by Frama-C: what is compiled is proved, and what is wrong in code or contract stays open."""

import re
import shutil
from dataclasses import replace

import pytest

import maviper
from codegen.agreement.compiled import Build
from codegen.equivalence.contracts import contracts_of
from codegen.errors import ExitCode, InputError, MissingToolError
from codegen.lowering.lower import lower
from codegen.policy_json import dumps
from codegen.targets import emit
from maviper.cli import main
from maviper.compilation import proofs
from maviper.compilation.compile import compile_and_prove
from tests.support.observations import blind
from tests.support.remembering import GIVING, HEATER, SOURCES, SUMMING, WHOLE, adding
from tests.support.teams import tree
from tests.support.tiers import sweep

installed = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in proofs.TOOLS), reason=f"no Frama-C here: {proofs.INSTALL}"
)


STEPS = 500_000  # of Z3, in which the code below is proved; where something is wrong, ten times as many do not do


def team():
    """Two agents, with thresholds of both signs, x < 0 and zero."""
    first = tree((0, -0.5, 1, 2), 0, (1, 1.5, 3, 6), (0, 0.25, 4, 5), 1, 2, 0)
    second = tree((2, -1e-45, 1, 2), 2, (1, 0.0, 3, 4), 0, 1)
    return blind({"a": first, "b": second})


def read(source, folder):
    """A controller in C, as it comes in."""
    (folder / "act.c").write_text(source)
    return maviper.from_file(folder / "act.c")


def proven(style, change=lambda code: code, promise=lambda text: text, steps=STEPS, profile=None):
    """What the tools say of the code of `team`, after a change of the header, and one of the contracts and axioms."""
    profile = profile or team()
    model = lower(profile, style=style)
    files = {name: change(text) for name, text in emit(profile, ["c"], style=style).items()}
    contracts = contracts_of(profile, model)
    contracts = replace(contracts, files={name: promise(text) for name, text in contracts.files.items()})
    return proofs.prove_contracts(Build(profile, model, files), contracts, steps)


@installed
@pytest.mark.parametrize("style", ["nested", pytest.param("ordered", marks=pytest.mark.slow)])
def test_what_is_compiled_is_proved(style):
    found = proven(style)
    assert found.complete and found.open_goals == () and found.goals == {"nested": 16, "ordered": 28}[style]
    assert found.axioms == (5 if style == "ordered" else 1)
    assert f"{found.goals} of {found.goals} goals" in str(found)


@installed
@pytest.mark.parametrize(
    ("source", "style", "goals", "axioms"),
    [(HEATER, "nested", 77, 1), (HEATER, "ordered", 86, 5), (WHOLE, "nested", 9, 0), (GIVING, "nested", 32, 0)],
    ids=["memory", "memory by its bits", "whole", "sums"],
)
def test_memory_whole_numbers_and_sums_are_proved(source, style, goals, axioms, tmp_path):
    found = proven(style, profile=read(source, tmp_path), steps=4 * STEPS)
    assert found.complete and found.goals == goals and found.axioms == axioms


@installed
@pytest.mark.parametrize(
    ("source", "style", "goals", "axioms"),
    [
        ("heater", "nested", 69, 1),
        pytest.param("heater", "ordered", 69, 1, marks=pytest.mark.slow),
        ("pump", "nested", 120, 2),
        pytest.param("timer", "ordered", 242, 6, marks=pytest.mark.slow),
    ],
)
def test_what_is_remembered_beside_sums_is_proved(source, style, goals, axioms, tmp_path):
    """The contract says for each action what led to it, and its updates, those that count included."""
    profile = read((SOURCES | SUMMING)[source], tmp_path)
    profile = adding(profile) if source in SOURCES else profile
    found = proven(style, profile=profile, steps=4 * STEPS)
    assert found.complete and (found.goals, found.axioms) == (goals, axioms)


IN_SUMS = {
    "set": ("on = 1;", "on = 0;", "step_ensures_taken"),
    "counted": ("held += 1;", "held += 2;", "step_ensures_taken"),
    "counted too far": ("[IMPORTED_ACT_X_HELD] <= 0x1p+2", "[IMPORTED_ACT_X_HELD] <= 0x1.4p+2", "act_ensures_only"),
    "another action": ("return IMPORTED_ACT_ACTION_1;", "return IMPORTED_ACT_ACTION_0;", "act_ensures_only"),
}


@installed
@pytest.mark.slow
@pytest.mark.parametrize("fault", sorted(IN_SUMS))
def test_what_is_wrong_of_memory_beside_sums_stays_open(fault, tmp_path):
    profile, (old, new, goal) = read(SUMMING["pump"], tmp_path), IN_SUMS[fault]
    assert any(old in text for text in emit(profile, ["c"]).values())
    wrong = proven("nested", change=lambda text: once(text, (old, new)), profile=profile, steps=4 * STEPS)
    assert any(goal in each for each in wrong.open_goals)


IN_MEMORY = {
    "set": ("state->heating = 1;", "state->heating = 2;"),
    "reset": ("state->heating = 0;\n}", "state->heating = 1;\n}"),
    "kept": ("default:\n", "default:\n        state->heating = 1;\n"),
    "seen": ("seen[i] = x[i];", "seen[i] = x[0] + 1.0f;"),
}


@installed
@pytest.mark.slow
@pytest.mark.parametrize("style", ["nested", "ordered"])
@pytest.mark.parametrize("fault", sorted(IN_MEMORY))
def test_what_is_wrong_of_memory_stays_open(fault, style, tmp_path):
    profile, change = read(HEATER, tmp_path), IN_MEMORY[fault]
    assert any(change[0] in text for text in emit(profile, ["c"], style=style).values())
    assert proven(style, change=lambda text: once(text, change), profile=profile, steps=4 * STEPS).open_goals


IN_C = {
    "threshold": ("<= 0x1.8p+0f", "<= 0x1.800002p+0f"),
    "threshold below": ("<= 0x1p-2f", "<= 0x1.fffffep-3f"),
    "strict": ("<= 0x1p-2f", "< 0x1p-2f"),
    "not strict": ("< 0x0p+0f", "<= 0x0p+0f"),
    "sign": ("<= -0x1p-1f", "<= 0x1p-1f"),
    "the other side": ("<= 0x1.8p+0f", "> 0x1.8p+0f"),
    "feature": ("x[IMPORTED_A_X_SPIN] <=", "x[IMPORTED_A_X_ANGLE] <="),
    "action": ("return IMPORTED_A_LEFT; /* leaf 1 */", "return IMPORTED_A_RIGHT;"),
    "no action": ("return IMPORTED_A_LEFT; /* leaf 1 */", "return 7;"),
    "beyond the end": ("x[IMPORTED_A_X_SPIN] <=", "x[IMPORTED_A_N_FEATURES] <="),
    "before the start": ("x[IMPORTED_A_X_ANGLE] <= -", "x[-1] <= -"),
    "written": ("return IMPORTED_A_LEFT; /* leaf 1 */", "*(float *)x = 0.0f; return IMPORTED_A_LEFT;"),
    "for ever": ("return IMPORTED_A_LEFT; /* leaf 1 */", "for (;;) { }"),
    "divided": ("return IMPORTED_A_LEFT; /* leaf 1 */", "return IMPORTED_A_LEFT / IMPORTED_A_LEFT;"),
    "overflow": ("return IMPORTED_A_LEFT; /* leaf 1 */", "return (2147483647 + 1) + (-2147483647 - 1);"),
    "NaN": ("if (x[IMPORTED_A_X_SPIN] <= 0x1.8p+0f)", "if (!(x[IMPORTED_A_X_SPIN] > 0x1.8p+0f))"),
}
IN_ORDERED = {
    "bits": ("INT32_C(0x3fc00000)", "INT32_C(0x3fc00001)"),
    "bits below": ("UINT32_C(0xbf000000)", "UINT32_C(0xbf000001)"),
    "no cast": ("(uint32_t)imported_bits(x[IMPORTED_A_X_ANGLE]) >= UINT32_C(0xbf000000)",
                "imported_bits(x[IMPORTED_A_X_ANGLE]) >= (int32_t)0xbf000000"),
    "order": (">= UINT32_C(0xbf000000)", "> UINT32_C(0xbf000000)"),
}  # fmt: skip
IN_CONTRACT = {
    "threshold": (r"(float)0x1.8p+0)", r"(float)0x1.800002p+0)"),
    "action": (r"\result == 2) && // leaf 5", r"\result == 1) && // leaf 5"),
    "sides": (r"!\le_float(x[1], (float)0x1.8p+0)", r"\le_float(x[1], (float)0x1.8p+0)"),
    "bounds": (r"\valid_read(x + (0 .. 1))", r"\valid_read(x + (0 .. 0))"),
}
IN_AXIOMS = {"bits": ("#x3fc00000)", "#x3fc00001)"), "order": ("bvuge b #xbf000000", "bvule b #xbf000000")}


def once(text, change):
    old, new = change
    return text.replace(old, new, 1) if old in text else text


def cases():
    yield from (pytest.param("nested", "code", change, id=f"nested {name}") for name, change in IN_C.items())
    yield from (pytest.param("ordered", "code", change, id=f"ordered {name}") for name, change in IN_ORDERED.items())
    yield from (pytest.param("nested", "promise", each, id=f"contract {name}") for name, each in IN_CONTRACT.items())
    yield from (pytest.param("ordered", "axioms", change, id=f"axiom {name}") for name, change in IN_AXIOMS.items())


@installed
@pytest.mark.parametrize(("style", "where", "change"), sweep(cases()))
def test_what_is_wrong_stays_open(style, where, change):
    """The faultless code is proved in `STEPS` steps (above); ten times as many prove nothing that is wrong."""
    texts = emit(team(), ["c"], style=style)
    made = contracts_of(team(), lower(team(), style=style)).files
    touched = texts.values() if where == "code" else made.values()
    assert any(once(text, change) != text for text in touched), "the fault is not in the text"
    found = proven(
        style,
        change=lambda text: once(text, change) if where == "code" else text,
        promise=lambda text: text if where == "code" else once(text, change),
        steps=10 * STEPS,
    )
    assert not found.complete
    assert found.open_axioms if where == "axioms" else found.open_goals


def test_what_is_missing_is_named(tmp_path, monkeypatch, capsys):
    (tmp_path / "team.json").write_text(dumps(team()))
    monkeypatch.setattr(shutil, "which", lambda tool, **_: None)
    command = ["compile", str(tmp_path / "team.json"), "--frama-c", "-o", str(tmp_path / "code")]
    assert main.run(command) == ExitCode.MISSING
    said = capsys.readouterr().err
    assert "frama-c, why3, z3" in said and "apt-get install frama-c-base why3 z3" in said
    assert not (tmp_path / "code").exists()


def test_contracts_are_written_beside_the_c(tmp_path):
    code = compile_and_prove(team(), ["c"], contracts=True)
    assert {"imported_contracts.c", "imported_axioms.smt2"} <= code.files.keys() and code.proven is None
    assert code.files["imported.h"] == emit(team(), ["c"])["imported.h"]  # the header stays as it is
    with pytest.raises(InputError, match="the target c is not asked for"):
        compile_and_prove(team(), ["python"], contracts=True)


def test_a_tool_that_gives_no_answer_is_no_proof(tmp_path, monkeypatch):
    for tool in proofs.TOOLS:
        (tmp_path / tool).write_text("#!/bin/sh\nexit 0\n")
        (tmp_path / tool).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(MissingToolError, match="gave no answer"):
        proven("nested")


def test_goals_are_read_from_what_wp_prints():
    said = """[wp] [CFG] Goal f_terminates : Valid (Trivial)
[wp] [Qed] Goal typed_f_assigns : Valid (2ms)
[wp] [Failed] Goal typed_f_ensures
  Z3 4.8.12: Failed Unknown error
[wp] [Z3 4.8.12] Goal typed_f_ensures_2 : Timeout (Qed:1ms) (5s)
[wp] Proved goals:    2 / 4
"""
    assert [goal["name"] for goal in proofs.GOAL.finditer(said)] == re.findall(r"Goal (\S+)", said)
    assert [goal["answer"] for goal in proofs.GOAL.finditer(said)] == ["Valid", "Valid", None, "Timeout"]
    total = proofs.TOTAL.search(said)
    assert (total["proved"], total["goals"]) == ("2", "4")
