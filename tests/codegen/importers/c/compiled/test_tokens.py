"""Tokens of a C file by the compiler's preprocessor, beside those of the one that the reader uses."""

import pytest

from codegen.agreement.compiled import find_compiler
from codegen.errors import InputError
from codegen.importers.c.compiled.tokens import ensure_same_tokens, list_headers
from codegen.importers.c.text import expand_source

COMPILER = find_compiler()
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler")


def compared(text, beside=None):
    beside = {name: content.encode() for name, content in (beside or {}).items()}
    expanded = expand_source(text.encode(), "tree.c", beside.get)
    ensure_same_tokens(expanded, COMPILER, "tree.c")


SAME = {
    "macros that stay names": "#define LOW (-3)\n#define ON 0x10\nint f(int x) { return x > LOW ? ON : 1; }",
    "a name that is given twice": "#define N 1\nint a = N;\n#undef N\n#define N 1\nint b = N;",
    "macros of the system": "#include <stdint.h>\n#include <math.h>\n#include <limits.h>\n#include <stdbool.h>\n"
    "int f(double x) { bool b = true; return x > INT_MAX && x < M_PI && !isnan(x) ? INT8_MIN : b; }",
    "macros that are called": "#define MAX(a, b) ((a) > (b) ? (a) : (b))\n#define JOIN(a, b) a##b\n"
    "int f(int x1) { return MAX(JOIN(x, 1), -2); }",
    "lines that go on": "#define LONG(v) \\\n  ((v) > 1 \\\n ? 2 : 3)\n"
    "int f(int x) { return LONG(x); } // a \\\n comment",
    "conditions": "#define A 3\n#if A > 2 && defined(A) && !defined(B)\nint a;\n#elif A\nint b;\n#else\nint c;\n#endif",
    "attributes": "__attribute__((noinline)) static __inline__ int f(int x) { return x; }",
    "assertions": "#include <assert.h>\nint f(int x) { assert(x > 2 && \"above\"); return 1; }",
    "guards": "#ifndef __cplusplus\nint a;\n#else\nextern \"C\" int b;\n#endif",
    "other line ends": "#define A 3\r\nint f(int x) { return x > A; }\r\n",
}  # fmt: skip


@needs_compiler
@pytest.mark.compile
@pytest.mark.parametrize("name", SAME)
def test_both_preprocessors_read_the_same(name):
    compared(SAME[name])


@needs_compiler
@pytest.mark.compile
def test_headers_beside_the_file_are_read_by_both():
    text = '#include "limits/low.h"\n#include <board.h>\nint f(int x) { return x > LOW + HIGH; }'
    compared(text, {"limits/low.h": '#pragma once\n#include "high.h"\n#define LOW 3', "high.h": "#define HIGH 9 + 1"})


OTHERS = [
    ("#ifdef __GNUC__\nint a = 1;\n#else\nint a = 2;\n#endif", "line 2", "reads 1 where the reader reads 2"),
    ("#include <math.h>\n#ifndef M_PI\n#define M_PI 3.14\n#endif\ndouble a = M_PI;", "line 5", "reader reads 3.14"),
    ("#include <limits.h>\n#if INT_MAX > 40000\nint a;\n#endif\nint b;", "line 3", "reads a where the reader reads b"),
    ("int a = sizeof(int) == 4 ? __LINE__ : 2;", "line 1", "reads 1 where the reader reads"),
]  # fmt: skip


@needs_compiler
@pytest.mark.compile
@pytest.mark.parametrize(("text", "line", "says"), OTHERS)
def test_what_compilers_expand_otherwise_is_refused_with_its_line(text, line, says):
    with pytest.raises(InputError, match=says) as caught:
        compared(text)
    assert line in caught.value.where


@needs_compiler
@pytest.mark.compile
def test_a_difference_in_a_header_names_it():
    with pytest.raises(InputError) as caught:
        compared('#include "low.h"\nint a = LOW;', {"low.h": "\n#ifdef __GNUC__\nint b;\n#endif\n#define LOW 3"})
    assert caught.value.where == "tree.c, line 3 of low.h"


@needs_compiler
@pytest.mark.compile
@pytest.mark.parametrize("name", ["/etc/passwd", "../high.h"])
def test_no_header_outside_the_folder_is_read(name):
    with pytest.raises(InputError, match="a header lies outside"):
        compared(f'#include "{name}"\nint a;')


def test_headers_of_the_language_are_listed_in_order():
    content = b'#include "low.h"\n#include <stdint.h>\n  #  include <math.h>\n#include <board.h>'
    text = expand_source(content, "tree.c", lambda name: b"#include <math.h>\n#include <float.h>")
    assert list_headers(text) == ["stdint", "math", "float"]
