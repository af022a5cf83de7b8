"""The header on a microcontroller: it compiles for a Cortex-M4 without warnings, the walk fits where it should, and on
machines of 32 bits every style gives the same answers.
"""

import shutil
import subprocess

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen.agreement import vectors
from codegen.agreement.compiled import STRICT, build
from codegen.importers import scikit
from codegen.targets import emit
from tests.support import machines

COMPILER = "arm-none-eabi-gcc"
MAX_BYTES = {4: 160, 6: 450}  # of code and tables, as an array walk by hand takes


def small_object(depth, style, flags, folder):
    """The object file of a random tree's header, built for a Cortex-M."""
    if shutil.which(COMPILER) is None:
        pytest.skip(f"{COMPILER} is not installed")
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, (4_000, 18)).astype(np.float32)
    classifier = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(x, rng.integers(5, size=len(x)))
    assert classifier.get_depth() == depth
    (header,) = emit(scikit.from_sklearn(classifier), ["c"], prefix="small", style=style).values()
    (folder / "small.h").write_text(header)
    source = '#include "small.h"\nint act(const float *x);\nint act(const float *x) { return small_agent_0_act(x); }\n'
    (folder / "small.c").write_text(source)
    flags = f"{flags} -mthumb -std=c99 -Os -Wall -Wextra -Werror -ffreestanding -c small.c -o small.o"
    built = subprocess.run([COMPILER, *flags.split()], cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return folder / "small.o"


def listing(tool, path):
    command = [COMPILER.replace("gcc", tool), str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.compile
@pytest.mark.parametrize("depth", MAX_BYTES)
def test_a_walk_fits_a_cortex_m4(depth, tmp_path):
    sizes = {}
    for style in ("nested", "ordered", "walk"):
        built = small_object(depth, style, "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16", tmp_path)
        sizes[style] = int(listing("size", built).splitlines()[1].split()[0])
    print(f"depth {depth}: {sizes} bytes")
    assert sizes["walk"] <= MAX_BYTES[depth]


@pytest.mark.compile
def test_whole_numbers_take_a_cortex_m0_no_more_than_emlearn(tmp_path):
    """40 leaves over 12-bit numbers, for which emlearn 0.23 (inline, int16_t) takes 588 bytes with gcc 12.2."""
    if shutil.which(COMPILER) is None:
        pytest.skip(f"{COMPILER} is not installed")
    x = np.random.default_rng(0).integers(0, 4096, (4_000, 6))
    y = (x[:, 0] > x[:, 1]).astype(int) + 2 * (x[:, 2] + x[:, 3] / 2 > 3000)
    fitted = DecisionTreeClassifier(max_depth=6, max_leaf_nodes=40, random_state=0).fit(x, y)
    (header,) = emit(scikit.from_sklearn(fitted, numbers="int16"), ["c"], prefix="small").values()
    (tmp_path / "small.h").write_text(header)
    act = "int act(const int16_t *x);\nint act(const int16_t *x) { return small_agent_0_act(x); }\n"
    (tmp_path / "small.c").write_text(f'#include "small.h"\n{act}')
    options = "-mthumb -std=c99 -Os -Wall -Wextra -Werror -ffreestanding"
    command = f"{COMPILER} -mcpu=cortex-m0 {options} -c small.c -o small.o"
    subprocess.run(command.split(), cwd=tmp_path, check=True)
    assert int(listing("size", tmp_path / "small.o").splitlines()[1].split()[0]) <= 588
    assert " U " not in listing("nm", tmp_path / "small.o")


@pytest.mark.compile
@pytest.mark.parametrize(("style", "compares"), [("nested", True), ("walk", True), ("ordered", False)])
def test_without_an_fpu_only_the_style_ordered_calls_no_function_for_a_test(style, compares, tmp_path):
    """Each comparison of floats is a call of the compiler's library there, of a hundred instructions or so."""
    symbols = listing("nm", small_object(5, style, "-mcpu=cortex-m0 -mfloat-abi=soft", tmp_path))
    assert ("__aeabi_fcmp" in symbols) == compares, symbols


@pytest.mark.compile
@pytest.mark.parametrize("machine", machines.MACHINES)
@pytest.mark.parametrize("style", ["nested", "ordered", "freestanding", "walk"])
def test_every_test_vector_has_the_same_answer_with_32_bits(style, machine, profile, tmp_path):
    made = build(profile, ["c"], style=style)
    model, files = made.model, {**made.files, **vectors.files(made, ["c"])}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    header, test = f"{model.prefix}.h", f"{model.prefix}_test.c"
    (tmp_path / "alone.c").write_text(f'#include "{header}"\nint main(void) {{ return 0; }}\n')
    machines.build(machine, tmp_path, "alone.c", [*STRICT, "-O2"])
    machines.build(machine, tmp_path, test, ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2"])
    done = machines.run(machine, tmp_path)
    assert done.returncode == 0 and done.stdout.endswith(" 0 wrong\n"), done.stdout + done.stderr
    n = len(files[f"{model.prefix}.vectors.txt"].splitlines()) - 1
    said = int(done.stdout.split()[0])
    assert said == n if style not in ("ordered", "freestanding") else 0.8 * n < said < n, (
        "NaN is left out by their contract"
    )
    (tmp_path / header).write_text(files[header].replace("<=", "<").replace(">=", ">"))
    machines.build(machine, tmp_path, test, ["-std=c99", "-O2"])
    bad = machines.run(machine, tmp_path)
    assert bad.returncode == 1 and not bad.stdout.endswith(" 0 wrong\n"), bad.stdout + bad.stderr
