"""If/else C of others: each file decides after its import as the program that a compiler makes of it, or is refused."""

import ctypes

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, Said, profile_of
from tests.codegen.importers.origins import asked, data, decided
from tests.support.c_source import COMPILER, compiled, scores

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler")


def answers(function, rows, kind=ctypes.c_float, result=ctypes.c_int):
    """What a function of one array returns for each row."""
    function.restype = result
    wide = np.ascontiguousarray(rows, dtype=np.float32 if kind is ctypes.c_float else np.float64)
    return [function(row.ctypes.data_as(ctypes.POINTER(kind))) for row in wide]


BODIES = [
    "if (x[0] <= 0.1) return 1; return 0;",
    "if (x[0] < 0.1f) { return 2; } else if (x[1] >= 3) { return -1; } return 0;",
    "if (0.1 > x[0] && !(x[1] > 1e-3f || x[2] != 0)) return 1; else return 0;",
    "return x[0] == 0.5f ? 3 : x[2] <= -0x1.8p-2 ? 4 : 5;",
    "int a = 1; if (x[0] <= 0.3) { a = 2; if (x[1] > .5) a = 3; } ; return a;",
    "if (x[0] == 0.1) return 1; /* never for float */ return 0; // the end\n",
    "const float t = 1; if (x[1] <= T) return ON; return OFF;",
    "if (x[0] <= 010) return 'a'; if (x[1] == '!' || -0x1F < x[2]) return 0777; return 2147483647L;",
]
HEAD = "#include <stdint.h>\nenum { OFF, ON = 4 };\nstatic const float T = 0.7;\n"


@needs_compiler
@pytest.mark.compile
@pytest.mark.parametrize("kind", ["float", "double"])
@pytest.mark.parametrize("body", BODIES)
def test_functions_decide_as_compiled(body, kind, tmp_path):
    text = f"{HEAD}int act(const {kind} *x)\n{{ {body} }}\n"
    origins = from_c(text.encode(), "tree.c")
    policy, rows = asked(origins)
    function = compiled(text, tmp_path).act
    wanted = answers(function, rows, ctypes.c_float if kind == "float" else ctypes.c_double)
    assert decided(origins, policy, rows) == wanted


@needs_compiler
@pytest.mark.compile
def test_one_parameter_a_feature(tmp_path):
    text = "double f(float speed, double gap) { if (speed < 0.1 && gap > 2) return 0.5; return -1.5; }"
    origins = from_c(text.encode(), "tree.c")
    policy, rows = asked(origins)
    assert [each.name for each in policy.features] == ["speed", "gap"]
    function = compiled(text, tmp_path).f
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_float, ctypes.c_double]
    assert decided(origins, policy, rows) == [function(*map(float, row)) for row in rows]


SCORES = """void score(double *input, double *output)
{
    double var0[2];
    if (input[0] <= 0.5) { memcpy(var0, (double[]){0.2, 0.8}, 2 * sizeof(double)); }
    else { memcpy(var0, (double[]){0.5, 0.5}, 2 * sizeof(double)); }
    memcpy(output, var0, 2 * sizeof(double));
}
"""


@needs_compiler
def test_a_list_of_numbers_is_scores_only_where_the_user_says_so(tmp_path):
    with pytest.raises(InputError, match="a list of 2 numbers is returned") as caught:
        from_c(SCORES.encode(), "tree.c")
    assert "--scores" in caught.value.next_step
    policy, rows = asked(from_c(SCORES.encode(), "tree.c", Said(scores=True)))
    text = f"#include <string.h>\n{SCORES}"
    assert ir.act(policy, rows).tolist() == scores(compiled(text, tmp_path).score, rows, 2)


@needs_compiler
@pytest.mark.interop
@pytest.mark.parametrize("seed", range(20))
def test_random_trees_of_m2cgen_decide_as_its_compiled_c(seed, tmp_path):
    m2cgen = pytest.importorskip("m2cgen", reason="the extra maviper[interop] is not installed")
    x, y = data(seed, classes=2 + seed % 3)
    text = m2cgen.export_to_c(DecisionTreeClassifier(max_depth=2 + seed % 8, random_state=seed).fit(x, y))
    origins = from_c(text.encode(), "tree.c", Said(scores=True))
    policy, rows = asked(origins)
    assert ir.act(policy, rows).tolist() == scores(compiled(text, tmp_path).score, rows, len(np.unique(y)))


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("int f(const float *x)\n{ while (x[0] > 1) return 1; return 0; }", 2, "statement is not understood: 'While'"),
        ("int f(const float *x)\n{\n    if (x[0] > x[1]) return 1; return 0; }", 3, "two features are compared"),
        ("int f(const float *x)\n{ if (x[0] + x[1] > 1) return 1; return 0; }", 2, "not of a feature and a number"),
        ("int f(const float *x)\n{ if (x[0]) return 1; return 0; }", 2, "condition is not understood"),
        ("int f(const float *x)\n{ if (0 < x[0] < 1) return 1; return 0; }", 2, "not of a feature"),
        ("int f(const float *x)\n{ if (sqrt(x[0]) > 1) return 1; return 0; }", 2, "not of a feature"),
        ("int f(const float *x)\n{ if (x[0] > 16777217) return 1; return 0; }", 2, "a number is no float: 16777217"),
        ("int f(const float *x)\n{ if (x[0] > 0.1L) return 1; return 0; }", 2, "not read as a number: 0.1L"),
        ("int f(const float *x)\n{ if (10u > x[0]) return 1; return 0; }", 2, "not read as a number: 10u"),
        ("int f(const float *x)\n{ if (x[0] > 1e400f) return 1; return 0; }", 2, "not read as a number: 1e400f"),
        ("int f(const float *x)\n{ if (x[0] > (float)1) return 1; return 0; }", 2, r"as a number: \(float\) 1"),
        ("enum { A = 2147483647, B };\nint f(const float *x) { return B; }", 1, "enumerator 'B' is not understood"),
        ("int f(const float *x)\n{ if (x[-1] > 1) return 1; return 0; }", 2, "feature is not understood"),
        ("int f(const float x[2])\n{ if (x[2] > 1) return 1; return 0; }", 2, "feature is not understood"),
        ("int f(const float *x)\n{ return x[0] > 1; }", 2, "value is not understood"),
        ("int f(const float *x)\n{ return 1.5; }", 2, "a number is no int"),
        ("uint8_t f(const float *x)\n{ return 300; }", 2, "a number is no uint8_t"),
        ("float f(const float *x)\n{ return 0.1; }", 2, "a number is no float"),
        ("int f(const float *x)\n{ int a; if (x[0] > 1) a = 2; return a; }", 2, "holds nothing on some path"),
        ("int f(const float *x)\n{ int a = 1; if (x[0] > 1) { int a = 2; } return a; }", 2, "not the first"),
        ("int f(const float *x)\n{ static int a = 1; return a; }", 2, "variable 'a' is not understood"),
        ("int f(const float *x)\n{ x[0] = 1; return 0; }", 2, "statement is not understood"),
        ("int f(const float *x)\n{ x++; return 0; }", 2, "statement is not understood"),
        ("int f(const float *x)\n{ goto end; end: return 0; }", 2, "'Goto'"),
        ("int f(const float *x)\n{ double a = 1; return a; }", 2, "another type is returned"),
        ("int f(const int *x)\n{ return 0; }", 1, "parameter is not understood"),
        ("int f(const float **x)\n{ return 0; }", 1, "parameter is not understood"),
        ("int f(const float *x, int n)\n{ return 0; }", 1, "parameter is not understood"),
        ("int f(void)\n{ return 0; }", 1, "parameter"),
        ("void f(double *x, double *y)\n{ return; }", 2, "'Return'"),
        ("int f(const float *x)\n{ if (x[0] > 1) return 1; }", None, "without a return"),
        ("#define A 1\nint f(const float *x)\n{ return A; }", 1, "line is not understood: #define A 1"),
        ("#include \"a.h\"\nint f(const float *x)\n{ return 1; }", 1, "line is not understood"),
        ("int f(const float *x)\n{ return 1; } \\\n", 2, "line is not understood"),
        ("int f(const float *x)\n{ return 1; \0 }", 2, "line is not understood"),
        ("int f(const float *x)\n{\n// \\\n    return 1;\n    return 0; }", 3, "line is not understood"),
        ("int f(const float *x)\n{\n// ??/\n    return 1;\n    return 0; }", 3, "line is not understood"),
        ("#ifndef __STDC__\nint f(const float *x)\n{ return 1; }\n#endif", 1, "line is not understood: #ifndef"),
        ("#include <math.h>\n#ifndef A_H\n#define A_H\nint f(float *x) { return 1; }\n#endif", 2, "not understood"),
        ("#ifndef A_H\n#define A_H\nint f(float *x) { return 1; }\n#endif\nint g(float *x) { return 1; }", 1, "not"),
        ("int f(const float *x)\n{ // a \f return 1;\n return 0; }", 2, "line is not understood"),
        ("#if 0\nint f(const float *x) { return 1; }\n#endif", 1, "line is not understood: #if 0"),
        ("int f(const float *x)\n{ return 1; }\n/* without an end", None, None),
        ("int a = 1;\nint f(const float *x)\n{ return a; }", 1, "'Decl' stands outside"),
        ("typedef float real;\nint f(const float *x)\n{ return 1; }", 1, "'Typedef' stands outside"),
        ("int f(const float *x)\n{ return 1; }\nint f(const float *x)\n{ return 2; }", 3, "'FuncDef' stands outside"),
        ("enum { f };\nint f(const float *x) { return 1; }", None, "several things"),
        ("const int a = 1; const int a = 2;\nint f(const float *x) { return a; }", 1, "'Decl' stands outside"),
        ("int f(const float *x)\n{ return 1 }", 2, "not C that is understood"),
        ("int f(const float *x)\n{ return '12'; }", 2, "value is not understood: '12'"),
        ("void f(double *x, double *y)\n{ double v[2]; memcpy(v, (double[]){1, 0}, 1 * sizeof(double));\n"
         "memcpy(y, v, 2 * sizeof(double)); }", 2, "memcpy is not understood"),
        ("void f(double *x, double *y)\n{ double v[2]; memcpy(v, (double[]){1, 0, 0}, 2 * sizeof(double));\n"
         "memcpy(y, v, 2 * sizeof(double)); }", 2, "3 numbers is set, 2 are declared"),
        ("void f(double *x, double *y)\n{ double v[2] = {1, 0}; memcpy(y, v, 2 * sizeof(double)); v[0] = 2; }", 2,
         "memcpy is not understood"),
        ("void f(double *x, double *y)\n{ double v[2] = {1, 0}; if (x[0] > 1) memcpy(y, v, 2 * sizeof(double)); }", 2,
         "memcpy is not understood"),
        ("", None, "no function"),
    ],
)  # fmt: skip
def test_other_c_is_refused_with_its_line(text, line, said):
    if said is None:  # what compilers refuse may be read
        assert from_c(text.encode(), "tree.c")
        return
    with pytest.raises(InputError, match=said) as caught:
        profile_of(from_c(text.encode(), "tree.c"), Names())
    assert line is None or f"line {line}" in caught.value.where


@pytest.mark.timeout(300)  # seconds, where it took hours
def test_a_guard_is_skipped_and_comments_take_no_time():
    text = "/* a */\n#ifndef TREE_H_\n#define TREE_H_\n#include <math.h>\nint f(float *x) { return 1; }\n#endif\n"
    assert from_c(text.encode(), "tree.h")
    with pytest.raises(InputError):
        from_c(b"/*" * 500_000, "tree.c")


@pytest.mark.parametrize("text", [b"\xff\xfe", b"{" * 5_000, b"int f(const float *x) { return " + b"(" * 5_000])
def test_what_is_no_c_is_refused(text):
    with pytest.raises(InputError):
        from_c(text, "tree.c")
