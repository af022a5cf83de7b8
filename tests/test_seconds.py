"""Records of what tests took: read and printed; the table that orders runs."""

import json
from types import SimpleNamespace

import pytest

from codegen import policy_json
from tests import conftest, seconds
from tests.support import kept

pytestmark = pytest.mark.smoke


def record(tmp_path, spent, skipped=()):
    file = tmp_path / "record.json"
    file.write_text(json.dumps({"seconds": spent, "skipped": dict(skipped)}))
    return str(file)


def test_the_table_is_renewed_from_a_record(tmp_path, monkeypatch):
    """For the files that ran; of the others it forgets those that are gone."""
    monkeypatch.setattr(seconds, "TABLE", tmp_path / "seconds.json")
    seconds.TABLE.write_text(json.dumps({"a.py": 4, "gone.py": 7, "tests/seconds.py": 5}))
    seconds.main(["--update", record(tmp_path, {"b.py": 3.4, "a.py": 10.6, "tiny.py": 0.1})])
    assert json.loads(seconds.TABLE.read_text()) == {"a.py": 11, "b.py": 3, "tests/seconds.py": 5}


def test_long_files_come_first_and_keep_their_order_and_unknown_ones_come_before_them():
    files = ("a.py", "b.py", "new.py", "c.py")
    items, backwards = (
        [SimpleNamespace(nodeid=f"{name}::{test}") for name in names for test in "xy"] for names in (files, files[::-1])
    )
    ordered = [item.nodeid for item in seconds.longest_first(items, {"a.py": 1, "b.py": 9})]
    assert ordered == [item.nodeid for item in seconds.longest_first(backwards, {"a.py": 1, "b.py": 9})]
    assert [name for name in ordered if name.endswith("x")] == ["c.py::x", "new.py::x", "b.py::x", "a.py::x"]
    assert [ordered.index(f"{name}::y") - ordered.index(f"{name}::x") for name in ("a.py", "b.py", "c.py")] == [1, 1, 1]


def test_a_recorder_adds_up_what_reports_say(tmp_path):
    recorder = seconds.Recorder(tmp_path / "record.json")
    for nodeid, spent in (("a.py::x", 1.0), ("a.py::x", 0.5), ("b.py::y", 2.0)):
        told = SimpleNamespace(nodeid=nodeid, duration=spent, skipped=False, passed=spent != 2.0, when="call")
        recorder.pytest_runtest_logreport(told)
    place = ("a.py", 3, "Skipped: no node")
    recorder.pytest_runtest_logreport(
        SimpleNamespace(nodeid="a.py::z", duration=0.0, skipped=True, longrepr=place, passed=False, when="setup")
    )
    recorder.pytest_sessionfinish()
    written = json.loads(recorder.place.read_text())
    assert written == {"seconds": {"a.py": 1.5, "b.py": 2.0}, "skipped": {"a.py::z": "no node"}, "passed": ["a.py::x"]}


def test_what_passed_in_an_earlier_run_is_not_run_again(tmp_path):
    """What failed or was skipped there is, and what was not there."""
    runs = []
    for place, names in ((tmp_path / "one.json", ["a.py::x", "a.py::y[1]"]), (tmp_path / "two.json", ["b.py::x"])):
        place.write_text(json.dumps({"passed": names}))
        runs.append(str(place))
    dropped = []
    hook = SimpleNamespace(pytest_deselected=lambda items: dropped.extend(items))
    config = SimpleNamespace(getoption=lambda name: runs, hook=hook)
    items = [SimpleNamespace(nodeid=name) for name in ("a.py::x", "a.py::y[1]", "a.py::y[2]", "b.py::x", "c.py::x")]
    conftest.pytest_collection_modifyitems(config, items)
    assert [item.nodeid for item in items] == ["a.py::y[2]", "c.py::x"]
    assert [item.nodeid for item in dropped] == ["a.py::x", "a.py::y[1]", "b.py::x"]


def test_tests_of_some_folders_must_not_be_skipped(tmp_path, capsys):
    skipped = {"tests/page/a.py::x": "no chromium", "tests/pages.py::y": "no torch", "b.py": "no torch"}
    file = record(tmp_path, {}, skipped)
    assert seconds.main([file]) == 0
    assert seconds.main([file, "--all-of", "tests/page"]) == 1
    out = capsys.readouterr().out
    assert "3 skipped" in out and "1  no chromium" in out and "2  no torch" in out
    assert "NOT TO BE SKIPPED: tests/page/a.py::x: no chromium" in out and "TO BE SKIPPED: tests/pages.py" not in out


def test_a_profile_is_made_once_for_the_sources_that_make_it(tmp_path, monkeypatch, profile):
    monkeypatch.setattr(kept, "PLACE", tmp_path / "profiles")
    made = []

    def make():
        made.append(profile)
        return profile

    first = kept.keep_profile("an expert", make)
    assert kept.keep_profile("an expert", make) is not first and len(made) == 1
    assert policy_json.dumps(first) == policy_json.dumps(profile)
    kept.keep_profile("another", make)
    monkeypatch.setattr(kept, "hash_sources", lambda: "0" * 64)
    kept.keep_profile("an expert", make)
    assert len(made) == 3 and len(list((tmp_path / "profiles").iterdir())) == 1
