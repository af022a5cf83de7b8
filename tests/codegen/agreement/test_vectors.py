"""Test vectors: the shipped tests pass, and fail on what is wrong."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import vectors
from codegen.agreement.compiled import STRICT, build, find_compiler
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said, read
from codegen.lowering.lower import lower

RUNS = {
    "c": [["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "physical_deception_test.c", "-o", "run"], ["./run"]],
    # without bytecode: that of the right source would stand in for a wrong one of the same second and length
    "python": [[sys.executable, "-B", "physical_deception_test.py"]],
    "javascript": [["node", "physical_deception_test.mjs"]],
    "rust": [["rustc", "--edition=2021", "physical_deception_test.rs", "-o", "run"], ["./run"]],
}


def ran(target, folder):
    for command in RUNS[target]:
        if shutil.which(command[0]) is None and not command[0].startswith("./"):
            pytest.skip(f"{command[0]} is not installed")
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done


@pytest.mark.compile
@pytest.mark.parametrize(("target", "style"), [*((target, "auto") for target in RUNS), ("c", "ordered"), ("c", "walk")])
def test_the_shipped_test_passes_and_notices_a_wrong_threshold(target, style, profile, tmp_path):
    made = build(profile, [target], style=style)
    files = {**made.files, **vectors.files(made, [target])}
    assert len(files) == 3 + (target == "c")
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    good = ran(target, tmp_path)
    n = len(files["physical_deception.vectors.txt"].splitlines()) - 1
    assert good.returncode == 0 and good.stdout.endswith(" 0 wrong\n"), good.stdout + good.stderr
    said = int(good.stdout.split()[0])
    assert said == n if style != "ordered" else 0.8 * n < said < n, "NaN is left out by that style's contract"
    source = next(name for name in files if "vectors" not in name and "_test" not in name)
    # doubles that decide are no float32 values in Python and JavaScript, where < would do as well
    wrong = {"c": ("<=", "<"), "rust": ("] <= f", "] < f"), "python": ("_double(v)) <= ", "_double(v)) >= ")}.get(
        target, ("] <= ", "] >= ")
    )
    (tmp_path / source).write_text(files[source].replace(*wrong))
    bad = ran(target, tmp_path)
    assert style == "ordered" or (bad.returncode == 1 and not bad.stdout.endswith(" 0 wrong\n"))


ARRAYS = """#include "{0}.h"
#include "{0}_vectors.h"
#include <string.h>
int main(void) {{
    int wrong = 0;
    {1}
    return wrong;
}}
"""
EACH = """for (unsigned i = 0; i < sizeof {0}_answers / sizeof *{0}_answers; i++) {{
        {1} x[sizeof *{0}_vectors / sizeof **{0}_vectors];
        memcpy(x, {0}_vectors[i], sizeof x);
        wrong |= sizeof x != sizeof *{0}_vectors || {0}_act(x) != {0}_answers[i];
    }}"""


@pytest.mark.compile
@pytest.mark.parametrize(("numbers", "style"), [("float32", "auto"), ("float32", "ordered"), ("int16", "auto")])
def test_arrays_of_vectors_have_the_same_answers_and_notice_a_wrong_threshold(numbers, style, profile, tmp_path):
    if numbers == "int16":
        text = b"def a(x):\n    return 1 if x > 3 else 2 if x > -70 else 0\n"
        profile = profile_of(read(text, "a.py", Said(run=False)), Names(), numbers)
    made = build(profile, ["c"], style=style)
    texts = {**made.files, **vectors.files(made, ["c"])}
    each = [EACH.format(f"{made.model.prefix}_{agent.lower}", agent.kind) for agent in made.model.agents]
    texts["main.c"] = ARRAYS.format(made.model.prefix, "\n    ".join(each))
    header = f"{made.model.prefix}.h"
    for wrong in (False, True):
        texts[header] = texts[header].replace("<=", "<").replace(">=", ">") if wrong else texts[header]
        for name, text in texts.items():
            (tmp_path / name).write_text(text)
        subprocess.run([*find_compiler(), *STRICT, "main.c", "-o", "main"], cwd=tmp_path, check=not wrong)
        assert subprocess.run(["./main"], cwd=tmp_path, check=False).returncode == wrong


def test_vectors_are_the_references_answers(profile):
    text = vectors.vectors(profile, lower(profile))
    assert text == vectors.vectors(profile, lower(profile))
    agents = set()
    for line in text.splitlines()[1:]:
        agent, action, *bits = line.split()
        policy = profile.agents[int(agent)]
        x = np.array([int(value, 16) for value in bits], dtype=np.uint32).view(np.float32)
        assert len(x) == len(policy.features) and ir.act(policy, x[None])[0] == int(action)
        agents.add(agent)
    assert len(agents) == len(profile.agents)
