"""generated/worlds/vcas/: trees of a collision advisory system keep what its README says, row by row."""

import re
import sys
from pathlib import Path

import pytest

from maviper.files.profiles import load
from maviper.worlds.stated.systems import read
from verify.checker.accept import accept
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.subjects import ClosedLoop
from verify.systems.properties import claims_of

PLACE = Path(__file__).parent.parent / "generated" / "worlds" / "vcas"
TEXT = (PLACE / "README.md").read_text()
ROWS = dict(re.findall(r"^\| `(\w+_[\d.]+)` .*\| (PROVED|VIOLATED) ", TEXT, re.MULTILINE))


@pytest.fixture(scope="module")
def vcas():
    """The script, imported as its folder has it."""
    sys.path.insert(0, str(PLACE))
    try:
        import vcas

        return vcas
    finally:
        sys.path.remove(str(PLACE))


@pytest.fixture(scope="module")
def trees():
    return load(PLACE / "vcas.json")


def test_the_files_are_those_that_the_script_writes(vcas):
    assert sorted(ROWS) == sorted(path.stem for path in PLACE.glob("*.toml"))
    for name, text in vcas.files().items():
        assert (PLACE / name).read_text() == text


QUICK = [next(row for row, said in ROWS.items() if said == verdict) for verdict in ("PROVED", "VIOLATED")]


@pytest.mark.parametrize("row", [row if row in QUICK else pytest.param(row, marks=pytest.mark.slow) for row in ROWS])
def test_each_row_has_its_verdict(row, trees):
    """A certificate is accepted by the checker where it is PROVED, a counterexample replayed where it is VIOLATED."""
    statement = read(PLACE / f"{row}.toml")
    (claim,) = claims_of(statement, trees, row)
    question = Question(ClosedLoop(trees, statement.system), claim, UNBOUNDED, budgets=Budgets(samples=256))
    found = decide(question)
    assert found.verdict.value == ROWS[row]
    if found.counterexample is not None:
        assert abs(found.counterexample.states[-1]["h"]) <= 100
    if found.certificate is not None:
        assert accept(found.certificate, trees, statement.system) == found.branches > 0


def test_the_trees_agree_with_the_table_and_alert_no_more(vcas, trees):
    """On the grid and on reached states, over fewer of both than the README's figures; no tree is constant."""
    figures = vcas.compared(trees, count=600, share=0.01)
    assert figures["grid"] >= 0.95 and figures["alerts, trees to table"] <= 1.1
    assert figures["reached by the table"] >= 0.99 and figures["reached by the trees"] >= 0.985
    policy = trees.policy("own")
    assert set(policy.tree.action[policy.tree.feature < 0].tolist()) >= {0, 1, 2, 5, 6}


def test_no_controller_saves_more_than_the_exact_bound():
    """At -25.5 ft/s a climb by g/3 from the first step on is the best there is: it ends at -100 for one height."""
    height, rate, g = -129.53333333333333, -25.5, 32.2
    for _ in range(2):
        height, rate = height - rate - g / 6, rate + g / 3
    assert abs(height + 100) < 1e-9 and abs((133 - 129.53333333333333) / 4 - 0.8666666) < 1e-6
