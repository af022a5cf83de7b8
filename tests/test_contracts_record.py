"""The record of what Frama-C proved: it is of the committed policies as they are, whole, and what its page says."""

import json

import pytest

from codegen.equivalence.contracts import contracts_of
from codegen.lowering.lower import lower
from tests.benchmarks import contracts as benchmark
from tests.support.outside import installed

ROWS = json.loads((benchmark.RECORD / "table.json").read_text())
PAGE = (benchmark.RECORD / "README.md").read_text()


def test_every_policy_is_there_in_its_styles():
    policies = {name: each for name, each in benchmark.shipped().items() if not benchmark.too_large(each)}
    every = [*policies.values(), benchmark.full()]
    wanted = {(benchmark.contract_hash(each, style), style) for each in every for style in benchmark.styles_of(each)}
    assert {(row["contract"], row["style"]) for row in ROWS} == wanted and len(ROWS) == len(wanted)
    for name in benchmark.shipped().keys() - policies.keys():
        assert name in PAGE.splitlines()[-1]


def test_nothing_is_open_and_64_leaves_take_a_minute():
    for row in ROWS:
        assert row["goals"] == row["proved"] > 0 and row["axioms"] == row["axioms proved"]
    full = [row for row in ROWS if row["leaves"] == benchmark.LEAVES and row["agents"] == 1]
    assert len(full) == 2 and all(row["cpu_s"] < benchmark.REACH[row["style"]] for row in full)


def test_the_page_shows_the_rows():
    rows = "".join(map(benchmark.line, ROWS))
    assert f"{benchmark.INTRO}{benchmark.HEAD}{rows}\n{PAGE.splitlines()[-1]}\n" == PAGE


def test_counts_follow_from_the_profiles():
    shipped = benchmark.shipped()
    for row in ROWS:
        profile = shipped.get(row["policy"]) or benchmark.full()
        made = contracts_of(profile, lower(profile, style=row["style"]))
        assert (row["agents"], row["leaves"], row["axioms"]) == (len(made.functions), made.leaves, made.axioms)


@installed
@pytest.mark.slow
@pytest.mark.parametrize("style", benchmark.STYLES)
def test_a_recorded_proof_is_found_again(style):
    name = "worlds/quadrotor"
    (row,) = [row for row in ROWS if row["policy"] == name and row["style"] == style]
    again = benchmark.row_of(name, benchmark.shipped()[name], style)
    assert again | {"cpu_s": 0} == row | {"cpu_s": 0}
