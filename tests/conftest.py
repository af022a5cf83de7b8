"""Fixtures that many tests share: the shipped expert and a small profile extracted from it."""

import contextlib
import ctypes
import gc
import hashlib
import importlib
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from hypothesis import settings

from codegen import ir
from codegen.agreement import compiled
from codegen.agreement.compiled import find_compiler
from codegen.policy_json import dumps
from tests import seconds
from tests.support.kept import keep_profile

settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=40)
settings.register_profile("random", deadline=None, max_examples=500, print_blob=True)  # --hypothesis-profile=random
settings.load_profile("repeatable")


M_TRIM_THRESHOLD, M_TOP_PAD, M_MMAP_THRESHOLD = -1, -2, -3  # of mallopt(3)

# Workers and commands that tests start keep bytecode, whatever the environment says: half of a start is compiling.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_addoption(parser):
    parser.addoption("--update-golden", action="store_true", help="renew golden files instead of comparing")
    parser.addoption("--seconds", metavar="RECORD", help="write there how long each file took and what was skipped")
    parser.addoption(
        "--left-of", metavar="RECORD", action="append", default=[], help="without what passed in that run (--seconds)"
    )


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """With several workers a file's tests stay together, so that what they share is set up once; and each worker has
    one thread of linear algebra, since more of them wait for one another longer than they compute.
    """
    if config.getoption("numprocesses", None):
        for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
            os.environ.setdefault(name, "1")  # the workers are not there yet
    if config.getoption("numprocesses", None) and config.getoption("dist", "no") in ("no", "load"):
        config.option.dist, config.option.loadscopereorder = "loadfile", False


def pytest_configure(config):
    gc.disable()  # while tests are collected: nearly all that imports make stays, and to look through it takes a second
    draw_nothing_of_sources()
    os.fsync = lambda handle: None  # nothing that tests write must outlive a power cut, and each wait is milliseconds
    read_each_header_once()
    report_less(config)
    if config.getoption("seconds") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(seconds.Recorder(Path(config.getoption("seconds"))))


def draw_nothing_of_sources():
    """Hypothesis draws constants that stand in our modules too, so that each edit would change what properties are
    tested with; and to read all modules takes each worker three seconds in a fresh checkout. It has no option for it.
    """
    with contextlib.suppress(ImportError, AttributeError):
        providers = importlib.import_module("hypothesis.internal.conjecture.providers")
        none = providers._local_constants
        providers._get_local_constants = lambda: none


CLEAN: set[bytes] = set()  # what compilers have read without a warning, as hashes


def read_each_header_once():
    """A compiler that has read a header without a warning is not asked about the same one again in a process."""
    asked = compiled.run

    def run(command, folder, *limit):
        if "-fsyntax-only" not in command:
            return asked(command, folder, *limit)
        texts = sorted((place.name, place.read_bytes()) for place in Path(folder).iterdir())
        read = hashlib.sha256(repr((shutil.which(command[0]), command, texts)).encode()).digest()
        if read not in CLEAN:
            ran = asked(command, folder, *limit)
            if ran.returncode != 0:
                return ran
            CLEAN.add(read)
        return subprocess.CompletedProcess(command, 0, "", "")

    compiled.run = run


SHORT_S = 0.01  # of a setup or teardown of which nobody is told


def report_less(config):
    """A worker says of a test that passes what it took, once; that it begins, is set up and torn down is half of what
    workers say, and hearing it takes the cores from other tests. pytest-xdist has no option for it.
    """
    workers = [each for each in config.pluginmanager.get_plugins() if type(each).__name__ == "WorkerInteractor"]
    for worker in workers:
        worker.sendevent = partial(_send_less, worker.sendevent, [0.0])


def _send_less(send, untold, name, **told):
    """`untold`: the seconds that the next test is said to take longer."""
    data = told.get("data", {})
    if name == "testreport" and data["when"] == "call":
        data["duration"] += untold.pop()
        untold.append(0.0)
    elif name == "testreport" and data["outcome"] == "passed" and data["duration"] < SHORT_S:
        untold[0] += data["duration"]
        return
    if name != "logstart":
        send(name, **told)


def pytest_ignore_collect(collection_path, config):
    """The smoke tests are an inner loop: files without one are not even imported."""
    if config.getoption("markexpr") == "smoke" and collection_path.suffix == ".py":
        return True if "mark.smoke" not in collection_path.read_text(encoding="utf-8") else None
    return None


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Every second worker reads the files from the last to the first: in a fresh checkout each then compiles half of
    them, and finds the others compiled.
    """
    report = yield
    worker = getattr(collector.config, "workerinput", {}).get("workerid", "gw0")
    if int(worker.removeprefix("gw")) % 2 and isinstance(collector, (pytest.Session, pytest.Directory)):
        report.result.reverse()
    return report


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Whole files, and one browser for all that open pages."""
    from tests.support.scheduling import Scheduling

    return Scheduling(config, log) if config.getoption("dist") == "loadfile" else None


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    done = seconds.passed_in(map(Path, config.getoption("left_of")))
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid in done])
    items[:] = [item for item in items if item.nodeid not in done]
    if hasattr(config, "workerinput"):
        items[:] = seconds.longest_first(items, seconds.table())


def pytest_collection_finish():
    """What all tests have loaded is looked through by no further collection of garbage, and those are rarer. Memory of
    large arrays is kept for the next ones: having the system give and clear it anew takes a twentieth of the time.
    """
    gc.freeze()
    gc.enable()
    gc.set_threshold(10_000, 20, 20)
    with contextlib.suppress(AttributeError, OSError, TypeError):  # not glibc
        keep = ctypes.CDLL(None).mallopt
        for option, size in ((M_TRIM_THRESHOLD, 2**30), (M_MMAP_THRESHOLD, 2**30), (M_TOP_PAD, 2**26)):
            keep(option, size)


def pytest_runtest_setup(item):
    if item.get_closest_marker("compile") and find_compiler() is None:
        pytest.skip("no C compiler (cc, gcc, clang or $CC)")
    if item.get_closest_marker("train"):
        pytest.importorskip("torch", reason="the extra maviper[train] is not installed")


@pytest.fixture
def unoptimised(monkeypatch):
    """For tests of what generated code decides: no compiler takes time to optimise C and Rust, which others do."""
    from codegen.agreement import compiled

    monkeypatch.setattr(compiled.Build.__init__, "__defaults__", (False,))
    keep_libraries(monkeypatch)


LIBRARIES: dict[tuple, object] = {}  # by what they are built from; closing one removes its file, and it stays loaded


def keep_libraries(patch):
    """A header is compiled once in a process, however often commands ask for it. Tests of builds do not keep any."""
    from codegen.agreement import compiled

    load = compiled.CompiledC

    def kept(header, model, compiler, optimised=True):
        made_from = header, *compiler, optimised
        if made_from not in LIBRARIES:
            LIBRARIES[made_from] = load(header, model, compiler, optimised)
        return LIBRARIES[made_from]

    patch.setattr(compiled, "CompiledC", kept)


@pytest.fixture
def kept_libraries(monkeypatch):
    """For tests that replay episodes of one profile: its header is compiled for the first."""
    keep_libraries(monkeypatch)


@pytest.fixture
def few_observations(monkeypatch, unoptimised, few_completions):
    """For tests that compile but are about something else: agreement is looked for on a hundredth of the random
    observations and in a tenth of the episodes, beside all thresholds and special values. Tests of agreement itself
    ask all.
    """
    del unoptimised, few_completions
    from codegen.agreement import selfcheck

    sample_less(monkeypatch, "ON_POLICY_EPISODES")
    monkeypatch.setattr(selfcheck.check, "__defaults__", (1_000,))


@pytest.fixture
def few_completions(monkeypatch):
    """For tests that compile many profiles: a threshold is asked about in a quarter of the random observations around
    it, other numbers and world states are fewer too. `tests/faults.py` has every planted fault found by these.
    """
    from codegen.agreement import probes

    for name, fewer in (("FILLINGS", 4), ("WILD", 100), ("TYPED", 40)):
        monkeypatch.setattr(probes, name, fewer)


@pytest.fixture
def few_episodes(monkeypatch):
    """For tests that extract but are about something else than the figures in a profile: fifty held-out episodes,
    not a thousand.
    """
    sample_less(monkeypatch, "EVALUATION_EPISODES", factor=20)


@pytest.fixture
def kept_processes(monkeypatch):
    """For tests that work in several processes: these stay for the next such test, as each loads all before it works.
    Tests of who is left behind start their own.
    """
    from joblib.externals import loky

    class Kept:
        def shutdown(self, wait):
            del wait

    monkeypatch.setattr(loky, "get_reusable_executor", Kept)


@pytest.fixture(scope="module")
def no_kept_processes():
    """For modules whose tests count processes: those that `kept_processes` left end first."""
    from joblib.externals.loky import reusable_executor

    if reusable_executor._executor is not None:
        reusable_executor._executor.shutdown(wait=True)


# Numbers of what is sampled, by name, with the modules that hold one; a test of the house finds those left out.
SAMPLED = {
    "SAMPLES": (
        *("verify.states.shares", "verify.solver.solve", "verify.counterexamples.search", "verify.extent.largest"),
        *("verify.repair", "verify.verdicts.episodes", "maviper.verification.diff", "maviper.evaluation.comparison"),
        "maviper.extraction.refitting",
    ),
    "DRAWN": ("verify.extent.largest",),
    "ON_POLICY_EPISODES": ("maviper.episodes.trees", "maviper.verification.diff"),
    "EVALUATION_EPISODES": ("maviper.evaluation.held_out", "maviper.tour"),
}


def sample_less(patch, *names, factor=10):
    """Divides the named numbers. All modules are loaded before: one that is loaded later would keep what it finds."""
    places = [(importlib.import_module(module), name) for name in names for module in SAMPLED[name]]
    for module, name in places:
        assert getattr(module, name) >= factor, f"{name} was left small by another test"
        patch.setattr(module, name, getattr(module, name) // factor)


def sample_few_states(patch):
    """A tenth of the sampled states and episodes; and a header is compiled once for all replays."""
    sample_less(patch, "SAMPLES", "DRAWN", "ON_POLICY_EPISODES")
    shares = importlib.import_module("verify.states.shares")
    patch.setattr(shares.measure, "__defaults__", (shares.SAMPLES,))
    keep_libraries(patch)


@pytest.fixture
def few_states(monkeypatch):
    """For tests that verify but are about something else than shares: a tenth of the sampled states and episodes.
    Tests of shares, and all that compare with committed reports, ask all.
    """
    sample_few_states(monkeypatch)


@pytest.fixture(scope="module")
def few_states_throughout():
    """As `few_states`, for all tests of a file and what they share."""
    with pytest.MonkeyPatch.context() as patch:
        sample_few_states(patch)
        yield


@pytest.fixture(scope="session")
def world():
    from maviper.worlds import find

    return find("physical-deception")


@pytest.fixture(scope="session")
def expert():
    from maviper.experts import network

    return network.load("physical-deception")[0]


@pytest.fixture(scope="session")
def clone():
    """A network that imitated the script: fixed roles, which small trees learn, and unlearn, at once."""
    from maviper.experts import network

    return network.load("physical-deception@clone")[0]


@pytest.fixture(scope="session")
def profile(world, expert) -> ir.PolicyProfile:
    """A real profile, extracted quickly: few iterations, depth 3."""
    return extracted_quickly(world, expert)


def extracted_quickly(world, expert, **more) -> ir.PolicyProfile:
    """Few iterations, depth 3; kept on disk, since it takes a third of the time of the smoke tests."""
    from maviper.extraction.algorithms import extract
    from maviper.extraction.settings import Settings

    settings = Settings(max_depth=3, iterations=4, rollouts=30, selection_episodes=30, **more)
    return keep_profile(f"{world.name} {expert.hash} {more}", lambda: extract(world, expert, settings))


@pytest.fixture
def profile_file(profile, tmp_path) -> Path:
    path = tmp_path / "profile.json"
    path.write_text(dumps(profile))
    return path


@pytest.fixture
def golden(request):
    """Compares texts with the files of a folder (relative to the project's root), or renews them."""
    root = Path(__file__).parent.parent

    def compare(folder: str, files: dict[str, str | bytes]) -> None:
        encoded = {name: item if isinstance(item, bytes) else item.encode() for name, item in files.items()}
        place = root / folder
        if request.config.getoption("--update-golden"):
            place.mkdir(parents=True, exist_ok=True)
            for name, content in encoded.items():
                (place / name).write_bytes(content)
            return
        for name, content in encoded.items():
            assert (place / name).read_bytes() == content, f"{folder}/{name} is stale: pytest --update-golden renews it"

    return compare
