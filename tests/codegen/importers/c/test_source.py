"""If/else C of others: each file decides after its import as the program that a compiler makes of it, or is refused."""

import ctypes

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.arithmetic import LIBRARY
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from codegen.importers.symbolic import paths
from tests.codegen.importers.origins import answered, asked, data, decided
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
    "while (x[0] > 1) return 1; return 0;",
    "if (x[0]) return 1; return !x[1];",
    "return 0 < x[0] < 1;",
    "return x[0] > 16777217 || x[1] > 16777217u;",
    "return (x[0] > 0.1f) + 2 * (x[1] > 0.1) - (x[2] > (float)0.1);",
    "if (10u > x[0]) return (unsigned char)300; return -7 / 2 * 10 + -7 % 3;",
    "int a = 1; if (x[0] > 1) { int a = 2; (void)a; } return a;",
    "return x[0] * 0.1 > 0.3;",
    "return 3 - x[0] * 2 > 0.1f ? -x[1] < 0.3 : x[2] / 3 >= 0.1f;",
    "return x[0] * x[0] > 0.3f;",
    "double d = x[0]; float g = d * 0.1; return g > 0.07f;",
    "return fabs(x[0]) < 0.1 || fabsf(x[1] - 1) > 0.5f;",
    "return fmax(x[0], 0.25) + 0.1 > 0.4 ? fminf(x[1], 1.0f) > 0.1f : floor(x[2]) == 1;",
    "if (x[0] > -9 && x[0] < 9) return (int)(x[0] * 3) == 2; return 7;",
    "if (x[0] > -9 && x[0] < 9) {"
    "signed char k = x[0]; switch (k) { case 1: return 4; case 2: k = 9; default: return k; } } return 7;",
    "int n = 0, i; for (i = 0; i < 3; i++) { if (x[i] < 0) continue; if (x[i] > 2) break; n += i + 1; } return n;",
    "int n = 0; do { n++; } while (n < 3 && x[0] > n); return n;",
    "bool fast = x[0] > 1, near = x[1] < 0.5; return fast && near ? 1 : fast != near ? 2 : 3;",
    "unsigned char flags = 0; if (x[0] > 1) flags |= 1 << 2; if (x[1] > 1) flags ^= 5; return flags & ~1;",
    "static const float table[] = {0.1f, 0.5f, 1}; int i = 0; while (i < 3 && x[0] > table[i]) ++i; return i;",
    "return SQUARE(2) + MORE(x[0]) + ON;",
    "struct { float a; int b; } s = {.b = 3, .a = 0.2f}, t; t = s; t.b++; return x[0] > t.a ? t.b : s.b;",
    "const FLOATS *p = &x[1]; return *p > 0.5 ? p[1] > 0.5 : *(p - 1) > 0.5;",
    "return helper(x[0] > 1 ? 2 : 0.5f, x[1]) + twice(3);",
    "\\\n// a comment that goes \\\n on: return 1;\nreturn x[0] > 0;",
    "return x[0] < 0x7fffffff && x[0] > -2147483647 - 1;",
    "return 4294967295u + 2 > x[0] ? -1 < 1u : (unsigned)-1 > x[1];",
    "enum { A = -1, B, C = 5 } e = x[0] > 1 ? C : A; return e;",
    "long long big = 3000000000LL; return x[0] > big / 1000000000;",
    # conditions that ask, set or decide something beside the last comparison
    "if ((x[0] > 0 ? 1 : 1) == 1) return 1; return x[1] > 0;",
    "int n = 0; if (n++ < x[0]) { if (x[1] > n) return n + 2; } return n;",
    "int a = 0; if ((a = x[0] > 0.5f) == 1) a += 2; if (x[1] > a) { int b = a; a = 7; if (x[2] > b) a = 9; } return a;",
    "if ((x[0] > 0.5f) > (x[1] > 0.5f)) return 1; if (x[0] > 0.5f && 0) return 2; return (x[2] < 1) == 1 ? 3 : 4;",
]
HEAD = """#include <stdint.h>
#include <stdbool.h>
#include <math.h>
#define SQUARE(n) ((n) * (n))
#define MORE(v) \\
    ((v) > 1 ? 10 \\
             : 20)
enum { OFF, ON = 4 };
static const float T = 0.7;
static inline int twice(int n) { return n > 0 ? 2 + twice(n - 1) : 0; }
static int helper(float limit, double v) { if (v > limit) return 1; return 0; }
"""


@needs_compiler
@pytest.mark.compile
@pytest.mark.parametrize("kind", ["float", "double"])
def test_functions_decide_as_compiled(kind, tmp_path):
    def text(place):
        return f"int act_{place}(const {kind} *x)\n{{ {BODIES[place]} }}\n"

    head = HEAD.replace("double v)", f"{kind} v)") + f"typedef {kind} FLOATS;\n"
    library = compiled(head + "".join(map(text, range(len(BODIES)))), tmp_path)
    for place in range(len(BODIES)):
        origins = from_c((head + text(place)).encode(), "tree.c", Said(wanted=f"act_{place}"))
        policy, rows = asked(origins)
        rows = rows[::7]
        wanted = answers(library[f"act_{place}"], rows, ctypes.c_float if kind == "float" else ctypes.c_double)
        assert decided(origins, policy, rows) == wanted, BODIES[place]


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


REFUSED = [
    ("int f(const float *x)\n{ if ((x[0] + x[1]) / 1e-40f + x[2] > 1) return 1; return 0; }", 2, "is no sum"),
    ("int f(const short *x)\n{ if (x[0] * 999 - x[1] * 9 > 5) return 1; return 0; }", 2, "may be no float"),
    ("int f(float x, float y, int on)\n{ return on && x - y > 1; }", 2, "given doubles, or whole numbers"),
    ("int f(const float *x)\n{ if (0.1f * x[0] + x[1] > 1) return 1; return 0; }", 2, "rounded once or twice"),
    ("int f(const float *x)\n{ if (0.1 * x[0] + x[1] > 1) return 1; return 0; }", 2, "which is no float"),
    ("int f(const float *x)\n{ if (x[0] * x[1] > 1) return 1; return 0; }", 2, "a product of features"),
    ("int f(const float *x)\n{ if (x[0] * x[1] > 1) return 1; return 0; }", 2, "product of features"),
    ("int f(const float *x)\n{ if (1 / x[0] > 1) return 1; return 0; }", 2, "divided by a feature"),
    ("int f(const float *x)\n{ if (sqrt(x[0]) > 1) return 1; return 0; }", 2, "function sqrt is not read"),
    ("int f(const float *x)\n{ if (x[0] > 0.1L) return 1; return 0; }", 2, "number is not read: 0.1L"),
    ("int f(const float *x)\n{ if (x[0] > 1e400f) return 1; return 0; }", 2, "number is not read: 1e400f"),
    ("int f(const float *x)\n{ return (int)x[0]; }", 2, "a number from -inf to inf is converted to int"),
    ("int f(const float *x)\n{ if (x[0] < 9) return (unsigned char)x[0]; return 0; }", 2, "from -inf to 8 is conv"),
    ("int f(const float *x)\n{ if (x[-1] > 1) return 1; return 0; }", 2, "no such item"),
    ("int f(const float x[2])\n{ if (x[2] > 1) return 1; return 0; }", 2, "no such item"),
    ("int f(const float *x, int i)\n{ return x[i] > 1; }", 2, "chosen by a feature"),
    ("int f(unsigned x)\n{ return x - 1 > 5; }", 2, "wraps around"),
    ("int f(int x)\n{ return x % 2; }", 2, "bits or remainders of a whole number of more than 16 bits"),
    ("int f(int x)\n{ return (x & 4) != 0; }", 2, "bits or remainders of a whole number of more than 16 bits"),
    ("int f(unsigned x)\n{ return (unsigned char)x > 5; }", 2, "which holds 0 to 255"),
    ("int f(unsigned short x)\n{ return (x & 1) != 0; }", 2, "fall more than"),
    ("int f(short x)\n{ return x >> 1 > 5; }", 2, "negative number may be shifted"),
    ("int f(short x)\n{ return (1 << 31) > x; }", 2, "is no int"),
    ("int f(short x)\n{ return 2147483647 + 1 > x; }", 2, "is no int"),
    ("int f(const int *x)\n{ return ((const char *)x)[0]; }", 2, "one to another type"),
    ("int f(const float *x)\n{ union { int a; float b; } u; return 1; }", 2, "type is not read"),
    ("struct s { int a : 2; int b; };\nint f(struct s x)\n{ return x.b > 1; }", 1, "member has bits or no name"),
    ("int f(float x)\n{ struct { int a; } s = {.b = 1}; return s.a; }", 2, "an initializer is not read"),
    ("int f(float x)\n{ float v[2] = {1, 2, 3}; return x > v[0]; }", 2, "too many parts"),
    ("int f(float *x, double *y)\n{ memcpy(y, x, 8); }", 2, "a copy of memory is not read"),
    ("int f(const float *x)\n{ int a; if (x[0] > 1) a = 2; return a; }", 2, "holds nothing on some path"),
    ("int f(const float *x)\n{ static int a = 1; a++; return a; }", 2, "a is counted without an end"),
    ("int n;\nint f(const float *x)\n{ return n++; }", 3, "n is counted without an end"),
    ("int n;\nvoid g(int a) { n = a; }\nint f(const float *x)\n{ return n; }", 3, "n is set by g, too"),
    ("int f(int e)\n{ static int last; int was = last; last = e; return was > 3; }", None, "a feature of many values"),
    ("int f(float e, int k)\n{ static int n; if (e > 0 && n < 999) n++; return k > n; }", None, "remembered is comp"),
    ("int f(float e)\n{ static float sum; sum += e; return sum > 1; }", None, "no whole number: sum"),
    ("int n[2];\nvoid g(int a) { int *p = n; *p = a; }\nint f(float x)\n{ return n[0]; }", 3, "n is set by g, too"),
    ("extern int n;\nint f(const float *x)\n{ return n; }", 3, "name n is not known"),
    ("void f(float *x)\n{ if (x[0] > 1) x[1] = 1; else x[1] = 0; }", 1, "what is remembered is no whole number"),
    ("int f(const float *x, int *y)\n{ *y = 1; return 0; }", 2, "another one is written"),
    ("void f(const float *x, int *y)\n{ if (x[0] > 1) *y = 1; }", 2, "nothing is returned or written"),
    ("int f(const float *x)\n{ return rand() % 2; }", 2, "function rand is not read"),
    ("int f(float x)\n{ while (x > 1) x = x / 2; return 0; }", 2, "deeper than"),
    ("int f(float x)\n{ for (;;) { } return 0; }", 2, "does not end"),
    ("int f(float x)\n{ goto end; end: return 0; }", 2, "goto is not read"),
    ("int f(float x)\n{ switch (x > 1) { case 0: for (;;) {\ncase 1: return 1; } } }", 3, "a case stands within"),
    ("int f(float x)\n{ return f(x); }", 2, "too deeply"),
    ("int f(void)\n{ return 0; }", None, "no function that decides"),
    ("int f(const float *x)\n{ if (x[0] > 1) return 1; }", None, "without a return"),
    ("int f(const float *x)\n{ return 1; \0 }", 2, "not printed"),
    ("int f(const float *x)\n{\n// ??/\n    return 1;\n    return 0; }", 3, "trigraph"),
    ("#if 0\nint f(const float *x) { return 1; }\n#endif", None, "no function that decides"),
    ("#include \"a.h\"\n#ifdef FAST\n#endif\nint f(float x)\n{ return 1; }", 2, "say what the macro FAST is"),
    ("#include \"a.h\"\n#if FAST\n#endif\nint f(float x)\n{ return 1; }", 2, "a.h is not there"),
    ("#include \"a.h\"\nint f(float x)\n{ return x > LIMIT; }", 3, "LIMIT is not known"),
    ("#error no\nint f(float x)\n{ return 1; }", 1, "#error: no"),
    ("#define A A2 A2\n" + "".join(f"#define A{n} A{n + 1} A{n + 1}\n" for n in range(2, 60)) + "int f(float x) { A }",
     None, "too much text"),
    ("int f(float x)\n{ return 1; }\nint f(float x)\n{ return 2; }", 3, "two functions f"),
    ("#include \"hal.h\"\nextern HAL_t h;\nint f(HAL_t x)\n{ return x > 1; }", 3, "type is not read: HAL_t"),
    ("int f(float x)\n{ /* return 1; }", 2, "comment has no end"),
    ("int f(float x)\n{ return 1 }", 2, "not C that is understood"),
    ("int f(float x)\n{ return '12'; }", 2, "number is not read: '12'"),
    ("enum e { A, B };\nint f(short x)\n{ enum e e = x > 3 ? B : A; return x < 2 * e + 1; }", 3, "negative number"),
    ("enum e { A, B };\nint f(enum e e, short x)\n{ return x < e; }", 3, "negative number"),
    ("enum e { A, B };\nint f(enum e e)\n{ return -e < 0; }", 3, "negative number"),
    ("int f(int x)\n{ enum e { A, B } e = A; return e - 1 < 0 ? x > 1 : 0; }", 2, "negative number"),
    ("int f(float x)\n{ return x * 0.1f + 0.1f > 0.7f; }", 2, "rounded once or twice"),
    ("void f(double *x, double *y)\n{ double v[2]; memcpy(v, (double[]){1, 0}, 1 * sizeof(double));\n"
     "memcpy(y, v, 2 * sizeof(double)); }", 3, "holds nothing"),
    ("static int g(float v) { return v > 1; }\nstatic int (*const t[1])(float) = {g};\n"
     "int f(float v)\n{ return t[0](v); }", 4, "called through a pointer"),
    ("int f(float x)\n{ return x > (-1LL < 0ul ? 5 : 3); }", 2, "the number -1 is no"),
    ("#include <stdint.h>\n#if UINTPTR_MAX > 99\n#endif\nint f(float x) { return x > 1; }", 2, "compilers give"),
    ("#include <math.h>\nint f(int x)\n{ return isnan(x); }", 3, "takes a float or a double"),
    ('int f(float x)\n{ return x > sizeof("abc\\0d"); }', 2, "a text is not read"),
    ("static const int L = 3;\n#define L 5\nint f(float x)\n{ return x > L; }", 1, "L is declared, and a macro"),
    ("enum { L };\n#define L 5\nint f(float x)\n{ return x > L; }", 1, "L is declared, and a macro"),
    ("struct s { float L; };\n#define L 5\nint f(struct s x)\n{ return 1; }", 1, "L is declared, and a macro"),
    ("int f(float L)\n{ return L > 1; }\n#define L 5\n", 1, "L is declared, and a macro"),
    ("int f(float x)\n{\nint L = 2; return x > L; }\n#define L 5\n", 3, "L is declared, and a macro"),
    ("#define NDEBUG\n#include <assert.h>\n#undef NDEBUG\nint f(float x)\n{ assert(x > 1); return 1; }", 1, "NDEBUG"),
    *((f"#define A {a}\n#if {test}\n#endif\nint f(float x)\n{{ return x > 1; }}", 2, "#if computes with")
      for a, test in [("1", "-7 / 2 == -3"), ("(-7 / 2)", "A == -3"), ("1", "0 || -7 % 2"), ("1", "-1 > 0u"),
                      ("1", "-1 >> 1"), ("1", "1 << 40"), ("1", "'a' > 3"), ("1", "A ? 1 : 0"),
                      ("1", "0xffffffffffffffff < 1"), ("~0", "A")]),
    ("#include <stdbool.h>\n#if true\n#endif\nint f(float x) { return x > 1; }", 2, "compilers give"),
    ("#define N 1\nint f(float x) { return x > N; }\n#undef N\n#define N 2\nint g(float x) { return x > N; }", 4,
     "the macro N means two numbers"),
    ("int f(const float *x)\n{ if (x[0] - x[1] > 1) return 1; return (double)x[0] + x[1] > 1.0; }", 2,
     "float and of double"),
    ("#include <math.h>\nint f(const float *x)\n{ return fabsf(x[0] + x[1] - x[1]) > -1.0f ? 1 : 0; }", 3,
     "the answer is the same but for NaN"),
    ("#include <math.h>\nvoid f(const double *x, double *u)\n{ u[0] = fmax(0.0, x[0] - x[1]); }", None,
     "the sign of the zero there is not known"),
    ("", None, "no function"),
]  # fmt: skip


FUNCTIONS = """
    abs assert ceil ceilf fabs fabsf fflush floor floorf fmax fmaxf fmin fminf fprintf fputc fputs isnan lround
    lroundf memcpy perror printf putc putchar puts round roundf trunc truncf
"""


def test_no_other_functions_are_read():
    """The hunt takes some steps with others, which are refused alike; a new one needs steps of its own there."""
    assert sorted(LIBRARY) == FUNCTIONS.split()


@pytest.mark.parametrize(("text", "line", "said"), REFUSED)
def test_other_c_is_refused_with_its_line(text, line, said, monkeypatch):
    monkeypatch.setattr(paths, "MAX_STEPS", 50_000)
    with pytest.raises(InputError, match=said) as caught:
        profile_of(from_c(text.encode(), "tree.c"), Names())
    assert caught.value.next_step and (line is None or f"line {line}" in caught.value.where)


@pytest.mark.timeout(300)  # seconds, where it took hours
def test_a_guard_is_skipped_and_comments_take_no_time():
    text = "/* a */\n#ifndef TREE_H_\n#define TREE_H_\n#include <math.h>\nint f(float *x) { return 1; }\n#endif\n"
    assert from_c(text.encode(), "tree.h")
    with pytest.raises(InputError):
        from_c(b"/*" * 100_000, "tree.c")


@pytest.mark.parametrize("text", [b"\xff\xfe", b"{" * 5_000, b"int f(const float *x) { return " + b"(" * 5_000])
def test_what_is_no_c_is_refused(text):
    with pytest.raises(InputError):
        from_c(text, "tree.c")


INPUT = "typedef struct { float v; double y; unsigned char on; } obs_t;\n#define LOW 0.1f\nenum { GO, HALT = 3 };\n"


def test_a_header_beside_the_file_is_read_and_names_stay():
    headers = {"obs.h": b"#ifndef OBS_H\n#define OBS_H\n" + INPUT.encode() + b"#endif\n"}
    text = '#include "obs.h"\n#include "obs.h"\nint f(const obs_t *o) { return o->v <= LOW && o->on ? HALT : GO; }'
    (origin,) = from_c(text.encode(), "tree.c", Said(beside=headers.get)).values()
    assert origin.features == ("v", "y", "on") and dict(origin.called) == {0: "GO", 3: "HALT"}
    assert origin.numbers == "float64" and not origin.notes
    with pytest.raises(InputError, match="not C that is understood"):
        from_c(text.encode(), "tree.c")


def test_a_macro_that_is_a_whole_number_names_an_action():
    text = b"#define LEFT 0\n#define RIGHT (0x2)\n#define N 1\nint f(float x[N]) { return x[LEFT] > 1 ? RIGHT : LEFT; }"
    (origin,) = from_c(text, "tree.c").values()
    assert dict(origin.called) == {0: "LEFT", 2: "RIGHT"} and origin.n_features == 1


def test_numbers_that_overflow_are_left_out_and_said():
    (origin,) = from_c(b"int f(int x) { return x * 3 > 9; }", "tree.c").values()
    rows = np.array([[0.0], [4.0], [1e9]], dtype=np.float32)
    assert "overflow" in origin.given and origin.takes(rows).tolist() == [True, True, False]
    (origin,) = from_c(b"int f(short x) { return x * 3 > 9; }", "tree.c").values()
    assert origin.takes is None


def test_whole_numbers_beyond_float32_are_compared_as_doubles():
    (origin,) = from_c(b"int f(int x, float y) { return x > 20000001 || y > 0.1f; }", "tree.c").values()
    assert origin.numbers == "float64"
    rows = np.array(
        [[20000001, 0], [20000002, 0], [0, np.float32(0.1)], [0, np.nextafter(np.float32(0.1), np.float32(1))]]
    )
    assert answered(origin, rows.astype(np.float64)) == [0, 1, 0, 1]


CONTRACTED = "int f(float x) {{ {} return x * 0.1f + 0.1f > 0.7f; }}"


def test_a_product_that_may_be_fused_asks_for_the_pragma_unless_it_is_exact():
    for text in (CONTRACTED.format(""), "int f(float x) { return x * 0.0125f + 1.5f > 40.0f; }"):
        with pytest.raises(InputError, match="once or twice"):
            from_c(text.encode(), "tree.c")
    assert from_c(("#pragma STDC FP_CONTRACT OFF\n" + CONTRACTED.format("")).encode(), "tree.c")
    assert from_c(b"int f(float x) { return x * 0.5f + 0.1f > 0.7f; }", "tree.c")  # an exact product


@needs_compiler
@pytest.mark.compile
def test_a_fused_sum_is_where_the_reading_says_it_is(tmp_path):
    """The number at which `fmaf` and two roundings differ is the one for which the file is refused."""
    text = "#include <math.h>\nint one(float x) { return fmaf(x, 0.1f, 0.1f) > 0.7f; }\n" + CONTRACTED.format("")
    library = compiled(text, tmp_path)
    library.one.argtypes = library.f.argtypes = [ctypes.c_float]
    assert (library.one(6.0), library.f(6.0)) == (0, 1)


def test_functions_that_only_print_or_name_are_skipped():
    text = """enum a { GO, HALT };
    const char *name(enum a x) { return x == GO ? "go" : "halt"; }
    enum a act(const float *x) { return x[0] > 1 ? HALT : GO; }
    static void show(const float *x) { printf("%s", name(act(x))); }
    int main(void) { float x[1] = {0}; show(x); return 0; }"""
    assert list(from_c(text.encode(), "tree.c")) == ["act"]
    assert list(from_c(text.encode(), "tree.c", Said(wanted="name"))) == ["name"]


def test_types_of_missing_headers_matter_only_where_a_decision_needs_them():
    text = b'#include "hal.h"\nextern ADC_t adc;\nvoid tick(ADC_t *a) { a->n = 1; }\nint f(float x) { return x > 1; }'
    (origin,) = from_c(text, "tree.c", Said(wanted="f")).values()
    assert origin.notes == ("read without hal.h",)


def test_bits_of_small_numbers_are_tests_of_each_value():
    (origin,) = from_c(b"int f(unsigned char x) { return (x & 6) == 4 && x % 3 == 1; }", "tree.c").values()
    rows = np.arange(256, dtype=np.float32)[:, None]
    wanted = [int((x & 6) == 4 and x % 3 == 1) for x in range(256)]
    assert answered(origin, rows) == wanted
    assert ir.act(profile_of({"f": origin}, Names()).agents[0], rows).tolist() == wanted


def test_functions_that_write_nothing_are_not_agents():
    text = b"""typedef struct { double t; } obs; int hot(obs *o) { return o->t > 26; }
    void all(obs *os, int n) { for (int i = 0; i < n; i++) { if (hot(&os[i])) puts("hot"); } }
    static void put(int *to, int v) { *to = v; } void act(const obs *o, int *out) { put(out, o->t > 3); }"""
    assert list(from_c(text, "tree.c")) == ["hot", "act"]


SKIPPED = ["#ifdef NOPE", "#if defined(NOPE) && NOPE > 2", "#if 0", "#if 1\n#else", "#ifndef __STDC__"]


@pytest.mark.parametrize("test", SKIPPED)
def test_lines_in_branches_that_are_not_taken_do_nothing(test):
    body = "int f(float x) { return x > 1.0f ? GO : HALT; }"
    names = "#define GO 1\n#define HALT 0\n"
    for line in ("#error no", "#define GO 7", "#undef GO", "#include <nowhere.h>", "#assert x", "#pragma"):
        found = from_c(f"{names}{test}\n{line}\n#endif\n{body}".encode(), "tree.c")
        assert [each.name for each in profile_of(found, Names()).agents[0].actions] == ["HALT", "GO"], line
    with pytest.raises(InputError, match="once or twice"):  # as if the line were not there
        from_c(f"{test}\n#pragma STDC FP_CONTRACT OFF\n#endif\n{CONTRACTED.format('')}".encode(), "tree.c")
    with pytest.raises(InputError, match="#error: no"):
        from_c(f"{test}\n#endif\n#error no\n{body}".encode(), "tree.c")


@pytest.mark.parametrize("place", ["", "static "])
def test_the_address_of_a_constant_changes_nothing(place):
    table = f"{place}const struct band {{ double lo; int act; }} bands[2] = {{ {{ 0, 1 }}, {{ 4, 2 }} }};"
    body = "const struct band *b = x > 4 ? &bands[1] : &bands[0]; return x > b->lo ? b->act : 0;"
    for text in (f"{table} int f(double x) {{ {body} }}", f"int f(double x) {{ {table} {body} }}"):
        (origin,) = from_c(text.encode(), "tree.c").values()
        assert answered(origin, np.array([[-1.0], [1.0], [5.0]])) == [0, 1, 2]
    held = table.replace("const ", "static ", 1) if not place else table.replace("const ", "", 1)
    with pytest.raises(InputError, match=r"variable bands is kept|no whole number"):
        from_c(f"int f(double x) {{ {held} struct band *b = bands + 1; b->act += 1; return 1; }}".encode(), "tree.c")
