"""What generated functions are given: another length, or what is no number, is an error in every one of them."""

import array
import json
import re
import shutil
import subprocess
from collections import deque
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import readback
from codegen.agreement.compiled import CompiledC, find_compiler
from codegen.errors import InputError
from codegen.floats import deciding_double
from codegen.lowering.lower import lower
from codegen.numbers import neighbour
from codegen.targets import emit
from tests.support.strategies import with_trees
from tests.support.teams import towards, tree


@pytest.fixture(scope="module")
def team(profile):
    """A tree whose first two tests are of early features, one that tests the last feature, and a single leaf."""
    return with_trees(
        {"adversary_0": tree(3), "agent_0": towards(0, 0), "agent_1": tree((9, 0.1, 1, 2), 1, 2)}, profile
    )


@pytest.fixture(scope="module")
def module(team):
    return readback.load_python(emit(team, ["python"])["physical_deception.py"])


def lengths(policy):
    n = len(policy.features)
    return [0, 1, n - 2, n - 1, n + 1, 2 * n, 100]


FORMS = {
    "list": list,
    "tuple": tuple,
    "float32": lambda x: np.array(x, dtype=np.float32),
    "float64": np.array,
    "array": lambda x: array.array("d", x),
    "memoryview": lambda x: memoryview(array.array("d", x)),
    "deque": deque,
    "range": lambda x: range(len(x)),
    "dictionary": lambda x: dict(enumerate(x)),
    "read-only view": lambda x: np.broadcast_to(np.array(x), (1, len(x)))[0],
}


@pytest.mark.parametrize("form", FORMS)
def test_another_length_is_an_error(form, team, module):
    for policy in team.agents:
        act, n = module[f"act_{policy.agent}"], len(policy.features)
        for given in lengths(policy):
            with pytest.raises(ValueError, match=f"^{policy.agent} observes {n} numbers, given {given}$"):
                act(FORMS[form]([0.0] * given))
        row = [0.25 * (place - 4) for place in range(n)]
        wanted = ir.act(policy, [list(range(n)) if form == "range" else row])[0]
        assert act(FORMS[form](row)) == wanted and module["ACT"][policy.agent](FORMS[form](row)) == wanted


def test_an_array_of_another_shape_is_an_error(team, module):
    for policy in team.agents:
        n = len(policy.features)
        for shape in ((1, n), (n, 1), (n, n), (5, n), (0, n), (1, 1, n), ()):
            said = f"{policy.agent} observes {n} numbers, given an array of shape {re.escape(str(shape))}$"
            with pytest.raises(ValueError, match=said):
                module[f"act_{policy.agent}"](np.zeros(shape))


@pytest.mark.parametrize(
    "given",
    [None, 0.5, iter([0.0] * 10), "0123456789", b"0123456789", bytearray(10)],
    ids=lambda value: type(value).__name__,
)
def test_what_is_no_sequence_of_numbers_is_an_error(given, team, module):
    for policy in team.agents:
        with pytest.raises(TypeError, match=f"{policy.agent} observes .* numbers, given {type(given).__name__}$"):
            module[f"act_{policy.agent}"](given)


def test_a_batch_of_another_width_is_an_error(team, module):
    for policy in team.agents:
        batch, n = module[f"act_{policy.agent}_batch"], len(policy.features)
        for width in lengths(policy):
            said = (
                f"^{policy.agent} observes rows of {n} numbers, given an array of shape {re.escape(str((5, width)))}$"
            )
            for rows in (np.zeros((5, width), dtype=np.float32), np.zeros((5, width)), [[0.0] * width] * 5):
                with pytest.raises(ValueError, match=said):
                    batch(rows)
        for rows in (np.zeros(n), [0.0] * n, np.zeros((2, 3, n)), np.float32(1), np.zeros((0, n + 1))):
            with pytest.raises(ValueError, match=f"{policy.agent} observes rows of {n} numbers, given an array of"):
                batch(rows)
        with pytest.raises(ValueError, match=f"{policy.agent} observes rows of {n} numbers: .*inhomogeneous"):
            batch([[0.0] * n, [0.0] * (n - 1)])
        for rows in ([], np.zeros((0, n)), np.zeros((0, n), dtype=np.float32)):
            found = batch(rows)
            assert found.shape == (0,) and found.dtype == np.int64


# --- numbers of every type are doubles first

TINY = Fraction(1, 10**400)
TYPES = {
    "float16": np.float16,
    "float32": np.float32,
    "float64": np.float64,
    "longdouble": np.longdouble,
    "longdouble above": lambda x: np.nextafter(np.longdouble(x), np.longdouble(np.inf)),
    "fraction above": lambda x: Fraction(x) + TINY,
    "fraction below": lambda x: Fraction(x) - TINY,
    "decimal": Decimal,
    "decimal above": lambda x: Decimal(x).next_plus(),
    "int": int,
    "int above": lambda x: int(x) + 1,
    "int64": lambda x: np.int64(np.clip(x, -(2.0**62), 2.0**62)),
    "uint64": lambda x: np.uint64(np.clip(abs(x), 0, 2.0**63)),
    "int8": lambda x: np.int8(np.clip(x, -100, 100)),
    "bool": bool,
    "numpy bool": np.bool_,
    "array": np.array,
}
FINITE = {"int", "int above", "fraction above", "fraction below", "int64", "uint64", "int8"}
THRESHOLDS = [0.1, -0.3, 0.5, 1.0, 1e-45, 65504.0, 65520.0, 2.0**60, 2.0**60 + 2.0**37, -(2.0**61), 1e30, 3.4e38]


def deciders(profile, threshold):
    """The policy of a stump, and its module."""
    profile = with_trees({"agent_0": tree((0, threshold, 1, 2), 1, 2)}, profile)
    return profile.policy("agent_0"), readback.load_python(emit(profile, ["python"])["physical_deception.py"])


def around(threshold):
    at = np.float32(threshold)
    turning = deciding_double(at)
    near = [*(float(neighbour(at, side)) for side in (-np.inf, np.inf)), float(at), turning]
    near += [float(np.nextafter(turning, side)) for side in (-np.inf, np.inf)]
    return [*near, 0.0, -0.0, 1.0, -1.0, 1e300, -1e300, np.inf, -np.inf, np.nan]


@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_numbers_of_every_type_are_doubles_first(threshold, profile):
    policy, module = deciders(profile, threshold)
    act, batch, n = module["act_agent_0"], module["act_agent_0_batch"], len(policy.features)
    decided = set()
    for name, kind in TYPES.items():
        values = [kind(x) for x in around(threshold) if np.isfinite(x) or name not in FINITE]
        wanted = ir.act(policy, [[float(value)] * n for value in values]).tolist()
        decided |= {*wanted}
        rows = [[value] * n for value in values]
        assert [act(row) for row in rows] == wanted, name
        assert [act(tuple(row)) for row in rows] == wanted, name
        assert [act(np.array(row)) for row in rows] == wanted, name
        assert batch(rows).tolist() == wanted, name
        assert batch(np.array(rows)).tolist() == wanted, name
        assert batch(np.array(rows, dtype=object)).tolist() == wanted, name
        assert [act(np.array(row, dtype=object)) for row in rows] == wanted, name
        for beside in (0.5, 2, np.float32(0.5), np.float16(0.5), Fraction(1, 3)):
            mixed = [[value, *[beside] * (n - 1)] for value in values]
            assert [act(row) for row in mixed] == batch(mixed).tolist() == wanted, (name, beside)
    assert decided == {1, 2}


@pytest.mark.parametrize("threshold", [0.1, 1e30])
def test_arrays_of_every_type(threshold, profile):
    policy, module = deciders(profile, threshold)
    act, batch, n = module["act_agent_0"], module["act_agent_0_batch"], len(policy.features)
    kinds = [np.float16, np.float32, np.float64, np.longdouble, np.int8, np.uint8, np.int64, np.uint64, np.bool_]
    for dtype in [*kinds, ">f4", ">f8", ">i8", *bfloat16()]:
        column = np.array(around(threshold)[:10] if np.dtype(dtype).kind in "iub" else around(threshold))
        with np.errstate(all="ignore"):
            rows = np.repeat(
                (column.clip(0, 100) if np.dtype(dtype).kind in "iub" else column)[:, None], n, axis=1
            ).astype(dtype)
        before = rows.copy()
        wanted = ir.act(policy, [[float(value) for value in row] for row in rows]).tolist()
        assert batch(rows).tolist() == batch(np.asfortranarray(rows)).tolist() == wanted, dtype
        assert [act(row) for row in rows] == [act(list(row)) for row in rows] == wanted, dtype
        assert rows.tobytes() == before.tobytes()


def bfloat16():
    try:
        return [__import__("ml_dtypes").bfloat16]
    except ImportError:
        return []


NO_NUMBERS = [
    "0.05", b"0.05", bytearray(b"0.05"), np.str_("0.05"), np.bytes_(b"0.05"), memoryview(b"0.05"), None, 0.05 + 0j,
    np.complex64(0.05), [0.05], np.array([0.05]), np.timedelta64(1, "s"), np.timedelta64(1, "ns"), {}, object(),
]  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("wrong", NO_NUMBERS, ids=lambda value: type(value).__name__)
def test_what_is_no_number_is_an_error(wrong, profile):
    policy, module = deciders(profile, 0.1)
    act, batch, n = module["act_agent_0"], module["act_agent_0_batch"], len(policy.features)
    held = np.empty(n, dtype=object)
    held[:] = [wrong, *[0.0] * (n - 1)]
    for given in ([wrong] * n, (wrong,) * n, held.tolist(), held):
        with pytest.raises(TypeError, match="an observation is of numbers, not of "):
            act(given)
    with pytest.raises(TypeError, match="an observation is of numbers, not of "):
        batch(held[None])
    for rows in ([[wrong] * n], [held.tolist()]):
        with pytest.raises((TypeError, ValueError), match=r"observation is of numbers|observes rows of"):
            batch(rows)


@pytest.mark.parametrize("dtype", ["U4", "S4", "c8", "c16", "m8[s]", "m8[ns]", "M8[ns]", [("a", "f4")]], ids=str)
def test_arrays_of_what_is_no_number_are_an_error(dtype, profile):
    policy, module = deciders(profile, 0.1)
    rows = np.zeros((2, len(policy.features)), dtype=dtype)
    with pytest.raises(TypeError, match=r"agent_0 observes rows of 10 numbers, given|of numbers, not of"):
        module["act_agent_0_batch"](rows)
    with pytest.raises(TypeError, match=r"agent_0 observes 10 numbers, given an array|of numbers, not of"):
        module["act_agent_0"](rows[0])


def test_masked_numbers_are_an_error(profile):
    policy, module = deciders(profile, 0.1)
    n = len(policy.features)
    whole = np.ma.masked_array(np.full((2, n), 0.3), mask=np.zeros((2, n), bool))
    wanted = ir.act(policy, np.full((2, n), 0.3)).tolist()
    assert module["act_agent_0_batch"](whole).tolist() == [module["act_agent_0"](row) for row in whole] == wanted
    whole.mask[1, 0] = True
    with pytest.raises(TypeError, match="masked"):
        module["act_agent_0_batch"](whole)
    with pytest.raises(TypeError, match="an observation is of numbers"):
        module["act_agent_0"](whole[1])


def test_a_number_beyond_the_doubles_is_an_error(profile):
    policy, module = deciders(profile, 0.1)
    for value in (10**400, Fraction(10**400)):
        row = [value] * len(policy.features)
        for function, given in ((module["act_agent_0"], row), (module["act_agent_0_batch"], [row])):
            with pytest.raises(OverflowError):
                function(given)


# --- JavaScript

SCRIPT = """
import * as policy from "./physical_deception.mjs";
const name = (error) => `${error.constructor.name}: ${error.message}`;
const said = (call) => { try { return call(); } catch (error) { return name(error); } };
const cases = CASES;
console.log(JSON.stringify(cases.map(said)));
"""


def javascript(team, calls, tmp_path):
    """What each call answers, or its error."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    (tmp_path / "physical_deception.mjs").write_text(emit(team, ["javascript"])["physical_deception.mjs"])
    (tmp_path / "script.mjs").write_text(SCRIPT.replace("CASES", f"[{', '.join(f'() => {call}' for call in calls)}]"))
    command = ["node", "script.mjs"]
    return json.loads(subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout)


def test_javascript_refuses_another_length(team, tmp_path):
    calls, wanted = [], []
    for policy in team.agents:
        n = len(policy.features)
        for given in lengths(policy):
            for form in (f"Array({given}).fill(0)", f"new Float32Array({given})", f"new Float64Array({given})"):
                for act in (f"policy.act_{policy.agent}", f"policy.ACT.{policy.agent}"):
                    calls.append(f"{act}({form})")
                    wanted.append(f"RangeError: {policy.agent} observes {n} numbers, given {given}")
        for count in ("undefined", "1.5", "null", "'1'", "NaN"):
            calls.append(f"policy.act_{policy.agent}_rows(new Float32Array({n}), {count})")
            shown = count.strip("'")
            said = f"act_rows(x, n) of {policy.agent}: n is the number of observations in x, given {shown}"
            wanted.append(f"RangeError: {said}")
        for rows, count in ((2 * n + 1, 2), (2 * n, 1), (n, 2), (0, -1)):
            calls.append(f"policy.act_{policy.agent}_rows(new Float32Array({rows}), {count})")
            said = f"{policy.agent} observes {n} numbers: {count} times {n} in a typed array, given {rows}"
            wanted.append(f"RangeError: {said}")
        for good in (f"Array({n}).fill(0)", f"new Float32Array({n})", f"new Int8Array({n})"):
            calls.append(f"policy.act_{policy.agent}({good})")
            wanted.append(int(ir.act(policy, np.zeros((1, n)))[0]))
        calls += [
            f"policy.act_{policy.agent}_rows(new Float32Array({2 * n}), 2).length",
            f"policy.act_{policy.agent}_rows(new Float32Array(0), 0).length",
        ]
        wanted += [2, 0]
    assert javascript(team, calls, tmp_path) == wanted


def test_javascript_refuses_what_is_no_number(team, tmp_path):
    values = {"'0.5'": "string", "''": "string", "5n": "bigint", "undefined": "undefined", "true": "boolean"}
    values |= dict.fromkeys(["null", "[0.5]", "new Date(0)"], "object")
    calls, wanted = [], []
    for policy in team.agents:
        n = len(policy.features)
        for value, kind in values.items():
            for place in (0, 1, n - 1):
                calls.append(f"policy.act_{policy.agent}(Object.assign(Array({n}).fill(0), {{{place}: {value}}}))")
                wanted.append(f"TypeError: {policy.agent} observes {n} numbers, given {kind} at {place}")
        calls += [f"policy.act_{policy.agent}(Array({n}))", f"policy.act_{policy.agent}('{'0' * n}')"]
        wanted += [
            f"TypeError: {policy.agent} observes {n} numbers, given {kind} at 0" for kind in ("undefined", "string")
        ]
        calls += [
            f"policy.act_{policy.agent}(new BigInt64Array({n}))",
            f"policy.act_{policy.agent}_rows(new BigInt64Array({n}), 1)",
        ]
        wanted += [f"TypeError: {policy.agent} observes {n} numbers, given bigint at 0"] * 2
        for value in ("null", "undefined"):
            calls.append(f"policy.act_{policy.agent}({value})")
            wanted.append(f"RangeError: {policy.agent} observes {n} numbers, given {value}")
        calls.append(f"policy.act_{policy.agent}_rows(Array({n}).fill(0), 1)")
        wanted.append(f"RangeError: {policy.agent} observes {n} numbers: 1 times {n} in a typed array, given object")
    assert javascript(team, calls, tmp_path) == wanted


# --- the reference, and the compiled C


@pytest.mark.parametrize("agent", ["adversary_0", "agent_0", "agent_1"])
def test_the_reference_refuses_another_shape_and_what_is_no_number(agent, team):
    policy = team.policy(agent)
    n = len(policy.features)
    for given in lengths(policy):
        for rows in (np.zeros((5, given)), np.zeros((5, given), dtype=np.float32), [[0.0] * given]):
            with pytest.raises(InputError, match=f"{agent} observes rows of {n} numbers, given an array of shape"):
                ir.act(policy, rows)
    for rows in (np.zeros((2, 3, n)), 0.0, np.zeros((n, 1))):
        with pytest.raises(InputError, match=f"{agent} observes rows of {n} numbers, given an array of shape"):
            ir.act(policy, rows)
    with pytest.raises(InputError, match=f"{agent} observes rows of one length"):
        ir.act(policy, [[0.0] * n, [0.0] * (n - 1)])
    for value in ("0.5", b"0.5", None, 0j, np.timedelta64(1, "s"), [0.5, None], {}, 10**400):
        with pytest.raises(InputError, match=f"{agent} observes"):
            ir.act(policy, [[value] * n])
        with pytest.raises(InputError, match=f"{agent} observes"):
            ir.act(policy, [[value, Fraction(1), *[0.0] * (n - 2)]])
    assert len(ir.act(policy, [])) == len(ir.act(policy, np.zeros((0, n)))) == 0
    assert ir.act(policy, np.zeros(n)).shape == (1,)


@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_numbers_of_every_type_are_doubles_first_in_the_reference(threshold, profile):
    policy = with_trees({"agent_0": tree((0, threshold, 1, 2), 1, 2)}, profile).policy("agent_0")
    for name, kind in TYPES.items():
        values = [kind(x) for x in around(threshold) if np.isfinite(x) or name not in FINITE]
        with np.errstate(over="ignore"):
            singles = np.array([float(value) for value in values]).astype(np.float32)
        wanted = np.where(singles <= policy.tree.threshold[0], 1, 2)
        for beside in (0.5, 2, np.float16(0.5), Fraction(1, 3)):
            rows = [[value, *[beside] * (len(policy.features) - 1)] for value in values]
            np.testing.assert_array_equal(ir.act(policy, rows), wanted, name)
            np.testing.assert_array_equal(ir.act(policy, np.array(rows, dtype=object)), wanted, name)
        column = np.repeat(np.array(values)[:, None], len(policy.features), axis=1)
        np.testing.assert_array_equal(ir.act(policy, column), wanted, name)


@pytest.mark.compile
def test_compiled_c_is_never_given_another_width(team):
    """It knows of no length, and would read on beyond the end."""
    if find_compiler() is None:
        pytest.skip("no C compiler")
    model, (header,) = lower(team), emit(team, ["c"]).values()
    with CompiledC(header, model, find_compiler()) as compiled:
        for policy in team.agents:
            n = len(policy.features)
            for width in (n - 1, n + 1):
                for ask in (compiled.act, compiled.checks, compiled.batch):
                    with pytest.raises(InputError, match=f"{policy.agent} observes rows of {n} numbers"):
                        ask(policy.agent, np.zeros((5, width), dtype=np.float32))
        right = [np.zeros((5, len(policy.features)), dtype=np.float32) for policy in team.agents]
        assert compiled.all(right).shape == (5, 3)
        with pytest.raises(InputError, match="agent_1 observes rows of 10 numbers"):
            compiled.all([*right[:2], np.zeros((5, 9), dtype=np.float32)])
        with pytest.raises(InputError, match="different numbers of observations"):
            compiled.all([*right[:2], right[2][:4]])
        coordinates = len(team.world.coordinates())
        assert compiled.team(np.zeros((5, coordinates))).shape == (5, 3)
        for shape in ((5, coordinates - 1), (coordinates,)):
            with pytest.raises(InputError, match=f"world states have {coordinates} coordinates"):
                compiled.team(np.zeros(shape))
