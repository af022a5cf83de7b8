"""A build: lowered once, written once and compiled once, whoever uses it."""

from collections import Counter
from pathlib import Path

import pytest

from codegen import policy_json
from codegen.agreement import compiled as compiled_c
from codegen.agreement.compiled import Build, build
from codegen.errors import ExitCode
from codegen.lowering import lower as lowering
from codegen.targets import TARGETS, emit
from maviper.cli import main
from maviper.compilation.compile import compile_profile
from maviper.verification.run import verify_claims
from tests.support.teams import team, towards
from verify.claims.catalogue import find_property
from verify.claims.region_files import everywhere
from verify.question import Question
from verify.result import Verdict
from verify.subjects import Game


@pytest.fixture
def counted(monkeypatch):
    """How often a profile was lowered and a library was built."""
    done = Counter()
    distinct, run = lowering.ensure_distinct, compiled_c.run

    def lowered(model, *more):
        done["lowered"] += 1
        return distinct(model, *more)

    def ran(command, folder):
        done["libraries"] += "-shared" in command
        return run(command, folder)

    monkeypatch.setattr(lowering, "ensure_distinct", lowered)
    monkeypatch.setattr(compiled_c, "run", ran)
    return done


@pytest.mark.compile
def test_a_compile_lowers_once_and_builds_one_library(profile, counted):
    done = compile_profile(profile, ["c", "python", "json", "smt"])
    assert {item.target for item in done.report.agreements} >= {"c", "python", "json", "smt", "episodes driven by c"}
    assert counted == {"lowered": 1, "libraries": 1}


@pytest.mark.compile
def test_proofs_and_vectors_use_the_same_build(profile, counted, tmp_path):
    (tmp_path / "profile.json").write_text(policy_json.dumps(profile))
    command = ["compile", str(tmp_path / "profile.json"), "--target", "c", "--prove", "--test-vectors"]
    assert main.run([*command, "-o", str(tmp_path / "out")]) == ExitCode.DONE
    assert len(list((tmp_path / "out").glob("*.vectors.txt"))) == 1 and counted == {"lowered": 1, "libraries": 1}


@pytest.mark.compile
@pytest.mark.solver
@pytest.mark.smoke
def test_a_verify_compiles_for_its_first_replay_only(profile, counted):
    apart = team(profile, towards(0, 1), towards(1, 1))
    claim, start = find_property("distinct_targets", apart), everywhere(apart)
    (proved,) = verify_claims([Question(Game(apart), claim, start)])
    assert proved.verdict is Verdict.PROVED and counted["libraries"] == 0, "nothing was replayed"
    found = verify_claims([Question(Game(profile), claim, start)] * 2)
    assert found[0].verdict is Verdict.VIOLATED and "compiled C" in found[0].evidence.replays
    assert counted == {"lowered": 1, "libraries": 1}, "not for a proof, and once for two questions"


@pytest.mark.solver
def test_a_proof_needs_no_header(profile, monkeypatch):
    apart = team(profile, towards(0, 1), towards(1, 1))

    def refuse(*_):
        raise AssertionError("a header was written")

    monkeypatch.setitem(TARGETS, "c", refuse)
    (proved,) = verify_claims([Question(Game(apart), find_property("distinct_targets", apart), everywhere(apart))])
    assert proved.verdict is Verdict.PROVED


@pytest.mark.compile
def test_the_library_is_removed_with_its_build(profile):
    with build(profile, ["c"]) as made:
        folder = Path(made.library._folder.name)
        assert made.library is made.library and folder.is_dir()
    assert not folder.exists()


def test_a_build_without_a_header_or_compiler_is_not_compilable(profile, monkeypatch):
    assert not build(profile, ["json"]).compilable
    monkeypatch.setenv("CC", "no-such-compiler")
    made = build(profile, TARGETS)
    assert not made.compilable and made.files == emit(profile, TARGETS)
    assert Build(profile, made.model, {}).text("h") is None and made.text("py") and made.text("nothing") is None
