"""The header where arithmetic is another: on x87, which keeps more digits than double has, and in threads that take
subnormal numbers for zero.
"""

import ctypes
import itertools
import math
import platform
import shutil
import stat
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import selfcheck
from codegen.agreement.compiled import STRICT, CompiledC, build, find_compiler
from codegen.boxes import is_inside
from codegen.floats import below_zero
from codegen.numbers import neighbour
from codegen.observe import observe
from codegen.targets.rendered import harness
from codegen.world import RegionSpec
from tests.support.games import random_profile

LARGEST = float(np.finfo(np.float32).max)
THRESHOLDS = [-0.75, 2.0**-149, 0.5 + 2.0**-24, 0.75, LARGEST]  # significands odd and even, the ends of the format
BORDER = 0.75  # of the region
OFFSETS = [0.0, 2.0**-60, 2.0**-20, 0.5 - 2.0**-52, 0.5, 0.5 + 2.0**-52, 0.5 + 2.0**-30, 0.5 + 2.0**-12, 1.0, 1.5]
SUM = ((1, "agent_0.x"), (-1, "landmark_0.x"), (1, "agent_0.vx"))
MEANINGS = (ir.Meaning(SUM[:2]), ir.Meaning(SUM), ir.Meaning(SUM, "sign"))
C, CXX = "gcc {} -fPIC -shared -Werror -o policy.so harness.c", "g++ {} -fPIC -shared -Werror -o policy.so wrapped.cpp"
WRAPPED = 'extern "C" {\n#include "harness.c"\n}\n'
COMPILERS = [
    *(C.format(f"-std={standard} {level} -mfpmath=387") for standard in ("c99", "gnu99") for level in ("-O0", "-O3")),
    C.format("-std=gnu99 -O2 -mfpmath=both"),
    *(CXX.format(f"-std=c++17 {level} -mfpmath=387") for level in ("-O0", "-O2")),
]


@pytest.fixture(scope="module")
def team():
    """One agent for each meaning, its tree a ladder of the thresholds, and a region that bounds a difference."""
    profile, ladder = random_profile("physical-deception,velocity=1"), _ladder(THRESHOLDS)
    agents = tuple(
        replace(policy, features=(replace(policy.features[0], name="f", meaning=meaning),), tree=ladder, grown=None)
        for policy, meaning in zip(profile.agents, MEANINGS, strict=True)
    )
    region = RegionSpec(profile.world.goals, {}, {"agent_0.x - landmark_0.x": (f"-{BORDER}", f"{BORDER}")})
    return replace(profile, agents=agents, region=region)


def _ladder(thresholds):
    n = len(thresholds)
    rows = [(0, threshold, 2 * k + 1, 2 * k + 2, -1) for k, threshold in enumerate(thresholds)]
    leaves = [(-1, 0.0, -1, -1, k % 5) for k in range(n + 1)]
    nodes = [item for pair in zip(rows, leaves, strict=False) for item in pair] + leaves[n:]
    return ir.Tree(*np.array(nodes).T)


@np.errstate(over="ignore")
def _worlds(team):
    """Offsets whose sums lie at and beside the places where a float or a double rounds up instead of down."""
    rows = []
    for threshold in THRESHOLDS:
        for side in (-1, 1):
            beside = float(neighbour(threshold, side * math.inf))
            turns = [(threshold + (beside if math.isfinite(beside) else 2.0**128)) / 2]
            for turn in [*turns, *([BORDER, math.nextafter(BORDER, 0)] if abs(threshold) == BORDER else [])]:
                signed = [sign * offset * math.ulp(turn) for offset in OFFSETS for sign in (-1, 1)]
                for base, less, more in itertools.product((math.ulp(turn), 0.0), signed, signed):
                    rows += [(turn + base, less, more), (turn, -base - less, more)]
    rng = np.random.default_rng(0)
    wild = np.ldexp(rng.uniform(-2, 2, (10_000, 3)), rng.integers(-1074, 1024, (10_000, 3)))
    close = wild[:, :1] * np.ldexp(rng.uniform(-2, 2, (10_000, 3)), rng.integers(-70, 1, (10_000, 3)))
    huge = np.finfo(float).max
    ends = [(huge, -(2.0**970) * (1 - 2.0**-k), -huge) for k in range(1, 54)]
    given = np.concatenate([np.array(rows + ends), wild, np.nan_to_num(close)])
    given = np.concatenate([given, -given, given[:, [1, 0, 2]]])
    cancelled = given.copy()
    cancelled[:, 2] = -np.nan_to_num(given[:, 0] - given[:, 1])
    worlds = np.zeros((2 * len(given), len(team.world.coordinates())))
    for column, (_, name) in zip(np.concatenate([given, cancelled]).T, SUM, strict=True):
        worlds[:, team.world.coordinates().index(name)] = column
    return worlds


def _library(command, made, folder):
    """The header as a library, by this command; its compiler is a script, since others than C need a file around."""
    tool = command.split()[0]
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed")
    script = folder / "compiler"
    script.write_text(f"#!/bin/sh\ncat > wrapped.cpp <<'end'\n{WRAPPED}end\n{command}\n")
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    return CompiledC(made.text("h"), made.model, [str(script)])


@pytest.mark.compile
@pytest.mark.parametrize("command", COMPILERS)
def test_wider_arithmetic_decides_from_world_states_as_the_reference(command, team, tmp_path):
    worlds = _worlds(team)
    made = build(team, ["c"])
    with _library(command, made, tmp_path) as library, np.errstate(over="ignore", invalid="ignore"):
        acted, within = library.team(worlds), library.region(worlds)
        for policy, actions in zip(team.agents, acted.T, strict=True):
            wanted = ir.act(policy, observe(policy.features, worlds, team.world, policy.numbers))
            wrong = np.flatnonzero(actions != wanted)
            assert not wrong.size, (policy.agent, len(wrong), worlds[wrong[0]].tolist())
        held = is_inside(team.region, worlds, team.world.coordinates())
    assert set(np.unique(held)) == {False, True} and not (within != held).any()


@pytest.mark.compile
def test_the_check_of_generated_code_passes_with_wider_arithmetic(monkeypatch):
    monkeypatch.setenv("CC", "gcc -mfpmath=387")
    with build(random_profile("predator-prey"), ["c"]) as made:
        selfcheck.check(made, random=1_000).ensure()


FLUSHING = """
#include <xmmintrin.h>
void %(name)s(const float *rows, long n, int *actions, int *checks);
void flushed(const float *rows, long n, int *actions, int *checks);
void flushed(const float *rows, long n, int *actions, int *checks)
{
    const unsigned int kept = _mm_getcsr();
    _mm_setcsr(kept | 0x8040u);
    %(name)s(rows, n, actions, checks);
    _mm_setcsr(kept);
}
"""


FLUSHES = pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="sets the MXCSR of x86-64")


BITS = np.array([0, 1, 2, 3, 2**22, 2**23 - 1, 2**23, 2**23 + 1], dtype=np.uint32)
SUBNORMAL = [-(2.0**-149), 0.0, 2.0**-149, 2.0**-127, 2.0**-126], np.concatenate([BITS, BITS | 2**31]).view(np.float32)
NUMBERS = np.array([0.0, -0.0, 2.0**-126, -(2.0**-126), 0.5, -0.5, 1.0, np.inf, -np.inf, np.nan], dtype=np.float32)
BELOW = [below_zero("float32"), 0.0, 0.5], NUMBERS


@pytest.mark.compile
@FLUSHES
@pytest.mark.parametrize(
    ("asked", "style", "holds"),
    [(SUBNORMAL, "nested", False), (SUBNORMAL, "walk", False), (SUBNORMAL, "ordered", True),
     (BELOW, "nested", True), (BELOW, "walk", False)],
)  # fmt: skip
def test_what_decides_alike_where_subnormals_are_flushed(asked, style, holds, team, tmp_path):
    """The style `ordered`. And nested code says x < 0: compared with the last number below 0, which is flushed to it, a
    0 would go left.
    """
    thresholds, rows = asked
    policy = replace(team.agents[0], tree=_ladder(thresholds))
    flushed = _flushed(replace(team, agents=(policy,)), style, rows, tmp_path)
    assert (flushed == ir.act(policy, rows[:, None])).all() == holds


def _flushed(profile, style, rows, tmp_path):
    """The actions of the one agent of a profile in a thread that takes subnormal numbers for zero."""
    made = build(profile, ["c"], style=style)
    for name, text in {**made.files, "harness.c": harness(made.model, "c")}.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "flushed.c").write_text(FLUSHING % {"name": made.model.agents[0].names.exported_rows})
    command = [*find_compiler(), *STRICT, "-O2", "-fPIC", "-shared", "harness.c", "flushed.c", "-o", "flushed.so"]
    subprocess.run(command, cwd=tmp_path, check=True)
    actions, checks = np.zeros((2, len(rows)), dtype=np.int32)
    given = [array.ctypes.data_as(ctypes.c_void_p) for array in (rows, actions, checks)]
    ctypes.CDLL(str(tmp_path / "flushed.so")).flushed(given[0], ctypes.c_long(len(rows)), *given[1:])
    return actions
