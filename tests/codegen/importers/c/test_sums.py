"""C with sums of features and numbers that it writes: the profile gives the bits of the compiled file."""

import ctypes

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from tests.support import sum_sources
from tests.support.c_libraries import library
from tests.support.sum_sources import rows_of

FEW, MANY, AT_ONCE = 8, 1_000, 50  # functions a kind
CASES = [(short, kind) for short in (True, False) for kind in ("numbers", "labels")]


def policies_of(text):
    """The policy of each function that is taken, by its name."""
    found = {}
    head, *functions = text.split("\n\n")
    for body in functions:
        name = body.split("(")[0].split()[-1]
        try:
            (found[name],) = profile_of(from_c(f"{head}\n\n{body}\n".encode(), "tree.c"), Names()).agents
        except InputError as error:
            assert error.next_step and error.where
    return found


def compared(seeds, short, kind, folder):
    """How many functions were taken and gave the compiled file's bits."""
    text = sum_sources.c_file(seeds, kind, short=short)
    found, compiled = policies_of(text), library(text, folder)
    for name, policy in found.items():
        rows = rows_of(policy)
        wide = np.zeros((len(rows), sum_sources.N), np.float32 if short else np.float64)
        wide[:, : rows.shape[1]] = rows
        function = compiled[name]
        if kind == "labels":
            said = [function(row.ctypes.data_as(ctypes.c_void_p)) for row in wide]
            labels = [place if each.label is None else each.label for place, each in enumerate(policy.actions)]
            assert [labels[action] for action in ir.act(policy, rows)] == said, text
            continue
        if not policy.outputs:
            continue  # constants alone are labels
        given = np.zeros((len(rows), len(policy.outputs)), wide.dtype)
        for row, into in zip(wide, given, strict=True):
            function(*(each.ctypes.data_as(ctypes.c_void_p) for each in (row, into)))
        ours = ir.outputs(policy, rows)
        both_nan = np.isnan(ours) & np.isnan(given)
        assert ours.dtype == given.dtype, text
        assert ((ours.view(f"u{ours.itemsize}") == given.view(f"u{given.itemsize}")) | both_nan).all(), (name, text)
    return len(found)


@pytest.mark.compile
@pytest.mark.parametrize(("short", "kind"), CASES)
def test_random_functions_give_the_compiled_bits(short, kind, tmp_path):
    assert compared(range(FEW), short, kind, tmp_path) >= FEW // 2


@pytest.mark.nightly
@pytest.mark.compile
@pytest.mark.parametrize(("short", "kind"), CASES)
def test_a_thousand_functions_give_the_compiled_bits(short, kind, tmp_path):
    taken = 0
    for first in range(0, MANY // 4, AT_ONCE):
        folder = tmp_path / str(first)
        folder.mkdir()
        taken += compared(range(first, first + AT_ONCE), short, kind, folder)
    assert taken >= MANY // 8


def taken(text):
    return profile_of(from_c(text.encode(), "tree.c"), Names()).agents[0]


def test_the_three_arithmetics_are_read_off_the_types():
    test = "int act(const {0} *x) {{ return {1} <= 0.1 ? 1 : 0; }}\n"
    cases = {
        ("float", "x[0] - x[1]"): "float32 steps",
        ("float", "(double)x[0] - x[1]"): "double sums",
        ("float", "0.5 * x[0] - 3.0 * x[1]"): "double sums",
        ("double", "x[0] - x[1]"): "float64",
    }
    for (kind, expression), arithmetic in cases.items():
        assert taken(test.format(kind, expression)).tree.arithmetic == arithmetic


def test_products_of_floats_in_double_are_exact_so_that_nothing_can_be_joined():
    assert taken("int act(const float *x) { return 0.1f * (double)x[0] + x[1] > 1.0; }\n").tree.sums
    with pytest.raises(InputError, match="rounded once or twice"):
        taken("int act(const double *x) { return 0.1 * x[0] + x[1] > 1.0; }\n")
    assert taken("int act(const double *x) { return 0.1 * x[0] > x[1]; }\n").tree.sums
    assert taken("double act(const double *x) { return 0.3 * (x[0] - x[1]); }\n").outputs
    for joined in (
        "0.4 + 2.5 * (x[1] - x[0])",
        "x[1] + -(0.1 * x[0])",
        "x[0] + 0.1 * x[0]",
        "-(0.3 * (x[0] - 1)) - x[1]",
    ):
        with pytest.raises(InputError, match="rounded once or twice"):
            taken(f"double act(const double *x) {{ return {joined}; }}\n")


def test_a_number_that_is_added_to_a_difference_of_whole_numbers_stays():
    text = "int act(short x, short y, short w) { return 2 * x + y > w - y + 5; }"
    (policy,) = profile_of(from_c(text.encode(), "act.c", Said(run=False)), Names()).agents
    rows = np.random.default_rng(0).integers(-6, 7, (20_000, 3))
    x, y, w = rows.T
    assert (ir.act(policy, rows) == (2 * x + y > w - y + 5)).all()
