"""Proofs for all observations: what is emitted is proved, what is wrong is shown, what is not understood is refused."""

import re

import numpy as np
import pytest
from hypothesis import given, settings

from codegen import ir, policy_json
from codegen.agreement import readback, selfcheck
from codegen.agreement.compiled import Build, CompiledC, find_compiler
from codegen.equivalence import obligations, symbolic
from codegen.equivalence.symbolic import Definitions, Header, Unreadable
from codegen.errors import DisagreementError, ExitCode, InputError
from codegen.lowering.lower import lower
from codegen.targets import emit
from maviper.cli import main
from maviper.compilation import proofs
from tests.support.chains import chain
from tests.support.games import NAMES, random_profile
from tests.support.strategies import profiles, with_trees
from tests.support.teams import tree
from tests.support.tiers import first_of

pytestmark = pytest.mark.solver
STYLES = ["nested", "ordered", "freestanding", "walk"]


def prove(profile, style="auto", targets=("c", "python"), change=lambda text: text):
    files = {name: change(text) for name, text in emit(profile, targets, style=style).items()}
    return proofs.prove(Build(profile, lower(profile, style=style), files))


@pytest.mark.parametrize("style", STYLES)
@settings(max_examples=3)
@given(profile=profiles())
def test_random_profiles_are_proved(style, profile):
    found = prove(profile, style)
    assert found.complete and len(found.proofs) == 2 * len(profile.agents)


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", first_of(1, NAMES[::2]))
def test_every_game_is_proved(name, style):
    profile = random_profile(name)
    found = prove(profile, style, ["c"])
    assert found.complete
    for proof, policy in zip(found.proofs, profile.agents, strict=True):
        assert f"2^{32 * len(policy.features)} " in str(proof) and ("NaN" in str(proof)) is (
            style in ("ordered", "freestanding")
        )


@pytest.mark.parametrize("style", STYLES)
def test_single_leaves_and_the_deepest_trees_are_proved(style, profile):
    trees = {"agent_0": tree(3), "agent_1": chain(ir.MAX_DEPTH)}
    assert prove(with_trees(trees, profile), style, ["c"]).complete


@pytest.mark.compile
@pytest.mark.parametrize("style", STYLES)
def test_an_answer_is_an_observation_that_shows_the_fault(style, profile):
    """One bit more in one threshold: the only observations that tell have that very number."""
    profile = with_trees({"agent_0": tree((0, 0.5, 1, 4), (1, -0.25, 2, 3), 1, 2, 3)}, profile)
    model = lower(profile, style=style)
    (header,) = emit(profile, ["c"], style=style).values()
    changed = re.sub("0x1p-1f|3f000000", lambda m: {"0x1p-1f": "0x1.000002p-1f"}.get(m[0], "3f000001"), header)
    assert changed != header
    asked = {question.agent: question for question in obligations.about_c(changed, profile, model)}["agent_0"]
    from verify.solver.solve import ask_bits

    answer = ask_bits(asked.text, asked.names)
    x = np.array([asked.observation(answer.model)], dtype=np.float32)
    assert answer.holds and x[0, 0] == np.nextafter(np.float32(0.5), np.float32(1))
    with CompiledC(changed, model, find_compiler()) as compiled:
        assert compiled.act("agent_0", x)[0] != ir.act(profile.policy("agent_0"), x)[0]


@pytest.mark.parametrize(("read", "form"), [(r"\)\)", tuple), (r"\]", np.array)], ids=["list", "array"])
def test_an_answer_about_doubles_shows_the_fault(read, form, profile):
    """In the function that decides for lists, or in the one that does for arrays."""
    profile = with_trees({"agent_0": tree((0, 0.1, 1, 2), 1, 2)}, profile)
    (module,) = emit(profile, ["python"]).values()
    changed = re.sub(rf"({read} <= )0\.1000\d+(?=:)", rf"\g<1>{float(np.float32(0.1))!r}", module)
    asked = [each for each in obligations.about_python(changed, profile, lower(profile)) if each.agent == "agent_0"]
    from verify.solver.solve import ask_bits

    (x,) = (each.observation(found.model) for each in asked if (found := ask_bits(each.text, each.names)).holds)
    assert readback.load_python(changed)["act_agent_0"](form(x)) != ir.act(profile.policy("agent_0"), [x])[0]
    with pytest.raises(DisagreementError, match="python double proof") as caught:
        prove(profile, targets=["python"], change=lambda text: changed)
    assert repr(x[0]) in caught.value.where


ONE = "static inline int decide(const float *x)\n{\n    BODY\n}\n"


@pytest.mark.parametrize(
    ("body", "action"),
    [
        ("if (x[0] < 1.5f && !(x[1] >= -0.5f)) { return 1; } return 2;", 1),
        ("if (x[0] > 1.5f || x[1] == -1.0f) return 1; else return 2;", 1),
        ("return x[0] <= 0x1p-1f ? 3 : x[1] <= 0.0f ? 4 : 5;", 4),
        ("int i; for (i = 0; i < 3; i++) { if (x[i] <= 0.0f) { return i; } } return 7;", 1),
        ("const float t = x[1]; int n = 2 * (t <= 0.0f) - 3; return n + 4;", 3),
    ],
)
def test_c_is_read_as_it_is_written(body, action):
    """Asked about x = (1, -1, 0), whose decision is known."""
    from verify.solver.solve import ask_bits

    into = Definitions("c")
    answer = Header(ONE.replace("BODY", body)).decide("decide", ["f0", "f1", "f2"], {}, into)
    values = ["(fp #b0 #x7f #b00000000000000000000000)", "(fp #b1 #x7f #b00000000000000000000000)", "(_ +zero 8 24)"]
    lines = [f"(define-fun f{place} () (_ FloatingPoint 8 24) {value})" for place, value in enumerate(values)]
    text = "\n".join([*lines, *into.lines, f"(assert (= {answer} {into.action(action)}))"])
    assert ask_bits(text, ()).holds


@pytest.mark.parametrize(
    ("constant", "bits"),
    [
        ("0.1f", 0x3DCCCCCD),
        ("0x1.99999ap-4f", 0x3DCCCCCD),
        ("1.00000005960464477540f", 0x3F800001),  # above a tie by less than a double tells
        ("1.000000059604644775390625f", 0x3F800000),  # the tie, to even
        ("1.00000005960464477538f", 0x3F800000),
        ("1.00000017881393432617f", 0x3F800001),  # below the next tie, which a double takes for it
        ("1.000000178813934326171875f", 0x3F800002),
        ("1e-45f", 1),
        ("0.0f", 0),
        ("3.4028235e38f", 0x7F7FFFFF),
    ],
)
def test_constants_are_rounded_once_as_compilers_do(constant, bits):
    into = Definitions("c")
    body = f"if (x[0] <= {constant}) {{ return 1; }} return 2;"
    Header(ONE.replace("BODY", body)).decide("decide", ["f0"], {}, into)
    assert f"#x{bits:08x}" in into.lines[0]


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return x[0] <= 3.4028236e38f;", "beyond the floats"),
        ("return x[3];", "entry 3 of 3"),
        ("if (x[0] <= 0.5) { return 1; } return 2;", "no float"),
        ("if (x[0] <= 1) { return 1; } return 2;", "compared with an integer"),
        ("if (x[0]) { return 1; } return 2;", "no comparison"),
        ("if (x[0] <= 1.0f) { return 1; }", "ends without"),
        ("while (x[0] <= 1.0f) { } return 1;", "end depends"),
        ("for (;;) { } return 1;", "decide"),
        ("int i = 0; while (i < 1) { } return 1;", "too many steps"),
        ("return sinf(x[0]) <= 1.0f;", "a call of sinf"),
        ("return 2147483647 + 1;", "overflows"),
        ("return (char)1;", "a cast to char"),
        ("goto end; end: return 1;", "a statement"),
    ],
)
def test_other_c_is_refused(body, said, monkeypatch):
    monkeypatch.setattr(symbolic, "MAX_STEPS", 20_000)
    with pytest.raises(Unreadable, match=said):
        Header(ONE.replace("BODY", body)).decide("decide", ["f0", "f1", "f2"], {}, Definitions("c"))


def test_what_cannot_be_read_is_skipped_and_said(profile):
    found = prove(profile, targets=["c"], change=lambda text: text.replace("agent_1_act(const float", "gone(float", 1))
    assert not found.complete and found.skipped == (
        "c float proof: there is no function physical_deception_agent_1_act",
    )
    assert "not C" in prove(profile, targets=["c"], change=lambda text: "int x = ;").skipped[0]
    found = prove(
        profile, targets=["python"], change=lambda text: text.replace("    if (v if", "    if 1.0 + (v if", 1)
    )
    assert "a test of Python" in found.skipped[0]
    with pytest.raises(InputError, match="nothing to prove"):
        proofs.ensure_askable(["json", "smt"], None)


@pytest.mark.slow
@pytest.mark.compile
def test_the_command_says_and_writes_what_was_proved(profile, tmp_path, capsys):
    (tmp_path / "profile.json").write_text(policy_json.dumps(profile))
    command = ["compile", str(tmp_path / "profile.json"), "-o", str(tmp_path / "out"), "--prove"]
    assert main.run(command) == ExitCode.DONE
    said = capsys.readouterr().err
    assert said.count("c float proof: ") == said.count("python double proof: ") == 3 and "2^320 observations, " in said
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"physical_deception.proofs.json", "physical_deception_agent_0.c.smt2"} <= written


def test_a_fault_that_the_replay_let_through_ends_in_exit_4(profile, tmp_path, capsys, monkeypatch):
    """The solver alone, the replay being switched off."""
    from maviper.compilation import compile

    def replaced(loaded, targets, prefix, style):
        files = emit(loaded, targets, prefix, style)
        files["physical_deception.h"] = files["physical_deception.h"].replace("] <= ", "] < ")
        made = Build(loaded, lower(loaded, prefix, style), files)
        return compile.Compiled(made, selfcheck.Report((), (), ""))

    monkeypatch.setattr(compile, "compile_profile", replaced)
    (tmp_path / "profile.json").write_text(policy_json.dumps(profile))
    command = ["compile", str(tmp_path / "profile.json"), "--prove", "-o", str(tmp_path / "out")]
    assert main.run(command) == ExitCode.DISAGREES
    said = capsys.readouterr().err
    assert "c float proof: code and profile differ" in said and "for x = (" in said and not (tmp_path / "out").exists()


REBOUND = "\n\nact_agent_0 = lambda x: 3\n"


@pytest.mark.parametrize(
    ("style", "change"),
    [
        ("walk", lambda text: text.replace("TABLE float ", "TABLE int ").replace("const float phys", "const int phys")),
        ("nested", lambda text: re.sub(r"inline int (\w+_act\()", r"inline _Bool \1", text, count=1)),
        ("nested", lambda text: re.sub(r"\n(static inline int \w+_act\()", r"\n#define NO 1\n\1", text, count=1)),
        ("nested", lambda text: re.sub(r"(inline int \w+_act\()const float", r"\1float", text, count=1)),
        (
            "walk",
            lambda text: text.replace(
                "    int i = 0;", "    int i = 0;\n    physical_deception_adversary_0_action[0] = 4;", 1
            ),
        ),
        ("walk", lambda text: text.replace("    int i = 0;", "    static int i = 0;", 1)),
        ("walk", lambda text: re.sub(r"(_action\[\d+\] = \{)\d+", r"\g<1>256", text)),
        ("walk", lambda text: text.replace("extern const float", "extern const double", 1)),
        ("walk", lambda text: text.replace("_TABLE static const", "_TABLE static const volatile", 1)),
        ("walk", lambda text: re.sub(r"(#if !defined.*\n)", r"\1int x;\n", text, count=1)),
        ("walk", lambda text: re.sub(r"(_TABLE float .*)(\n)", r"\1 int x;\2", text, count=1)),
        ("nested", lambda text: re.sub(r"<= -?0x[\w.]+p", "<= 0x1.000001000000001p", text, count=1)),
    ],
)
def test_c_whose_types_or_lines_could_change_it_is_refused(profile, style, change):
    text = emit(profile, ["c"], style=style)["physical_deception.h"]
    assert change(text) != text
    with pytest.raises(Unreadable):
        obligations.about_c(change(text), profile, lower(profile, style=style))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text + REBOUND,
        lambda text: text.replace("def act_agent_0(x: Numbers)", "@staticmethod\ndef act_agent_0(x: Numbers)"),
        lambda text: re.sub(r"(\)\) <= )(-?[\d.e-]+)", r"\1'\2'", text, count=1),
        lambda text: re.sub(r"(\)\) <= )(-?[\d.e-]+)", r"\1PROFILE", text, count=1),
        lambda text: text.replace("def act_agent_0(x: Numbers)", "def act_agent_0()"),
        lambda text: text.replace("def _act_agent_0(", "def _acts_agent_0("),
        lambda text: text.replace("def act_agent_0(x: Numbers)", "def act_agent_0(x, *len)"),
        lambda text: text + "\n\nfloat = int\n",
        lambda text: text + "\n\nfloat: Any = int\n",
        lambda text: text + "\n\nclass float(IntEnum):\n    A = 0\n",
        lambda text: text + "\n\nclass Late(IntEnum):\n    act_agent_0 = print()\n",
        lambda text: text.replace("from math import isfinite", "from math import isfinite as len"),
        lambda text: text.replace("from math import isfinite", "from math import *"),
        lambda text: text.replace("from math import isfinite", "from mine import isfinite"),
        lambda text: text.replace("    from numpy.typing import NDArray", "    from numpy.typing import act_agent_0"),
        lambda text: text + "\n\ndef type(x):\n    return list\n",
        lambda text: re.sub(r"(len\(x\) != )\d+", r"\g<1>3", text),
        lambda text: text.replace("(kind := type(x)) is not list and ", ""),
        lambda text: re.sub(r"\(v if (.* is) float else", r"(x if \1 float else", text, count=1),
        lambda text: re.sub(r"\(v if (.* is) float else", r"(v if \1 int else", text, count=1),
        lambda text: re.sub(r"v := x\[\d\]", "v := x[99]", text, count=1),
    ],
)
def test_python_that_could_mean_more_is_refused(profile, change):
    text = emit(profile, ["python"])["physical_deception.py"]
    assert change(text) != text
    with pytest.raises(Unreadable):
        obligations.about_python(change(text), profile, lower(profile))
