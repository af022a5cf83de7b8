"""The best of several seeds, for trainings and extractions alike."""

import json

import pytest

from codegen.errors import InputError
from maviper.files.jobs import Scored, best_of, ensure_counts, folder_of, is_resumed


def test_the_first_of_the_best_is_kept_and_every_score_is_said(tmp_path):
    scores, lines = {"a": 0.25, "b": 0.5, "c": 0.5}, []
    found = best_of(
        tmp_path, range(7, 10), iter(scores), lambda name: Scored(scores[name], f", {name}", {"name": name}),
        lambda label, line: lines.append((label, line)),
    )  # fmt: skip
    assert found == (8, "b")
    assert lines == [
        ("seed", "7: score 0.250, a"), ("seed", "8: score 0.500, b"), ("seed", "9: score 0.500, c"), ("best", "seed 8"),
    ]  # fmt: skip
    table = json.loads((tmp_path / "seeds.json").read_text())
    assert table["best"] == 8 and table["seeds"]["9"] == {"score": 0.5, "name": "c"}


def test_counts_out_of_their_range_are_refused():
    ensure_counts(1_000, 1)
    for seeds, jobs, said in ((0, 1, "seeds must be from 1 to 1000, not 0"), (1, 0, "jobs must be at least 1, not 0")):
        with pytest.raises(InputError, match=said) as caught:
            ensure_counts(seeds, jobs)
        assert caught.value.where == ("--jobs" if seeds else "--seeds")


def test_a_seed_goes_on_only_where_it_had_begun(tmp_path):
    folder = folder_of(tmp_path, 3)
    assert folder == tmp_path / "seed-3" and not is_resumed(folder, True)
    folder.mkdir()
    (folder / "config.json").write_text("{}")
    assert is_resumed(folder, True) and not is_resumed(folder, False)
