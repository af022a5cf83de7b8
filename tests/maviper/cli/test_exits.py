"""How commands end: what an interrupted one says works, and what nobody could write or read is no verdict."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from codegen.errors import ExitCode
from codegen.policy_json import dumps
from maviper.cli import exits, main
from maviper.experts.training import train as commands
from maviper.extraction import run
from maviper.files import runs
from tests.support.small import small_profile
from tests.support.teams import team, towards
from tests.support.tiers import first_of

PROVED = Path(__file__).parents[3] / "generated" / "proved_defenders" / "profile.json"
VERIFY = ["verify", "--claim", "alive_leaves", PROVED]
QUICK = ["--iterations", "2", "--rollouts", "4", "--refinement-episodes", "0", "--max-depth", "2"]
QUICK += ["--set", "selection_episodes=4"]


@pytest.fixture(autouse=True)
def _handlers():
    """An interrupted command turns off what listens for further interrupts."""
    handler, hook = signal.getsignal(signal.SIGINT), sys.unraisablehook
    yield
    signal.signal(signal.SIGINT, handler)
    sys.unraisablehook = hook


def interrupted(*given, **named):
    raise KeyboardInterrupt


def told(capsys, *arguments):
    """The advice of a command that is interrupted."""
    assert main.run([str(argument) for argument in arguments]) == ExitCode.INTERRUPTED
    lines = capsys.readouterr().err.splitlines()
    assert lines[-2] == "error: interrupted"
    return lines[-1].strip()


def extract(place, *more):
    return ["-q", "extract", "physical-deception", *QUICK, *more, "-o", place]


@pytest.mark.smoke
def test_a_run_folder_goes_on_with_resume_alone(capsys, monkeypatch, tmp_path):
    with monkeypatch.context() as patched:
        patched.setattr(run, "extract", interrupted)
        assert told(capsys, *extract(tmp_path / "run")) == exits.RESUME
        assert told(capsys, *extract(tmp_path / "run", "--resume")) == exits.RESUME
    assert main.run(list(map(str, extract(tmp_path / "run")))) == ExitCode.INPUT
    assert "continue it with --resume" in capsys.readouterr().err
    assert main.run(list(map(str, extract(tmp_path / "run", "--resume")))) == ExitCode.DONE
    assert (tmp_path / "run" / runs.PROFILE_FILE).exists()


def test_before_a_run_has_begun_there_is_nothing_to_resume(capsys, monkeypatch, tmp_path):
    with monkeypatch.context() as patched:
        patched.setattr(run.runs, "claim", interrupted)
        assert told(capsys, *extract(tmp_path / "run")) == exits.AGAIN
    with monkeypatch.context() as patched:
        patched.setattr(run, "find_expert", interrupted)
        assert told(capsys, *extract(tmp_path / "run")) == exits.AGAIN
    assert main.run(list(map(str, extract(tmp_path / "run", "--resume")))) == ExitCode.INPUT
    assert main.run(list(map(str, extract(tmp_path / "run")))) == ExitCode.DONE


def test_a_single_file_is_made_again(capsys, monkeypatch, tmp_path):
    """Also beside a run, which this command has nothing to do with."""
    (tmp_path / runs.CONFIG_FILE).write_text("{}")
    with monkeypatch.context() as patched:
        patched.setattr(run, "extract", interrupted)
        assert told(capsys, *extract(tmp_path / "x.json")) == exits.AGAIN
    assert main.run(list(map(str, extract(tmp_path / "x.json")))) == ExitCode.DONE


def test_several_seeds_go_on_with_resume_once_one_has_begun(capsys, monkeypatch, tmp_path):
    seeds = ["--seeds", "2"]
    with monkeypatch.context() as patched:
        patched.setattr(run, "side_by_side", interrupted)
        assert told(capsys, *extract(tmp_path / "run", *seeds)) == exits.AGAIN
    with monkeypatch.context() as patched:
        patched.setattr(run, "finalist_score", interrupted)  # after the first seed
        assert told(capsys, *extract(tmp_path / "run", *seeds)) == exits.RESUME
    assert main.run(list(map(str, extract(tmp_path / "run", *seeds)))) == ExitCode.INPUT
    assert main.run(list(map(str, extract(tmp_path / "run", *seeds, "--resume")))) == ExitCode.DONE
    assert (tmp_path / "run" / runs.PROFILE_FILE).exists()


def test_training_goes_on_with_resume_alone(capsys, monkeypatch, tmp_path):
    def begins(world, folder, request, *given, resume=False):
        runs.claim(folder, {"settings": {}, "command": ""}, (), resume)
        raise KeyboardInterrupt

    def asked(place, *more):
        return ["-q", "train", "physical-deception", *more, "-o", place]

    monkeypatch.setattr(commands, "schedule", lambda *_: "")  # this and the settings need torch
    monkeypatch.setattr(commands, "settings_of", lambda *_: None)
    with monkeypatch.context() as patched:
        patched.setattr(commands, "find", interrupted)
        assert told(capsys, *asked(tmp_path / "run")) == exits.AGAIN
        patched.setattr(commands, "_one", interrupted)
        assert told(capsys, *asked(tmp_path / "run")) == exits.AGAIN
    with monkeypatch.context() as patched:
        patched.setattr(commands, "train", begins)
        assert told(capsys, *asked(tmp_path / "run")) == exits.RESUME
        assert told(capsys, *asked(tmp_path / "runs", "--seeds", "2")) == exits.RESUME


@pytest.mark.solver
@pytest.mark.usefixtures("few_observations")
def test_commands_without_runs_are_run_again(capsys, monkeypatch, tmp_path):
    """Also after another one in this process that had a run, and into a folder that holds one."""
    place = tmp_path / "run"
    with monkeypatch.context() as patched:
        patched.setattr(run, "extract", interrupted)
        assert told(capsys, *extract(place)) == exits.RESUME
    (tmp_path / "profile.json").write_text(dumps(team(small_profile(), towards(0, 0), towards(1, 1))))
    for name, stops, arguments in (
        ("verify", "maviper.verification.run.one_by_one", [tmp_path / "profile.json", "-o", place]),
        ("repair", "maviper.verification.repair.repair", [tmp_path / "profile.json", "-o", place]),
        ("compile", "maviper.compilation.compile.compile_profile", [tmp_path / "profile.json", "-o", place]),
        ("show", "maviper.evaluation.show.rules", [tmp_path / "profile.json"]),
        ("demo", "maviper.tour.extract_live", ["-o", place]),
    ):
        with monkeypatch.context() as patched:
            patched.setattr(stops, interrupted)
            assert told(capsys, "-q", name, *arguments) == exits.AGAIN
    for name in ("verify", "compile"):
        code = main.run([*map(str, ["-q", name, tmp_path / "profile.json", "-o", place])])
        assert code in (ExitCode.DONE, ExitCode.INCONCLUSIVE), name


@pytest.mark.slow
def test_a_signal_in_the_middle_of_an_extraction(tmp_path):
    """A real process, a real Ctrl-C, and the advice that it prints."""
    asked = [sys.executable, "-m", "maviper", *extract(tmp_path / "run")[1:]]
    asked[asked.index("--iterations") + 1] = "60"
    asked = [str(word) for word in asked]
    process = subprocess.Popen(asked, stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        if list((tmp_path / "run").glob("steps/*")):
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == ExitCode.INTERRUPTED and err.strip().endswith(exits.RESUME), err
    again = subprocess.run(asked, capture_output=True, text=True, check=False)
    assert again.returncode == ExitCode.INPUT
    again = subprocess.run([*asked, "--resume"], capture_output=True, text=True, check=False)
    assert again.returncode == ExitCode.DONE, again.stderr
    assert json.loads((tmp_path / "run" / runs.PROFILE_FILE).read_text())["agents"]


# --- output that nobody can write, or reads


def ended(streams, arguments):
    """The exit code, and what standard error got where it is not one of the given streams."""
    kept = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, **streams}
    command = [sys.executable, "-m", "maviper", *map(str, arguments)]
    done = subprocess.run(command, **kept, check=False)
    return done.returncode, (done.stderr or b"").decode()


@pytest.fixture
def full():
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    with Path("/dev/full").open("w") as stream:
        yield stream


@pytest.fixture
def closed():
    """A pipe whose reader is gone."""
    reader, writer = os.pipe()
    os.close(reader)
    yield writer
    os.close(writer)


WRITTEN = [[*VERIFY, "--json"], ["show", PROVED], ["guide"], ["--help"], ["verify", "--list"], ["worlds", "list"]]
COMMANDS = [[name, "--help"] for names in main.NAMES.values() for name in names]


@pytest.mark.parametrize(
    "arguments", first_of(9, [*WRITTEN, *COMMANDS]), ids=lambda arguments: " ".join(map(str, arguments))
)
def test_a_full_standard_output_is_said_in_words(arguments, full):
    code, said = ended({"stdout": full}, arguments)
    lines = said.splitlines()
    assert code == ExitCode.MISSING and "Traceback" not in said and "bug" not in said
    assert [line for line in lines if line.startswith("error:")] == ["error: cannot write: No space left on device"]


def test_a_full_standard_error_gives_no_verdict(full):
    """The claim is proved; 1 would say that it is violated, 0 that someone was told."""
    assert ended({}, VERIFY)[0] == ExitCode.DONE
    for streams in ({"stderr": full}, {"stdout": full, "stderr": full}):
        assert ended(streams, VERIFY)[0] == ExitCode.MISSING
    assert ended({"stdout": full, "stderr": full}, ["-q", "check", "nowhere"])[0] == ExitCode.INPUT


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_closed_pipe_gives_no_verdict_and_no_words(stream, closed):
    code, said = ended({stream: closed}, [*VERIFY, "--json"])
    assert code == ExitCode.MISSING and "error" not in said
