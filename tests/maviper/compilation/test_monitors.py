"""Monitors: they vouch for a state in the region of a proof, in all languages alike, and for nothing else."""

import ctypes
import json
import math
import platform
import subprocess

import numpy as np
import pytest

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.errors import InputError, RefusedError
from codegen.lowering.covering import Cover
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch
from codegen.targets import emit, rendered
from codegen.world import RegionSpec
from maviper import load
from maviper.compilation.compile import compile_and_prove, split_targets
from maviper.compilation.monitors import load_proof, lower_monitor
from tests.benchmarks import monitor as benchmark
from tests.support import monitors
from tests.support.altered import sealed
from tests.support.generated import FOLDER
from tests.support.monitors import INVALID, LEAVING, OK, OUTSIDE, Twin, drawn, files, inside, module_of
from tests.support.small import small_profile
from tests.support.tiers import first_of

GENERATED = FOLDER.parent
VERDICTS = GENERATED / "verdicts"
PROVED = VERDICTS / "physical_deception" / "certificate-1-distinct_targets.json"
BOX = {f"{name}.{axis}": ("-1", "1") for name in ("adversary_0", "agent_0", "agent_1", "landmark_0", "landmark_1")
       for axis in "xy"}  # fmt: skip
SPEC = RegionSpec(
    ("landmark_0", "landmark_1"),
    BOX | {"agent_0.x": ("-1/3", "0.7")},
    {"agent_0.y - agent_1.y": ("-0.9", "1/7")},
    {"agent_0 - agent_1": "0.1"},
)


def asked(profile, spec, count, seed):
    """States around a region and its border, measurements that fail, steps that are late: w, fresh, dt, start."""
    rng = np.random.default_rng(seed)
    w, _ = drawn(profile, spec, count, rng)
    odd = rng.random(w.shape) < 0.002
    w[odd] = rng.choice([np.nan, np.inf, -np.inf, 1e12], odd.sum())
    fresh = (rng.random(w.shape) > 0.02).astype(np.int32)
    dt = rng.choice([profile.world.dt, 0.0, 1.4 * profile.world.dt, np.nan, -0.1, 9.0], count, p=[0.95, *[0.01] * 5])
    return w, fresh, dt, (rng.random(count) < 0.4).astype(np.int32)


@pytest.mark.compile
def test_all_languages_say_what_the_region_says(tmp_path):
    profile = small_profile()
    _, watched = files(profile, SPEC)
    rows = asked(profile, SPEC, 3_000, 7)
    wanted = Twin(profile, SPEC, watched).said(rows)
    names = profile.world.coordinates()  # exactly: bounds are rounded inward
    assert all(inside(SPEC, names, w) for w, word in zip(rows[0], wanted, strict=True) if word in (OK, LEAVING))
    assert {OK, LEAVING, OUTSIDE, INVALID} == set(wanted) and wanted.count(OK) > 100
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path)


def made(profile, certificate):
    """The module of a monitor."""
    found = load_proof(certificate, profile)
    watched = watch(profile, lower(profile), found.region, found.certificate, found.claim)
    return module_of(watched)


@pytest.fixture(scope="module")
def proved():
    """A committed profile, and the monitor of a proof about it."""
    profile = load(PROVED.parent / "profile.json")
    return profile, made(profile, PROVED)


def ready(space, profile):
    """A monitor that has said OK, and the state of which it did."""
    found, w = space["Monitor"](), [0.0] * len(profile.world.coordinates())
    found.renew_all()
    assert found.step(w, 0.1) == OK
    return found, w


FAULTS = {
    "shape": lambda found, w: found.step(w[:-1], 0.1),
    "not a number": lambda found, w: found.step([math.nan, *w[1:]], 0.1),
    "infinite": lambda found, w: found.step([math.inf, *w[1:]], 0.1),
    "number": lambda found, w: found.step([None, *w[1:]], 0.1),
    "late": lambda found, w: found.step(w, 0.2),
    "range": lambda found, w: found.step([1e10, *w[1:]], 0.1),
    "text": lambda found, w: found.step([*map(str, w)], 0.1),
    "interval": lambda found, w: found.step(w, "0.1"),
    "output": lambda found, w: word_after(found, 5),
    "half": lambda found, w: word_after(found, 2.5),
    "no action": lambda found, w: word_after(found, None),
}


def word_after(found, action):
    assert found.act("agent_0", action) == 0
    return found.word


def fail_by_age(found, w):
    assert found.step(w, 0.1) == OK  # a step without news is allowed, two are not
    return found.step(w, 0.1)


def fail_by_agent(found, w):
    with pytest.raises(KeyError):
        found.act("nobody", 0)
    return found.word


@pytest.mark.parametrize("fault", [*FAULTS, "age", "agent"])
def test_a_fault_leaves_the_mode_for_good(fault, proved):
    """PX4's list for networks that fly: shape, validity, age, finiteness, output range; and then the fallback."""
    profile, space = proved
    found, w = ready(space, profile)
    assert found.act("agent_0", 3) == 3
    if fault != "age":
        found.renew_all()
    assert ({"age": fail_by_age, "agent": fail_by_agent} | FAULTS)[fault](found, w) == INVALID
    found.renew_all()
    assert found.step(w, 0.1) == INVALID and found.act("agent_0", 3) == space["FALLBACK"]["agent_0"]
    found.start()
    found.renew_all()
    assert found.step(w, 0.1) == OK and found.act("agent_0", 3) == 3


def test_a_state_outside_stays_outside_and_one_that_leaves_is_told_before(proved):
    profile, space = proved
    names = profile.world.coordinates()
    found, w = ready(space, profile)
    place, speed = names.index("agent_0.x"), names.index("agent_0.vx")
    w[place], w[speed], said = 0.7, 1.0, []
    for _ in range(5):
        found.renew_all()
        said.append(int(found.step(w, 0.1)))
        w[place] += 0.1 * w[speed]
    assert said == [OK, OK, OK, LEAVING, OUTSIDE]  # at 0.7, 0.8, 0.9, 1 and 1.1
    w[place] = 0.0
    found.renew_all()
    assert found.step(w, 0.1) == OUTSIDE


def test_hashes_and_claim_are_in_the_code(proved):
    _, space = proved
    stated = json.loads(PROVED.read_text())
    assert space["CERTIFICATE"] == stated["content_hash"] and space["PROFILE"] == stated["profile"]


@pytest.mark.parametrize(
    ("folder", "certificate", "said"),
    [
        ("physical_deception", "cooperative_navigation/certificate-1-distinct_targets.json", "profile"),
        ("physical_deception", "../arch/acc/certificate-1-stays_in.json", "agent"),
        ("physical_deception", "../worlds/cart_pole/certificate-1-stays_in.json", "unknown agent"),
        ("physical_deception", "physical_deception/report.json", "certificate"),
    ],
)
def test_other_certificates_are_refused(folder, certificate, said):
    profile = load(VERDICTS / folder / "profile.json")
    with pytest.raises(InputError, match=said):
        load_proof(VERDICTS / certificate, profile)


def test_a_proof_that_does_not_hold_is_refused(tmp_path):
    """The proof of one goal left out: the checker does not take it, and so there is no monitor."""
    body = json.loads(PROVED.read_text())
    body["proofs"].pop(next(iter(body["proofs"])))
    (tmp_path / "edited.json").write_text(sealed(body))
    with pytest.raises(RefusedError, match="refused"):
        load_proof(tmp_path / "edited.json", load(PROVED.parent / "profile.json"))


def test_target_and_certificate_come_together():
    profile = load(PROVED.parent / "profile.json")
    with pytest.raises(InputError, match="made from a certificate"):
        compile_and_prove(profile, ["python", "monitor"])
    with pytest.raises(InputError, match="only for the target monitor"):
        compile_and_prove(profile, ["python"], certificate=PROVED)
    assert split_targets(["monitor", "json"], PROVED) == (True, ("json", "c"))  # C, where no language has a monitor
    assert split_targets(["monitor", "rust"], PROVED) == (True, ("rust", "c"))  # which has none
    assert split_targets(["monitor", "python"], PROVED) == (True, ("python",))


@pytest.mark.compile
def test_the_header_of_another_profile_does_not_compile(tmp_path):
    profile = small_profile()
    texts, watched = files(profile, SPEC, ["c"])
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "use.c").write_text(f'#include "{watched.model.prefix}_monitor.h"\nint main(void) {{ return 0; }}\n')
    command = [*find_compiler(), *STRICT, "-Wno-unused-function", "-c", "use.c"]
    assert subprocess.run(command, cwd=tmp_path, check=False).returncode == 0
    header = tmp_path / f"{watched.model.prefix}.h"
    header.write_text(header.read_text().replace(watched.model.names.guard, "ANOTHER_H"))
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "of another profile" in done.stderr


@pytest.mark.compile
@pytest.mark.parametrize("game", first_of(1, ["predator_prey", "physical_deception", "cooperative_navigation"]))
def test_every_game_has_monitors_of_its_proofs(game, tmp_path):
    profile = load(VERDICTS / game / "profile.json")
    certificate = next((VERDICTS / game).glob("certificate-1-*.json"))
    spec = load_proof(certificate, profile).region
    _, watched = files(profile, spec, ["c", "python"])
    rows = asked(profile, spec, 400, 3)
    wanted = Twin(profile, spec, watched).said(rows)
    assert OK in wanted and INVALID in wanted
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path, ("c", "python"))


@pytest.mark.compile
@pytest.mark.parametrize("name", [benchmark.GAMES[0], *(name for name in benchmark.SYSTEMS if "crossing" in name)])
def test_no_claim_fails_where_the_monitor_vouches(name):
    """A small run of the benchmark; its control shows that the judge says where a claim fails."""
    ((_, found),) = benchmark.measured(5_000, name)
    assert found["fails_while_vouched"] == 0 < found["control_fails"] and found["refused"] == 0
    assert found["vouched"] > 0.1 and found["false_alarms"] < 0.05


UNBEGUN = """#include "{p}_monitor.h"
static {p}_monitor m; /* all 0 */
static const double w[] = {{{w}}};
int main(void)
{{
    int first, acted = {p}_monitor_{agent}(&m, {act});
    {p}_monitor_renew_all(&m);
    first = {p}_monitor_step(&m, w, {dt});
    {p}_monitor_start(&m);
    {p}_monitor_renew_all(&m);
    return 100 * acted + 10 * first + {p}_monitor_step(&m, w, {dt});
}}
"""


@pytest.mark.compile
@pytest.mark.parametrize("path", ["verdicts/physical_deception/certificate-1-distinct_targets",
                                  "worlds/crossing/certificate-1-stays_in"])  # fmt: skip
def test_a_monitor_that_was_never_started_vouches_for_nothing(path, tmp_path):
    """One that is all 0, as static variables are: it gives the fallback alone, and its first step is INVALID."""
    if (compiler := find_compiler()) is None:
        pytest.skip("no C compiler")
    certificate = FOLDER.parent / f"{path}.json"
    profile = load(certificate.parent / "profile.json")
    proved = load_proof(certificate, profile)
    watched = lower_monitor(profile, lower(profile), proved)
    for name, text in {**emit(profile, ["c"]), **rendered.emit_monitors(watched, ["c"])}.items():
        (tmp_path / name).write_text(text)
    stated = isinstance(proved.region, Cover)
    w = proved.region.steps[0][0].low[0] if stated else np.zeros(len(profile.world.coordinates()))
    agent, rest = watched.acts[0].agent, watched.acts[0].action
    given = next(act for act in range(len(agent.actions)) if act != rest)
    told = {"p": watched.model.prefix, "agent": agent.lower, "act": given, "w": ", ".join(map(repr, w.tolist()))}
    dt = proved.region.dt if stated else profile.world.dt
    (tmp_path / "unbegun.c").write_text(UNBEGUN.format(**told, dt=dt))
    command = [*compiler, *STRICT, "-Wno-unused-function", "unbegun.c", "-o", "unbegun"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run([str(tmp_path / "unbegun")], check=False)
    assert done.returncode == 100 * rest + 10 * INVALID + OK


# --- threads that take subnormal numbers for zero (FTZ, DAZ), as programs linked with -ffast-math have them

FLUSHING = """#include "{p}_monitor.h"
#include <xmmintrin.h>
int said(const double *w, double dt, unsigned int mode);
int said(const double *w, double dt, unsigned int mode)
{{
    const unsigned int before = _mm_getcsr();
    {p}_monitor m;
    int word;
    _mm_setcsr(before | mode);
    {p}_monitor_start(&m);
    {p}_monitor_renew_all(&m);
    word = {p}_monitor_step(&m, w, dt);
    _mm_setcsr(before);
    return word;
}}
void flush(unsigned int mode);
void flush(unsigned int mode)
{{
    _mm_setcsr((_mm_getcsr() & ~0x8040u) | mode);
}}
"""
FLUSH = 0x8040  # FTZ and DAZ


@pytest.fixture(scope="module")
def flushing(tmp_path_factory):
    """C that says a word in a thread of a mode, and that changes the mode of the thread."""
    if platform.machine() != "x86_64" or find_compiler() is None:
        pytest.skip("no C compiler for x86-64, whose MXCSR the test sets")
    folder, profile = tmp_path_factory.mktemp("flushing"), small_profile()
    texts, watched = files(profile, SPEC, ["c"])
    for name, text in {**texts, "said.c": FLUSHING.format(p=watched.model.prefix)}.items():
        (folder / name).write_text(text)
    command = [*find_compiler(), "-std=c99", "-O2", "-shared", "-fPIC", "said.c", "-o", "said.so"]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "said.so"))
    library.said.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_uint]
    return library, profile


@pytest.mark.compile
def test_nothing_is_vouched_for_where_subnormals_are_zero(flushing):
    """There a number below a border at 0 would pass, and trees decide next to 0 otherwise than is proved."""
    library, profile = flushing
    w = np.zeros(len(profile.world.coordinates()))
    w[list(profile.world.coordinates()).index("agent_0.x")] = 0.5
    assert library.said(w.ctypes.data, profile.world.dt, 0) == OK
    for mode in (FLUSH, 0x0040):  # zero where they are read (DAZ), too
        assert library.said(w.ctypes.data, profile.world.dt, mode) == INVALID
    space, said = module_of(files(profile, SPEC, ["python"])[1]), []
    for mode in (0, FLUSH, 0):
        library.flush(mode)
        try:
            found = space["Monitor"]()
            found.renew_all()
            said.append(int(found.step(w.tolist(), profile.world.dt)))
        finally:
            library.flush(0)
    assert said == [OK, INVALID, OK]
