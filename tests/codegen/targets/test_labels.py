"""Labels of an imported source in generated code: each language returns an action's place, and has its label."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from codegen import ir
from codegen.importers.c.header import from_header
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.lowering.lower import lower
from codegen.targets import TARGETS

LABELS = {
    "whole": [-1, 0, 1],
    "long": [-(2**40), 0, 2**53],
    "doubles": [-0.1, 0, 1e300],
    "texts": ["go left?*/ /* ??/", 'st\u00f6p\\ "', "\U0001f600 {x}"],
}
MAIN = """#include <stdio.h>
#include "imported.h"
int main(void) { int i; for (i = 0; i < 3; i++) { printf(FORMAT, imported_act_label[i]); } return 0; }
"""


@pytest.fixture(params=LABELS)
def labelled(request, tmp_path):
    """A profile, its labels, and a folder."""
    first, second, third = LABELS[request.param]
    text = f"def act(x):\n    if x[0] < 0: return {first!r}\n    return {second!r} if x[0] < 1 else {third!r}\n"
    return profile_of(from_python(text.encode(), "act.py"), Names()), LABELS[request.param], tmp_path


def written(profile, folder, target):
    """The text of the first file of a target, which lies in the folder."""
    files = TARGETS[target](lower(profile), profile)
    for name, content in files.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return next(iter(files.values()))


def said(*words, **given):
    ran = subprocess.run(words, check=True, capture_output=True, text=True, timeout=60, **given)
    return ran.stdout.split("\n")[:-1]


def test_python_has_the_labels_and_returns_their_places(labelled):
    profile, labels, folder = labelled
    space = {"__name__": "imported"}
    exec(written(profile, folder, "python"), space)
    assert list(space["LABELS"]["act"]) == labels
    assert [space["LABELS"]["act"][space["act_act"]([each])] for each in (-1.0, 0.5, 2.0)] == labels
    assert [each["label"] for each in json.loads(written(profile, folder, "json"))["agents"][0]["actions"]] == labels


@pytest.mark.compile
@pytest.mark.skipif(not shutil.which("gcc"), reason="no C compiler")
def test_c_has_the_labels_and_its_header_gives_them_back(labelled):
    profile, labels, folder = labelled
    header = written(profile, folder, "c")
    text, form = isinstance(labels[0], str), {str: "%s", int: "%lld", float: "%.17g"}[type(labels[0])]
    form = "%d" if labels[-1] == 1 else form
    (folder / "main.c").write_text(MAIN.replace("FORMAT", f'"{form}\\n"'))
    strict = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    said("gcc", *strict, str(folder / "main.c"), "-o", str(folder / "main"))
    found = said(str(folder / "main"))
    assert (found if text else [float(each) for each in found]) == labels
    (folder / "other.c").write_text('#include "imported.h"\nint main(void) { return 0; }\n')
    said("gcc", *strict, "-Wunused", str(folder / "other.c"), "-o", str(folder / "other"))
    back = profile_of(from_header(header.encode(), "imported.h"), Names())
    assert [each.label for each in back.agents[0].actions] == labels
    rows = np.array([[-1.0], [0.5], [2.0]])
    assert ir.act(back.agents[0], rows).tolist() == ir.act(profile.agents[0], rows).tolist() == [0, 1, 2]


@pytest.mark.compile
@pytest.mark.skipif(not shutil.which("node"), reason="no node")
def test_javascript_has_the_labels(labelled):
    profile, labels, folder = labelled
    written(profile, folder, "javascript")
    script = "import('./imported.mjs').then(m => console.log(JSON.stringify(m.LABELS.act)))"
    assert json.loads(said("node", "-e", script, cwd=folder)[0]) == labels


@pytest.mark.compile
@pytest.mark.skipif(not shutil.which("rustc"), reason="no rustc")
def test_rust_has_the_labels(labelled):
    profile, labels, folder = labelled
    written(profile, folder, "rust")
    text = (
        '#[allow(dead_code)] mod imported;\nfn main() { for each in imported::act::LABELS { println!("{}", each); } }\n'
    )
    (folder / "main.rs").write_text(text)
    said("rustc", "--edition", "2021", str(folder / "main.rs"), "-o", str(folder / "run"))
    found = said(str(folder / "run"))
    assert (found if isinstance(labels[0], str) else [float(each) for each in found]) == labels


def test_a_model_of_onnx_names_the_labels(labelled):
    onnx = pytest.importorskip("onnx", reason="the extra maviper[onnx] is not installed")
    profile, labels, folder = labelled
    model = onnx.load_model_from_string(written(profile, folder, "onnx"))
    assert json.loads({each.key: each.value for each in model.metadata_props}["labels"]) == labels


def test_actions_that_are_their_numbers_have_no_table(tmp_path):
    profile = profile_of(from_python(b"def act(x):\n    return 0 if x[0] < 0 else 2\n", "act.py"), Names())
    for target in ("c", "python", "javascript", "rust", "json"):
        assert "label" not in written(profile, tmp_path, target).lower()
