"""Names from files that look like others, or steer a terminal: nothing of them is printed as it stands."""

import json

import pytest

import maviper
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.policy_json import dumps
from codegen.profiles import UNSEEN, check
from codegen.wording import visible
from maviper.cli import exits, main
from maviper.console import Console, say
from tests.support.altered import edited, sealed
from tests.support.episode_cases import arriving
from tests.support.small import small_profile
from tests.support.teams import team, towards

pytestmark = pytest.mark.usefixtures("few_states_throughout")
STRANGE = [
    *("agent_0\u200b", "аgent_0", "agent_0\r", "\x1b[2Kagent_0"),
    *("agent_0\naccepted", "agent_0\u202e", "\x9b2J", "é"),
]


def plain(text):
    return all(" " <= letter <= "~" for letter in text)


@pytest.mark.parametrize("name", STRANGE)
def test_what_is_shown_is_ascii_on_one_line(name):
    assert plain(escape_text(name)) and escape_text(name) != name and escape_text("agent_0 \\x") == "agent_0 \\x"
    assert visible(name).isprintable() and visible("ärger\tя") == "ärger\tя"
    assert plain(str(UnknownNameError("agent", name, ["agent_0", "other"])).replace("\n", ""))


def test_errors_and_lines_steer_no_terminal(capsys):
    def failing():
        raise InputError("a\x1b[2Kb", "c\u200bd\ne\rf", "g\x85h")

    assert exits.run_command(failing, False) == 2
    assert capsys.readouterr().err == "error: a\\x1b[2Kb\n  c\\u200bd\n  e\\rf\n  g\\x85h\n"
    Console().line("la\x1bbel", "text\u202e\n")
    say("one\x1b\ntwo")
    assert capsys.readouterr() == ("one\\x1b\ntwo\n", "la\\x1bbel      text\\u202e\n")


# --- profiles


@pytest.fixture(scope="module")
def document():
    found = json.loads(dumps(small_profile()))
    return {key: value for key, value in found.items() if key != "content_hash"}


PLACES = [
    ("world", "name"), ("world", "agents", 0, "name"), ("world", "landmarks", 0, "name"), ("world", "goals", 0),
    ("agents", 1, "agent"), ("agents", 1, "team"), ("agents", 1, "features", 0, "name"),
    ("agents", 1, "features", 0, "meaning"), ("agents", 1, "actions", 0, "name"), ("agents", 1, "tree", 0, "feature"),
    ("agents", 1, "tree", 1, "float32"), ("semantics",), ("content_hash",), ("agents", 1, "strange", "member"),
]  # fmt: skip
TEXTS = [
    ("world", "reference"), ("agents", 1, "features", 0, "unit"), ("provenance", "algorithm"),
    ("provenance", "preset"), ("provenance", "expert"), ("provenance", "tool"), ("world", "options", "prey"),
    ("provenance", "training", "repair"),
]  # fmt: skip


@pytest.mark.parametrize("name", STRANGE)
def test_profiles_with_strange_names_are_refused_in_plain_words(document, tmp_path, capsys, name):
    file = tmp_path / "profile.json"
    for place in PLACES:
        file.write_text(json.dumps(edited(document, place, name)))
        assert main.run(["show", str(file)]) == 2, place
        out, err = capsys.readouterr()
        assert not out and plain(err.replace("\n", "")), place
    file.write_text(json.dumps(document | {name: 1}))
    assert main.run(["show", str(file)]) == 2 and plain(capsys.readouterr().err.replace("\n", ""))


@pytest.mark.solver
def test_texts_that_are_no_names_are_seen(document, tmp_path, capsys):
    """Such texts may be in any language; where they stand for a name they are shown in plain letters."""
    file = tmp_path / "profile.json"
    for place in TEXTS:
        for text in STRANGE:
            file.write_text(json.dumps(edited(document, place, text)))
            seen = text.isprintable()
            assert main.run(["-q", "show", str(file)]) == (0 if seen else 2), (place, text)
            said = capsys.readouterr().err
            assert plain(said.replace("\n", "")) and (seen or "an invisible character" in said)
    for place in TEXTS:
        document = edited(document, place, "mpе2")  # the third letter is Cyrillic
    file.write_text(json.dumps(document))
    assert main.run(["verify", str(file), "-o", str(tmp_path)]) in (0, 1)
    assert plain(capsys.readouterr().err.replace("\n", ""))
    report = (tmp_path / "report.txt").read_text()
    assert plain(report.replace("\n", "")) and "mp\\u04352" in report


def test_a_region_file_that_no_file_can_be_called_is_refused(document, tmp_path, capsys):
    file, claims = tmp_path / "profile.json", tmp_path / "claims.toml"
    file.write_text(json.dumps(document))
    claims.write_text('[[property]]\nname = "alive_leaves"\nregion = "a\\u0000b"\n')
    assert main.run(["verify", str(file), "--claims", str(claims), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "an invisible character" in said and plain(said.replace("\n", ""))


def test_every_text_of_a_profile_is_looked_at(document):
    """A place in a profile's JSON that holds a text has a rule, as a name or as a text."""
    known = {place[-1] for place in (*PLACES, *TEXTS)} | {"meaning", "action"}
    listed = {"seed", "threshold", "left", "right", "range", "effect", "schema_version", "grown"}

    def texts(value, key):
        if isinstance(value, dict):
            for name, item in value.items():
                yield from texts(item, name)
        elif isinstance(value, list):
            for item in value:
                yield from texts(item, key)
        elif isinstance(value, str) and key not in listed:
            yield key

    assert set(texts(document, "")) <= known | {"goals"}
    assert check(small_profile()) == () and "Cf" in UNSEEN


# --- certificates and counterexamples


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A team that violates and one that is proved, with their files."""
    found = tmp_path_factory.mktemp("names")
    for name, pair in (("same", (towards(0, 0), towards(0, 1))), ("roles", (towards(0, 0), towards(1, 1)))):
        folder = found / name
        folder.mkdir()
        (folder / "profile.json").write_text(dumps(team(small_profile(), *pair)))
        asked = ["verify", str(folder / "profile.json"), "--claim", "distinct_targets", "--claim", "covers"]
        assert main.run(["-q", *asked, "-o", str(folder)]) == 1
    arrivers, small = team(small_profile(), arriving(0), arriving(1)), found / "small.toml"
    small.write_text("default = [-0.02, 0.02]\n")
    (found / "arrivers").mkdir()
    (found / "arrivers" / "profile.json").write_text(dumps(arrivers))
    asked = ["verify", str(found / "arrivers" / "profile.json"), "--claim", "reaches", "--region", str(small)]
    assert main.run(["-q", *asked, "-o", str(found / "arrivers")]) == 0
    return found


def variants(document, name):
    """The document with `name` in each place that holds a text, as a member or as a key."""
    for key, value in document.items():
        rest = {other: item for other, item in document.items() if other != key}
        yield rest | {name: value}
        if isinstance(value, str):
            yield document | {key: name}
        elif isinstance(value, dict):
            yield from (document | {key: inner} for inner in variants(value, name))
        elif isinstance(value, list) and value and isinstance(value[0], str):
            yield document | {key: [name, *value[1:]]}
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            yield from (document | {key: [inner, *value[1:]]} for inner in variants(value[0], name))


@pytest.mark.solver
@pytest.mark.parametrize("name", [STRANGE[0], STRANGE[1], STRANGE[3], STRANGE[4]])
@pytest.mark.parametrize("which", ["roles/certificate-1-distinct_targets.json", "arrivers/certificate-1-reaches.json"])
def test_whatever_a_certificate_says_is_checked_or_shown_in_plain_letters(place, tmp_path, capsys, which, name):
    document, beside = json.loads((place / which).read_text()), (place / which).parent / "profile.json"
    accepted = 0
    for changed in variants({key: value for key, value in document.items() if key != "content_hash"}, name):
        file = tmp_path / "c.json"
        file.write_text(sealed(changed))
        code = main.run(["check", str(file), "--profile", str(beside)])
        out, err = capsys.readouterr()
        assert plain(out.replace("\n", "")) and plain(err.replace("\n", "")) and out.count("\n") <= 1
        accepted += code == 0
    assert accepted == 1, "the name of the region, which nothing rests on and nobody is shown"


@pytest.mark.solver
@pytest.mark.usefixtures("unoptimised")
@pytest.mark.parametrize("name", [STRANGE[1], STRANGE[3]])
@pytest.mark.parametrize("file", ["counterexample-1-distinct_targets.json", "counterexample-2-covers.json"])
def test_whatever_a_counterexample_says_is_shown_in_plain_letters(place, tmp_path, capsys, file, name):
    document = json.loads((place / "same" / file).read_text())
    document["explanation"] = {}
    told = set()
    for changed in variants(document, name):
        (tmp_path / "c.json").write_text(json.dumps(changed))
        code = main.run(["replay", str(tmp_path / "c.json"), "--profile", str(place / "same" / "profile.json")])
        out, err = capsys.readouterr()
        told.add(code)
        assert code in (1, 2) and plain(out.replace("\n", "")) and plain(err.replace("\n", "")), err
    assert told == {1, 2}
    assert maviper.replay(place / "same" / file, place / "same" / "profile.json").violated
