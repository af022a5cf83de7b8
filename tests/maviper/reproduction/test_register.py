"""The register of claims: what it must hold, and that faults in it are named, all at once."""

import hashlib
import json
import re

import pytest

from codegen.errors import InputError
from maviper.reproduction import register
from maviper.worlds import find
from maviper.worlds.world import RETURN

REGISTERED = "a17febb3b0762eb4a10b6d61ab51b37e3735f25c0c80b7babcdfb5b92518a3b5"  # before the records


@pytest.fixture
def text():
    return register.FILE.read_text()


def faults(tmp_path, text):
    path = tmp_path / "claims.toml"
    path.write_text(text)
    with pytest.raises(InputError) as found:
        register.read(path)
    return str(found.value)


def test_the_register_holds_the_papers_claims():
    known = register.read()
    assert len(known.claims) >= 65 and len(known.sha256) == len(known.more) == 64
    assert {claim.test for claim in known.claims} == set(register.TESTS)
    assert {claim.statistic for claim in known.claims} == set(register.STATISTICS)
    main = {claim.family for claim in known.claims if claim.main}
    assert main == {"joint deception", "joint navigation", "table 1", "ablation"}


def test_figures_have_the_papers_numbers():
    """Individual performance is figure 2, joint 3, importances 4, ablation 5, reward 6 and 7, exploitability 8."""
    found = {}
    for claim in register.read().claims:
        for number in re.findall(r"figure (\d+)", claim.place):
            found.setdefault(int(number), set()).add(claim.id.partition("-")[0])
    assert found == {
        2: {"individual"},
        3: {"joint"},
        4: {"features"},
        5: {"ablation"},
        6: {"reward"},
        7: {"reward"},
        8: {"exploitability", "number"},
    }


def test_at_most_six_claims_are_never_compared_and_none_of_them_is_an_order():
    numbers = [claim for claim in register.read().claims if claim.test == register.NUMBER]
    assert 0 < len(numbers) <= 6
    assert all(claim.reason and not claim.second for claim in numbers)


def test_measures_and_lineups_are_those_of_the_games():
    for claim in register.read().claims:
        worlds = [find(game) for game in claim.list_values("game")]
        labels = {each.label for world in worlds for each in world.measures}
        labels |= {f"{team} {RETURN}" for world in worlds for team in world.teams}
        assert set(claim.list_values("measure")) <= labels
        assert set(claim.list_values("lineup")) <= {team for world in worlds for team in world.teams}


def test_table_1_is_the_mean_of_tables_3_and_4_but_for_one_cell():
    """The paper's average over opponents, and the cell that repeats the expert's column."""
    tables, off = register.read().tables, []
    for row in tables["average"]["rows"]:
        told = tables[row["game"]]
        defends = row["side"] == "defenders"
        rows = told.get("defence", told["attack"]) if defends else told["attack"]
        for place, printed in enumerate(row["mean"]):
            cells = [each[place] for each in rows] if defends else rows[place]
            mean = sum(cells) / len(cells)
            if abs(mean - printed) > 0.01:  # cells and means are rounded
                off.append((row["game"], row["side"], tables["average"]["algorithms"][place], round(mean, 2), printed))
    assert off == [("predator-prey", "defenders", "fitted-q", 2.4, 1.11)]


def test_the_hash_is_of_the_bytes(tmp_path, text):
    path = tmp_path / "claims.toml"
    path.write_text(text + "# one line more\n")
    assert register.read(path).claims == register.read().claims[:40]
    assert register.read(path).sha256 != register.read().sha256


def test_later_claims_change_no_word_on_those_of_before():
    """They are in families of their own, and the hash that stands in every cell is that of the first file."""
    known = register.read()
    first, later = known.claims[:40], known.claims[40:]
    assert known.sha256 == hashlib.sha256(register.FILE.read_bytes()).hexdigest() == REGISTERED
    assert known.more == hashlib.sha256(register.MORE.read_bytes()).hexdigest()
    assert all(claim.family.startswith(register.FURTHER) and not claim.main for claim in later)
    assert not {claim.family for claim in first} & {claim.family for claim in later}
    records = sorted((register.FILE.parents[2] / "generated" / "reproduction").rglob("claims.json"))
    assert {json.loads(each.read_text())["register"] for each in records} == {known.sha256}


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('id = "joint-prey"', 'id = "joint-predators"', "joint-predators: the id stands twice"),
        ('second = ["iviper", "imitation"]', 'second = ["ivipre"]', "ivipre"),
        ('test = "some above"', 'test = "mostly above"', "mostly above"),
        ('statistic = "joint"', 'statistic = "joined"', "joined"),
        ("depth = [2, 4, 6], measure", "deepness = [2, 4, 6], measure", "deepness"),
        ('lineup = "defenders"', 'mean = "defenders"', "the column mean does not choose cells"),
        ("bound = 0.9\n", "", "`bound` stands with above and below alone"),
        ('main = true\nstatistic = "joint"', 'main = true\nsays2 = 1\nstatistic = "joint"', "says2"),
        ("main = true", 'main = "yes"', "bool"),
        (", effect = 0.489 }", " }", "a main claim has no effect"),
        ("maviper-claims-1", "maviper-claims-9", "format"),
        ("[[claim]]", "[[claim]", "damaged"),
    ],
)
def test_faults_are_named(tmp_path, text, old, new, fault):
    assert old in text
    assert fault in faults(tmp_path, text.replace(old, new, 1))


def test_all_faults_are_named_at_once(tmp_path, text):
    found = faults(tmp_path, text.replace('"joint-prey"', '"joint-predators"', 1).replace("bound = 0.9\n", "", 1))
    assert "joint-predators" in found and "individual-heights" in found
