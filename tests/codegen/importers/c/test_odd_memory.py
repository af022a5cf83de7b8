"""C that remembers in odd ways: it comes in as the compiler runs it, call after call, or is refused with its line."""

import ctypes
import random
import re
import subprocess

import numpy as np
import pytest

from codegen.agreement.compiled import find_compiler
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from maviper.team import Team

pytestmark = pytest.mark.compile
ODD = {
    "address taken": """static void bump(int *p) { if (*p < 5) ++*p; else *p = 0; }
int act(float x) { static int n; if (x > 0) bump(&n); return n; }""",
    "alias local": """static int n;
int act(float x) { int *p = &n; if (x > 0) *p = 3 - *p; return n; }""",
    "recursion": """int act(float x) { static int n; if (n < 3) { n++; return act(x); }
    if (x > 0) n = 0; return n; }""",
    "two helpers same static": """static int edge(float x) { static int was; int e = x > 0 && !was;
    was = x > 0; return e; }
int act(float x) { return edge(x) + 2 * edge(x - 1); }""",
    "wraps": """#include <stdint.h>
int act(float x) { static uint8_t n = 250; if (x > 0) n++; return n > 200; }""",
    "wraps signed char": """#include <stdint.h>
int act(float x) { static int8_t n = 120; if (x > 0) n++; return n > 0; }""",
    "wraps down": """#include <stdint.h>
int act(float x) { static uint8_t n = 3; if (x > 0) n--; return n > 100; }""",
    "bool counts": """#include <stdbool.h>
int act(float x) { static bool b; if (x > 0) b++; if (x < -1) b--; return b; }""",
    "fallthrough": """int act(float x) { static int s; switch (s) { case 0: if (x > 0) s = 1;
    case 1: if (x > 1) s = 2; break; case 2: s = x < 0 ? 0 : 2; default: ; } return s; }""",
    "comma": """int act(float x) { static int a, b;
    return (x > 0 ? (a = 1, b = a + 1) : (b = 0, a = b)), a * 10 + b; }""",
    "post in index": """static const int t[4] = {7, 5, 3, 1};
int act(float x) { static int i; return t[i++ & 3] + (i > 100 ? (i = 0) : 0) + (x > 0); }""",
    "array": """int act(float x) { static int h[3]; h[2] = h[1]; h[1] = h[0]; h[0] = x > 0;
    return h[0] + 2 * h[1] + 4 * h[2]; }""",
    "enum wrap": """enum e { A, B, C }; int act(float x) { static enum e s = C;
    if (x > 0) s = (enum e)((s + 1) % 3); return s; }""",
    "struct copy": """typedef struct { int a, b; } s_t; static s_t now = {1, 2};
int act(float x) { s_t was = now; if (x > 0) { now.a = was.b; now.b = was.a; }
    return was.a * 10 + now.a; }""",
    "sizeof": """int act(float x) { static int n; (void)sizeof(n++); if (x > 0) n ^= 1; return n; }""",
    "negative mod": """int act(float x) { static int n = -3; n = (n - 2) % 5; return x > 0 ? n : 9; }""",
    "divides": """int act(float x) { static int n = 64; if (x > 0) n /= 2; if (n == 0) n = 64; return n; }""",
    "early return": """int act(float x) { static int n; if (x > 2) return 9; n = n < 3 ? n + 1 : 0;
    if (x > 0) return n; n = 0; return 7; }""",
    "short circuit": """int act(float x) { static int n;
    return x > 0 && n++ < 3 ? 1 : (n > 5 ? (n = 0) : 2); }""",
    "ternary lvalue": """static int a, b; int act(float x) { *(x > 0 ? &a : &b) ^= 1; return a * 2 + b; }""",
    "loop counts": """int act(float x) { static int n; for (int i = 0; i < 3; i++) if (x > i) n++;
    n %= 5; return n; }""",
    "unsigned compare": """int act(float x) { static int n = 0; if (x > 0 && n > -3) n--;
    if (n < -1u) return 1; return 0; }""",
    "big ok": """int act(float x) { static int n = 16777215; if (x > 0 && n < 16777216) n++;
    if (x < 0) n = 16777215; return n == 16777216; }""",
    "extern": """extern int n; int act(float x) { if (x > 0) n = 1; return n; } int n = 2;""",
    "thread": """static _Thread_local int n; int act(float x) { if (x > 0) n = 1; return n; }""",
    "narrow int8": """#include <stdint.h>
int act(float x) { static int8_t n; if (x > 0) n = 200; if (x < -1) n = 0; return n; }""",
    "cast of feature": """int act(float x) { static int n; if (x > 0 && x < 4) n = (int)x; return n; }""",
    "two statics of one name": """static int helper(float x) { static int n; if (x > 0) n = 1; return n; }
int act(float x) { static int n = 3; if (helper(x)) n = 3 - n; return n; }""",
    "names that meet": """static int h[2], h_1;
int act(float x) { h_1 = h[1]; h[1] = h[0]; h[0] = x > 0; return h_1 * 4 + h[1] * 2 + h[0]; }""",
    "chain": """static int a(float x) { static int n; n = x > 0 ? (n + 1) % 3 : n; return n; }
static int b(float x) { static int n = 2; if (a(x) == 2) n = 2 - n; return n; }
int act(float x) { static int n; n = a(x - 1) + b(x); return n; }""",
    "member like var": """struct s { int n; }; int act(float x) { static int n = 1;
    static struct s s = {4}; if (x > 0) { n = s.n; s.n = 5 - s.n; } return n; }""",
    "init in loop": """int act(float x) { static int n; int k; for (k = 0; k < 4; k++) {
    static int m = 1; if (x > k) m = 3 - m; n = m; } return n; }""",
    "logic order": """static int n; static int t(void) { n = (n + 1) % 4; return n; }
    int act(float x) { return (x > 0 && t() > 1) || (x < 0 && t() > 2); }""",
    "same pointer twice": """static void mix(int *a, int *b) { *a = 1; *b = 2; *a = *a + *b; }
    int act(float x) { static int a; if (x > 0) mix(&a, &a); if (x < 0) a = 0; return a; }""",
    "struct in struct": """typedef struct { struct { int on, n; } m[2]; } s_t; static s_t s;
    int act(float x) { int k = x > 2; if (x > 0) { s.m[k].on = !s.m[k].on;
    s.m[1 - k].n = (s.m[1 - k].n + 1) % 3; } return s.m[0].on + 2 * s.m[1].on + 4 * s.m[0].n + 16 * s.m[1].n; }""",
}
REFUSED = {
    "the variable n is kept or constant": """static int n = 2; static int *const p = &n;
int act(float x) { if (x > 0 && *p < 4) (*p)++; return n; }""",
    "a feature is returned, not an action": """static int tick(void) { static int n;
    n = n == 4 ? 0 : n + 1; return n; }
int act(float x) { int a = tick(); if (x > 0) a = a * 10 + tick(); return a; }""",
    "the name n is not known": """static volatile int n; int act(float x) { if (x > 0) n = 1;
    else if (x < -1) n = 0; return n; }""",
    "a member has bits or no name": """struct s { unsigned a : 2; int b : 3; }; static struct s st;
int act(float x) { if (x > 0) st.a++; if (x > 1) st.b++; return st.a * 10 + st.b; }""",
    "holds nothing on some path": """int act(float x) { int n; static int m; if (x > 0) n = m; m = !m;
    return n; }""",
    "what is written is not read: again": """int act(float x) { static int n;
    again: if (n < 3 && x > 0) { n++; goto again; } if (x < 0) n = 0; return n; }""",
    "a case stands within another statement": """int act(float x) { static int s, n; switch (s) {
    case 0: do { n++; case 1: n++; } while (n < 3); } s = x > 0; if (n > 4) n = 0; return n; }""",
    "there is no such item": """int act(float x) { static int h[3], i; h[i] = x > 0;
    i = i == 2 ? 0 : i + 1; return h[0] + 2 * h[1] + 4 * h[2]; }""",
    "the name u is not known": """static union { int i; unsigned char c[4]; } u; int act(float x) {
    u.c[0] = x > 0; return u.i; }""",
    "the function memset is not read": """#include <string.h>
static struct { int a, b; } s; int act(float x) { if (x > 0 && s.a < 3) s.a++;
    if (x < 0) memset(&s, 0, sizeof s); return s.a; }""",
    "deeper than 64 splits": """#include <stdint.h>
int act(float x) { static uint8_t h; h = (uint8_t)((h << 1) | (x > 0)); return (h & 7) == 7; }""",
    "no whole number: f": """int act(float x) { static float f; f = x; return f > 0; }""",
    "no whole number: n": """int act(float x) { static double n; if (x > 0 && n < 5) n += 1;
    return n > 3; }""",
    "the function f is not read": """static int f0(float x) { return x > 0; } static int f1(float x) {
    return x > 1; } static int (*f)(float) = f0;
int act(float x) { int r = f(x); f = r ? f1 : f0; return r; }""",
    "the static variable n keeps what": """static int n = 1;
int act(float x) { int r = n; { static int n = 5; if (x > 0) n = 11 - n; r += n; } n = r & 1; return r; }""",
    "the static variable n hides another name": """enum { n = 7 };
int act(float x) { int r = n; { static int n = 5; if (x > 0) n = 11 - n; r += n; } return r; }""",
    "n keeps what earlier decisions set": """int act(float x) {
    if (x > 1) { static int n; n = !n; return n; }
    static int n = 4; n = 9 - n; return n; }""",
}


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """All of them in one library, each under its number, as nobody rewrote them."""
    folder = tmp_path_factory.mktemp("odd")
    for number, text in enumerate(ODD.values()):
        (folder / f"odd_{number}.c").write_text(f"#define act act_{number}\n{text}\n")
    files = [f"odd_{number}.c" for number in range(len(ODD))]
    subprocess.run([*find_compiler(), "-O1", "-w", "-shared", "-fPIC", *files, "-o", "odd.so"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "odd.so"))


@pytest.mark.parametrize("name", ODD)
def test_what_is_odd_comes_in_as_the_compiler_runs_it(name, compiled):
    """The compiler reads the text itself: the reader's own comparison compiles what statics were moved in."""
    act, rng = getattr(compiled, f"act_{[*ODD].index(name)}"), random.Random(0)
    act.argtypes, act.restype = [ctypes.c_float], ctypes.c_int
    team = Team.of(profile_of(from_c(ODD[name].encode(), "act.c", Said(run=False)), Names()))
    for _ in range(1_500):
        x = float(np.float32(rng.choice([0, 1, 2, 3, -1, 0.5, -0.5, -2, 5, np.inf, rng.uniform(-3, 6)])))
        assert team.act([x]) == act(x)


@pytest.mark.parametrize("said", REFUSED)
def test_what_is_not_followed_is_refused_with_its_line(said):
    with pytest.raises(InputError, match=said) as caught:
        profile_of(from_c(REFUSED[said].encode(), "act.c", Said(run=False)), Names())
    assert re.search(r"line \d", str(caught.value))


@pytest.mark.parametrize(
    ("const", "told"), [("const ", "a copy of memory is not read"), ("", "nothing that is read sets gap")]
)
def test_a_member_whose_address_alone_is_taken_is_no_memory(const, told):
    """It was taken as remembered, so every other path was left out."""
    text = f"""#include <stdint.h>
#include <string.h>
typedef struct {{ double slope; uint8_t gap; }} in_t;
int policy({const}in_t *obs)
{{
    double v;
    if (obs->gap < 128) return 0;
    memcpy(&v, &obs->gap, sizeof obs->gap);
    return v > 1;
}}
"""
    with pytest.raises(InputError, match=told):
        from_c(text.encode(), "policy.c")
