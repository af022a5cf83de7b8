"""Generated code of trees with sums: the bits of the reference, whatever the compiler fuses, in C and in Python."""

import platform
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from codegen.agreement import probes, selfcheck
from codegen.agreement.compiled import STRICT, Build, build
from codegen.lowering.lower import lower
from codegen.targets import emit
from maviper.compilation.compile import compile_profile
from tests.support import machines, summed, summed_c
from tests.support.tiers import first_of

KINDS = summed.every(1, levels=3, inner=0.3, over=0.3)
SMALL = summed.every(2, levels=2, inner=0.3)
FEW = {kind: SMALL[kind] for kind in SMALL if kind.startswith("outputs") or kind == "agents of two kinds"}
RANDOM = 300
FUSING = [
    "gcc -O2 -march=native -ffp-contract=fast",
    "gcc -O2 -mfma",
    "clang -O2 -march=native -ffp-contract=fast",
    "g++ -x c++ -O2 -march=native",
]


@pytest.mark.parametrize("kind", first_of(7, KINDS))
def test_every_target_gives_the_bits_of_the_reference(kind):
    with build(KINDS[kind], ["c", "python", "json"]) as made:
        report = selfcheck.check(made, random=RANDOM).ensure()
    targets = {each.target for each in report.agreements}
    assert {"c", "c rows", "c columns", "python", "python batch", "python doubles", "json", "json reader"} <= targets
    assert report.observations > 10_000


def test_compiling_says_what_was_compared():
    made = compile_profile(FEW["outputs, double sums"], ["c"])
    assert not [line for line in made.report.skipped if "as grown" in line]


def rows_of(profile, few):
    """Observations of each agent: ties, numbers of every size."""
    found = {}
    for policy in profile.agents:
        rng = np.random.default_rng(3)
        rows = np.concatenate(list(probes.telling(policy, rng)))
        found[policy.agent] = rows[rng.permutation(len(rows))[:few]]
    return found


@pytest.mark.compile
@pytest.mark.parametrize("flags", first_of(1, FUSING))
def test_fused_multiply_adds_change_nothing(flags, tmp_path):
    command = flags.split()
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed")
    if "-mfma" in command and "fma" not in cpu_flags():
        pytest.skip("this processor has no fused multiply-add")
    for place, (kind, profile) in enumerate(FEW.items()):
        folder = tmp_path / str(place)
        folder.mkdir()
        (folder / "sums.h").write_text(emit(profile, ["c"])["sums.h"])
        (folder / "program.c").write_text(summed_c.program(profile, rows_of(profile, 400)))
        built = subprocess.run(
            [*command, "-Wall", "-Wextra", "-Werror", "program.c", "-o", "program"],
            cwd=folder, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert built.returncode == 0, built.stderr
        done = subprocess.run([folder / "program"], capture_output=True, text=True, check=False)
        assert done.stdout == "0 wrong\n", kind


def cpu_flags():
    if platform.machine() != "x86_64":
        return ""
    return Path("/proc/cpuinfo").read_text()


CALLER = """#include "sums.h"
#include <stdio.h>
static int fused(const double *a, const double *b, const double *c)
{{
    double x[5] = {{0.0, 0.0, 0.0, 0.0, 0.0}};
    x[0] = *a * *b; /* stored, and so rounded: whoever fuses it with the sum decides otherwise */
    x[1] = *c;
    return sums_agent_0_act(x);
}}

int main(void)
{{
    volatile double a = 0x1.0000001p0, b = 0x1.0000001p0, rounded = 0x1.0000002p0;
    const double first = a, second = b, product = rounded;
    printf("%d\\n", fused(&first, &second, &product));
    return 0;
}}
"""


@pytest.mark.compile
def test_a_product_of_the_caller_is_not_fused_either(tmp_path):
    """gcc puts the caller's product and our difference into one instruction, where nothing keeps them apart."""
    if shutil.which("gcc") is None or "fma" not in cpu_flags():
        pytest.skip("no gcc, or no fused multiply-add")
    profile = summed.difference(0.0)
    header = emit(profile, ["c"])["sums.h"]
    found = []
    for text in (header, header.replace("sums_kept(x[", "(x[")):
        (tmp_path / "sums.h").write_text(text)
        (tmp_path / "caller.c").write_text(CALLER.format())
        subprocess.run(["gcc", "-O2", "-mfma", "caller.c", "-o", "caller"], cwd=tmp_path, check=True)
        found.append(subprocess.run([tmp_path / "caller"], capture_output=True, text=True, check=True).stdout)
    assert found == ["0\n", "1\n"], "and without the barrier it would be"


@pytest.mark.compile
def test_a_cortex_m4_gives_the_same_bits(tmp_path):
    for place, (kind, profile) in enumerate(FEW.items()):
        folder = tmp_path / str(place)
        folder.mkdir()
        (folder / "sums.h").write_text(emit(profile, ["c"])["sums.h"])
        (folder / "alone.c").write_text('#include "sums.h"\nint main(void) { return 0; }\n')
        (folder / "program.c").write_text(summed_c.program(profile, rows_of(profile, 150)))
        machines.build("cortex-m4", folder, "alone.c", [*STRICT, "-O2"])
        machines.build("cortex-m4", folder, "program.c", ["-O2", "-ffp-contract=fast"])
        done = machines.run("cortex-m4", folder)
        assert (done.returncode, done.stdout) == (0, "0 wrong\n"), kind


@pytest.mark.compile
@pytest.mark.parametrize(
    "flag",
    ["-ffast-math", "-fassociative-math -fno-signed-zeros -fno-trapping-math", "-freciprocal-math", "-mfpmath=387"],
)
def test_what_would_compute_otherwise_is_refused(flag, tmp_path):
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    (tmp_path / "sums.h").write_text(emit(FEW["outputs, double sums"], ["c"])["sums.h"])
    (tmp_path / "a.c").write_text('#include "sums.h"\n')
    command = ["gcc", "-std=gnu17", "-O2", *flag.split(), "-fsyntax-only", "a.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "#error" in done.stderr


@pytest.mark.compile
@pytest.mark.parametrize(
    ("profile", "refused"),
    [
        (FEW["outputs, double sums"], True),
        (summed.difference(-5e-324, "float64"), True),
        (summed.difference(-(2.0**-149), "float32"), True),
    ],
)
def test_constants_of_one_precision_are_refused_where_doubles_decide(profile, refused, tmp_path):
    """With -fsingle-precision-constant `x[0] <= 0.1` holds at 0.100000001."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    (tmp_path / "sums.h").write_text(emit(profile, ["c"])["sums.h"])
    (tmp_path / "a.c").write_text('#include "sums.h"\n')
    for flags, fails in ((["-fsingle-precision-constant"], refused), ([], False)):
        command = ["gcc", "-std=c99", "-pedantic", "-Werror", *flags, "-fsyntax-only", "a.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode != 0) == fails and ("double_constants" in done.stderr) == fails, done.stderr


@pytest.mark.parametrize(("numbers", "last"), [("float32", -(2.0**-149)), ("float64", -5e-324)])
def test_a_sum_below_zero_is_asked_for_as_that(numbers, last):
    """A thread that takes subnormal numbers for zero must not send 0 to the left."""
    profile = summed.difference(last, numbers)
    files = emit(profile, ["c", "python"])
    assert ") < 0x0p+0" in files["sums.h"] and "x[0] - x[1]" in files["sums.py"] and " < 0.0:" in files["sums.py"]
    with build(profile, ["c", "python", "json"]) as made:
        selfcheck.check(made, random=RANDOM).ensure()
    beside = emit(summed.difference(-(2.0**-149), "float64"), ["c"])["sums.h"]
    assert " < 0x0p+0" not in beside, "which is another number of float64"


# --- faults


C_FAULTS = [
    ("outputs, double sums", " + ", " - "),
    ("outputs, double sums", "(double)x[", "(double)(float)1 * (double)(int)x["),
    ("actions, double sums", " - (double)", " + (double)"),
    ("outputs, float64", "sums_kept(0x1p-1 * ", "sums_kept(0x1.0000000000001p-1 * "),
    ("outputs, float32 steps", "(float)(", "("),
    ("outputs, float64", "(y < low)", "(y <= low)"),
    ("outputs, double sums", "return (y > high) ? high : y;", "return (y > (2 * high)) ? high : y;"),
    ("double sums given as float32", ") <= ", ") < "),
]


@pytest.mark.compile
@pytest.mark.parametrize(("kind", "right", "wrong"), C_FAULTS)
def test_faults_in_the_c_are_found(kind, right, wrong):
    profile = summed.every(1)[kind]
    header = emit(profile, ["c"])["sums.h"]
    assert right in header
    files = {"sums.h": header.replace(right, wrong)}
    with Build(profile, lower(profile), files, optimised=False) as made:
        report = selfcheck.check(made, random=RANDOM)
    harmless = wrong == "(y <= low)" or (right == "(float)(" and "float32 steps" in kind)
    assert bool([each for each in report.agreements if each.differences]) != harmless
