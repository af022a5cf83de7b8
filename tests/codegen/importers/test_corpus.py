"""Files as people write them: each decides after its import as in its own language, or is refused as the manifest says.

The import compares: Python itself, or three builds of the C compiler, answer at tens of thousands of observations. That
it sees wrong trees is tested where it stands (running/test_asking.py, c/test_compiled.py) and by the hunt.
"""

import contextlib
import gc
import shutil
import tomllib
from pathlib import Path

import pytest

import maviper
from codegen.errors import InputError
from codegen.importers.reading import NOT_COMPARED

CORPUS = Path(__file__).parents[2] / "corpus"
FILES = tomllib.loads((CORPUS / "manifest.toml").read_text())["file"]
OPTIONS = {"features": "feature_names", "arrays": "arrays", "scores": "scores"}
NO_COMPILER = (pytest.mark.compile, pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc"))


def imported(file):
    """The profile of a file, and the agent that is its entry."""
    options = {OPTIONS[name]: value for name, value in file.items() if name in OPTIONS}
    profile = maviper.from_file(CORPUS / file["path"], **options)
    wanted = {part.lower().strip("_") for part in file["entry"].split(".")}
    (policy,) = (each for each in profile.agents if each.agent in wanted or len(profile.agents) == 1)
    return profile, policy


def cases(*, refused):
    """The files that are to be refused, or to come in, as parameters."""
    for file in FILES:
        if ("refused" in file) == refused:
            marks = NO_COMPILER if file["path"].startswith("c/") and not refused else ()
            yield pytest.param(file, id=f"{file['path']}:{file['entry']}", marks=marks)


@pytest.mark.parametrize("file", [*cases(refused=False)])
def test_accepted_files_decide_as_their_own_language(file):
    profile, policy = imported(file)
    facts = profile.provenance.training
    assert facts[f"{policy.agent} replayed by"] != NOT_COMPARED and facts[f"{policy.agent} replayed"] > 4_000


@pytest.mark.parametrize("file", [*cases(refused=True)])
def test_refused_files_say_where_why_and_what_instead(file):
    with pytest.raises(InputError) as caught:
        imported(file)
    error = caught.value
    assert f"line {file['line']}" in error.where and file["says"] in error.what and error.next_step


def test_at_least_105_of_135_files_are_to_be_accepted():
    """119 were before a subset was stated; those that it leaves out say so in the manifest."""
    accepted = [each["path"] for each in FILES if "refused" not in each]
    assert len(accepted) >= 105 and len(FILES) == 135
    assert sum(each.startswith("python/") for each in accepted) >= 45
    assert sum(each.startswith("c/") for each in accepted) >= 20


def test_garbage_is_collected_again_behind_a_reader():
    """Also behind one that refuses; and by nobody who did not ask for it."""
    for collects in (True, False):
        (gc.enable if collects else gc.disable)()
        try:
            for path in ("python/acrobot_swing.py", "python/abstract_agent.py"):
                with contextlib.suppress(InputError):
                    maviper.from_file(CORPUS / path)
                assert gc.isenabled() is collects
        finally:
            gc.enable()
