"""Whole numbers of their declared width: each file decides after its import as a compiler's program, or is refused."""

import ctypes
import subprocess

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from tests.codegen.importers.origins import decided
from tests.support.c_source import COMPILER, compiled

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler")
TYPES = {
    "int8_t": ctypes.c_int8, "uint8_t": ctypes.c_uint8, "int16_t": ctypes.c_int16, "uint16_t": ctypes.c_uint16,
    "int32_t": ctypes.c_int32, "uint32_t": ctypes.c_uint32,
}  # fmt: skip
CODES = "static const uint32_t codes[] = {7, 100000001u, 100000003u, 4294967295u};\n"
CODED = "for (int i = 0; i < 4; i++) if (codes[i] == t) return i; return -1;"
BODIES = [  # type of the feature t, and the body
    ("int32_t", "if (t == 100000001) return 1; return 0;"),
    ("int32_t", "return t != 100000001;"),
    ("int32_t", "if (t >= 100000001 && t <= 100000003) return 1; return 0;"),
    ("int32_t", "switch (t) { case 100000001: return 1; case -100000003: return 2; } return 0;"),
    ("int32_t", "if (t < 5) return 0; if (t == 100000001) return 1; return t > 9 ? 2 : 3;"),
    ("int32_t", "return t > 2147483646 ? 1 : t < -2147483647 ? 2 : 0;"),
    ("uint32_t", CODED),
    ("uint32_t", "return t == 4294967295u;"),
    ("uint32_t", "return (t >> 8) == 390625u;"),
    ("uint32_t", "return t / 3 > 100000001u;"),
    ("int16_t", "return (t & 0x0100) != 0;"),
    ("uint16_t", "return (t & 0x0300) == 0x0100 ? (t >> 12) : 20;"),
    ("int16_t", "return (uint8_t)t > 100;"),
    ("uint8_t", "return (int8_t)t;"),
    ("uint8_t", "return (int8_t)t < -5 ? (t >> 3) & 3 : ~t + 20 > 0;"),
    ("int8_t", "return t % 5;"),
    ("uint8_t", "return (t ^ 0x55) > 100 ? (t | 3) == 7 : (t & 6) == 4;"),
    ("uint8_t", "uint8_t v = t + 200; return v < 100 ? v > 20 : 7;"),
    ("uint8_t", "uint8_t v = t; v <<= 2; v -= 8; return v > 100;"),
    ("uint8_t", "return (uint16_t)(t << 4 | t >> 4) > 3000;"),
    ("uint8_t", "return t - 10 > 5 ? 1 : -t < -3 ? 2 : 3;"),
    ("int8_t", "return -t > 100 ? 1 : t * t > 144;"),
]  # fmt: skip


def asked(kind, text):
    """Whole numbers of a type: those of the text with their neighbours, the ends, and all where they are few."""
    info = np.iinfo(kind.removesuffix("_t"))
    near = [
        sign * int(each, 0)
        for each in np.unique(np.char.strip(text.replace("u", " ").split(), ";{},)("))
        if each.lstrip("-").isdigit()
        for sign in (1, -1)
    ]
    few = range(int(info.min), int(info.max) + 1) if info.bits <= 8 else range(0)
    wide = [int(each) for each in np.random.default_rng(0).integers(info.min, info.max, 400)]
    near += [100000001, 100000001 << 8, 300000003, 390625 << 8, info.min, info.max, 0]
    return sorted(
        {min(max(each + by, int(info.min)), int(info.max)) for each in (*near, *few, *wide) for by in (-1, 0, 1)}
    )


@needs_compiler
@pytest.mark.compile
def test_whole_numbers_decide_as_compiled(tmp_path):
    texts = [
        f"#include <stdint.h>\n{CODES}int act_{at}({kind} t) {{ {body} }}\n" for at, (kind, body) in enumerate(BODIES)
    ]
    (tmp_path / "all.c").write_text(
        "#include <stdint.h>\n" + CODES + "".join(each.split("\n")[2] + "\n" for each in texts)
    )
    library = tmp_path / "all.so"
    subprocess.run([COMPILER, "-O2", "-shared", "-fPIC", "-o", library, tmp_path / "all.c"], check=True)
    loaded = ctypes.CDLL(str(library))
    for at, (kind, body) in enumerate(BODIES):
        (origin,) = from_c(texts[at].encode(), "tree.c").values()
        wide = np.iinfo(kind.removesuffix("_t")).bits == 32
        assert origin.numbers == ("float64" if wide else "float32"), body
        values = asked(kind, body)
        policy = profile_of({"f": origin}, Names()).agents[0]
        function = loaded[f"act_{at}"]
        function.argtypes = [TYPES[kind]]
        rows = np.array(values, dtype=origin.numbers)[:, None]
        assert decided({"f": origin}, policy, rows) == [function(each) for each in values], body


SEVERAL = [
    "int act(const int32_t *x) { return x[0] > x[1]; }",
    "int act(const uint8_t *x) { return x[0] - x[1] > 5; }",
    "int act(const int16_t *x) { return x[0] * 2 - x[1] + 7 > 5 || x[0] == x[1]; }",
    "int act(const uint32_t *x) { return x[0] >= x[1]; }",
]


@needs_compiler
@pytest.mark.compile
@pytest.mark.parametrize("text", SEVERAL)
def test_several_whole_numbers_decide_as_compiled(text, tmp_path):
    text = f"#include <stdint.h>\n{text}\n"
    (origin,) = from_c(text.encode(), "tree.c").values()
    policy = profile_of({"f": origin}, Names()).agents[0]
    kind = text.split("const ")[1].split("_t")[0]
    info, rng = np.iinfo(kind), np.random.default_rng(0)
    rows = np.concatenate([rng.integers(info.min, info.max, (400, 2)), rng.integers(0, 30, (400, 2))])
    rows = np.concatenate([rows, np.stack([rows[:, 0], np.clip(rows[:, 0] + 1, info.min, info.max)], axis=1)])
    given, function = np.ascontiguousarray(rows, dtype=kind), compiled(text, tmp_path).act
    said = [function(ctypes.c_void_p(row.ctypes.data)) for row in given]
    assert decided({"f": origin}, policy, rows.astype(origin.numbers)) == said


@pytest.mark.parametrize("kind", ["int64_t", "uint64_t", "long", "unsigned long", "size_t", "long long"])
def test_numbers_of_64_bits_are_refused_where_a_decision_reads_them(kind):
    text = f"#include <stdint.h>\n\nstruct s {{ {kind} at; unsigned char on; }};\nint f(const struct s *o)\n"
    with pytest.raises(InputError, match="large numbers are no float64") as caught:
        from_c(f"{text}{{ return o->at > 3; }}".encode(), "tree.c")
    assert "line 5" in caught.value.where and "int32_t" in caught.value.next_step
    assert from_c(f"{text}{{ {kind} big = 3; return o->on > big; }}".encode(), "tree.c")


def test_an_assertion_limits_what_is_taken():
    text = b"""#include <assert.h>
    int f(int used, int total) { assert(total >= 4 && used >= 0); return used * 4 > total; }"""
    (origin,) = from_c(text, "tree.c").values()
    rows = np.array([[1.0, 4.0], [2.0, 4.0], [5.0, 3.0], [-1.0, 9.0], [1e9, 9.0], [np.nan, 9.0]])
    assert origin.takes is not None and origin.takes(rows).tolist() == [True, True, False, False, False, False]
    assert "observations for which its assertions hold" in origin.given and "do not overflow" in origin.given
    profile = profile_of({"f": origin}, Names())
    assert ir.act(profile.agents[0], rows[:2]).tolist() == [0, 1]
    assert origin.grown.threshold[origin.grown.feature >= 0].min() > -1  # no split of what is ruled out
    with pytest.raises(InputError, match="every observation is ruled out"):
        from_c(b"int f(int x) { assert(x > 3 && x < 2); return 1; }", "tree.c")
