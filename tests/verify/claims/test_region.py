"""Regions: exact numbers in, the same numbers out, and clear words for bad files."""

import sys
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.errors import InputError
from codegen.floats import rational_literal
from codegen.intervals import Share
from maviper.worlds import find
from tests.support.strategies import WORLD
from verify.claims.region import Region
from verify.claims.region_files import positions, read_region, region_toml, start_region
from verify.decimals import exact, plain, text
from verify.exact import read_number
from verify.states.state import contains, inside, sample
from verify.states.values import has_matching

FRACTIONS = st.fractions(-2, 2, max_denominator=1000)
INTERVALS = st.tuples(FRACTIONS, FRACTIONS).map(lambda pair: (min(pair), max(pair)))


@given(FRACTIONS)
def test_numbers_are_written_exactly(number):
    assert Fraction(text(number).strip('"')) == number


@given(st.dictionaries(st.sampled_from(positions(WORLD.spec)), INTERVALS), st.fractions(0, 2, max_denominator=1000))
def test_a_region_file_reads_back(bounds, least):
    start = start_region(WORLD.spec)
    differences = (("agent_0.x", "agent_1.x", (Fraction(-1, 3), least)),)
    region = Region(start.box | bounds, ("landmark_1",), differences, (("landmark_0", "landmark_1", Fraction(1, 5)),))
    assert read_region(region_toml(region), WORLD.spec, "region.toml") == region


def test_what_is_said_of_a_pair_twice_holds_at_once():
    """TOML takes `a - b`, `a  - b` and `b - a` for three keys."""
    source = """
    [difference]
    "agent_0.x - agent_1.x" = [-1, 0.5]
    " agent_0.x -  agent_1.x" = [-0.25, 1]
    "agent_1.x - agent_0.x" = [-0.4, 0.3]
    [apart]
    "agent_0 - agent_1" = 0.2
    "agent_0  - agent_1" = 0.1
    "agent_1 - agent_0" = 0.3
    """
    region = read_region(source, WORLD.spec, "r")
    assert region.differences == (("agent_0.x", "agent_1.x", (Fraction(-1, 4), Fraction(2, 5))),)
    assert region.apart == (("agent_0", "agent_1", Fraction(3, 10)),)
    lines = "\n".join(f'"agent_0{" " * k} - agent_1" = 0.1' for k in range(2_000))
    assert len(read_region(f"[apart]\n{lines}", WORLD.spec, "r").apart) == 1
    with pytest.raises(InputError, match="is above the upper one"):
        read_region(
            '[difference]\n"agent_0.x - agent_1.x" = [0.1, 1]\n"agent_1.x - agent_0.x" = [0, 1]', WORLD.spec, "r"
        )


@pytest.mark.parametrize("written", ["-1e-300", "1e-999", "7.25", "1/3", f"1{'0' * 20}1/{'7' * 900}"])
def test_whatever_is_read_is_written_so_that_it_is_read_again(written):
    number = exact(written, "here")
    assert exact(plain(number), "here") == number == read_number(rational_literal(number))


@given(st.integers(-(10**20), 10**20), st.integers(0, 30_000), st.integers(1, 10**6), st.integers(0, 9_000))
def test_numbers_of_any_length_have_a_text(n, shift, d, under):
    number = Fraction(n * 10**shift + 1, d * 7**under)
    limit = sys.get_int_max_str_digits()
    text = rational_literal(number)
    sys.set_int_max_str_digits(0)
    try:
        assert text == str(number)
    finally:
        sys.set_int_max_str_digits(limit)


def test_small_numbers_are_numbers():
    assert read_region("default = [-1e-300, 1_0.5e-1]", WORLD.spec, "r").box["agent_0.x"] == (
        -Fraction(1, 10**300),
        Fraction(21, 20),
    )


def test_defaults(tmp_path):
    region = read_region('default = [-2, 2]\n[box]\n"agent_0.x" = [0.1, "1/3"]\n', WORLD.spec, "r")
    assert region.box["agent_0.x"] == (Fraction(1, 10), Fraction(1, 3))
    assert region.box["agent_1.x"] == (-2, 2)
    assert region.goals == ("landmark_0", "landmark_1")


def test_entities_start_in_boxes_of_their_own():
    """Predator-prey: obstacles within 0.9, the float64 number, everybody else within 1; no goal."""
    spec = find("predator-prey").spec
    region = start_region(spec)
    assert tuple(region.box) == positions(spec) and region.goals == ()
    for name, bounds in region.box.items():
        end = Fraction(0.9) if name.startswith("obstacle") else Fraction(1)
        assert bounds == (-end, end)
    assert read_region(region_toml(region), spec, "r") == region
    assert read_region("", spec, "r") == region  # what a file does not say is as at the start
    assert read_region("[box]\n", spec, "r").box["obstacle_1.y"] == (-Fraction(0.9), Fraction(0.9))
    assert set(read_region("default = [-2, 2]", spec, "r").box.values()) == {(-2, 2)}
    one = read_region('[box]\n"obstacle_0.x" = [0.5, 1]', spec, "r")
    assert one.box["obstacle_0.x"] == (Fraction(1, 2), 1) and one.box["obstacle_0.y"] == (-Fraction(0.9), Fraction(0.9))
    coordinates, goals = sample(region, spec, 1_000, 0)
    assert len(coordinates) == 1_000 and contains(region, coordinates, spec).all() and not goals.any()
    names = spec.coordinates()
    obstacles = [names.index(name) for name in region.box if name.startswith("obstacle")]
    assert 0.85 < np.abs(coordinates[:, obstacles]).max() <= 0.9
    assert not coordinates[:, [place for place, name in enumerate(names) if ".v" in name]].any()
    with pytest.raises(InputError, match=r"unknown landmark|goals"):
        read_region('goals = ["obstacle_0"]', spec, "r")


@pytest.mark.parametrize(("damping", "has"), [(0.0, "no"), (1e-320, "a"), (1e-12, "a")])
def test_a_region_states_the_speeds_that_nothing_bounds(damping, has):
    """And a start region that cannot be stated is an error that says what to do, which then works."""
    spec = replace(WORLD.spec, damping=damping)
    speeds = ("agent_0.vx", "agent_0.vy")
    with pytest.raises(InputError, match=rf"nothing bounds agent_0\.vx: the world has {has} damping") as raised:
        start_region(spec, speeds)
    assert "region file" in raised.value.next_step
    with pytest.raises(InputError, match=r"nothing bounds agent_0\.vy"):
        read_region('[box]\n"agent_0.vx" = [-1, 1]\n', spec, "r", speeds)
    stated = read_region('[box]\n"agent_0.vx" = [-1, 1]\n"agent_0.vy" = [0, 1]\n', spec, "r", speeds)
    assert tuple(stated.box) == (*positions(spec), *speeds) and stated.box["agent_0.vy"] == (0, 1)
    slow = replace(spec, agents=tuple(replace(agent, max_speed=2.0) for agent in spec.agents))
    assert start_region(slow, speeds).box["agent_0.vx"] == (-2, 2)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("goals = [", "not a readable region file"),
        ("gaols = []", "did you mean 'goals'"),
        ('goals = ["landmark_9"]', "unknown goal"),
        ("goals = []", "list of landmarks"),
        ("goals = 3", "list of landmarks"),
        ("box = 3", "must be a table"),
        ('[box]\n"agent_0.z" = [0, 1]', "did you mean 'agent_0."),
        ('[box]\n"agent_0.x" = [0]', "two numbers"),
        ('[box]\n"agent_0.x" = [0, "one"]', "not a number"),
        ('[box]\n"agent_0.x" = [0, true]', "not a number"),
        ('[box]\n"agent_0.x" = [1, -1]', "above the upper"),
        ("default = [-1, 1e999999999]", "not a number"),
        ("default = [-1, 1e400]", "at most"),
        ("default = [-1, 1e5000]", "not a number"),
        ("default = [0, 0x" + "f" * 5000 + "]", "at most"),
        ("default = [0, 9999999999]", "at most"),
        ('[box]\n"agent_0.x" = [0, nan]', "not a"),
        ('[box]\n"agent_0.x" = [0, inf]', "not a"),
        ('[box]\n"agent_0.x" = [0, "1/0"]', "not a number"),
        ('[difference]\n"agent_0.x" = [0, 1]', "cannot read"),
        ('[difference]\n"agent_0.x - agent_9.x" = [0, 1]', "unknown coordinate"),
        ('[apart]\n"agent_0 - agnt_1" = 1', "did you mean 'agent_1'"),
    ],
)
def test_bad_region_files_are_refused_with_the_place(source, message):
    with pytest.raises(InputError) as error:
        read_region(source, WORLD.spec, "r.toml")
    assert message in str(error.value) and "r.toml" in str(error.value)


def test_sampled_states_lie_inside():
    source = '[difference]\n"agent_0.x - agent_1.x" = [0, 0.5]\n[apart]\n"landmark_0 - landmark_1" = 1\n'
    region = read_region(source, WORLD.spec, "r")
    coordinates, goals = sample(region, WORLD.spec, 5_000, 0)
    assert 0 < len(coordinates) < 5_000
    assert contains(region, coordinates, WORLD.spec).all()
    names = WORLD.spec.coordinates()
    from verify.states.state import State

    for row, goal in zip(coordinates[:50], goals[:50], strict=True):
        position = {name: row[names.index(name)] for name in positions(WORLD.spec)}
        assert inside(region, State(position, f"landmark_{goal}"))
        assert row[names.index("goal.x")] == position[f"landmark_{goal}.x"]


@given(st.integers(1, 4), st.data())
def test_matching_against_all_permutations(n, data):
    from itertools import permutations

    related = np.array(data.draw(st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=n, max_size=n)))
    expected = any(all(related[i, p[i]] for i in range(n)) for p in permutations(range(n)))
    assert bool(has_matching(related)) == expected


def test_wilson_interval_against_scipy():
    from scipy.stats import binomtest

    for hits, count in ((0, 50), (1, 50), (25, 50), (50, 50), (317, 100_000)):
        low, high = Share(hits, count).interval
        ours = binomtest(hits, count).proportion_ci(0.95, method="wilson")
        assert low == pytest.approx(ours.low, abs=1e-12) and high == pytest.approx(ours.high, abs=1e-12)


@pytest.mark.parametrize(("number", "written"), [("1/3", "1/3"), ("-1/7", "-1/7"), ("1/40", "0.025"), ("-3", "-3")])
def test_numbers_are_written_one_way_and_quoted_in_files_only(number, written):
    found = Fraction(number)
    assert plain(found) == written and exact(written, "") == found
    assert text(found) == (f'"{written}"' if "/" in written else written) and read_number(text(found)) == found
