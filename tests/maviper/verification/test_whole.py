"""Whole numbers from C to code and claims, beside the compiler and all numbers of two small types."""

import ctypes
import itertools
import json
import random
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

import maviper
from codegen import ir
from codegen.agreement import selfcheck
from codegen.agreement.compiled import ReplayedC, build, find_compiler
from codegen.errors import InputError, ProfileError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.scikit import from_sklearn
from codegen.policy_json import dumps
from codegen.profiles import loads
from codegen.targets import emit
from maviper.verification.ask import VerifyOptions, questions
from verify.checker.decisions import check_certificate
from verify.result import Verdict
from verify.verdicts import decisions

pytestmark = pytest.mark.compile
PUMP = """#include <stdint.h>
typedef struct { int16_t t; uint8_t mode; int32_t load; } in_t;
int pump(const in_t *in)
{
    if (in->mode == 3) return 1;
    if (in->t < 0 && in->load >= 100000) return 2;
    return in->load < -2147483647 ? 0 : in->t == 32767;
}
"""
FAN = "int fan(int16_t celsius, uint8_t mode) { return mode == 3 ? 2 : celsius > 20 ? 1 : celsius * 3 < -100; }"
ENDS = {"int8_t": (-128, 127), "uint8_t": (0, 255)}
OPERATORS = ("<", "<=", ">", ">=", "==", "!=")


def imported(source, numbers=None):
    return profile_of(from_c(source.encode(), "act.c"), Names(), numbers)


def test_a_source_of_whole_numbers_keeps_its_type_and_compiles_without_floats():
    profile = imported(FAN)
    (policy,) = profile.agents
    assert (policy.whole, policy.numbers, policy.grown) == ("int16", "float32", None)
    assert [(each.low, each.high) for each in policy.features] == [(-32768, 32767), (0, 255)]
    assert sorted({*policy.tree.threshold.tolist()}) == [-34, 0, 2, 3, 20]
    text = dumps(profile)
    assert '"numbers": "int16"' in text and dumps(loads(text, "p.json")) == text
    header = emit(profile, ["c"])["imported.h"]
    assert "const int16_t *x" in header and "<= 20)" in header
    code = header[header.index("#include") :]
    assert not any(word in code for word in ("float", "double", "0x"))
    between = np.array([[20.5, 0], [20, 2.5], [-34.5, 1e9], [-1e9, 3]])  # as a world shows them
    with ReplayedC.of(profile) as compiled:
        assert (compiled.act("fan", between) == ir.act(policy, between)).all()
    assert imported(FAN, "float32").agents[0].whole == ""
    with pytest.raises(ProfileError, match="is no int16"):
        loads(text.replace('"threshold": 20,', '"threshold": 20.5,'), "p.json")


def test_all_targets_agree_at_the_ends_of_types():
    profile = imported(PUMP)
    assert profile.agents[0].whole == "int32"
    with build(profile, ("c", "python", "json"), style="walk") as walking, build(profile) as nested:
        assert "(-2147483647 - 1)" in nested.text("h")
        for made in (walking, nested):
            report = selfcheck.check(made, random=20).ensure()
            assert {"c structure", "c", "c columns", "python", "json reader"} <= {
                each.target for each in report.agreements
            }


def test_a_header_of_whole_numbers_comes_back():
    from codegen.importers.c.header import from_header

    profile = imported(FAN)
    back = profile_of(from_header(emit(profile, ["c"])["imported.h"].encode(), "fan.h"), Names())
    assert back.agents[0].whole == "int16"
    assert (back.agents[0].tree.threshold == profile.agents[0].tree.threshold).all()


def test_a_tree_of_floats_is_told_that_it_observes_whole_numbers(tmp_path):
    rng = np.random.default_rng(5)
    x = np.column_stack([rng.uniform(-200, 200, 400), rng.uniform(-3, 3, 400)])
    fitted = DecisionTreeClassifier(max_depth=7, random_state=0).fit(x, (x.sum(axis=1) // 40) % 3)
    rows = np.array([*itertools.product(range(-128, 128), range(-128, 128))])
    profile = from_sklearn(fitted, numbers="int8")
    (policy,) = profile.agents
    assert policy.whole == "int8" and len(policy.tree.feature) < len(from_sklearn(fitted).agents[0].tree.feature)
    with ReplayedC.of(profile) as compiled:
        assert (compiled.act("agent_0", rows) == fitted.predict(rows)).all()
    for source in (
        "int f(float t) { return t > 3.5f; }",
        "int f(unsigned char t, int u) { return t > 3 || u < -70000; }",
    ):
        assert imported(source, "int8").agents[0].whole == "int8"
    (tmp_path / "f.py").write_text("def f(x):\n    return 'up' if x[0] > 0.5 else 'down' if x[1] < -2.25 else 'stay'\n")
    (policy,) = maviper.from_file(tmp_path / "f.py", numbers="uint8").agents
    assert (policy.whole, policy.tree.threshold.max(), len(policy.tree.feature)) == ("uint8", 0, 3)
    with pytest.raises(InputError, match="memory goes from 0 to 200, which int8 has not"):
        imported("int f(short t) { static int n; if (t > 3 && n < 200) n++; return n > 100; }", "int8")


def drawn_tree(rng, kinds, depth):
    if not depth:
        return f"return {rng.randrange(3)};"
    name = rng.choice("ab")
    low, high = ENDS[kinds[name]]
    at = rng.choice([low - 1, low, low + 1, high - 1, high, high + 1, *(rng.randint(low, high) for _ in range(6))])
    tested = (name, at), (f"{name} * 3", 3 * at + rng.randint(-1, 1)), (f"{name} / 4", at // 4), (f"-{name}", -at)
    left, right = rng.choice(tested)
    parts = [drawn_tree(rng, kinds, depth - 1) for _ in range(2)]
    return f"if ({left} {rng.choice(OPERATORS)} {right}) {{ {parts[0]} }} else {{ {parts[1]} }}"


def drawn_condition(rng, kinds, sums, scale):
    name = rng.choice("ab")
    low, high = ENDS[kinds[name]]
    at = rng.choice([low, high, low - 0.5, high + 0.5, rng.randint(low, high) + rng.choice([0, 0, 0.25, -0.0001])])
    if sums and rng.random() < 0.3:
        return f"a {rng.choice('+-')} b {rng.choice(OPERATORS)} {rng.randint(-90, 90) + rng.choice([0, 0.5])}"
    factor, offset = scale if name == "a" else (1, 0)
    return f"{name} {rng.choice(OPERATORS)} {(at - offset) / factor}"


def answers_of(source, kinds, folder):
    """All observations, [65536, 2], and what the compiled program does."""
    (folder / "act.c").write_text(
        f"{source}\nvoid all(const short *x, int *y)\n"
        f"{{ for (long i = 0; i < 65536; i++) y[i] = act(({kinds['a']})x[2 * i], ({kinds['b']})x[2 * i + 1]); }}"
    )
    subprocess.run([*find_compiler(), "-O1", "-shared", "-fPIC", "act.c", "-o", "act.so"], cwd=folder, check=True)
    ends = [range(low, high + 1) for low, high in (ENDS[kinds[name]] for name in "ab")]
    rows, told = np.array([*itertools.product(*ends)], np.int16), np.zeros(65536, np.int32)
    ctypes.CDLL(str(folder / "act.so")).all(*(ctypes.c_void_p(each.ctypes.data) for each in (rows, told)))
    return rows, told


@pytest.mark.parametrize("seed", [3, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(20, 26))])
def test_claims_are_decided_as_by_trying_all_observations(seed, tmp_path):
    rng = random.Random(seed)
    kinds = {name: rng.choice([*ENDS]) for name in "ab"}
    source = f"#include <stdint.h>\nint act({kinds['a']} a, {kinds['b']} b) {{ {drawn_tree(rng, kinds, 4)} }}"
    profile = imported(source)
    (policy,), (rows, told) = profile.agents, answers_of(source, kinds, tmp_path)
    assert (policy.act(rows) == told).all()
    with ReplayedC.of(profile) as compiled:
        assert (compiled.act("act", rows) == ir.act(policy, rows)).all()
    for sums, scale in ((False, (1, 0)), (False, (16.0, 800.0)), (False, (0.5, -7.0)), (True, (16.0, 800.0))):
        columns = {"a": (rows[:, 0] - scale[1]) / scale[0], "b": rows[:, 1].astype(float)}
        features = (replace(policy.features[0], scale=scale), policy.features[1])
        profile = replace(profile, agents=(replace(policy, features=features),))
        parts, joined = [drawn_condition(rng, kinds, sums, scale) for _ in range(2)], rng.choice(["and", "or"])
        place, sign = rng.randrange(len(policy.actions)), rng.choice(["==", "!="])
        action = policy.actions[place]
        (tmp_path / "c.toml").write_text(
            f"[[claim]]\nformula = '({f' {joined} '.join(parts)}) implies acts(act) {sign} {action.name}'\n"
        )
        said = [eval(part, {}, columns) for part in parts]
        held = said[0] & said[1] if joined == "and" else said[0] | said[1]
        keeps = (told == action.known_as(place)) == (sign == "==")
        right = Verdict.VACUOUS if not held.any() else Verdict.PROVED if keeps[held].all() else Verdict.VIOLATED
        (asked,) = questions(profile, "p.json", VerifyOptions(file=tmp_path / "c.toml"))
        result = decisions.verify(asked.question, {})
        assert result.verdict == right or (sums and result.verdict == Verdict.UNKNOWN), (source, parts, joined)
        if result.verdict == Verdict.VIOLATED:
            at = result.evidence.counterexample.state.position
            assert all(float(value).is_integer() for value in at.values())
        if result.verdict == Verdict.PROVED:
            assert check_certificate(result.evidence.certificate, profile)


def test_claims_that_know_no_whole_numbers_are_refused_by_name():
    for options in ({"claims": ("symmetric(agent=fan)",)}, {"names": ("alive_leaves",), "semantics": "real"}):
        with pytest.raises(InputError, match="does not take whole numbers yet"):
            questions(imported(FAN), "p.json", VerifyOptions(**options))


def test_regions_are_the_whole_numbers_in_them(tmp_path):
    (tmp_path / "c.toml").write_text(
        "[[claim]]\nformula = 'celsius <= 20'\nregion = { box = { celsius = [0.5, 20.9], mode = [-7, 300] } }\n"
        "[[claim]]\nformula = 'celsius <= 20'\nregion = { box = { celsius = [20.1, 20.9], mode = [0, 1] } }\n"
    )
    with pytest.raises(InputError, match="no whole number celsius"):
        questions(imported(FAN), "p.json", VerifyOptions(file=tmp_path / "c.toml"))
    (tmp_path / "c.toml").write_text((tmp_path / "c.toml").read_text().replace("20.1", "20.0"))
    first, _ = questions(imported(FAN), "p.json", VerifyOptions(file=tmp_path / "c.toml"))
    assert {name: [*map(int, ends)] for name, ends in first.region.box.items()} == {
        "celsius": [1, 20],
        "mode": [0, 255],
    }
    assert decisions.verify(first.question, {}).verdict == Verdict.PROVED


def test_a_scale_is_kept_and_said_and_asked_for_in_claims_alone(tmp_path):
    text = dumps(imported(FAN))
    document = json.loads(text)
    document["agents"][0]["features"][0] |= {"unit": "degC", "scale": [16, 800]}
    del document["content_hash"]
    profile = loads(json.dumps(document), "p.json")
    assert profile.agents[0].features[0].scale == (16.0, 800.0) and loads(dumps(profile), "p.json").agents[0].whole
    assert "16 * celsius + 800 */" in emit(profile, ["c"])["imported.h"]
    (tmp_path / "c.toml").write_text("[[claim]]\nformula = 'mode <= 3'\nregion = { box = { celsius = [0, 9] } }\n")
    with pytest.raises(InputError, match="bounds celsius, which has a scale"):
        questions(profile, "p.json", VerifyOptions(file=tmp_path / "c.toml"))
    document["agents"][0]["features"][0]["scale"] = [0, 800]
    with pytest.raises(ProfileError, match="a factor above 0"):
        loads(json.dumps(document), "p.json")
