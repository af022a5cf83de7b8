"""A training killed at any instant: what is left is whole, and it goes on to the same bytes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from maviper.worlds import find
from tests.support.killing import killed_at, needs_fork

ROOT = Path(__file__).parent.parent.parent.parent
TINY = {"games": 128, "checkpoint_steps": 6_400, "steps": 12_800, "hidden": 8, "steps_per_update": 400, "batch": 256}
INSTANTS = 6


def files(folder):
    """What does not depend on how long a training took, nor on how often it was begun."""
    found = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in found.items() if name not in ("state.safetensors", "card.json")}


def untimed(card):
    return {key: value for key, value in card.items() if key not in ("seconds", "machine")}


@needs_fork
@pytest.mark.train
def test_a_training_killed_at_some_of_its_calls(tmp_path):
    """In an interpreter of its own: a process is not forked once other tests have started torch's threads in it."""
    program = f"import sys; from pathlib import Path; from {__name__} import ensure_resumed as e; e(Path(sys.argv[1]))"
    words = [sys.executable, "-c", program, str(tmp_path)]
    ran = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


def ensure_resumed(tmp_path):
    """A training killed at some of its calls goes on to what one that was not killed ends with."""
    from maviper.experts.cards import Request
    from maviper.experts.training import train as training

    training.CHECKPOINT_EPISODES = training.FINAL_EPISODES = 20
    world, asked = find("physical-deception"), Request("vdn", overrides={**TINY, "seed": 3})

    def train(name, resume=False):
        return training.train(world, tmp_path / name, asked, resume=resume)

    card = train("whole")
    whole = files(tmp_path / "whole")
    cut, total = killed_at(0, lambda: train("counted"))
    assert not cut and total > 20
    for last in range(1, total, total // INSTANTS):
        name = str(last)
        cut, _ = killed_at(last, lambda name=name: train(name))
        assert cut
        folder = tmp_path / name
        if (folder / "config.json").exists():
            json.loads((folder / "config.json").read_text())
        again = train(name, resume=(folder / "config.json").exists())
        assert untimed(again) == untimed(card)
        assert files(folder) == whole
