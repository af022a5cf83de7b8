"""Claims written as calls: what is read, what is refused, and that what is written reads back. Of every claim the
parameters are in one table, of which files and Python take all.
"""

import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.errors import InputError
from maviper.options import VerifyOptions as Options
from maviper.options import table_of
from maviper.verification.ask import VerifyOptions
from tests.support.small import small_profile
from verify.claims import files
from verify.claims.built_in import CLAIMS as CLASSES
from verify.claims.catalogue import NAMES, ZONES, find_claim, read_call, readable, spell_call, write_call
from verify.claims.decisions import STEADY
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.files import read_claim
from verify.claims.parameters import PARAMETER_NAMES, PARAMETERS
from verify.claims.region_files import everywhere
from verify.claims.relations import RELATIONS
from verify.claims.wording import BUILT_IN

PROFILE = small_profile()
TEXTS = st.text(st.characters(exclude_categories=["Cs"]), min_size=1)
FRACTIONS = st.fractions(min_value=0, max_value=9, max_denominator=40)


def read(written):
    return read_claim(written, PROFILE, "--claim", lambda name: everywhere(PROFILE))


@pytest.mark.parametrize(
    ("written", "table"),
    [
        ("reaches", {"name": "reaches"}),
        (" reaches ( ) ", {"name": "reaches"}),
        ("reaches(radius=0.4, steps=25)", {"name": "reaches", "radius": "0.4", "steps": 25}),
        ("reaches(radius=2/5,steps=always)", {"name": "reaches", "radius": "2/5", "steps": "always"}),
        ("a(b=[c, 'd,e'], f=\"g)h\")", {"name": "a", "b": ["c", "d,e"], "f": "g)h"}),
        ("a(region=near.toml)", {"name": "a", "region": "near.toml"}),
    ],
)
def test_a_call_is_a_table_of_a_property_file(written, table):
    assert read_call(written) == table


@pytest.mark.parametrize(
    ("written", "what"),
    [
        ("reaches(", "not a claim"),
        ("", "not a claim"),
        ("x.y > 1", "not a claim"),
        ("a(b)", "'b' is no parameter"),
        ("a(b=)", "is no parameter"),
        ("a(b=1, b=2)", "b is given twice"),
        ("a(name=b)", "name is given twice"),
        ('a(b="c)', "a quotation mark is not closed"),
        ("a(b=c d)", "cannot read the value c d"),
        ("a(region={box={}})", "a region is `start` or a file here"),
        ("reaches(steps=x)", "steps must be a whole number"),
        ("reaches(pace=1)", "pace"),
        ("reaches(radius=x)", "not a number"),
    ],
)
def test_what_cannot_be_read_is_refused_and_shown(written, what):
    with pytest.raises(InputError, match=what) as caught:
        read(written)
    assert written.strip() in caught.value.where


@given(st.dictionaries(st.sampled_from("abc"), st.one_of(TEXTS, st.integers(), st.lists(TEXTS).map(tuple))))
def test_every_value_reads_back(said):
    lists = {key: list(value) if isinstance(value, tuple) else value for key, value in said.items()}
    assert read_call(spell_call("claim", said)) == {"name": "claim", **lists}


@given(FRACTIONS, st.integers(1, 50), st.sampled_from(NAMES))
def test_what_is_written_of_a_claim_reads_back(radius, steps, name):
    given = {"reaches": {"radius": radius, "steps": steps}, "covers": {"steps": steps}, "steady": {"of": "no_double"}}
    try:
        claim = find_claim(name, PROFILE, "defenders", **given.get(name, {}))
    except InputError:
        return  # about observations, or about two agents
    assert read(write_call(claim)).claim == claim
    assert read(write_call(claim, 7) if "max_zones" in claim.limits else write_call(claim)).claim == claim


def test_budget_label_and_assumption_are_read_as_in_a_file():
    stated = read('own_target(label="mine", assume="agent_0.x > 0", margin=1/40)')
    assert stated.claim.label == "mine" and stated.claim.margin == Fraction(1, 40)
    assert read(write_call(stated.claim)).claim.assumption == "agent_0.x > 0"
    assert read("reaches(zones=9)").max_zones == 9


def test_the_table_has_what_claims_read():
    read = {parameter for claim in NAMES for parameter in readable(claim)} - {ZONES}
    assert read == set(PARAMETER_NAMES) and len(set(PARAMETER_NAMES)) == len(PARAMETER_NAMES) == len(PARAMETERS)


def test_what_a_claim_means_reads_what_it_is_declared_with():
    """Certificates rest on the one, users know the other."""
    kinds = BUILT_IN | RELATIONS
    assert {name: kinds[name].reads for name in kinds} == {name: CLASSES[name].parameters() for name in kinds}
    episodes = {name: ("steps", "radius", *filter(None, [kind.whom])) for name, kind in EPISODE_CLAIMS.items()}
    assert episodes == {name: CLASSES[name].parameters() for name in EPISODE_CLAIMS}
    assert set(CLASSES) == {*kinds, *EPISODE_CLAIMS, STEADY}
    assert all(re.search(rf"claims\.{kind.__name__}\(", kind.__doc__) for kind in CLASSES.values())


def test_files_python_and_questions_take_what_the_table_has():
    assert set(PARAMETER_NAMES) < set(files.KEYS) and set(PARAMETER_NAMES) < set(table_of(Options))
    given = VerifyOptions.of({"names": ("covers",), "steps": 3, "radius": None, "max_zones": 7, "team": "a"})
    assert given.parameters == {"steps": 3} and given.max_zones == 7 and given.team == "a"
