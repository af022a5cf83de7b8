"""What benchmarks share: figures as lines and as JSON, turns, and what a command spends; each prints its help."""

import importlib
import json
import sys
from pathlib import Path

import pytest

from tests.benchmarks import common

MODULES = sorted(Path(common.__file__).parent.glob("*.py"))
COMMANDS = [path.stem for path in MODULES if "\ndef main(" in path.read_text()]


def test_figures_are_told_beside_their_targets_or_as_json(capsys):
    figures = [common.figure("bytes", 12_345, 10, 5), *common.listed({"s": 0.25}, {"s": (1.0, 0.5, "lower")})]
    common.tell(figures, as_json=False)
    assert capsys.readouterr().out == "bytes: 12,345  (reach 10, stretch 5)\ns: 0.25  (reach 1, stretch 0.5)\n"
    common.tell(figures, as_json=True)
    assert json.loads(capsys.readouterr().out)["figures"] == figures
    assert common.figure("alone", 1.0) == {"name": "alone", "value": 1.0, "better": "lower"}


def test_ways_are_timed_in_turns_another_one_first_each_round():
    asked: list[str] = []
    times = common.interleave({name: lambda name=name: asked.append(name) for name in "abc"}, 3, lambda: len(asked))
    assert "".join(asked) == "abcbcacab" and times == {name: [1, 1, 1] for name in "abc"}


def test_what_a_command_spends_is_its_own():
    ended = common.spent_by(sys.executable, "-c", "import sys; sys.exit(sum(range(10**6)) % 7 + 1)")
    assert ended.code == sum(range(10**6)) % 7 + 1 and ended.seconds > 0 and ended.megabytes > 1


@pytest.mark.parametrize("name", COMMANDS)
def test_a_benchmark_prints_its_help(name, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", [name, "--help"])
    with pytest.raises(SystemExit) as ended:
        importlib.import_module(f"tests.benchmarks.{name}").main()
    assert ended.value.code == 0 and f"tests.benchmarks.{name}" in capsys.readouterr().out
