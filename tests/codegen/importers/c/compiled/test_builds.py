"""Builds of C that are asked: what is not defined, what differs, and what a program may not do."""

import numpy as np
import pytest
from pycparser import CParser

from codegen.agreement.compiled import find_compiler
from codegen.errors import InputError, MissingToolError
from codegen.importers.c.compiled.builds import Compiled
from codegen.importers.c.compiled.unit import Asked, write_unit
from codegen.importers.c.kinds import Place

COMPILER = find_compiler()
pytestmark = [pytest.mark.compile, pytest.mark.skipif(COMPILER is None, reason="no C compiler")]


def built(text, parameter="x", width=1, contracts=False, headers=(), compiler=None):
    """The builds of a text with a function f."""
    parsed = CParser().parse(text)
    asked = Asked("f", tuple(Place(parameter, (place,)) for place in range(width)), (Place(""),))
    unit = write_unit(parsed, [asked], {}, headers)
    return Compiled(unit, [asked], compiler or COMPILER, "tree.c", contracts=contracts)


def rows(*values):
    return np.array(values, np.float64)


def test_answers_are_those_of_the_program():
    program = built("float f(const float *x) { return x[0] > 0.5f ? -0.0f : 0.1f; }")
    assert [repr(each) for (each,) in program.answers("f", rows([0.5], [0.625]))] == [
        repr(float(np.float32(0.1))),
        "-0.0",
    ]
    assert program.types("f") == ["float32"]


@pytest.mark.parametrize(
    ("text", "row", "says"),
    [
        ("int f(const int *x) { return x[0] * 2 > 5; }", [2**30], "not defined in C: signed integer overflow"),
        ("int f(const int *x) { return x[0] + 5 > 9; }", [2**31 - 1], "answer differently: -O0 0, -O2 1"),
        ("int f(const float *x) { return (int)x[0]; }", [2.0**70], "outside the range of representable values"),
        ("int f(const int *x) { return 1 << x[0]; }", [40], "shift exponent 40 is too large"),
        ("int f(const int *x) { return 7 / x[0]; }", [0], "it ends there|division by zero"),
        ("int f(const int *x) { int t[3] = {1, 2, 3}; return t[x[0]]; }", [5], "index 5 out of bounds"),
    ],
)  # fmt: skip
def test_what_is_not_defined_is_refused_with_the_row(text, row, says):
    with pytest.raises(InputError, match=says) as caught:
        built(text).answers("f", rows([1], row, [1]))
    assert caught.value.where.startswith("tree.c, function f, at x.0 ") and f"{float(row[0])!r}" in caught.value.where


def test_products_that_a_compiler_may_join_with_a_sum_are_compared_both_ways():
    text = "float f(const float *x) { return x[0] * x[1] + x[2]; }"
    row = np.float32([[1 + 2**-12, 1 + 2**-12, -1]]).astype(np.float64)
    assert built(text, width=3).answers("f", row)
    try:
        built(text, width=3, contracts=True).answers("f", row)
    except InputError as error:
        assert "answer differently" in error.what
    else:
        pytest.skip("this processor joins no product with a sum")


def test_what_the_program_reads_beside_its_features_changes_with_the_row():
    answers = built("int f(const unsigned char *x) { return x[3]; }").answers("f", rows([0], [0], [0]))
    assert answers == [(0,), (1,), (0,)]


def test_what_does_not_compile_is_refused():
    with pytest.raises(InputError, match=r"does not take what was read: .*implicit"):
        built("int f(const float *x) { return away(x); }").answers("f", rows([0]))


def test_a_compiler_without_traps_is_missing_something(tmp_path):
    fake = tmp_path / "cc"
    refuses = 'case "$*" in *sanitize*) echo "error: no traps" >&2; exit 1;; esac'
    fake.write_text(f'#!/bin/sh\n{refuses}\nexec {COMPILER[0]} "$@"\n')
    fake.chmod(0o755)
    with pytest.raises(MissingToolError, match="builds nothing with -fsanitize"):
        built("int f(const float *x) { return 1; }", compiler=[str(fake)]).answers("f", rows([0]))


def test_a_program_writes_no_file(tmp_path):
    canary = tmp_path / "canary"
    text = f"""typedef struct _IO_FILE FILE; FILE *fopen(const char *, const char *);
    int fputs(const char *, FILE *);
    int fclose(FILE *); int f(const float *x) {{ return fclose((fputs("w", fopen("{canary}", "w")), 0)); }}"""
    with pytest.raises(InputError):
        built(text, headers=["stdio"]).answers("f", rows([0]))
    assert not canary.exists() or canary.read_text() == ""


def test_what_the_program_prints_is_no_answer():
    text = 'int puts(const char *); int f(const float *x) { puts("7"); return 3; }'
    assert built(text).answers("f", rows([0])) == [(3,)]


def test_numbers_are_those_of_all_constant_expressions():
    text = """enum { LOW = -3, NEXT }; static const float T = 0.7f; static const int table[] = {11, 22};
    int f(const float *x) { if (x[0] > T * 2 || x[0] < (float)0.1 || x[0] == 5 - 9 * 2) return NEXT;
        return table[1]; }"""
    numbers = set(built(text).numbers)
    assert {-3.0, -2.0, 11.0, 22.0, 2.0, -13.0, float(np.float32(0.7)), 2 * float(np.float32(0.7))} <= numbers
    assert {0.1, float(np.float32(0.1))} <= numbers
