"""generated/embedding/: the policies in mpe2, in C, in C++17, in a web page, in JaxMARL and in VMAS, beside our
simulator.
"""

import ast
import importlib.util
import json
import re
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pytest

from codegen import ir
from codegen.agreement.compiled import STRICT, find_compiler
from codegen.lowering.lower import lower
from codegen.lowering.render import render
from codegen.observe import observe
from codegen.targets import emit
from maviper import load
from maviper.episodes.play import play, tree_policies
from maviper.worlds import WorldState
from maviper.worlds.games.particle import SUCCESS
from maviper.worlds.matching import matching_world
from tests.support import machines
from tests.support.generated import FOLDER

EMBEDDING = FOLDER.parent / "embedding"
PROGRAM = EMBEDDING / "mpe2" / "play.py"
SIMULATION = EMBEDDING / "c_simulation" / "simulation.c"
FLAGS = [*STRICT, "-O2", "-ffp-contract=off"]
WORDS = 2 + 25  # of a line: two successes, the actions of each step
MODULES = {"jax": "jaxmarl", "torch": "vmas"}
SEED, EPISODES, FEW, MANY = 9_600_000, 4_000, 200, 10_000
BEGIN, END = "/* begin physical_deception.mjs", "/* end physical_deception.mjs */"
PUBLIC = "AGENTS, COORDINATES, DT, DAMPING, FORCE, EFFECTS, act_team"


@pytest.fixture(scope="module")
def team():
    return load(FOLDER / "profile.json")


@pytest.fixture(scope="module")
def starts(team):
    return matching_world(team).start_from_seeds(range(SEED, SEED + EPISODES))


def ours(team, starts, ends=True):
    """What our simulator says of episodes from these starts, in the lines of the programs; C's say where they end."""
    world = matching_world(team)
    episodes = play(world, [tree_policies(team.agents)] * len(team.agents), starts)
    rows = [world.measures.index(measure) for measure in world.measures if measure.name == SUCCESS[0]]
    assert [world.measures[row].team for row in rows] == ["adversaries", "defenders"] and len(starts) > 0
    successes = episodes.values[rows].astype(int)
    actions = episodes.actions.transpose(1, 0, 2).tolist()
    last = episodes.states[-1].position[:, : len(team.agents)].reshape(len(starts), -1).tolist()
    lines = []
    for wins, steps, end in zip(successes.T.tolist(), actions, last, strict=True):
        words = [*map(str, wins), *("".join(map(str, step)) for step in steps)]
        lines.append(" ".join([*words, *(f"{value:.17g}" for value in end)] if ends else words))
    assert all(0 < row.sum() < len(starts) for row in successes), "nothing to tell apart"
    return [*lines, *summary(successes)]


def summary(successes):
    n = successes.shape[1]
    teams = zip(("adversaries", "defenders"), successes.sum(axis=1).tolist(), strict=True)
    return [f"{team} success r=0.316: {wins} of {n} episodes, {wins / n:.3f}" for team, wins in teams]


def rows_of(starts):
    return zip(starts.goal.tolist(), starts.position.reshape(len(starts), -1).tolist(), strict=True)


def printed(*command, **options):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


# --- mpe2


def test_mpe2_played_by_the_generated_module_is_our_simulator(team, starts, tmp_path):
    options = ["--episodes", FEW, "--seed", SEED, "--each"]
    found = printed(sys.executable, PROGRAM, *options, cwd=tmp_path, env={"PATH": "/usr/bin:/bin"})
    assert found == ours(team, starts[:FEW], ends=False)


def test_the_program_needs_mpe2_and_the_module_only():
    nodes = list(ast.walk(ast.parse(PROGRAM.read_text())))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in nodes if isinstance(node, ast.ImportFrom)]
    assert {name.split(".")[0] for name in names} - sys.stdlib_module_names == {"mpe2", "physical_deception"}


# --- C


def compilers():
    """Every compiler here, the one that the tests use first."""
    usual = find_compiler()
    found = [usual] if usual else []
    return found + [[name] for name in ("gcc", "clang") if shutil.which(name) and [name] != usual]


def written(starts, place):
    """Starts as the simulation reads them, in hexadecimal floats."""
    place.write_text("".join(f"{goal} {' '.join(value.hex() for value in row)}\n" for goal, row in rows_of(starts)))
    return place.name


@pytest.mark.compile
def test_every_compiler_plays_our_starts_as_our_simulator_does(team, starts, tmp_path):
    wanted, name = ours(team, starts), written(starts, tmp_path / "starts.txt")
    for place, compiler in enumerate(compilers()):
        for level in ("-O0", "-O3"):
            program = tmp_path / f"simulation{place}{level}"
            built = [*compiler, *FLAGS, level, str(SIMULATION), "-o", str(program)]
            assert subprocess.run(built, check=False).returncode == 0, built
            assert printed(program, "--starts", name, "--each", cwd=tmp_path) == wanted, built


@pytest.mark.compile
@pytest.mark.parametrize("machine", machines.MACHINES)
def test_machines_of_32_bits_play_the_same_episodes(machine, team, starts, tmp_path):
    name = written(starts[:FEW], tmp_path / "starts.txt")
    machines.build(machine, tmp_path, SIMULATION, FLAGS)
    done = machines.run(machine, tmp_path, "--starts", name, "--each")
    assert done.returncode == 0, done.stderr
    found, wanted = done.stdout.splitlines(), ours(team, starts[:FEW])
    if machine == "x87":  # its products and sums are rounded twice
        assert [line.split()[:WORDS] for line in found] == [line.split()[:WORDS] for line in wanted]
        ends = [np.array([line.split()[WORDS:] for line in lines[:FEW]], float) for lines in (found, wanted)]
        np.testing.assert_allclose(*ends, rtol=0, atol=1e-12)
    else:
        assert found == wanted


# --- their pages


@pytest.mark.compile
@pytest.mark.parametrize(("name", "tool"), [("c_simulation", "cc"), ("mpe2", "python")])
def test_a_pages_command_prints_what_it_shows(name, tool, golden, tmp_path):
    shutil.copytree(FOLDER, tmp_path / FOLDER.name)
    place = tmp_path / "embedding" / name
    shutil.copytree(EMBEDDING / name, place)
    page = (place / "README.md").read_text().splitlines()
    command, *shown = [number for number, line in enumerate(page) if line.startswith("    ")]
    run = page[command].strip()
    assert len(page) <= 25 and (name == "mpe2" or run in SIMULATION.read_text())
    wanted = find_compiler() if tool == "cc" else [sys.executable]
    run = run.removeprefix("pip install mpe2 && ").replace(f"{tool} ", f"{shlex.join(wanted)} ", 1)
    for number, line in zip(shown, printed("sh", "-c", run, cwd=place), strict=True):
        page[number] = f"    {line}"
    golden(f"generated/embedding/{name}", {"README.md": "\n".join(page) + "\n"})


# --- C++ and the page


@pytest.mark.compile
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_the_program_in_cpp_plays_as_our_simulator(compiler, team, starts, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    flags = [flag for flag in STRICT if flag not in ("-std=c99", "-Wconversion")]
    source, program = EMBEDDING / "cpp" / "play.cpp", tmp_path / "play"
    subprocess.run([compiler, "-std=c++17", *flags, "-O2", "-ffp-contract=off", source, "-o", program], check=True)
    given = "".join(f"{goal} {' '.join(map(repr, row))}\n" for goal, row in rows_of(starts[:FEW]))
    done = subprocess.run([program, "--starts"], input=given, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ours(team, starts[:FEW], ends=False)[:FEW]
    assert subprocess.run([program, "0"], capture_output=True, check=False).returncode == 2


@pytest.mark.compile
def test_the_readme_of_cpp_shows_what_it_prints(golden, tmp_path):
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed")
    command = ["g++", "-std=c++17", "-O2", "-ffp-contract=off", EMBEDDING / "cpp" / "play.cpp", "-o", tmp_path / "play"]
    subprocess.run(command, check=True)
    said = subprocess.run([tmp_path / "play"], capture_output=True, text=True, check=True).stdout
    page = (EMBEDDING / "cpp" / "README.md").read_text()
    lines = "".join(f"    {line}\n" for line in said.splitlines())
    golden("generated/embedding/cpp", {"README.md": re.sub(r"(    \w+ success .*\n)+", lines, page)})


def test_the_page_holds_the_module(team, golden):
    """Written anew: `pytest tests/test_embedded.py --update-golden`."""
    page = (EMBEDDING / "page" / "index.html").read_text()
    code = render("javascript/module.js.j2", model=lower(team)).replace("\nexport ", "\n")
    before, rest = page.split(BEGIN)
    first = BEGIN + rest.split("\n")[0]
    inside = f"{first}\nconst policy = (() => {{\n{code}return {{ {PUBLIC} }};\n}})();\n{END}"
    golden("generated/embedding/page", {"index.html": before + inside + page.split(END)[1]})
    assert "</script" not in code and "http" not in page


DRIVER = """
const lines = STARTS.map(([goal, position]) => {
  const w = world(goal, position), found = [0, 0], actions = [];
  for (let t = 0; t < STEPS; t++) {
    const chosen = policy.act_team(w);
    actions.push(chosen.join(""));
    step(w, chosen);
    reached(w).forEach((now, team) => (found[team] |= now));
  }
  return [...found, ...actions].join(" ");
});
console.log(lines.join("\\n"));
"""


def test_the_page_plays_as_our_simulator(team, starts, tmp_path):
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    scripts = re.findall(r"<script>\n(.*?)</script>", (EMBEDDING / "page" / "index.html").read_text(), flags=re.S)
    given = json.dumps([[goal, row] for goal, row in rows_of(starts[:FEW])])
    (tmp_path / "play.js").write_text("\n".join([*scripts[:2], DRIVER.replace("STARTS", given)]))
    done = subprocess.run(["node", "play.js"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert len(scripts) == 3 and done.stdout.splitlines() == ours(team, starts[:FEW], ends=False)[:FEW]


@pytest.mark.parametrize("library", MODULES)
def test_the_modules_beside_the_programs_are_the_compilers(library, team, golden):
    golden(f"generated/embedding/{MODULES[library]}", emit(team, [library]))


@pytest.mark.parametrize("name", ["jaxmarl", "vmas", "cpp", "page"])
def test_its_page_is_short(name):
    lines = (EMBEDDING / name / "README.md").read_text().splitlines()
    assert 10 <= len(lines) <= 25 and lines[0].startswith("# The generated policies in ")


# --- simulators of others


def program(name, monkeypatch):
    """The program as a module."""
    pytest.importorskip(name, reason="the extra maviper[interop] is not installed", exc_type=ImportError)
    monkeypatch.syspath_prepend(str(EMBEDDING / name))
    spec = importlib.util.spec_from_file_location(f"{name}_play", EMBEDDING / name / "play.py")
    found = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, found)
    spec.loader.exec_module(found)
    return found


def arrays(played):
    """Successes [2, episodes], actions [episodes, steps, agents], positions [episodes, steps, entities, 2], goals."""
    adversary, defenders, actions, positions, goal = (np.asarray(each) for each in played)
    return np.stack([adversary, defenders]), actions, positions.astype(np.float64), goal


def acted(team, positions, goal):
    """The profile's actions in these states, [episodes, steps, agents]."""
    episodes, steps = positions.shape[:2]
    at_goal = positions[np.arange(episodes), :, 3 + goal][:, :, None]
    places = np.concatenate([positions, at_goal], axis=2).reshape(episodes * steps, -1)
    states = np.concatenate([places, np.zeros((len(places), 6))], axis=1)
    found = [ir.act(policy, observe(policy.features, states, team.world, policy.numbers)) for policy in team.agents]
    return np.stack(found, axis=1).reshape(episodes, steps, -1)


def successes(team, positions, goal):
    """What our simulator says of episodes from the same starts, [2, episodes], and its actions."""
    starts = WorldState(positions[:, 0], np.zeros((len(goal), 3, 2)), goal.astype(np.int64))
    world = matching_world(team)
    episodes = play(world, [tree_policies(team.agents)] * len(team.agents), starts)
    rows = [world.measures.index(measure) for measure in world.measures if measure.name == SUCCESS[0]]
    return episodes.values[rows] > 0, episodes.actions.transpose(1, 0, 2)


@pytest.mark.interop
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")
def test_jaxmarl_plays_as_our_simulator(team, monkeypatch):
    found, actions, positions, goal = arrays(program("jaxmarl", monkeypatch).play(MANY, seed=1))
    assert found.shape == (2, MANY) and len(set(goal.tolist())) == 2
    assert (actions == acted(team, positions, goal)).all(), "in its own states, every action is the profile's"
    wanted, of_ours = successes(team, positions, goal)
    print(f"JaxMARL {found.mean(axis=1)}, ours {wanted.mean(axis=1)}, actions equal {(actions == of_ours).mean()}")
    assert np.abs(found.mean(axis=1) - wanted.mean(axis=1)).max() < 0.01
    assert (actions == of_ours).mean() > 0.99 and (found == wanted).mean() > 0.99


@pytest.mark.interop
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")
def test_vmas_needs_its_force_to_be_mpe2s(team, monkeypatch):
    vmas = program("vmas", monkeypatch)
    found, actions, positions, goal = arrays(vmas.play(MANY, seed=1))
    assert len(set(goal.tolist())) == 2
    assert (actions == acted(team, positions, goal)).all(), "in its own states, every action is the profile's"
    wanted, _ = successes(team, positions, goal)
    weak = arrays(vmas.play(MANY, seed=1, force=1.0))[0]
    print(f"VMAS {found.mean(axis=1)}, with force 1 {weak.mean(axis=1)}, ours {wanted.mean(axis=1)}")
    assert found[1].mean() >= wanted[1].mean() - 0.01 and abs(found[0].mean() - wanted[0].mean()) < 0.03
    assert weak[1].mean() < 0.4 * wanted[1].mean()
