"""The subset of Python: what an earlier reader took for something else is refused with line and rewriting, or decides
as Python itself, which another process runs.
"""

import itertools
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.importers.python.library import KNOWN
from codegen.importers.reading import Said
from tests.support.python_source import imported

FOLDER = Path(__file__).parent
MISREAD = (FOLDER / "misread.txt").read_text().split("#----\n")
NUMBERS = (-1.5, -0.5, 0.0, 0.1, 0.15, 0.30000000000000004, 0.5, 0.75, 1.0, 2.0, 2.5, 30.0, 31.0)
RUN = """
import json, sys
text, rows = json.load(sys.stdin)
names = {"__name__": "policy"}
exec(compile(text, "policy.py", "exec"), names)
print(json.dumps([repr(names[sys.argv[1]](row)) for row in rows]))
"""


def sources(name):
    """The sources of a file, by what they are called."""
    parts = (FOLDER / name).read_text().split("#---- ")[1:]
    return dict(each.split("\n", 1) for each in parts)


NEAR, REFUSED = sources("near_read.txt"), sources("near_refused.txt")


def said_by_python(text, name, rows):
    """What Python returns for rows of floats, run by itself."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, name], input=json.dumps([text, rows]), capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def compare(text, said):
    """The agent of a text, after it was compared with Python."""
    profile = imported(text, said)
    for policy in profile.agents:
        rows = [list(each) for each in itertools.product(NUMBERS, repeat=2)]
        theirs = said_by_python(text, policy.agent, rows)
        ours = ir.act(policy, np.array(rows)[:, : len(policy.features)]).tolist()
        called = {}
        for given, action in zip(theirs, ours, strict=True):
            assert called.setdefault(given, action) == action, given
        assert len(set(called.values())) == len(called)
    return profile


def test_every_source_that_was_misread_is_refused_or_right():
    right = []
    for text in MISREAD:
        options = re.search(r"# kw: (.*)", text)
        said = Said(**json.loads(options[1].replace("'", '"'))) if options else Said()
        try:
            compare(text, said)
        except InputError as error:
            assert error.next_step and "line" in error.where
        else:
            right.append(re.search(r"def (\w+)", text)[1])
    assert len(MISREAD) >= 25 and right == ["fan", "brake"]


@pytest.mark.parametrize("name", NEAR)
def test_what_is_near_to_them_decides_as_python(name):
    compare(NEAR[name], Said())


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_near_to_them_is_refused(name):
    with pytest.raises(InputError) as caught:
        imported(REFUSED[name])
    assert caught.value.next_step and "line" in caught.value.where


@pytest.mark.parametrize(
    "body",
    [
        "return (x[0] > 0.5) + (x[1] > 0.5)",
        "match x[0] > 0, x[1] > 0:\n        case True, True:\n            return 1\n    return 0",
        "return [3, 4][x[0] > 0]",
    ],
)
def test_what_floats_and_arrays_do_differently_is_read_of_floats_and_refused_of_arrays(body):
    text = f"def act(x):\n    {body}\n"
    for arrays in ("", "float64", "float32"):
        with pytest.raises(InputError) as caught:
            imported(text, Said(arrays=arrays))
        assert bool(arrays) != ("--arrays floats" in caught.value.next_step)
    assert compare(text, Said(arrays="floats")).provenance.training["act given"] == "Python's floats"


NAMES = """
    abs all any bool dataclasses.dataclass dataclasses.field dict enum.Enum enum.IntEnum enum.auto enum.unique
    enumerate float int len list logging.debug logging.error logging.getLogger logging.info logging.warning
    math.atan math.ceil math.cos math.degrees math.e math.exp math.fabs math.floor math.inf math.log math.nan
    math.pi math.radians math.sin math.sqrt math.tan max min numpy.abs numpy.array numpy.asarray numpy.clip
    numpy.deg2rad numpy.dot numpy.e numpy.float32 numpy.float64 numpy.inf numpy.matmul numpy.maximum
    numpy.minimum numpy.nan numpy.pi numpy.rad2deg object print range reversed round str sum tuple
    typing.NamedTuple typing.Protocol typing.TYPE_CHECKING typing.TypedDict zip
"""


def test_no_other_names_are_read():
    """The hunt takes some steps with others, which are refused alike; a new name needs steps of its own there."""
    assert sorted(KNOWN) == NAMES.split()
