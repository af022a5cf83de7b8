"""Files as people write them: each decides after its import as in its own language, or is refused as the manifest says.

The default run asks fewer observations; the slow form asks 10,000 of each file, and both ask at every threshold.
"""

import contextlib
import gc
import shutil

import pytest

from codegen.errors import InputError
from tests.support import corpus, originals

FILES = corpus.files()
needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")


def names_of(files):
    return [corpus.called(each) for each in files]


TO_ACCEPT = [each for each in FILES if "refused" not in each]
TO_REFUSE = [each for each in FILES if "refused" in each]


def compared(count, folder):
    """Which files differ from the original, and where first."""
    chosen = [(file, corpus.imported(file)) for file in TO_ACCEPT]
    rows = [corpus.observations(file, policy, count) for file, policy in chosen]
    theirs = originals.answers([(file, each) for (file, _), each in zip(chosen, rows, strict=True)], folder)
    found: dict[str, object] = {}
    for (file, policy), asked, said in zip(chosen, rows, theirs, strict=True):
        ours = corpus.decided(file, policy, asked)
        for place in corpus.differences(said, ours)[:1]:
            found[corpus.called(file)] = (asked[place].tolist(), said[place], ours[place])
    return found


@needs_compiler
@pytest.mark.compile
def test_accepted_files_decide_as_their_own_language(tmp_path):
    assert compared(300, tmp_path) == {}


@needs_compiler
@pytest.mark.compile
@pytest.mark.slow
def test_accepted_files_decide_as_their_own_language_on_many_observations(tmp_path):
    assert compared(10_000, tmp_path) == {}


def test_garbage_is_collected_again_behind_a_reader():
    """Also behind one that refuses; and by nobody who did not ask for it."""
    for collects in (True, False):
        (gc.enable if collects else gc.disable)()
        try:
            for file in (TO_ACCEPT[0], TO_REFUSE[0]):
                with contextlib.suppress(InputError):
                    corpus.imported(file)
                assert gc.isenabled() is collects
        finally:
            gc.enable()


@pytest.mark.parametrize("file", TO_REFUSE, ids=names_of(TO_REFUSE))
def test_refused_files_say_where_why_and_what_instead(file):
    with pytest.raises(InputError) as caught:
        corpus.imported(file)
    error = caught.value
    assert f"line {file['line']}" in error.where
    assert file["says"] in error.what
    assert error.what and error.next_step


def test_at_least_105_of_135_files_are_to_be_accepted():
    """119 were before a subset was stated; those that it leaves out say so in the manifest."""
    assert len(TO_ACCEPT) >= 105 and len(FILES) == 135
    assert sum(each["path"].startswith("python") for each in FILES) >= 45
    assert sum(each["path"].startswith("c/") for each in FILES) >= 20
