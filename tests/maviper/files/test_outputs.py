"""An output folder holds the files of one run: what an earlier run of the verb left there goes, a user's files stay."""

from functools import partial
from pathlib import Path

import pytest

from codegen import policy_json
from codegen.errors import ExitCode, InputError
from maviper.cli import main
from maviper.files import outputs
from tests.support.observations import blind, far, robust
from tests.support.teams import tree

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.solver
CLAIM = '[[property]]\nlabel = "q"\nformula = "angle < {} implies acts(cart) == left"\n'


def run(*arguments):
    return main.run([*map(str, arguments)])


def names(folder):
    return {path.name for path in folder.iterdir()}


@pytest.fixture
def place(tmp_path):
    """`left` and `late` go left up to 0 and up to 0.5; `claim` says: up to 0.25."""
    for name, threshold in (("early", 0.0), ("late", 0.5)):
        cart = blind({"cart": tree((0, threshold, 1, 2), 0, 2)})
        (tmp_path / f"{name}.json").write_text(policy_json.dumps(cart))
    (tmp_path / "claim").write_text(CLAIM.format(0.25))
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "certificate-of-mine.json").write_text("{}")
    (tmp_path / "out" / "region-1-mine.toml").write_text("[box]\nangle = [-1, 1]\n")
    return tmp_path


def test_no_certificate_of_before_stands_beside_violated(place):
    given, out = names(place / "out"), place / "out"
    asked = ["--claims", place / "claim", "-o", out]
    assert run("verify", place / "late.json", *asked) == 0
    assert "certificate-1-formula.json" in names(out)
    assert run("verify", place / "early.json", *asked, "--where") == 1
    assert "certificate-1-formula.json" not in names(out) and given < names(out)
    left = names(out)
    assert {"counterexample-1-formula.json", "zones-1-formula.json", "region-1-formula.toml"} < left
    region = out / "region-1-formula.toml"
    assert run("verify", place / "late.json", *asked, "--region", region) == 0
    assert region.exists()  # it was asked about
    assert run("verify", place / "late.json", *asked) == 0
    fresh = place / "fresh"
    assert run("verify", place / "late.json", *asked[:-1], fresh) == 0
    assert names(out) - given - {"profile.json"} == names(fresh)  # a profile may be the user's


def texts(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_profile_that_no_run_wrote_is_never_written_over(place, capsys):
    """Neither by a verb for the first time, nor after the verb was run on that very profile in its place."""
    out, other = place / "out", place / "late.json"
    (out / "profile.json").write_text((place / "early.json").read_text())
    asked = ["--claims", place / "claim"]
    for _ in range(2):
        before = texts(out)
        for verb in (["verify", other, *asked], ["diff", other, place / "early.json"], ["repair", other]):
            assert run(*verb, "-o", out) == 2
            told = capsys.readouterr().err
            assert "another profile.json" in told and "choose another folder with -o" in told
        assert texts(out) == before
        assert run("verify", out / "profile.json", *asked, "-o", out) == 1  # in its place
        assert (out / "profile.json").read_text() == (place / "early.json").read_text()
    for name in ("early", "late", "early"):  # a folder of its own may hold one profile after another
        assert run("verify", place / f"{name}.json", *asked, "-o", place / "own") == (name == "early")
        assert (place / "own" / "profile.json").exists() == (name == "early")
    (place / "own" / "profile.json").write_text("edited")
    assert run("verify", other, *asked, "-o", place / "own") == 2


def test_another_verb_is_no_earlier_run(place):
    for name, threshold in (("a", 30.0), ("b", 40.0)):
        (place / name).write_text(policy_json.dumps(far(threshold, 1)))
    assert run("diff", place / "a", place / "b", "-o", place / "both") == 1
    before = (place / "both" / "profile.json").read_bytes()
    assert run("verify", place / "late.json", "--claims", place / "claim", "-o", place / "both") == 2
    assert run("diff", place / "b", place / "a", "-o", place / "both") == 1
    assert (place / "both" / "profile.json").read_bytes() != before
    (region := place / "both" / "certificate.json").write_text("[box]\n")
    assert run("diff", place / "b", place / "a", "--region", region, "-o", place / "both") == 2
    assert region.read_text() == "[box]\n"


def test_an_edited_property_file_is_not_written_over(tmp_path, capsys):
    path = tmp_path / "claims.toml"
    asked = ["verify", "--new", "physical-deception", "-o", path]
    assert run(*asked) == 0 and run(*asked) == 0
    path.write_text("mine")
    assert run(*asked) == 2 and path.read_text() == "mine"
    assert "choose another name with -o" in capsys.readouterr().err


def test_a_repair_that_finds_nothing_leaves_none_of_before(place, monkeypatch):
    from dataclasses import replace

    from maviper.verification import repair as repairs

    profile, out = place / "proved.json", place / "repaired"
    profile.write_text((ROOT / "generated" / "proved_defenders" / "profile.json").read_text())
    asked = ["repair", profile, "--episodes", "2", "-o", out]
    search, answers = repairs.repair, []
    monkeypatch.setattr(repairs, "repair", lambda *given: answers.append(search(*given)) or answers[0])
    assert run(*asked) == 0 and {"profile.json", "repair.json"} < names(out)
    (out / "mine").write_text("mine")
    monkeypatch.setattr(repairs, "repair", lambda *given: replace(answers[0], ended=False, reason="none"))
    region = out / "region.toml"
    region.write_text('[box]\n"agent_0.x" = [-0.5, 0.5]\n')
    assert run(*asked, "--region", region) == 3 and "repair.json" in names(out)  # a file given is there too
    region.unlink()
    assert run(*asked) == 3 and names(out) == {"mine"}
    assert run(*asked) == 3 and names(out) == {"mine"}


def test_a_comparison_leaves_no_certificate_of_before(place):
    out = place / "out"
    for name, threshold in (("a", 30.0), ("b", 40.0)):
        (place / name).write_text(policy_json.dumps(far(threshold, 1)))
    assert run("diff", place / "a", place / "a", "-o", out) == 0 and "certificate.json" in names(out)
    assert run("diff", place / "a", place / "b", "-o", out) == 1 and "certificate.json" not in names(out)


def test_radii_leave_no_certificate_of_before(place):
    out = place / "out"
    (place / "seen.csv").write_text("angle\n-0.5\n0.75\n")
    asked = partial(robust, place / "early.json", place / "seen.csv", "-o", out)
    assert run(*asked(certify=True)) == 0 and "certificate-2-robust.json" in names(out)
    assert run(*asked()) == 0 and not {name for name in names(out) if name.endswith("robust.json")}


@pytest.mark.usefixtures("few_observations")
def test_code_of_another_profile_goes_with_what_was_compared(place):
    out, mine = place / "out", "imported_main.c"
    (out / mine).write_text("int main(void) { return 0; }")
    assert run("compile", place / "early.json", "--target", "c,python", "-o", out) in (0, 3)
    assert run("compile", place / "early.json", "--target", "json", "-o", out) in (0, 3)
    assert {"imported.py", "imported.json"} < names(out)  # all of one profile
    assert run("compile", place / "late.json", "--target", "c", "-o", out) in (0, 3)
    assert {"imported.h", mine} < names(out) and not {"imported.py", "imported.json"} & names(out)


def test_queries_of_before_go_too(place):
    folder = place / "queries"
    (place / "two").write_text(CLAIM.format(0.25) + CLAIM.format(0.5))
    asked = ["verify", place / "late.json", "--verdict-only", "--smt", folder]
    assert run(*asked, "--claims", place / "two") == 0
    assert "02-formula-no-goal.smt2" in names(folder)
    assert run(*asked, "--claims", place / "claim") == 0
    assert not {name for name in names(folder) if name.startswith("02-")}


def test_what_a_manifest_lists_goes_unless_it_was_changed(tmp_path):
    for name, text in (("old", "of before"), ("changed", "by its user"), ("new", "again")):
        (tmp_path / name).write_text(text)
    before = '{"sha256": {"old": "%s", "changed": "0", "new": "%s", "../outside": "%s"}}'
    digests = [outputs.sha256(text.encode()).hexdigest() for text in ("of before", "again", "mine")]
    folder = tmp_path / "folder"
    folder.mkdir()
    (tmp_path / "outside").write_text("mine")
    for path in (tmp_path / name for name in ("old", "changed", "new")):
        path.rename(folder / path.name)
    (folder / "manifest.json").write_text(before % tuple(digests))
    outputs.write_listed(folder, {"new": "more"}, "manifest.json")
    assert names(folder) == {"changed", "new", "manifest.json"} and (tmp_path / "outside").exists()


def test_a_listed_run_writes_over_nothing_that_is_not_its_own(tmp_path):
    folder, digest = tmp_path / "folder", outputs.sha256(b"first").hexdigest()
    files = {"profile.json": "first", "manifest.json": f'{{"sha256": {{"profile.json": "{digest}"}}}}'}
    outputs.write_listed(folder, files, "manifest.json")
    outputs.write_listed(folder, {**files, "profile.json": "second"}, "manifest.json")
    for name, text in (("profile.json", "by its user"), ("manifest.json", "{}")):
        (folder / name).write_text(text)
        with pytest.raises(InputError, match=f"another {name}, which no earlier run wrote") as caught:
            outputs.write_listed(folder, files, "manifest.json")
        assert caught.value.where == str(folder / name) and (folder / name).read_text() == text
        (folder / name).write_text(files[name])
    outputs.write_listed(folder, files, "manifest.json")


def test_a_region_that_a_property_file_names_stays_in_the_folder_of_results(place):
    """Region files are seen from the folder of the property file, which need not be the region's own."""
    out, claim = place / "out", place / "claim"
    assert run("verify", place / "early.json", "--claims", claim, "-o", out, "--where") == 1
    found = out / "region-1-formula.toml"
    text = found.read_text()
    (place / "asked").write_text(f'{CLAIM.format(0.25)}region = "out/{found.name}"\n')
    again = ["--claims", place / "asked", "-o", out]
    assert run("verify", place / "early.json", *again) == 0 and found.read_text() == text
    assert run("verify", place / "early.json", *again, "--where") == 2 and found.read_text() == text


def test_a_profile_stays_in_the_folder_that_it_is_compiled_into(place, few_observations):
    """Also where its name is that of code, and the code there is of another profile."""
    out = place / "code"
    assert run("compile", place / "early.json", "--target", "json,python", "-o", out) == 3  # no tree as grown
    (given,) = out.glob("*[!t].json")
    given.write_text((place / "late.json").read_text())
    assert run("compile", given, "--target", "python", "-o", out) == 3
    assert given.read_text() == (place / "late.json").read_text()
    given.write_text(f"{given.read_text()}\n")  # the same profile, written otherwise
    assert run("compile", given, "--target", "json", "-o", out) == 2 and given.read_text().endswith("\n\n")


def test_a_file_that_a_run_was_given_is_neither_written_over_nor_removed(place, capsys):
    """Whatever it is called, and also if an earlier run of the verb left its mark in the folder."""
    out, claim = place / "out", place / "claim"
    rows, early = "angle\n0.1\n", (place / "early.json").read_text()
    (out / "seen").write_text(rows)
    assert run(*robust(place / "early.json", out / "seen", "-o", out)) == 0
    for name, text, words in (
        ("certificate-1-robust.json", early, robust("GIVEN", out / "seen", certify=True)),
        ("certificate-1-robust.json", rows, robust(place / "early.json", "GIVEN", certify=True)),
        ("certificate-2-robust.json", early, robust("GIVEN", out / "seen")),
        ("certificate-2-robust.json", rows, robust(place / "early.json", "GIVEN")),
        ("report.html", early, ["verify", "GIVEN", "--claims", claim]),
        ("play.html", CLAIM.format(0.25), ["verify", place / "early.json", "--claims", "GIVEN"]),
    ):
        (out / name).write_text(text)
        code = run(*[str(word).replace("GIVEN", str(out / name)) for word in words], "-o", out)
        assert (out / name).read_text() == text, name
        assert (code == ExitCode.INPUT) == ("would overwrite the file given" in capsys.readouterr().err), name
        assert code == (0 if "-2-" in name else ExitCode.INPUT), name
        (out / name).unlink()
