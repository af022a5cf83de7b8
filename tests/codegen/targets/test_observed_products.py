"""World states that the caller multiplies: what generated C observes is the difference of what was stored."""

import platform
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from codegen.targets import emit

KEPT = '__asm__("" : "+x"(a), "+x"(b));'
FLAGS = ("gcc -O2 -mfma", "gcc -O3 -march=native", "clang -O2 -march=native -ffp-contract=fast", "g++ -x c++ -O2 -mfma")
CALLER = """#include "physical_deception.h"
#include <stdio.h>
static void observed(const double *p, const double *q, float *x)
{{
    double w[PHYSICAL_DECEPTION_N_COORDINATES] = {{0.0}};
    w[PHYSICAL_DECEPTION_W_LANDMARK_0_X] = p[0] * q[0];
    w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X] = p[1] * q[1];
    physical_deception_adversary_0_observe(w, x);
}}

int main(void)
{{
    static const double rows[][4] = {{{rows}}};
    for (unsigned k = 0; k < sizeof rows / sizeof rows[0]; k++) {{
        float x[PHYSICAL_DECEPTION_ADVERSARY_0_N_FEATURES];
        observed(rows[k], rows[k] + 2, x);
        printf("%a\\n", (double)x[0]);
    }}
    return 0;
}}
"""


@pytest.mark.compile
@pytest.mark.parametrize("flags", FLAGS)
def test_products_of_the_caller_are_rounded_before_they_are_observed(flags, profile, tmp_path):
    """gcc fuses them with the difference where nothing keeps them apart: half of these rows come out otherwise."""
    command = flags.split()
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed")
    if platform.machine() == "x86_64" and "fma" not in Path("/proc/cpuinfo").read_text():
        pytest.skip("this processor has no fused multiply-add")
    rng = np.random.default_rng(7)
    left = rng.uniform(0.5, 1.0, (200, 2))
    near = left[:, 0] * (1 + 1e-9 * rng.integers(0, 3, 200))
    rows = np.column_stack([left[:, 0], near, left[:, 1], left[:, 1]])  # p[0], p[1], q[0], q[1]
    wanted = [(np.float32(p * r - q * s)) for p, q, r, s in rows.tolist()]
    header = emit(profile, ["c"])["physical_deception.h"]
    assert header.count(KEPT) == 1
    text = ", ".join("{" + ", ".join(value.hex() for value in row) + "}" for row in rows.tolist())
    (tmp_path / "program.c").write_text(CALLER.format(rows=text))
    found = []
    stored = header.replace("defined(__GNUC__) && defined(__x86_64__)", "0")  # the other compilers' way
    for each in (header, stored, header.replace(KEPT, "")):
        (tmp_path / "physical_deception.h").write_text(each)
        built = subprocess.run(
            [*command, "program.c", "-o", "program"], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert built.returncode == 0, built.stderr
        done = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True)
        found.append([np.float32(float.fromhex(line)) for line in done.stdout.splitlines()])
    assert found[0] == found[1] == wanted
    if command[0] == "gcc" and platform.machine() == "x86_64":
        assert sum(a != b for a, b in zip(found[2], wanted, strict=True)) > 20  # what it is for
