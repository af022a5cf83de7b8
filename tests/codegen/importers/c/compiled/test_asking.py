"""C files that the compiler is asked about: what the reader misreads is refused, and what it reads is compared."""

import numpy as np
import pytest

from codegen import ir
from codegen.agreement.compiled import find_compiler
from codegen.errors import DisagreementError, InputError
from codegen.importers import replay
from codegen.importers.c import kinds, machine
from codegen.importers.c.compiled.builds import COMPILED_BY
from codegen.importers.c.inputs import Inputs
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, Said, profile_of
from codegen.importers.reading import NOT_COMPARED
from codegen.importers.symbolic import feature
from tests.codegen.importers.origins import label_of
from verify.reports.telling import readers

pytestmark = [pytest.mark.compile, pytest.mark.skipif(find_compiler() is None, reason="no C compiler")]
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
    "a sum": "float f(const float *x) { return x[0] - x[1] > 1 ? x[0] + x[1] : 0; }",
    "a macro": "#define LOW (-3)\n#define TWICE(n) ((n) * 2)\n"
    "int f(const int16_t *x) { return x[0] > TWICE(LOW) ? LOW : 1; }",
    "names of the C library": "/* of the library */ float round(float y0) { return y0; }"
    "int f(float index) { return round(index) > 1; }",
    "a table of functions": "static int one(float v) { return v > 1; } static int two(float v) { return v > 2; }"
    "static int (*const t[2])(float) = {one, two}; int f(float v) { return t[1](v) + t[0](v); }",
}


def test_what_no_decision_needs_is_left_out():
    text = '#include "servo.h"\nstatic Servo arm; void setup(void) { attach(arm, 9); }'
    _, _, facts = imported(text + "\nint f(float x) { return x > 2; }")
    assert "read without servo.h" in facts["f notes"] and facts["f replayed"] > 50


def test_several_functions_of_a_file_are_compared():
    text = "#define N 3\nstatic int high(float v) { return v > N; } int up(float v) { return high(v); }"
    origins = from_c((text + "int down(int v) { return v < -N; }").encode(), "tree.c")
    facts = profile_of(origins, Names()).provenance.training
    assert facts["up replayed by"] == facts["down replayed by"] == COMPILED_BY


@pytest.mark.parametrize("name", BODIES)
def test_what_is_read_is_what_is_compiled(name):
    _, _, facts = imported(BODIES[name])
    assert facts["f replayed by"] == COMPILED_BY and facts["f replayed"] > 50


def test_scores_are_compared_by_the_largest():
    text = "void f(const double *x, double *out) { out[0] = x[0] > 1 ? 0.2 : 0.8; out[1] = 0.5; }"
    _, _, facts = imported(text, scores=True)
    assert facts["f replayed by"] == COMPILED_BY


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
