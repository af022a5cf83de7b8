"""Golden files, one a target in the language's own extension, and what strict compilers say to them."""

import functools
import itertools
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import compiled, probes, selfcheck, vectors
from codegen.agreement.compiled import build
from codegen.equivalence import obligations
from codegen.form import layout
from codegen.lowering.lower import NESTED, ORDERED, WALK, lower
from codegen.profiles import loads, schema
from codegen.targets import TARGETS, emit
from codegen.targets.rendered import harness
from tests.support.generated import FOLDER as DEMO
from tests.support.small import small_profile

FOLDER = "tests/golden"
PROFILES = [small_profile(), loads((DEMO / "profile.json").read_text())]
COMPILERS = [
    *("gcc -std=c99", "clang -std=c99", "g++ -x c++ -std=c++17"),
    *("gcc -std=c11", "clang -std=c11", "g++ -x c++ -std=c++20", "clang++ -x c++ -std=c++17"),
]
SANITIZE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def test_every_target_has_its_golden_file(golden):
    """Python's are beside the demo's profile: module and reader here, those of JAX and PyTorch in test_embedded.py."""
    profile = small_profile()
    files = emit(profile, TARGETS)
    assert len(files) == len(TARGETS) + 1 - 4 + 4 * len(profile.agents), "a reader; four for each agent"
    golden("generated/physical_deception", emit(PROFILES[1], ["python", "json"]))
    asked = obligations.about_c(files["physical_deception.h"], profile, lower(profile))
    asked += obligations.about_python(files["physical_deception.py"], profile, lower(profile))
    files = {name: text for name, text in files.items() if not name.endswith(".py")}
    files |= {f"walk_{name}": text for name, text in emit(profile, ["c"], style="walk").items()}
    files |= {f"ordered_{name}": text for name, text in emit(profile, ["c"], style="ordered").items()}
    made = vectors.files(build(profile, TARGETS), TARGETS)
    files |= {name: text for name, text in made.items() if not name.endswith("_vectors.h")}  # the same, once more
    named = {"c": asked[1], "python": asked[len(profile.agents) + 1]}
    files |= {f"physical_deception_{each.agent}.{kind}.smt2": each.text for kind, each in named.items()}
    golden(FOLDER, files)
    golden(FOLDER, {"profile.schema.json": layout(schema()) + "\n"})


@pytest.mark.compile
def test_the_golden_files_agree_with_the_reference():
    selfcheck.check_files(small_profile(), emit(small_profile())).ensure()


def by_tier():
    """The README's line asks three compilers; clang, which warns much as gcc does, in one style."""
    for compiler, style in itertools.product(COMPILERS, (NESTED, ORDERED, WALK)):
        rest = pytest.mark.nightly if compiler not in COMPILERS[:3] else pytest.mark.slow
        usual = compiler in COMPILERS[:3] and (style == WALK or not compiler.startswith("clang"))
        yield pytest.param(compiler, style, marks=[] if usual else rest)


@pytest.mark.compile
@pytest.mark.parametrize(("compiler", "style"), [*by_tier()])
def test_strict_compilers_and_sanitizers_find_nothing(style, compiler, tmp_path):
    """Compiled with every warning an error, then run under address and undefined sanitizers on boundary vectors: one
    decision, rows and columns, in every style.
    """
    command, *options = compiler.split()
    if shutil.which(command) is None:
        pytest.skip(f"{command} is not installed")
    sanitized = links_sanitizers(command)
    level = "-O1" if "-std=c99" in options or "-std=c++17" in options else "-O0"  # an optimiser finds more to warn of
    sanitize = [*SANITIZE, level]
    warnings = [*compiled.STRICT[1:], "-Wno-float-conversion"]
    for profile in PROFILES:
        for name, text in emit(profile, ["c"], style=style).items():
            (tmp_path / name).write_text(text)
        (tmp_path / "harness.c").write_text(
            harness(lower(profile, style=style), "c") + driver(profile, style, tmp_path)
        )
        build = [command, *options, *warnings, *(sanitize if sanitized else [level, "-c"]), "harness.c", "-o", "run"]
        built = subprocess.run(build, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert built.returncode == 0, built.stderr
        if not sanitized:
            continue
        ran = subprocess.run([str(tmp_path / "run")], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 0 and ran.stdout.split()[0] == "0", ran.stdout + ran.stderr
    if not sanitized:
        pytest.skip(f"{command} has no sanitizer runtime here; its warnings were asked for")


@functools.cache
def links_sanitizers(command):
    """Whether a compiler finds what its sanitizers need; some are installed without."""
    asked = [command, "-x", "c", "-", *SANITIZE, "-o", "/dev/null"]
    told = subprocess.run(asked, input="int main(void) { return 0; }\n", capture_output=True, text=True, check=False)
    assert told.returncode == 0 or "libclang_rt" in told.stderr or "cannot find" in told.stderr, told.stderr
    return told.returncode == 0


# exactly sized on the heap, so that a read past the end of an observation is seen
FROM_FILE = """
#include <stdio.h>
#include <stdlib.h>
static void *from(const char *file, size_t size)
{
    FILE *open = fopen(file, "rb");
    void *read = malloc(size);
    if (!open || !read || fread(read, 1, size, open) != size) { exit(2); }
    fclose(open);
    return read;
}
"""


def driver(profile: ir.PolicyProfile, style: str, folder: Path) -> str:
    """A main function that replays boundary and special vectors and prints the number of differences. It reads the
    vectors from files, since compilers take long over thousands of literals.
    """
    rng = np.random.default_rng(0)
    lines = [FROM_FILE, "int main(void)", "{", "    int wrong = 0;"]
    for policy in profile.agents:
        rows = np.concatenate(
            [probes.boundary(policy.tree, policy.features, rng), probes.special(policy.features, rng)]
        )
        rows = rows[rng.permutation(len(rows))[:397]]  # no multiple of eight, which are walked side by side
        if style == ORDERED:  # its contract
            rows = rows[~np.isnan(rows).any(axis=1)]
        name, n = policy.agent, len(rows)
        (folder / f"{name}.rows").write_bytes(rows.tobytes())
        (folder / f"{name}.columns").write_bytes(rows.T.tobytes())
        (folder / f"{name}.wanted").write_bytes(ir.act(policy, rows).astype(np.int32).tobytes())
        lines += [
            "    {",
            f"        static int actions[{n}], checks[{n}];",
            f"        unsigned char *by_rows = (unsigned char *)malloc({n});",
            f"        unsigned char *by_columns = (unsigned char *)malloc({n});",
            "        int i;",
            f'        float *rows = (float *)from("{name}.rows", {rows.size} * sizeof(float));',
            f'        float *columns = (float *)from("{name}.columns", {rows.size} * sizeof(float));',
            f'        int *wanted = (int *)from("{name}.wanted", {n} * sizeof(int));',
            "        if (!by_rows || !by_columns) { return 2; }",
            f"        {lower(profile).prefix}_{name}_decide(rows, {n}, actions, checks);",
            f"        {name}_batch(rows, columns, {n}, by_rows, by_columns);",
            f"        for (i = 0; i < {n}; i++) {{",
            "            wrong += actions[i] != wanted[i] || by_rows[i] != wanted[i] || by_columns[i] != wanted[i];",
            "        }",
            "        free(rows); free(columns); free(wanted); free(by_rows); free(by_columns);",
            "    }",
        ]
    return "\n".join([*lines, '    printf("%d differences\\n", wrong);', "    return wrong != 0;", "}", ""])


@pytest.mark.parametrize("profile", PROFILES, ids=["small", "demo"])
def test_the_python_module_runs_with_nothing_installed(profile, tmp_path):
    """-I -S: no site-packages, no environment; the module must import and decide."""
    (tmp_path / "policy.py").write_text(emit(profile, ["python"])["physical_deception.py"])
    code = (
        "import sys; sys.path.insert(0, '.'); import policy;"
        "print([policy.ACT[a]([0.0] * len(policy.FEATURES[a])) for a in policy.AGENTS])"
    )
    ran = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    zero = [int(ir.act(policy, np.zeros((1, len(policy.features))))[0]) for policy in profile.agents]
    assert ran.stdout.strip() == str(zero)
