"""The verbs of the package: documented, typed, with the defaults of the command line, and the same answers."""

import ast
import inspect
import re
import textwrap
from fractions import Fraction
from pathlib import Path

import pytest

import maviper
from codegen import ir, policy_json
from codegen.errors import InputError, RefusedError, UnknownNameError
from codegen.rows import Shown
from maviper import answers, claims
from maviper.verification.ask import number
from verify.result import Verdict

ROOT = Path(__file__).parents[2]
PROVED = ROOT / "generated" / "proved_defenders"
CERTIFICATE = PROVED / "certificate-1-distinct_targets.json"


@pytest.mark.parametrize("name", maviper.__all__)
def test_every_verb_has_an_example_that_parses(name):
    """Indented lines below an empty one, in which the package is named."""
    text = inspect.getdoc(getattr(maviper, name))
    examples = [part for part in re.findall(r"(?<=\n\n)(?: {4}.*\n?)+", text) if "maviper." in part]
    assert examples, f"maviper.{name} shows no example"
    for example in examples:
        ast.parse(textwrap.dedent(example))


@pytest.mark.parametrize("name", maviper.__all__)
def test_every_verb_says_its_types_and_is_no_folder(name):
    verb = getattr(maviper, name)
    signature = inspect.signature(verb)
    assert inspect.getdoc(verb) and signature.return_annotation is not inspect.Signature.empty
    assert not (ROOT / "maviper" / name).exists()
    for parameter in signature.parameters.values():
        assert parameter.annotation is not inspect.Parameter.empty
        assert parameter.kind not in (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)


def test_a_stated_system_by_function_and_by_command():
    """The same answers as tests/test_worlds.py has from the command line."""
    folder = ROOT / "generated" / "worlds"
    found = maviper.verify_system(maviper.load(folder / "corridor.json"), str(folder / "corridor.toml"))
    assert [result.verdict for result in found.results] == [Verdict.PROVED]
    with pytest.raises(InputError, match="unknown agent"):
        maviper.verify_system(maviper.load(folder / "pendulum.json"), folder / "corridor.toml")


def test_each_class_that_users_name_has_an_example():
    for named in (*vars(answers).values(), *vars(claims).values()):
        if isinstance(named, type) and named.__module__.split(".")[0] in ("maviper", "verify"):
            lines = [line for line in inspect.cleandoc(named.__doc__).split("\n") if line.startswith("    ")]
            assert lines, named
            ast.parse(inspect.cleandoc("\n".join(["", *lines])))


@pytest.mark.parametrize("name", [name for name in vars(maviper.Team) if name[0] != "_" and name != "played"])
def test_each_method_of_a_team_has_an_example(name):
    text = inspect.getdoc(getattr(maviper.Team, name))
    (example,) = re.findall(r"(?<=\n\n)(?: {4}.*\n?)+", text)[:1]
    assert re.search(r"\bteam\b|Team", example) and ast.parse(textwrap.dedent(example))


def test_options_are_read_by_name_nowhere():
    for path in (ROOT / "maviper").rglob("*.py"):
        assert not re.search(r"options\[[\"']", path.read_text()), path


@pytest.mark.parametrize(
    ("value", "found"),
    [(None, None), ("1/40", Fraction(1, 40)), (0.025, Fraction(1, 40)), (2, 2), (Fraction(1, 3),) * 2],
)
def test_numbers_are_exact(value, found):
    assert number(value, "margin") == found


@pytest.mark.parametrize("value", ["much", float("nan"), float("inf"), "1/0"])
def test_what_is_no_number_is_told(value):
    with pytest.raises(InputError, match="not a number"):
        number(value, "margin")


@pytest.fixture(scope="module")
def proved():
    return maviper.load(PROVED / "profile.json")


@pytest.mark.solver
def test_verify_takes_parameters(profile, tmp_path):
    (tmp_path / "near.toml").write_text("default = [-0.1, 0.1]")
    found = maviper.verify(
        profile, "own_target", tmp_path / "near.toml", margin=0.025, landmarks=["landmark_1", "landmark_0"]
    )
    assert found.claim.margin == Fraction(1, 40) and found.claim.landmarks == ("landmark_1", "landmark_0")
    assert found.region.name == "near.toml"
    steps = maviper.verify(profile, claims.Covers(steps=2), max_zones=10)
    assert maviper.verify(profile, "covers", steps=2, max_zones=10).claim == steps.claim
    assert steps.claim.steps == 2 and steps.cost.budget == 10
    assert maviper.verify(profile, solver_units=5).verdict in (Verdict.UNKNOWN, Verdict.VIOLATED)
    with pytest.raises(UnknownNameError, match="distinct_target"):
        maviper.verify(profile, "distinct_target")
    with pytest.raises(InputError, match="distinct_targets has no parameter steps"):
        maviper.verify(profile, steps=3)
    with pytest.raises(InputError, match="no effect without where"):
        maviper.verify(profile, max_cells=7)


@pytest.mark.solver
def test_verify_file_answers_in_the_files_order(profile, tmp_path):
    (tmp_path / "p.toml").write_text(
        '[[property]]\nname = "no_double"\n[[property]]\nformula = "true"\nlabel = "mine"\n'
    )
    found = maviper.verify_file(profile, tmp_path / "p.toml")
    assert [each.claim.shown for each in found] == [row["claim"] for row in found.rows] == ["no_double", "mine"]
    assert found[1].proved and len(found.to_csv().splitlines()) == 1 + len(found) and "<table>" in found._repr_html_()
    with pytest.raises(InputError, match="max_cells has no effect without where"):
        maviper.verify_file(profile, tmp_path / "p.toml", max_cells=5)
    (tmp_path / "p.toml").write_text('[[property]]\nname = "no_doubl"\n')
    with pytest.raises(UnknownNameError) as error:
        maviper.verify_file(profile, tmp_path / "p.toml")
    assert "p.toml, line 2" in error.value.where


@pytest.mark.parametrize("name", maviper.__all__)
def test_what_a_verb_returns_has_rows(name):
    """A list of answers would have neither `rows` nor `to_csv`."""
    returned = str(inspect.signature(getattr(maviper, name)).return_annotation)
    if returned not in ("Team", "PolicyProfile", "str", "dict[str, Any]"):  # teams, `version` and `train`
        for kind in returned.replace("AnyResult", "Result").split(" | "):
            assert issubclass(getattr(answers, kind), Shown)


def test_check_says_what_a_certificate_proves(proved, profile):
    found = maviper.check(CERTIFICATE)
    assert found.closed > 0 and "distinct_targets of the defenders" in found.subject and "region start" in found.subject
    assert maviper.check(str(CERTIFICATE), proved) == found == maviper.check(CERTIFICATE, PROVED / "profile.json")
    with pytest.raises((InputError, RefusedError)):
        maviper.check(CERTIFICATE, profile)


@pytest.mark.solver
def test_repair_returns_the_profile_and_its_cost(proved):
    found = maviper.repair(proved, episodes=5)
    assert found.repair.ended and found.repair.guards == () and found.after == proved
    assert found.results[0].verdict is Verdict.PROVED and found.cost.compared


@pytest.mark.solver
def test_repair_takes_a_claim_as_an_object(proved):
    claim = claims.OwnTarget(landmarks=["landmark_0", "landmark_1"])
    found = maviper.repair(proved, claim, episodes=2)
    assert found.claim == maviper.repair(proved, "own_target", landmarks=claim.landmarks, episodes=2).claim
    with pytest.raises(InputError, match="aligned cannot be repaired"):
        maviper.repair(proved, claims.Aligned(kappa=1))
    with pytest.raises(InputError, match="the claim is an object, which has margin itself"):
        maviper.repair(proved, claim, margin="1/100")


def test_compile_takes_passes_and_vectors(profile):
    found = maviper.compile(profile, ["json"], passes=["merge"], test_vectors=True)
    assert found.notes[0].startswith("merge: ") and any("vectors" in name for name in found.files)
    assert found.proofs is None


def test_extract_writes_nothing_unless_it_is_told_where(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    small = {"max_depth": 1, "iterations": 1, "rollouts": 2, "selection_episodes": 4, "refinement_episodes": 0}
    found = maviper.extract("physical-deception", **small)
    assert not list(tmp_path.iterdir()) and capsys.readouterr() == ("", "")
    again = maviper.extract("physical-deception", "p.json", **small)
    assert policy_json.dumps(again) == policy_json.dumps(found) == (tmp_path / "p.json").read_text()
    drawn = maviper.extract("physical-deception", max_samples=2, **{**small, "max_depth": 6})
    assert all(len(ir.leaves(policy.tree)) <= 2 for policy in drawn.agents)  # a leaf has a point, at least
    with pytest.raises(InputError, match="several seeds need a run folder"):
        maviper.extract("physical-deception", seeds=2, **small)
    measured = maviper.evaluate(tmp_path / "p.json", against=["random"], team="defenders", episodes=3)
    assert (
        measured.episodes == 3
        and list(measured.against) == ["random"]
        and set(measured.trees) == {"agent_0", "agent_1"}
    )


def test_train_without_torch_is_told(tmp_path, monkeypatch):
    import sys

    from codegen.errors import MissingToolError

    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(MissingToolError):
        maviper.train("physical-deception", tmp_path / "run", settings={"games": 4})
