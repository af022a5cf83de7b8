"""`maviper verify` and `maviper properties` as users call them."""

import json
import shlex
import sys
from dataclasses import replace
from fractions import Fraction

import pytest

import maviper
from codegen import policy_json
from codegen.errors import ExitCode, ProfileError
from maviper.files.outputs import FOUND
from maviper.verification.run import PROCEDURES, procedure, report_files, verify_claims
from maviper.verification.starters import starter
from maviper.worlds import WORLDS, find
from tests.support.teams import STAY, UP, team, team_in, towards, tree
from tests.support.verifying import run
from verify.claims.built_in import CLAIMS, OfEpisodes
from verify.claims.catalogue import find_claim
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.region_files import everywhere
from verify.kinds import Kind
from verify.question import Question
from verify.reports import report
from verify.reports.report import TELLINGS
from verify.subjects import Game

pytestmark = pytest.mark.usefixtures("few_states_throughout")
FOLDER = "tests/golden"


@pytest.fixture
def place(tmp_path, profile, monkeypatch):
    """A folder with a profile of fixed roles, which every start state proves."""
    monkeypatch.chdir(tmp_path)
    roles = team(profile, towards(0, 0), towards(1, 1))
    (tmp_path / "roles.json").write_text(policy_json.dumps(roles))
    (tmp_path / "same.json").write_text(policy_json.dumps(team(profile, towards(0, 0), towards(0, 1))))
    (tmp_path / "still.json").write_text(policy_json.dumps(team(profile, tree(STAY), tree(UP))))
    return tmp_path


def results(out):
    return json.loads(out)["results"]


def test_the_function_checks_the_profile_first(place):
    profile = maviper.load("roles.json")
    wrong = replace(profile, world=replace(profile.world, damping=float("nan")))
    with pytest.raises(ProfileError, match="damping"):
        maviper.verify(wrong)


@pytest.mark.solver
def test_only_the_start_region_is_called_start(place):
    """Whatever name a caller gives to a region."""
    profile = maviper.load("same.json")
    start = everywhere(profile)
    half = replace(start, box={name: (low / 2, high / 2) for name, (low, high) in start.box.items()})
    claims = [find_claim(name, profile) for name in ("distinct_targets", "covers")]
    asked = [(claim, region) for claim in claims for region in (start, half)]
    assert all(region.name == "start" for _, region in asked)
    results = verify_claims([Question(Game(profile), *one) for one in asked])
    files = report_files(report.document(profile, results, [""] * len(asked)))
    told = [result["region_name"] for result in json.loads(files["report.json"])["results"]]
    assert told == ["start", "", "start", ""]
    assert [line.split()[1] for line in files["report.txt"].splitlines() if line.startswith("   region ")] == [
        "start;", "given;", "start;", "given;"
    ]  # fmt: skip
    assert files["report.html"].count("Region: given.") == 2


def test_the_starter_file(golden):
    golden(FOLDER, {"starter.toml": starter("physical-deception")})


@pytest.mark.solver
def test_the_starter_verifies_as_it_is_written(capsys, tmp_path):
    """On the demo's profile: every property has an answer, the violated ones are replayed."""
    from tests.support.generated import FOLDER as generated

    file = tmp_path / "starter.toml"
    assert run(capsys, "verify", "--new", "physical-deception", "-o", file)[0] == ExitCode.DONE
    code, out, _ = run(capsys, "-q", "verify", generated / "extracted" / "profile.json", "--claims", file, "--json")
    verdicts = [result["verdict"] for result in results(out)]
    assert code == ExitCode.VIOLATED and verdicts == ["VIOLATED"] * 3 + ["PROVED", "VIOLATED", "PROVED"]


@pytest.mark.parametrize("world", sorted({*WORLDS} - {"coordination"}))
def test_every_world_has_a_starter_that_reads(world):
    from verify.claims.files import read_properties

    found = find(world)
    profile = team_in(found, [tree(STAY)] * len(found.agents))
    claims = read_properties(starter(world), profile, "starter.toml", lambda name: None)
    names = {one.claim.name for one in claims}
    assert ("reaches" in names) == (not world.startswith("predator-prey"))
    assert ("keeps_apart" in names) == (not world.startswith("physical-deception"))
    assert len(claims) >= 2 and claims[-1][0].name == "alive_leaves"


def test_the_list_of_properties(capsys):
    code, out, _ = run(capsys, "verify", "--list", "--json")
    found = {one["name"]: one for one in json.loads(out)["claims"]}
    assert code == ExitCode.DONE and found["aligned"]["parameters"] == {"margin": "0", "radius": "0.1", "kappa": "0.5"}
    assert found["steady"]["parameters"] == {"eps": "0.01", "of": "distinct_targets"}
    assert found["reaches"]["parameters"] == {"steps": "", "radius": "0.4", "landmarks": "", "zones": "5000000"}
    code, text, _ = run(capsys, "verify", "--list")
    assert "steps (default: the world's episode)" in text and "landmarks (default: any matching)" in text
    assert code == ExitCode.DONE and all(f"{name}: " in text for name in found)
    assert run(capsys, "verify", "--list")[:2] == (ExitCode.DONE, text)


@pytest.mark.solver
def test_options_reach_the_properties_that_read_them(capsys, place):
    stated = "team=defenders, margin=1/40"
    claims = (f'own_target({stated}, landmarks=["landmark_1", "landmark_0"])', f"no_double({stated})")
    asked = [word for claim in claims for word in ("--claim", claim)]
    code, out, _ = run(capsys, "-q", "verify", "roles.json", *asked, "--json")
    own, double = results(out)
    assert code == ExitCode.VIOLATED and own["verdict"] == "VIOLATED"
    assert own["parameters"] == {"margin": "0.025", "radius": "0.1", "landmarks": "landmark_1, landmark_0"}
    assert double["parameters"] == {"margin": "0.025"}
    again = shlex.split(own["command"])[1:]
    assert "own_target(" in again[3] and "landmarks=" in again[3]
    assert results(run(capsys, "-q", *again, "--json")[1])[0] == own
    code, out, _ = run(capsys, "-q", "verify", "roles.json", "--claim", "aligned(kappa=0)", "--json")
    assert results(out)[0]["parameters"]["kappa"] == "0" and results(out)[0]["verdict"] == "PROVED"


@pytest.mark.solver
def test_steady_and_its_command(capsys, place):
    options = ("--claim", "steady(of=own_target, eps=1/4)")
    code, out, err = run(capsys, "verify", "-v", "roles.json", *options, "--json")
    (found,) = results(out)
    assert code == ExitCode.VIOLATED and found["changing"]["hits"] > 0 and "measures wrongly" in err
    assert any(agent["errors"] for agent in found["counterexample"]["agents"])
    assert found["command"].endswith(""" 'steady(team="defenders", eps=0.25, of="own_target")' --region start""")
    assert results(run(capsys, "-q", *shlex.split(found["command"])[1:], "--json")[1])[0] == found
    _, text, _ = run(capsys, "-q", "verify", "-v", "roles.json", *options)
    assert "off by" in text and "changing " in text


@pytest.mark.solver
def test_dead_leaves_are_printed(capsys, place, profile):
    dead = tree((2, 0.5, 1, 2), STAY, (4, 0.5, 3, 4), UP, (0, -0.5, 5, 6), STAY, UP)
    (place / "dead.json").write_text(policy_json.dumps(team(profile, dead, tree(UP))))
    code, out, _ = run(capsys, "verify", "dead.json", "--claim", "alive_leaves", "-o", "report")
    assert code == ExitCode.VIOLATED and "dead: agent_0 leaf 5" in out and "report      " in out
    (found,) = json.loads((place / "report" / "report.json").read_text())["results"]
    assert [(leaf["agent"], leaf["leaf"]) for leaf in found["leaves"] if leaf["verdict"] == "VIOLATED"] == [
        ("agent_0", 5)
    ]
    assert "agent_0 leaf 5" in (place / "report" / "report.html").read_text()
    assert "agent_0 leaf 5" in (place / "report" / "report.txt").read_text()
    assert run(capsys, "-q", "verify", "still.json", "--claim", "alive_leaves")[0] == ExitCode.DONE
    asked = run(capsys, "-q", "verify", "dead.json", "--claim", "alive_leaves", "--set", "solver_units=1")
    assert asked[0] == ExitCode.INCONCLUSIVE


@pytest.mark.solver
def test_questions_are_exported_and_repeat(capsys, place):
    (place / "p.toml").write_text('[[property]]\nlabel = "; \\"é"\nformula = "true"\nassume = "agent_0.x > 0"\n')
    asked = ("--claim", "no_double", "--claim", "alive_leaves", "--claims", "p.toml")
    for folder in ("one", "two"):
        assert run(capsys, "-q", "verify", "still.json", *asked, "--smt", folder)[0] == ExitCode.DONE
    files = {path.name: path.read_bytes() for path in (place / "one").iterdir()}
    assert files == {path.name: path.read_bytes() for path in (place / "two").iterdir()}
    goals = ("landmark_0", "landmark_1")
    wanted = {f"01-formula-{goal}.smt2" for goal in goals} | {f"02-no_double-{goal}.smt2" for goal in goals}
    assert set(files) == wanted | {f"03-alive_leaves-agent_{k}-0-{goal}.smt2" for goal in goals for k in (0, 1)}
    for text in files.values():
        lines = text.decode("ascii").splitlines()
        assert lines[0].startswith("; Profile ") and lines.count("(check-sat)") == 1


@pytest.mark.solver
def test_a_property_file_end_to_end(capsys, place):
    (place / "sub").mkdir()
    (place / "sub" / "near.toml").write_text("default = [0, 0.5]\n")
    (place / "sub" / "p.toml").write_text(
        '[[property]]\nlabel = "mine"\nformula = """\nengaged(agent_0, landmark_0)\nor true"""\nregion = "near.toml"\n'
        '[[property]]\nname = "distinct_targets"\nassume = "goal == landmark_0"\n'
        '[[property]]\nname = "distinct_targets"\nassume = "agent_0.x > 2"\n'
    )
    code, out, err = run(capsys, "verify", "roles.json", "--claims", "sub/p.toml", "-o", "report", "--json")
    mine, assumed, vacuous = results(out)
    assert code == ExitCode.INCONCLUSIVE and vacuous["verdict"] == "VACUOUS"
    assert mine["label"] == "mine" and mine["formula"].endswith("or true") and mine["region_name"] == "near.toml"
    assert assumed["assumption"] == "goal == landmark_0" and assumed["verdict"] == "PROVED"
    assert assumed["command"] == "maviper verify roles.json --claims p.toml"
    page, text = (place / "report" / "report.html").read_text(), (place / "report" / "report.txt").read_text()
    for shown in (page, text):
        assert "engaged(agent_0, landmark_0)" in shown and "goal == landmark_0" in shown and "mine" in shown
        assert "room " in shown or "largest margin" in shown
    assert "PROVED      mine, region near.toml" in err


EPISODES = (
    '[[property]]\nlabel = "all <arrive>"\nname = "reaches"\nsteps = 4\nradius = 2.5\nzones = 3_000\n'
    '[[property]]\nname = "no_double"\n[[property]]\nname = "covers"\nsteps = 0\n[property.region]\ndefault = [0, 0]\n'
)


@pytest.mark.solver
def test_a_property_file_with_both_kinds_of_claims(capsys, place):
    """Every result in its form, solver questions of the one kind only, certificates with the report's numbers."""
    (place / "p.toml").write_text(EPISODES)
    more = ("--claim", "reaches(radius=5/2)", "--set", "max_zones=9000", "--set", "solver_units=9999999")
    asked = ("--claims", "p.toml", *more)
    code, out, err = run(capsys, "verify", "roles.json", *asked, "-o", "report", "--smt", "smt", "--json")
    arrive, double, cover, named = results(out)
    verdicts = [result["verdict"] for result in results(out)]
    assert code == ExitCode.VIOLATED and verdicts == ["PROVED", "VIOLATED", "PROVED", "PROVED"]
    assert arrive["label"] == "all <arrive>" and arrive["budget"] == 3_000 and named["budget"] == 9_000
    assert arrive["parameters"] == {"steps": "4", "radius": "2.5", "landmarks": "landmark_0, landmark_1"}
    assert cover["parameters"]["landmarks"] == "any matching" and cover["region_name"] == "of property 3"
    assert arrive["command"] == cover["command"] == "maviper verify roles.json --claims p.toml"
    assert double["command"].endswith("--set solver_units=9999999") and "zones=9000)" in named["command"]
    assert results(run(capsys, "-q", *shlex.split(named["command"])[1:], "--json")[1])[0] == named
    names = [path.name for path in (place / "smt").iterdir()]
    assert names and all(name.startswith("02-no_double") for name in names)
    assert "not exported: all <arrive>," in err and "not exported: covers," in err
    assert "PROVED      all <arrive>, region start" in err and "whatever all others do" not in err
    _, out, err = run(capsys, "verify", "-v", "roles.json", *asked)
    assert "PROVED      all <arrive>, region start" in out and "whatever all others do" in err
    page, text = (place / "report" / "report.html").read_text(), (place / "report" / "report.txt").read_text()
    assert "all &lt;arrive&gt;" in page and "1. all <arrive>: PROVED" in text
    for shown in (page, text):
        assert "conflict" in shown and "steps 4, radius 2.5" in shown and "start at rest" in shown


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--claim", "reaches", "--set", "semantics=real"], "reaches is decided for the deployed arithmetic only"),
        (["--claims", "episodes.toml", "--set", "semantics=real"], "deployed arithmetic only"),
        (["--claim", "covers", "--smt", "smt"], "none of these claims gives a query to the solver"),
        (["--claim", "covers", "--set", "solver_units=5"], "none of these claims is decided by the solver"),
        (["--claim", "no_double", "--set", "max_zones=5"], "none of these claims is decided by zones"),
        (["--claims", "episodes.toml", "--steps", "5"], "No such option '--steps'"),
        (["--claim", "covers(kappa=1)"], "covers has no parameter kappa"),
        (["--claim", "cover"], "did you mean 'covers'"),
        (["--claim", "reaches(landmarks=[landmark_0])"], "(landmarks=[landmark_0]): landmarks"),
        (["--claim", "steady(of=reaches)"], "unknown claim 'reaches'"),
        (["--claim", "distinct_targets(kappa=1)"], "distinct_targets has no parameter kappa"),
        (["--claim", "no_double(radius=1)"], "parameter radius"),
        (["--claim", "own_target(landmarks=[landmark_0])"], "different landmark"),
        (["--claim", "own_target(landmarks=[landmark_0,landmrk_1])"], "did you mean 'landmark_1'"),
        (["--claim", "steady(eps=0)"], "eps above 0"),
        (["--claim", "stedy"], "did you mean 'steady'"),
        (["--set", "semantics=reel"], "machine or real"),
        (["--claims", "none.toml"], "cannot read the file"),
        (["--claims", "bad.toml"], "not a readable file of claims"),
        (["--claims", "bytes.toml"], "not UTF-8"),
        (["--claims", "far.toml"], "far.toml, line 3: property 1, region"),
        (["--smt", "roles.json"], "roles.json"),
        (["--claim", "covers", "--where", "--set", "max_cells=7"], "--where is about single decisions"),
        (["--set", "max_cells=7"], "add --where"),
        (["--where", "--set", "max_cells=0"], "between 1 and"),
    ],
)
def test_what_cannot_be_asked_is_told(capsys, place, arguments, message):
    (place / "episodes.toml").write_text(EPISODES)
    (place / "bad.toml").write_text("[[property]")
    (place / "bytes.toml").write_bytes(b"\xff\xfe")
    (place / "good.toml").write_text('[[property]]\nformula = "true"')
    (place / "far.toml").write_text('[[property]]\nformula = "true"\nregion = "elsewhere.toml"')
    code, out, err = run(capsys, "-q", "verify", "roles.json", *arguments)
    assert code == ExitCode.INPUT and message in err and out == "", err


@pytest.mark.solver
def test_a_subnormal_threshold_is_refused_before_anything_is_written(capsys, place, profile):
    (place / "tiny.json").write_text(policy_json.dumps(team(profile, tree((0, 1e-40, 1, 2), STAY, UP), tree(UP))))
    for name in ("distinct_targets", "steady", "alive_leaves"):
        code, _, err = run(capsys, "-q", "verify", "tiny.json", "--claim", name, "-o", "report")
        assert code == ExitCode.INPUT and "subnormal" in err
    assert not list((place / "report").glob("*"))


@pytest.mark.solver
def test_where_a_claim_holds(capsys, place):
    """Zones and the largest region found, as lines, report and files; the region is read back and proved."""
    code, out, err = run(capsys, "verify", "same.json", "--where", "-o", "report")
    assert code == ExitCode.VIOLATED and "VIOLATED" in out and "violating zones\n" in err and " % exactly, " in err
    folder = place / "report"
    (found,) = json.loads((folder / "report.json").read_text())["results"]
    told, zones = found["where"], json.loads((folder / "zones-1-distinct_targets.json").read_text())
    assert told["zones"] == len(zones["violating"]) and told["complete"] and found["command"].endswith(" --where")
    assert told["exact"]["fraction"] == zones["share"] == str(sum(Fraction(one["share"]) for one in zones["violating"]))
    assert found["violating"]["low"] <= told["exact"]["share"] <= found["violating"]["high"]
    assert set(told["leaves"]) == {"agent_0", "agent_1"} and told["most"][0]["words"]
    assert told["region"]["verdict"] == "PROVED" and told["region"]["conflict"]["low"] > 0
    assert told["region"]["visited"]["states"] > 0 and told["region"]["checker"] == "accepted"
    for name in ("report.txt", "report.html"):
        assert "region-1-distinct_targets.toml" in (folder / name).read_text()
    proof = folder / "certificate-1-distinct_targets-region.json"
    assert run(capsys, "check", proof, "--profile", "same.json")[0] == ExitCode.DONE
    region = folder / "region-1-distinct_targets.toml"
    code, out, _ = run(capsys, "-q", "verify", "same.json", "--region", region, "--json")
    (again,) = results(out)
    assert code == ExitCode.DONE and again["conflict"] == told["region"]["conflict"]
    assert again["certificate"]["checker"] == "accepted" and again["visited"] == told["region"]["visited"]
    assert run(capsys, "-q", "verify", "same.json", "--where", "-o", "again")[0] == ExitCode.VIOLATED
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert files == {path.name: path.read_bytes() for path in (place / "again").iterdir()}


@pytest.mark.solver
def test_where_with_bounds_of_a_thousand_digits(capsys, place):
    """Shares are fractions of more digits than Python turns into text; files are read back."""
    bounds = '"agent_0.x" = [-1e-300, 0.7]\n"agent_0.y" = [-0.3, 1e-999]\n"landmark_1.x" = [-1, 1.3e-500]\n'
    (place / "fine.toml").write_text(f"[box]\n{bounds}")
    code, _, err = run(capsys, "verify", "same.json", "--region", "fine.toml", "--where", "-o", "fine")
    assert code == ExitCode.VIOLATED and " % exactly" in err
    (found,) = json.loads((place / "fine" / "report.json").read_text())["results"]
    assert len(found["where"]["exact"]["fraction"]) > sys.get_int_max_str_digits()
    found = place / "fine" / "region-1-distinct_targets.toml"
    assert run(capsys, "-q", "verify", "same.json", "--region", found)[0] == ExitCode.DONE
    replayed = place / "fine" / "counterexample-1-distinct_targets.json"
    assert run(capsys, "replay", replayed, "--profile", "same.json")[0] == ExitCode.VIOLATED


@pytest.mark.solver
def test_where_says_what_it_does_not_know(capsys, place):
    asked = ("--claim", "distinct_targets", "--claim", "alive_leaves", "--where", "-o", "report")
    code, _, err = run(capsys, "verify", "roles.json", *asked)
    assert code == ExitCode.DONE and "holds everywhere in the region" in err and "about leaves" in err
    assert not list((place / "report").glob("zones*")) and not list((place / "report").glob("region*"))
    text = (place / "report" / "report.txt").read_text()
    assert "everywhere in the region" in text and "not available: the claim is about leaves" in text
    _, out, err = run(capsys, "verify", "same.json", "--where", "--set", "max_cells=7", "--json")
    told = results(out)[0]["where"]
    assert told["zones"] == 7 and not told["complete"] and told["exact"] is None
    assert "not all violating zones are known" in told["exact_reason"] and told["exact_reason"] in err
    _, out, _ = run(capsys, "-q", "verify", "-v", "same.json", "--claim", "aligned", "--where")
    assert "only a solver can decide it" in out


def test_an_interrupted_search_leaves_no_file(capsys, place, monkeypatch):
    from verify.extent import largest

    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(largest, "where", interrupted)
    code, out, _ = run(capsys, "verify", "same.json", "--where", "-o", "report")
    assert code == ExitCode.INTERRUPTED and out == "" and not (place / "report").exists()


def test_a_region_found_overwrites_no_region_of_the_user(capsys, place, monkeypatch):
    """Neither one that is asked about, by option or property file, nor a file that is no region found."""
    from verify.extent import largest as extent

    monkeypatch.setattr(extent, "where", lambda *given: pytest.fail("asked before"))
    folder = place / "report"
    folder.mkdir()
    mine = folder / "region-1-distinct_targets.toml"
    (folder / "asked.toml").write_text(f'[[property]]\nname = "distinct_targets"\nregion = "{mine.name}"\n')
    found = f"{FOUND} a claim\n"
    for text, arguments in (
        ("default = [0, 1]\n", ()),
        (found, ("--region", mine)),
        (found, ("--claims", folder / "asked.toml")),
    ):
        mine.write_text(text)
        code, out, err = run(capsys, "-q", "verify", "same.json", *arguments, "--where", "-o", "report")
        assert code == ExitCode.INPUT and out == "" and "would overwrite" in err and mine.name in err
        assert mine.read_text() == text and sorted(path.name for path in folder.iterdir()) == ["asked.toml", mine.name]


@pytest.mark.solver
def test_a_region_found_says_what_holds_in_it_and_is_found_again(capsys, place):
    for _ in range(2):
        assert run(capsys, "-q", "verify", "same.json", "--where", "-o", "report")[0] == ExitCode.VIOLATED
    first = (place / "report" / "region-1-distinct_targets.toml").read_text().splitlines()[0]
    assert first.startswith(FOUND) and "distinct_targets of the defenders" in first
    text = (place / "report" / "report.txt").read_text()
    part = text[text.index("holds in ") :]
    bounds = part[part.index("goal ") : part.index("all other bounds are those of the region above")]
    assert 1 < len(bounds.splitlines()) < 8 and "-1 <= adversary_0.x" not in bounds


def test_a_kind_of_claim_has_an_entry_in_each_table():
    assert set(PROCEDURES) == set(TELLINGS) == set(Kind)
    assert {name for name, kind in CLAIMS.items() if issubclass(kind, OfEpisodes)} == set(EPISODE_CLAIMS)
    assert procedure(EPISODE_CLAIMS["covers"]("team", 3)) is not PROCEDURES[Kind.DECISIONS]()
