"""if/else Python with sums and returned numbers: the profile gives Python's own bits, or says what it needs to know."""

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from tests.support import sum_sources
from tests.support.sum_sources import rows_of
from tests.support.summed import bits

FEW, MANY = 12, 1_000  # files a kind


def imported(text, arrays="float64", **said):
    outputs = said.pop("outputs", None)
    origins = from_python(text.encode(), "policy.py", Said(arrays=arrays, outputs=tuple(outputs or ()), **said))
    (policy,) = profile_of(origins, Names(outputs=outputs)).agents
    return policy


def told(text, rows):
    """What Python itself returns for rows of floats, or of arrays."""
    space = {}
    exec(compile(text, "policy.py", "exec"), space)
    with np.errstate(all="ignore"):
        return [space["act"](row) for row in rows]


def compared(seed, arrays, kind):
    text = sum_sources.Writer(seed, kind, 1 + seed % 3, short=arrays == "float32").python_file()
    policy = imported(text, arrays)
    rows = rows_of(policy)
    wide = np.zeros((len(rows), sum_sources.N), rows.dtype)
    wide[:, : rows.shape[1]] = rows  # what comes after the last feature that is read
    found = told(text, wide if arrays == "float32" or seed % 2 else wide.tolist())
    if not policy.outputs:  # a file may return constants alone
        labels = [place if each.label is None else each.label for place, each in enumerate(policy.actions)]
        assert [labels[action] for action in ir.act(policy, rows).tolist()] == found, text
        return
    given = ir.outputs(policy, rows)
    wanted = [
        [float(one) for one in (each if isinstance(each, list | tuple | np.ndarray) else [each])] for each in found
    ]
    assert [bits(row) for row in given.tolist()] == [bits(row) for row in wanted], text


CASES = [(arrays, kind) for arrays in ("float32", "float64") for kind in ("numbers", "labels")]


@pytest.mark.parametrize(("arrays", "kind"), CASES)
def test_random_files_give_pythons_own_bits(arrays, kind):
    done = sum(tried(seed, arrays, kind) for seed in range(FEW))
    assert done >= FEW // 2


@pytest.mark.nightly
@pytest.mark.parametrize(("arrays", "kind"), CASES)
def test_a_thousand_files_give_pythons_own_bits(arrays, kind):
    done = sum(tried(seed, arrays, kind) for seed in range(MANY // 4))
    assert done >= MANY // 8


def tried(seed, arrays, kind):
    """Whether a file was taken. Constants that are no float32 are refused beside float32 steps, for example."""
    try:
        compared(seed, arrays, kind)
    except InputError as error:
        assert error.next_step and error.where
        return False
    return True


def test_the_arithmetic_is_asked_for_where_it_matters():
    sums = "def act(x):\n    return 1 if x[0] - x[1] <= 0.1 else 0\n"
    with pytest.raises(InputError, match="their roundings depend") as caught:
        imported(sums, "")
    assert "--arrays float32" in caught.value.next_step and caught.value.where.endswith("line 2")
    assert imported(sums, "float32").tree.arithmetic == "float32 steps"
    for sign_only in ("x[0] < x[1]", "x[0] >= x[1]", "x[0] - x[1] > 0"):
        assert imported(f"def act(x):\n    return 1 if {sign_only} else 0\n", "").tree.arithmetic == "float64"


def test_numpys_rounding_shows():
    """0.1 is another number among float32 arrays."""
    text = "def act(x):\n    return 1 if x[0] - x[1] <= 0.1 else 0\n"
    x = [float(np.float32(0.1)), 0.0]
    assert told(text, [x]) == [0] == ir.act(imported(text, "float64"), [x]).tolist()
    assert told(text, [np.array(x, np.float32)]) == [1] == ir.act(imported(text, "float32"), [x]).tolist()


def test_outputs_have_the_names_that_are_given():
    text = "def act(x):\n    return (1.0, -0.0) if x[0] < 0 else (0.5, 2.0)\n"
    policy = imported(text, "", outputs=("force", "turn"))
    assert [each.name for each in policy.outputs] == ["force", "turn"] and not policy.actions
    assert np.signbit(ir.outputs(policy, [[-1.0]])).tolist() == [[False, True]]
    with pytest.raises(InputError, match="may be an action of several numbers") as caught:
        imported(text, "")
    assert "--outputs" in caught.value.next_step
    with pytest.raises(InputError, match="1 output name for 2 numbers"):
        imported(text, "", outputs=("force",))
    with pytest.raises(InputError, match="without ="):
        imported(text, "", outputs=("force=a", "turn=b"))


def test_a_sum_may_be_scaled_and_bent_where_it_is_tested():
    text = "def act(x):\n    return 1 if abs((x[0] - x[1]) / 3 - 0.25) < 0.1 and -(x[2] - x[1]) > 0.5 else 0\n"
    policy = imported(text)
    rows = rows_of(policy)
    assert ir.act(policy, rows).tolist() == told(text, rows.tolist())


@pytest.mark.parametrize("test", ["abs(x[0] - x[0]) > -3.6", "x[0] - 2 * x[0] <= 3 or x[0] - 2 * x[0] > 3"])
def test_a_sum_whose_only_other_answer_is_that_to_nan_is_refused(test):
    """As that of one infinite number is: no test of the tree would show that there is a sum."""
    with pytest.raises(InputError, match="the answer is the same but for NaN") as caught:
        imported(f"def act(x):\n    if {test}:\n        return 0\n    return 1\n")
    assert caught.value.where.endswith("line 2")
    ladder = ["if x[0] - 2 * x[0] <= 3:", "    return 0", "elif x[0] - 2 * x[0] > 3:", "    return 1", "return 2"]
    policy = imported("def act(x):\n    " + "\n    ".join(ladder) + "\n")
    assert len(policy.tree.sums) == 1
