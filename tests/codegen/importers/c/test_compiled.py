"""The second reading of C: builds are asked, tokens are compared, and readers that misread are seen."""

import numpy as np
import pytest
from pycparser import CParser

from codegen import ir
from codegen.agreement.compiled import find_compiler
from codegen.errors import DisagreementError, InputError, MissingToolError
from codegen.importers import replay
from codegen.importers.c import compiled as c_compiled
from codegen.importers.c import kinds, machine
from codegen.importers.c.compiled import (
    Asked,
    Compiled,
    ensure_same_tokens,
    write_unit,
)  # fmt: skip
from codegen.importers.c.kinds import Inputs, Place
from codegen.importers.c.source import from_c
from codegen.importers.c.text import expand_source
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import NOT_COMPARED, Said
from codegen.importers.symbolic import feature
from tests.benchmarks.interop import c_ifs
from tests.codegen.importers.origins import label_of
from verify.reports.report import readers

COMPILER = find_compiler()
ONE_BUILD, ALL_BUILDS = "the C compiler (-O0)", "the C compiler (-O0, -O2, UBSan)"
pytestmark = [pytest.mark.compile, pytest.mark.skipif(COMPILER is None, reason="no C compiler")]


def built(text, parameter="x", width=1, contracts=False, headers=(), compiler=None):
    """The builds of a text with a function f."""
    parsed = CParser().parse(text)
    asked = Asked("f", tuple(Place(parameter, (place,)) for place in range(width)), (Place(""),))
    unit = write_unit(parsed, parsed.ext, [asked], {}, headers)
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


# --- tokens of the preprocessors


def compare_tokens(text, beside=None):
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


@pytest.mark.parametrize("name", SAME)
def test_both_preprocessors_read_the_same(name):
    compare_tokens(SAME[name])


def test_headers_beside_the_file_are_read_by_both():
    text = '#include "limits/low.h"\n#include <board.h>\nint f(int x) { return x > LOW + HIGH; }'
    compare_tokens(
        text, {"limits/low.h": '#pragma once\n#include "high.h"\n#define LOW 3', "high.h": "#define HIGH 9 + 1"}
    )


OTHERS = [
    ("#ifdef __GNUC__\nint a = 1;\n#else\nint a = 2;\n#endif", "line 2", "reads 1 where the reader reads 2"),
    ("#include <math.h>\n#ifndef M_PI\n#define M_PI 3.14\n#endif\ndouble a = M_PI;", "line 5", "reader reads 3.14"),
    ("#include <limits.h>\n#if INT_MAX > 40000\nint a;\n#endif\nint b;", "line 2", "compilers give other values"),
    ("#ifdef __GNUC__\n#define L 3\n#else\n#define L 5\n#endif\nint a = L;", "tree.c", "reads L as 3"),
    ("int a = sizeof(int) == 4 ? __LINE__ : 2;", "line 1", "reads 1 where the reader reads"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "says"), OTHERS)
def test_what_compilers_expand_otherwise_is_refused_with_its_line(text, line, says):
    with pytest.raises(InputError, match=says) as caught:
        compare_tokens(text)
    assert line in caught.value.where


def test_a_difference_in_a_header_names_it():
    with pytest.raises(InputError) as caught:
        compare_tokens('#include "low.h"\nint a = LOW;', {"low.h": "\n#ifdef __GNUC__\nint b;\n#endif\n#define LOW 3"})
    assert caught.value.where == "tree.c, line 3 of low.h"


@pytest.mark.parametrize("name", ["/etc/passwd", "../high.h"])
def test_no_header_outside_the_folder_is_read(name):
    with pytest.raises(InputError, match="a header lies outside"):
        compare_tokens(f'#include "{name}"\nint a;')


def test_headers_of_the_language_are_listed_in_order():
    content = b'#include "low.h"\n#include <stdint.h>\n  #  include <math.h>\n#include <board.h>'
    text = expand_source(content, "tree.c", lambda name: b"#include <math.h>\n#include <float.h>")
    assert text.headers == ["math", "float", "stdint"]


# --- sources that are asked

HEAD = "#include <stdint.h>\n#include <stdbool.h>\n#include <math.h>\n"


def imported(text, **options):
    """The agent of a text, and its origin."""
    head = "" if "library" in text else HEAD
    origins = from_c((head + text).encode(), "tree.c", Said(**options))
    profile = profile_of(origins, Names())
    (policy,), (origin,) = profile.agents, origins.values()
    return policy, origin, profile.provenance.training


CODES = "static const int32_t codes[] = {100000001, 200000003, 300000007};"
WHOLE = [  # sources, and rows with the right answers
    ("int gate(const int32_t *s) { if (s[0] == 100000001) return 1; return 0; }", {100000001: 1, 100000000: 0}),
    ("int gate(const int32_t *s) { if (s[0] != 100000001) return 1; return 0; }", {100000001: 0, 100000002: 1}),
    ("int gate(const int32_t *t) { return t[0] >= 100000001 && t[0] <= 100000003; }", {100000000: 0, 100000002: 1}),
    (
        "int gate(uint32_t c) { switch (c) { case 3000000001u: return 1; case 3000000003u: return 2; } return 0; }",
        {3000000001: 1, 3000000002: 0, 3000000003: 2},
    ),
    (
        f"{CODES} int gate(int32_t c) {{ for (int i = 0; i < 3; i++) if (codes[i] == c) return i + 1; return 0; }}",
        {100000001: 1, 200000003: 2, 300000007: 3, 300000008: 0},
    ),
    ("int gate(const int32_t *s) { if (s[0] > 5 && s[0] < 9) return 2; return s[0] == 100000001; }", {100000001: 1}),
    ("int gate(const int64_t *s) { if (s[0] == 9007199254740993LL) return 1; return 0; }", {}),
    ("int gate(uint64_t s) { if (s > 18446744073709551613ULL) return 1; return 0; }", {}),
    ("int gate(uint64_t s) { return s == 5; }", {}),
]


@pytest.mark.parametrize(("text", "right"), WHOLE, ids=range(len(WHOLE)))
def test_whole_numbers_come_in_as_they_are_or_not_at_all(text, right):
    try:
        policy, origin, _ = imported(text)
    except (DisagreementError, InputError):
        return
    for number, label in right.items():
        (action,) = ir.act(policy, np.array([[number]], np.float64)).tolist()
        assert label_of(policy, origin, action) == label


BODIES = {
    "an enumerator": "enum mode { OFF, ON = 4 }; enum mode f(const float x[3]) { return x[2] > 1.5f ? ON : OFF; }",
    "texts": 'const char *f(double speed) { return speed > 0.1 ? "go \\"now\\"" : "stay"; }',
    "letters": "char f(const float *x) { return x[0] > 0 ? 'a' : 'b'; }",
    "negative numbers": "float f(const float *x) { return x[0] > 0 ? -0.1f : -0x1.8p-3f; }",
    "a struct": "struct obs { float gap; uint8_t mode; };"
    "int f(const struct obs *o) { return o->mode == 3 && o->gap < 1; }",
    "structs in arrays": "typedef struct { float v[2]; bool on; } Wheel; typedef struct { Wheel w[2]; } Car;"
    "int f(Car c) { return c.w[1].on && c.w[0].v[1] > 2; }",
    "a pointer's type": "typedef const float *Row; int f(Row x) { return x[1] < 3; }",
    "a number of the caller's": "void f(const float *x, int *out) { *out = x[0] > 2; }",
    "what is printed": '#include <stdio.h>\nint f(float x) { printf("%f\\n", x); return x > 2; }',
    "names of headers that the file leaves out": "static float y0 = 2; int f(float log2)"
    "{ const float MAX_INPUT = 5; return log2 > MAX_INPUT ? 2 : log2 > y0; }",
    "names of ours": "int f(float in, float row, float number, float returned, float kind)"
    "{ return in > 1 ? row > 2 : number > 3 && returned > kind; }",
    "a sum": "float f(const float *x) { return x[0] - x[1] > 1 ? x[0] + x[1] : 0; }",
    "a macro": "#define LOW (-3)\n#define TWICE(n) ((n) * 2)\n"
    "int f(const int16_t *x) { return x[0] > TWICE(LOW) ? LOW : 1; }",
    "names of the C library": "/* of the library */ float round(float y0) { return y0; }"
    "int f(float index) { return round(index) > 1; }",
}


def test_what_no_decision_needs_is_left_out():
    text = '#include "servo.h"\nstatic Servo arm; void setup(void) { attach(arm, 9); }'
    _, _, facts = imported(text + "\nint f(float x) { return x > 2; }")
    assert "read without servo.h" in facts["f notes"] and facts["f replayed"] > 50


def test_several_functions_of_a_file_are_compared():
    text = "#define N 3\nstatic int high(float v) { return v > N; } int up(float v) { return high(v); }"
    origins = from_c((text + "int down(int v) { return v < -N; }").encode(), "tree.c")
    facts = profile_of(origins, Names()).provenance.training
    assert facts["up replayed by"] == facts["down replayed by"] == ALL_BUILDS


@pytest.mark.parametrize("name", BODIES)
def test_what_is_read_is_what_is_compiled(name):
    _, _, facts = imported(BODIES[name])
    assert facts["f replayed by"] in (ALL_BUILDS, ONE_BUILD) and facts["f replayed"] > 50


@pytest.mark.parametrize(
    ("text", "builds"),
    [
        ("int f(const float *x) { if (x[0] > 0.1 && !(x[1] <= -2)) return 1; else return K; }", ONE_BUILD),
        ("int f(float x) { if (x + 1 > 2) return 1; return 0; }", ALL_BUILDS),
        ("int f(float x) { if (-x > 2) return 1; return 0; }", ALL_BUILDS),
        ("int f(float x) { if (x < 200) if (x > -200) return x; return 0; }", ALL_BUILDS),
        ("int f(float x) { int v = 3; if (x > v) return 1; return 0; }", ALL_BUILDS),
        ("int f(float x) { if ((double)x > 2) return 1; return 0; }", ALL_BUILDS),
        ("int f(const float *x) { if (x[0 + 1] > 2) return 1; return 0; }", ALL_BUILDS),
        ("static int g(float v) { return v > 1; } int f(float x) { if (g(x)) return 1; return 0; }", ALL_BUILDS),
    ],
)
def test_functions_that_compare_with_constants_alone_are_built_once(text, builds):
    parsed = CParser().parse(text)
    by = "the C compiler (-O0)" if not any(map(c_compiled._computes, parsed.ext)) else ALL_BUILDS
    assert by == builds


def test_thousands_of_ifs_are_built_in_parts(monkeypatch):
    """Which decide as the function that is read; one that sets something stays whole."""
    monkeypatch.setattr(c_compiled, "LARGE", 300)
    text = c_ifs(900)
    facts = profile_of(from_c(text.encode(), "tree.c"), Names()).provenance.training
    assert facts["act replayed by"] == ONE_BUILD
    asked = Asked("act", (Place("o", ("speed",)),), (Place(""),))
    parsed = CParser().parse(text)
    unit = write_unit(parsed, parsed.ext, [asked], {}, [])
    assert unit.count("noinline)) static int maviper_part_") == unit.count("return maviper_part_") == 4
    setting = CParser().parse(text.replace("{\n    if", "{\n    static int last;\n    if", 1))
    assert "maviper_part_" not in write_unit(setting, setting.ext, [asked], {}, [])


def test_a_number_that_is_misread_in_a_part_is_seen(monkeypatch):
    read = kinds.literal
    monkeypatch.setattr(kinds, "literal", lambda text: read("0.0f" if text == "62.654f" else text))
    text = c_ifs(900)
    assert "62.654f" in text
    with pytest.raises(DisagreementError):
        profile_of(from_c(text.encode(), "tree.c"), Names())


def test_scores_are_compared_by_the_largest():
    text = "void f(const double *x, double *out) { out[0] = x[0] > 1 ? 0.2 : 0.8; out[1] = 0.5; }"
    _, _, facts = imported(text, scores=True)
    assert facts["f replayed by"] == ALL_BUILDS


def test_observations_of_whole_numbers_are_whole_and_within_their_type():
    origins = from_c((HEAD + "int f(const int8_t *x, float v) { return x[0] > 3 && v < 2.5f; }").encode(), "tree.c")
    (policy,), (origin,) = profile_of(origins, Names()).agents, origins.values()
    with origin.second() as running:
        rows = replay.source_observations(policy, running, [0, 1], nan=True, finite=False)
    assert set(rows[:, 0].tolist()) <= set(range(-128, 128)) and {3, 4, 127, -128} <= set(rows[:, 0].tolist())
    held = rows[~np.isnan(rows[:, 1]), 1]
    assert (held.astype(np.float32) == held).all() and 2.5 in held


# --- readers that misread


def test_a_number_that_is_misread_is_seen(monkeypatch):
    read = kinds.literal
    monkeypatch.setattr(kinds, "literal", lambda text: read("0.7000001" if text == "0.7" else text))
    with pytest.raises(DisagreementError, match="takes action 0 where its origin takes 1"):
        imported("int f(const double *x) { return x[0] > 0.7; }")


def test_a_comparison_that_is_misread_is_seen(monkeypatch):
    monkeypatch.setitem(feature.SIGNS, "<", feature.SIGNS["<="])
    with pytest.raises(DisagreementError):
        imported("int f(const int32_t *x) { return x[0] * 2 < 14; }")


def test_features_that_change_places_are_seen(monkeypatch):
    order = Inputs.features

    def swapped(self, used):
        places, names, count = order(self, used)
        return [1 - each for each in places], names, count

    monkeypatch.setattr(Inputs, "features", swapped)
    with pytest.raises(DisagreementError):
        imported("int f(float speed, float gap) { return speed > 1 && gap < 2; }")


def test_a_text_that_is_misread_is_seen(monkeypatch):
    plain = machine.Machine._plain
    monkeypatch.setattr(machine.Machine, "_plain", lambda self, value: plain(self, value).upper())
    with pytest.raises(DisagreementError):
        imported('const char *f(float x) { return x > 1 ? "go" : "stay"; }')


def test_observations_that_an_assertion_rules_out_are_not_asked():
    text = "#include <assert.h>\nint f(float total) { assert(total >= 4); if (total > 9) return 1; return 0; }"
    policy, _, facts = imported(text)
    assert facts["f replayed"] > 50 and policy.tree.threshold[0] == 9


def test_an_assertion_that_is_misread_is_seen(monkeypatch):
    read = kinds.literal
    text = "#include <assert.h>\nint f(float total) { assert(total >= 4); if (total > 9) return 1; return 0; }"
    for wrong, says in (("5", "leaves out an observation"), ("3", "an assertion fails that the reader does")):
        monkeypatch.setattr(kinds, "literal", lambda text, wrong=wrong: read(wrong if text == "4" else text))
        with pytest.raises(InputError, match=says):
            imported(text)


def test_numbers_that_overflow_are_not_asked():
    _, _, facts = imported("int f(int16_t v, int32_t w) { return v * 3 > 7 || w + 5 > 9; }")
    assert "overflow" in facts["f given"] and facts["f replayed"] > 50


def test_nobody_is_asked_where_nothing_may_be_run():
    _, origin, facts = imported("int f(float x) { return x > 2; }", run=False)
    assert origin.act is None and origin.second is None
    assert (facts["f replayed"], facts["f replayed by"]) == (0, NOT_COMPARED)


def test_nobody_is_asked_without_a_compiler(monkeypatch):
    monkeypatch.setenv("CC", "/no/compiler")
    _, _, facts = imported("int f(float x) { return x > 2; }")
    assert facts["f replayed by"] == NOT_COMPARED
    profile = profile_of(from_c(b"int f(float x) { return x > 2; }", "tree.c"), Names())
    (line,) = readers(profile)
    assert "f was read as its language means it (the reader of if/else C)" in line


def test_reports_trust_no_reader_that_was_compared():
    assert readers(profile_of(from_c(b"int f(float x) { return x > 2; }", "tree.c"), Names())) == []
