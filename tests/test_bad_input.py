"""The sweep: whatever a user feeds the commands, the answer is an error in words or a verdict, never a traceback.

Every example runs the real command. After it, the output folder holds whole files or nothing.
"""

import copy
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen import policy_json, profiles
from codegen.errors import ExitCode
from maviper.cli import main
from tests.support.strategies import WORLD
from verify.claims.region_files import positions

pytestmark = pytest.mark.usefixtures("few_states_throughout")

ANSWERS = {ExitCode.DONE, ExitCode.VIOLATED, ExitCode.INPUT, ExitCode.INCONCLUSIVE}
WORDS = ["", " ", "x", "agent_0", "goal_dx", "x*/", "a\nb", "__init__", "é", "a" * 100, "../../x", "%s%n", "{{7*7}}"]
NAMES = st.sampled_from([*WORDS, "\x00"])
EXTREMES = st.sampled_from([0, -1, 1e308, 1e-320, 2**31])
NUMBERS = st.one_of(st.integers(-(2**70), 2**70), st.floats(allow_nan=True, allow_infinity=True), EXTREMES)
VALUES = st.one_of(
    NAMES, NUMBERS, st.none(), st.booleans(), st.lists(NUMBERS, max_size=3), st.dictionaries(NAMES, NUMBERS, max_size=2)
)


def paths_of(value, path=()):
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from paths_of(item, (*path, key))


def edit(document, path, change, value):
    """Applies one edit to a copy of the document."""
    document = copy.deepcopy(document)
    if not path:
        return value
    here = document
    for key in path[:-1]:
        here = here[key]
    if change == "replace":
        here[path[-1]] = value
    elif change == "delete":
        del here[path[-1]]
    elif change == "add" and isinstance(here, dict):
        here["extra"] = value
    elif change == "repeat" and isinstance(here, list):
        here.append(here[path[-1]])
    return document


def run(*arguments):
    return main.run([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def document(profile):
    return json.loads(policy_json.dumps(profile))


@pytest.fixture
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("bad")


@pytest.fixture(scope="module")
def shared_place(tmp_path_factory):
    """One folder for all examples of a hypothesis test; each overwrites its input file."""
    return tmp_path_factory.mktemp("sweep")


@settings(max_examples=max(250, settings.default.max_examples))
@given(data=st.data())
def test_edited_profiles(document, shared_place, data):
    """One or two random edits anywhere; the hash is dropped half of the time, so that later checks are reached."""
    changed = document
    if data.draw(st.booleans(), label="drop the hash"):
        changed = {key: value for key, value in document.items() if key != "content_hash"}
    for _ in range(data.draw(st.integers(1, 2))):
        path = data.draw(st.sampled_from(list(paths_of(changed))), label="path")
        change = data.draw(st.sampled_from(["replace", "delete", "add", "repeat"]), label="change")
        changed = edit(changed, path, change, data.draw(VALUES, label="value"))
        if not isinstance(changed, dict):
            break
    file = shared_place / "profile.json"
    file.write_text(json.dumps(changed))
    assert run("-q", "show", file) in ANSWERS


@settings(max_examples=max(40, settings.default.max_examples))
@given(st.binary(max_size=300), st.integers(0, 2**31))
def test_damaged_bytes(document, shared_place, noise, seed):
    """Bytes overwritten, cut off or inserted."""
    text = bytearray(json.dumps(document).encode())
    at = random.Random(seed).randrange(len(text))
    text[at : at + len(noise)] = noise
    file = shared_place / "profile.json"
    file.write_bytes(bytes(text))
    assert run("-q", "show", file) in ANSWERS


FASTER = {"name": "vx", "unit": "length/s", "range": [-9, 9], "meaning": "agent_0.vx"}


@pytest.mark.parametrize(
    ("place_of", "value", "says"),
    [
        (("dt",), -0.1, "$.world.dt: must be from 0"),
        (("agents", 1, "force"), -5.0, "$.world.agents[1].force: must be from 0"),
        (("start_box",), [1.0, -1.0], "$.world.start_low: is above start_high"),
        (("landmarks", 0, "start_box"), [1.0, -1.0], "$.world.landmarks[0].start_box: needs low <= high"),
        (("damping",), 0.0, "nothing bounds agent_0.vx"),
        (("damping",), 1e-320, "nothing bounds agent_0.vx"),
        (("agents", 1, "force"), -0.0, ""),
        (("landmarks", 0, "start_box"), [0.0, -0.0], ""),
    ],
)
@pytest.mark.usefixtures("few_observations")
def test_start_regions_that_are_none(document, place, capsys, place_of, value, says):
    """Whatever a start region is computed from: speeds in it come from force, time step and damping."""
    changed = {key: item for key, item in copy.deepcopy(document).items() if key != "content_hash"}
    changed["agents"][1]["features"].append(FASTER)
    changed = edit(changed, ("world", *place_of), "replace", value)
    (place / "profile.json").write_text(json.dumps(changed))
    for command, *more in (["verify"], ["compile", "--pass", "drop", "--region", "start"]):
        asked = [command, place / "profile.json", *more, "-o", place / "out"]
        code = run("-q", *asked)
        assert code in ANSWERS, command
        assert not says or (code == ExitCode.INPUT and says in capsys.readouterr().err)


TOML_VALUES = st.one_of(
    st.floats(-3, 3).map(repr), st.integers(-3, 3).map(str),
    st.sampled_from(["nan", "inf", "true", '"1/3"', '"1/0"', "1e400", "[]", "{}", "1979-05-27", '"x"', "9" * 500]),
)  # fmt: skip


@st.composite
def regions(draw):
    """Region files, most of them wrong somewhere."""
    names = st.sampled_from([*positions(WORLD.spec), "agent_9.x", "agent_0", "goal.x", ""])
    lines = []
    if draw(st.booleans()):
        lines.append(f"goals = [{draw(st.sampled_from(['', 'landmark_0', 'landmark_7']))!r}]")
    if draw(st.booleans()):
        lines.append(f"default = [{draw(TOML_VALUES)}, {draw(TOML_VALUES)}]")
    for table in ("box", "difference", "apart"):
        if draw(st.booleans()):
            lines.append(f"[{table}]")
            for _ in range(draw(st.integers(0, 2))):
                key = draw(names) if table == "box" else f"{draw(names)} - {draw(names)}"
                value = draw(TOML_VALUES)
                lines.append(f'"{key}" = {value}' if table == "apart" else f'"{key}" = [{value}, {draw(TOML_VALUES)}]')
    return "\n".join(lines)


@pytest.mark.solver
@given(regions())
def test_random_region_files(document, shared_place, region):
    (shared_place / "profile.json").write_text(json.dumps(document))
    (shared_place / "region.toml").write_text(region)
    asked = ("-q", "verify", shared_place / "profile.json", "--region", shared_place / "region.toml", "--json")
    assert run(*asked) in ANSWERS


NO_TEXTS = [b"\xff\xfe", b"\x00", b"[" * 10_000, b"a = " + b"[" * 5_000, b"x" * 2**21, b"", b"[[property]]\n" * 10_000]


@pytest.mark.parametrize("source", NO_TEXTS, ids=lambda text: repr(text[:12]))
@pytest.mark.parametrize("option", ["--region", "--claims"])
@pytest.mark.smoke
def test_files_that_are_not_text(document, place, option, source):
    (place / "profile.json").write_text(json.dumps(document))
    (place / "given.toml").write_bytes(source)
    code = run("-q", "verify", place / "profile.json", option, place / "given.toml")
    assert code in ANSWERS if (option, source) == ("--region", b"") else code == ExitCode.INPUT


PARAMETERS = {
    "team": ["", "adversaries", "defenders\n", "x"],
    "margin": ["", "nan", "inf", "-1", "1e999", "1/0", "2/-3", "9" * 5000, "0x1"],
    "radius": ["", "nan", "-0.5", "1_000", "1/3"],
    "kappa": ["", "1"],
    "eps": ["", "0", "nan", "1/100"],
    "landmarks": ["", ",", "landmark_0", "landmark_0,landmark_0"],
    "of": ["", "aligned", "steady"],
}
OPTIONS = {
    "--claim": ["", "distinct_targets ", "own_target", "é"],
    "--set": ["", *(f"solver_units={each}" for each in ("", "0", "-1", "1", "2.5", "9" * 30)), "semantics=Real"],
    "--claims": ["", ".", "no/such", "profile.json"],
    "--region": ["", "/", "..", "\x00" if os.name == "nt" else "no/such", "start "],
}


@pytest.mark.solver
@pytest.mark.parametrize(
    ("parameter", "value"), [(parameter, value) for parameter, values in PARAMETERS.items() for value in values]
)
def test_parameters_of_claims(document, place, parameter, value):
    (place / "profile.json").write_text(json.dumps(document))
    for claim in ("distinct_targets", "aligned", "steady", "own_target"):
        for written in (json.dumps(value), value):
            stated = f"{claim}({parameter}={written})"
            assert run("-q", "verify", place / "profile.json", "--claim", stated) in ANSWERS


@pytest.mark.solver
@pytest.mark.parametrize(
    ("option", "value"), [(option, value) for option, values in OPTIONS.items() for value in values]
)
def test_options_of_verify(document, place, option, value):
    (place / "profile.json").write_text(json.dumps(document))
    assert run("-q", "verify", place / "profile.json", option, value) in ANSWERS


FORMULA_WORDS = st.sampled_from([
    "acts(agent_0)", "==", "left", "closes(agent_0, goal)", "agent_0.x", "landmark_0", "goal", ">=", "0.5", "1/0",
    "(", ")", "|", "not", "and", "or", "implies", "in", "[stay]", "distance(agent_0, goal)", "*", "1e400", "'", "\x00",
])  # fmt: skip


@st.composite
def property_files(draw):
    """Property files, most of them wrong somewhere: in TOML, a key, a value or a formula."""
    lines = []
    for _ in range(draw(st.integers(0, 2))):
        lines.append(draw(st.sampled_from([*["[[property]]"] * 3, "[property]", "[[x]]", "["])))
        if draw(st.booleans()):
            lines.append("formula = " + json.dumps(" ".join(draw(st.lists(FORMULA_WORDS, max_size=8)))))
        for key in draw(st.lists(st.sampled_from(["name", "team", "label", "assume", "of", "region"]), max_size=2)):
            words = "steady,alive_leaves,covers,defenders,start,false,agent_0.x > 3,aligned,x,"
            lines.append(f"{key} = {draw(st.sampled_from(words.split(',')))!r}")
        numbers = ["margin", "eps", "kappa", "landmarks", "steps", "zones", "x"]
        for key in draw(st.lists(st.sampled_from(numbers), max_size=1)):
            lines.append(f"{key} = {draw(TOML_VALUES)}")
        if draw(st.booleans()):
            lines += ["[property.region.box]", f'"agent_0.x" = [{draw(TOML_VALUES)}, {draw(TOML_VALUES)}]']
    return "\n".join(lines)


@pytest.mark.solver
@settings(max_examples=max(60, settings.default.max_examples))
@given(property_files())
def test_random_property_files(document, shared_place, source):
    (shared_place / "profile.json").write_text(json.dumps(document))
    (shared_place / "p.toml").write_text(source)
    asked = ("-q", "verify", shared_place / "profile.json", "--claims", shared_place / "p.toml", "--json")
    assert run(*asked) in ANSWERS


@pytest.mark.solver
def test_ctrl_c_while_a_property_is_decided(document, place):
    """A question that the solver cannot finish soon; one line says that it was interrupted."""
    (place / "profile.json").write_text(json.dumps(document))
    hard = " and ".join(
        f"acts(agent_{k % 2}) != stay or {n} * agent_0.x + agent_1.y > 0" for k, n in enumerate(range(99))
    )
    (place / "p.toml").write_text(f'[[property]]\nformula = "{hard}"\n' * 60)
    command = [sys.executable, "-m", "maviper", "verify", "profile.json", "--claims", "p.toml"]
    process = subprocess.Popen(command, cwd=place, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    first = process.stderr.readline()  # it listens
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert first and process.returncode == ExitCode.INTERRUPTED
    assert "error: interrupted" in err and "Traceback" not in err


LOOP_PARAMETERS = {
    "steps": ["", "-1", "0", "2.5", "1001", "9" * 30],
    "zones": ["", "0", "1", "-1", "9" * 30],
    "radius": ["nan", "-1", "0", "9" * 30],
    "landmarks": ["", ",", "landmark_0", "landmark_0,landmark_0", "nowhere,landmark_1", " landmark_1 , landmark_0"],
}


@pytest.mark.parametrize("name", ["reaches", "covers"])
@pytest.mark.parametrize(
    ("parameter", "value"), [(parameter, value) for parameter, values in LOOP_PARAMETERS.items() for value in values]
)
def test_parameters_of_claims_about_episodes(document, place, name, parameter, value):
    (place / "profile.json").write_text(json.dumps(document))
    stated = {"steps": 4, parameter: value}
    asked = f"{name}({', '.join(f'{key}={json.dumps(each)}' for key, each in stated.items())})"
    assert run("-q", "verify", place / "profile.json", "--claim", asked) in ANSWERS


EXTRACT = [
    ["--seed", "-1"], ["--seed", "9" * 30], ["--max-depth", "65"], ["--max-depth", "0"], ["--rollouts", "0"],
    ["--iterations", "1000000"], ["--set", "selection_episodes=-5"], ["--set", "selection_episodes=100001"],
    ["--preset", ""], ["--algorithm", "viper"],
]  # fmt: skip


@pytest.mark.parametrize("arguments", EXTRACT, ids=" ".join)
def test_options_of_extract(place, arguments):
    assert run("-q", "extract", "physical-deception", *arguments, "-o", place / "p.json") == ExitCode.INPUT
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("source", ["", ".", "/dev/null", "no/such/run", "physical_deception", "profile.json"])
def test_what_is_not_an_expert(place, document, source, monkeypatch):
    monkeypatch.chdir(place)
    (place / "profile.json").write_text(json.dumps(document))
    assert run("-q", "extract", source, "-o", place / "p.json") == ExitCode.INPUT
    assert not (place / "p.json").exists()


@pytest.mark.parametrize("command", ["show", "verify", "compile"])
def test_huge_files_are_refused_before_they_are_read(place, command):
    with (place / "huge.json").open("wb") as file:
        file.truncate(profiles.MAX_BYTES + 1)  # sparse: takes no room on the disk
    options = ["-o", place / "out"] if command == "compile" else []
    assert run("-q", command, place / "huge.json", *options) == ExitCode.INPUT


def test_a_profile_of_a_hundred_thousand_nodes(document, place):
    """Large but legal numbers of nodes: an unbalanced chain is refused for its depth, not by a crash."""
    changed = {key: value for key, value in copy.deepcopy(document).items() if key != "content_hash"}
    split = next(node for node in changed["agents"][1]["tree"] if "feature" in node)
    n = 50_000
    chain = [split | {"left": k + 1, "right": 2 * n - k} for k in range(n)]
    changed["agents"][1] |= {"tree": chain + [{"action": "stay"}] * (n + 1), "grown": None}
    (place / "profile.json").write_text(json.dumps(changed))
    assert run("-q", "show", place / "profile.json") == ExitCode.INPUT


LAST = """
import atexit, os, sys, time
atexit.register(time.sleep, 1.0)
atexit.register(os.write, 2, b"ending\\n")  # what is registered last is called first
sys.argv = ["maviper", "--version"]
from maviper.__main__ import main
main()
"""


def test_interrupted_after_its_end():
    """A command that has said how it ended keeps that word while the interpreter tidies up."""
    process = subprocess.Popen([sys.executable, "-c", LAST], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stderr.readline() == "ending\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "") and out.startswith("maviper")
