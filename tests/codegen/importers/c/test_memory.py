"""C that remembers: what comes in, beside the compiled program itself, and what a wrong reading would be."""

import ctypes
import random
import re
import subprocess

import numpy as np
import pytest

from codegen.agreement.compiled import find_compiler
from codegen.errors import DisagreementError, InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from codegen.importers.symbolic import memory
from codegen.ir import leaves
from maviper.team import Team
from tests.support.remembering import SOURCES, SUMMING

pytestmark = pytest.mark.compile
RANGES = {
    "heater": {"heating": (0, 1, 0)},
    "debounce": {"stable": (0, 1, 0), "count": (0, 49, 0)},
    "light": {"s_phase": (0, 2, 1), "s_green_for": (0, 30, 7), "s_waiting": (0, 59, 3)},
    "watchdog": {"silent": (0, 1000, 0)},
    "edge": {"before": (0, 1, 0), "presses": (0, 255, 250), "level": (0, 3, 1)},
}
LEAVES = {"heater": 4, "debounce": 6, "light": 8, "watchdog": 4, "edge": 24}


@pytest.mark.parametrize("name", SOURCES)
def test_what_remembers_acts_as_the_compiled_program_in_long_walks(name, tmp_path):
    profile = profile_of(from_c(SOURCES[name].encode(), "act.c"), Names())
    (policy,), team = profile.agents, Team.of(profile)
    assert {each.name: (each.low, each.high, each.initial) for each in policy.memory} == RANGES[name]
    assert len(leaves(policy.tree)) <= LEAVES[name]
    (tmp_path / "act.c").write_text(SOURCES[name])
    built = [*find_compiler(), "-O1", "-shared", "-fPIC", "act.c", "-o", "act.so"]
    subprocess.run(built, cwd=tmp_path, check=True)
    act, rng = ctypes.CDLL(str(tmp_path / "act.so")).act, random.Random(0)
    act.argtypes, act.restype = [ctypes.c_float], ctypes.c_ubyte if name in ("heater", "debounce") else ctypes.c_int
    x = 0.0
    for _ in range(20_000):
        if rng.random() < 0.02:
            x = float(np.float32(rng.choice([rng.uniform(-2, 25), 0.5, 19, 21, 0, 10, 11, 1])))
        assert team.act([x]) == act(x)


SUMMED_RANGES = {
    "pump": {"held": (0, 5, 0), "on": (0, 1, 0)},
    "timer": {"low": (0, 9, 0), "trips": (0, 3, 0)},
    "rising": {"n": (0, 5, 0)},
    "tank": {"mode": (0, 2, 0), "timer": (0, 4, 4), "alarm": (-2, 2, -2)},
}


@pytest.mark.parametrize("name", SUMMING)
def test_what_tests_sums_beside_memory_acts_as_the_compiled_program_in_long_walks(name, tmp_path):
    profile = profile_of(from_c(SUMMING[name].encode(), "act.c"), Names())
    (policy,), team, kind = profile.agents, Team.of(profile), ctypes.c_double if name == "pump" else ctypes.c_float
    assert {each.name: (each.low, each.high, each.initial) for each in policy.memory} == SUMMED_RANGES[name]
    assert policy.tree.sums and policy.numbers == ("float64" if name == "pump" else "float32")
    (tmp_path / "act.c").write_text(SUMMING[name])
    built = [*find_compiler(), "-O1", "-shared", "-fPIC", "act.c", "-o", "act.so"]
    subprocess.run(built, cwd=tmp_path, check=True)
    library, rng = ctypes.CDLL(str(tmp_path / "act.so")), random.Random(0)
    state, seen, taken = (ctypes.c_int * 3)(), [0.0, 0.0], set()
    if name == "tank":
        library.tank_init(state)
    else:
        library.act.argtypes = [kind, kind]
    for _ in range(20_000):
        if rng.random() < 0.3:  # near the ties of sums
            x = float(np.float32(rng.uniform(-4, 9)))
            seen = [
                x,
                float(np.float32(rng.choice([x - 1.6, x - 1.5, x - 0.5, 3 - x / 2, 12 - 2 * x, rng.uniform(-4, 9)]))),
            ]
        answer = library.act(state, (kind * 2)(*seen)) if name == "tank" else library.act(*seen)
        assert team.act(seen) == answer
        taken.add(answer)
    assert taken == {"pump": {0, 1}, "rising": {0, 1}, "timer": {0, 1, 2, 5, 6, 7}, "tank": {0, 1, 2}}[name]


WRITTEN = """#pragma STDC FP_CONTRACT OFF
typedef struct {{ float a, b; int level, cmd; }} io_t;
typedef struct {{ int cmd; }} out_t;
void act(const io_t *in, out_t *out) {{ out->cmd = in->a - in->b > 0.5f; }}
int level(io_t *io) {{ io->cmd = io->a - io->b > 0.5f{}; return io->cmd; }}
"""


def test_a_whole_number_that_is_set_only_makes_no_doubles_of_floats():
    """One that is observed, beside a member of the same struct that is set, does: float sums are none of doubles."""
    alone = WRITTEN.format("").replace("int level, cmd; } io_t", "} io_t").partition("int level(")[0]
    (policy,) = profile_of(from_c(alone.encode(), "act.c"), Names()).agents
    assert policy.numbers == "float32" and policy.tree.sums
    only_set = "typedef struct { int heat; } out_t;\nvoid act(float t, out_t *out) { out->heat = t < 18.5f; }"
    for source in (only_set, only_set.replace("out_t *", "int *").replace("out->heat", "*out")):
        (policy,) = profile_of(from_c(source.encode(), "act.c", Said(run=False)), Names()).agents
        assert policy.numbers == "float32"
    seen = WRITTEN.format(" && io->level > 70000").replace("void act", "static void act")
    with pytest.raises(InputError, match="given doubles, or whole numbers of more than 16 bits"):
        from_c(seen.encode(), "act.c", Said(run=False))


STRUCT = """typedef struct { int mode; int n; } state_t;
typedef struct { float level; float limit; } input_t;
void tank_init(state_t *s) { s->mode = 1; s->n = 2; }
int tank(state_t *s, const input_t *in) {
    if (in->level > 2.0f && in->limit > 1.0f) s->mode = 0;
    if (s->mode == 0 && s->n > 0) s->n--;
    if (s->n == 0) { s->mode = 1; s->n = 2; }
    return s->mode;
}"""


def test_a_struct_that_is_passed_in_and_out_begins_as_its_function_says():
    (policy,) = profile_of(from_c(STRUCT.encode(), "tank.c"), Names()).agents
    assert [each.name for each in policy.features] == ["level", "limit", "mode", "n"]
    assert [(each.low, each.high, each.initial) for each in policy.memory] == [(0, 1, 1), (1, 2, 2)]


SET_FIRST = """typedef struct { _Bool on; int starts; } state_t;
typedef enum { OFF, ON } act_t;
void heat_init(state_t *s) { s->on = 1; s->starts = 0; }
RESULT heat(state_t *s, float celsiusGIVEN) {
    if (celsius < 18.5f) { s->on = 1; ANSWER ON; RETURN }
    if (celsius > 21.5f) { s->on = 0; ANSWER OFF; RETURN }
    ANSWER s->on ? ON : OFF; RETURN
}"""


@pytest.mark.parametrize(
    ("result", "given", "answer", "end"), [("act_t", "", "return", ""), ("void", ", act_t *out", "*out =", "return;")]
)
def test_a_struct_may_be_set_before_the_first_path_that_reads_it(result, given, answer, end):
    written = {"RESULT": result, "GIVEN": given, "ANSWER": answer, "RETURN": end}
    source = re.sub("|".join(written), lambda found: written[found[0]], SET_FIRST)
    profile = profile_of(from_c(source.encode(), "heat.c"), Names())
    team = Team.of(profile)
    assert profile.agents[0].numbers == "float32"  # an int that nothing observes makes no doubles of floats
    assert [team.act([x]) for x in (20, 22, 20, 18, 20)] == [1, 0, 0, 1, 1]


def test_a_struct_that_is_only_set_is_no_memory():
    source = SET_FIRST.replace("s->on ? ON : OFF", "OFF").replace("RESULT", "int").replace("GIVEN", "")
    with pytest.raises(InputError, match="a part of s is not set on some path"):
        from_c(source.replace("ANSWER", "return").replace("RETURN", "").encode(), "heat.c")


@pytest.mark.parametrize(("name", "fault"), [("watchdog", "counts"), ("light", "begins"), ("heater", "keeps")])
def test_memory_that_is_misread_is_seen(name, fault, monkeypatch):
    if fault == "counts":
        added = memory._added
        monkeypatch.setattr(memory, "_added", lambda value: 2 * (added(value) or 0) or None)
    elif fault == "begins":
        post = memory.Memory.__post_init__

        def begin(self):
            self.initial = 8 if self.initial == 7 else self.initial
            post(self)

        monkeypatch.setattr(memory.Memory, "__post_init__", begin)
    else:
        monkeypatch.setattr(memory.Memories, "settle", lambda *_: ())
    with pytest.raises((DisagreementError, InputError), match=r"where its origin takes|counted without"):
        profile_of(from_c(SOURCES[name].encode(), "act.c"), Names())
