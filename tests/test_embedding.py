"""generated/embedding/: the committed code in mpe2 and in a simulation in C plays episodes as our simulator does."""

import ast
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pytest

from codegen.agreement.compiled import STRICT, find_compiler
from maviper import load
from maviper.worlds.matching import matching_world
from tests.support import machines
from tests.support.embedding import EMBEDDING, EPISODES, FEW, SEED, ours
from tests.support.generated import FOLDER

PROGRAM = EMBEDDING / "mpe2" / "play.py"
SIMULATION = EMBEDDING / "c_simulation" / "simulation.c"
FLAGS = [*STRICT, "-O2", "-ffp-contract=off"]
WORDS = 2 + 25  # of a line: two successes, the actions of each step
WIDE = 5.0  # standard deviations between two measured shares


@pytest.fixture(scope="module")
def team():
    return load(FOLDER / "profile.json")


@pytest.fixture(scope="module")
def starts(team):
    return matching_world(team).start_from_seeds(range(SEED, SEED + EPISODES))


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
    rows = zip(starts.goal.tolist(), starts.position.reshape(len(starts), -1).tolist(), strict=True)
    place.write_text("".join(f"{goal} {' '.join(value.hex() for value in row)}\n" for goal, row in rows))
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
