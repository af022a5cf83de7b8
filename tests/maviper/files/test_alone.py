"""Two runs of one folder at once: the second is refused; what a killed one held is free again."""

import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from codegen.errors import InputError
from maviper.experts.cards import Request
from maviper.experts.training import train
from maviper.files import runs
from maviper.files.runs import fcntl, working_alone
from maviper.worlds import find

ROOT = Path(__file__).parents[3]
HOLDER = """
import sys, time
from pathlib import Path
from maviper.files.runs import working_alone
with working_alone(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(fcntl is None, reason="nothing can be locked")
def test_one_process_at_a_time_and_killed_ones_hold_nothing(tmp_path):
    (tmp_path / "config.json").write_text("{}")
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None and holder.stdout.readline() == "held\n"
        with pytest.raises(InputError, match="another process works on the run"), working_alone(tmp_path):
            pass
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    with working_alone(tmp_path), pytest.raises(InputError), working_alone(tmp_path):
        pass
    with working_alone(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["config.json"]


def test_a_training_is_alone_in_its_folder(tmp_path, monkeypatch):
    """Without torch: nothing of a trainer is asked before the folder is held."""
    monkeypatch.setattr(train, "_trainer", lambda algorithm: SimpleNamespace(trainer=lambda *given: None))
    monkeypatch.setattr(train, "settings_of", lambda *given: None)
    monkeypatch.setattr(train, "_check_device", lambda device: None)
    monkeypatch.setattr(train, "_against", lambda *given: {})
    monkeypatch.setattr(
        train.cards, "config", lambda *given: {"settings": {}, "command": "", **dict.fromkeys(train.SAME)}
    )
    runs.claim(tmp_path, {"settings": {}, "command": "", **dict.fromkeys(train.SAME), "against": {}}, train.SAME, False)
    with working_alone(tmp_path), pytest.raises(InputError, match="another process works on the run"):
        train.train(find("physical-deception"), tmp_path, Request("vdn"), resume=True)
    assert [path.name for path in tmp_path.iterdir()] == ["config.json"]
