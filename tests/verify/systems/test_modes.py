"""Modes, cases, choices and the number of the step, as world files state them."""

from fractions import Fraction as F

import pytest

from codegen.errors import InputError, UnknownNameError
from tests.support.system_cases import policy, team
from tests.support.systems import CASES, HEATER, read
from verify.claims.formula import Acts, conjunction
from verify.systems.properties import claims_of, ensure_claims
from verify.systems.system import Affine, Feature, Measure


def refused(text):
    with pytest.raises(InputError) as error:
        statement = read(text)
        ensure_claims(statement, "world.toml")
    return f"{error.value}"


def form(constant=0, **terms):
    return Affine.of({name: F(factor) for name, factor in terms.items()}, F(constant))


def test_modes_are_numbers_with_names():
    system = read(HEATER + CASES).system
    (_, heat) = system.variables
    assert (heat.name, heat.range, heat.modes) == ("heat", (0, 2), ("off", "low", "high"))
    assert system.features["a"]["high"] == Feature(form(-2, heat=1), Measure.EQUALS)
    assert system.features["a"]["number"] == Feature(form(heat=1))
    assert all(half.holds({"x": F(0), "heat": F(0)}) for half in system.start)
    assert not all(half.holds({"x": F(0), "heat": F(1)}) for half in system.start)


def moved(system, x, heat, action):
    """All (x, heat) that may follow, with what was chosen."""
    state = {"x": F(x), "heat": F(heat)}
    holding = [piece for piece in system.pieces if piece.holds(state)]
    after = [(piece.step(state, {"a": action}, {}), dict(piece.choice)) for piece in holding]
    return [(each["x"], each["heat"], choice) for each, choice in after]


def test_cases_hold_each_state_once_and_a_choice_is_a_piece_for_each_value():
    system = read(HEATER + CASES).system
    assert moved(system, 1, 2, "high") == [(3, 1, {})]
    just_below = F(1) - F(1, 10**9)
    one, other = moved(system, just_below, 2, "high")
    assert one == (just_below + 1, 2, {"noise": "-1[K]"}) and other == (just_below + 3, 2, {"noise": "1[K]"})
    assert [each[:2] for each in moved(system, 5, 1, "off")] == [(4, 0), (6, 0)]


def test_choices_that_are_written_twice_are_two_and_a_name_is_one():
    apart = CASES.replace('noise", heat', 'noise + choice(0[K], 0.5[K])", heat')
    assert {each[0] for each in moved(read(HEATER + apart).system, 0, 0, "off")} == {-1, F(-1, 2), 1, F(3, 2)}
    same = CASES.replace('noise", heat', 'noise - noise", heat')
    assert {each[0] for each in moved(read(HEATER + same).system, 0, 0, "off")} == {0}
    names = [sorted(piece.choice) for piece in read(HEATER + apart).system.pieces if piece.choice]
    assert names[0] == ["noise", "x"]


def test_modes_are_chosen_kept_and_follow_actions():
    chosen = CASES.replace('"acts(a)"', '"choice(heat, low)"')
    assert {each[1] for each in moved(read(HEATER + chosen).system, 0, 0, "off")} == {0, 1}
    assert {each[1] for each in moved(read(HEATER + CASES).system, 0, 1, "high")} == {2}


STEP = CASES + '[[property]]\nname = "avoids"\nregion = { box = { step = [2, 6] }, where = ["x >= 0.5[K]*step"] }\n'


def test_the_step_is_known_where_a_file_speaks_of_it():
    assert [one.name for one in read(HEATER + CASES).system.variables] == ["x", "heat"]
    labelled = '[[property]]\nlabel = "a step"\nname = "stays_in"\nregion = { box = { x = [-50, 50] } }\n'
    assert [one.name for one in read(HEATER + CASES + labelled).system.variables] == ["x", "heat"]
    system = read(HEATER + STEP).system
    assert system.variables[-1].name == "step" and system.variables[-1].range == (0, 6)
    assert all(piece.move["step"] == form(1, step=1) for piece in system.pieces)
    own = HEATER.replace("x = { unit", "step = { range = [0, 9] }\nx = { unit", 1).replace(
        "x = [-1, 1]", "x = [-1, 1], step = 3"
    )
    stays = STEP.replace("next = {", "next = { step = 'step',")
    assert all(piece.move["step"] == form(step=1) for piece in read(own + stays).system.pieces)
    timed = CASES.replace("heat == high and x >= 1[K]", "step >= 3")
    assert "step" in read(HEATER + timed).system.pieces[0].where


def test_claims_name_modes():
    claims = """
[[property]]
name = "avoids"
region = { box = { heat = "low" }, where = ["heat == low", "x >= 2[K]"] }
[[property]]
formula = "heat in [off, high] implies acts(a) == high"
[[property]]
formula = "heat not in [off, high] implies acts(a) == high"
"""
    statement = read(HEATER + CASES + claims)
    profile = team(policy("a", ["x", "high", "number"], ["off", "high"], 0))
    avoids, inside, outside = claims_of(statement, profile, "world.toml")
    assert avoids.inside == conjunction(avoids.inside) and len(avoids.regions[0]) == 5
    for mode, fails in ((0, (True, False)), (1, (False, True)), (2, (True, False))):
        from verify.claims.formula import holds

        for claim, failing in zip((inside, outside), fails, strict=True):
            assert holds(claim.formula, {"x": F(0), "heat": F(mode)}, {"a": 0}) is not failing
    assert inside.formula != outside.formula and Acts("a", 1) in inside.formula.parts


REFUSED = {
    "heat + x": (CASES.replace("x + a.power + noise", "x + heat"), "heat is a mode, and no number"),
    "ordered": (CASES.replace("heat == high and", "heat >= high and"), "not ordered by >="),
    "unknown mode": (CASES.replace("heat == high and", "heat == hot and"), "unknown mode 'hot'"),
    "overlap": (CASES.replace('"otherwise"', '"x <= 1[K] or heat != high"'), "cases 1 and 2 overlap"),
    "gap": (CASES.replace('"otherwise"', '"heat != high"'), "leave a gap: heat = high, x in [-50, 1]"),
    "empty": (CASES.replace("x >= 1[K]", "x >= 99[K]"), "case 1 holds no state"),
    "twice otherwise": (
        CASES.replace("heat == high and x >= 1[K]", "otherwise"),
        "several cases are 'otherwise'",
    ),
    "both": (CASES.replace('when = "otherwise"', "where = { x = [0, 1] }"), "one piece has conditions"),
    "curved": (CASES.replace("x >= 1[K]", "x*x >= 1[K^2]"), "not an affine form"),
    "no condition": (CASES.replace('"heat == high and x >= 1[K]"', '"x"'), "not a condition"),
    "units": (CASES.replace("x >= 1[K]", "x >= 1[m]"), "units do not fit"),
    "no mode": (CASES.replace('"acts(a)"', '"warm"'), "unknown mode of heat 'warm'"),
    "no sum": (CASES.replace('"acts(a)"', '"heat + 1"'), "no mode"),
    "no agent": (CASES.replace('"acts(a)"', '"acts(b)"'), "unknown agent 'b'"),
    "error": (
        CASES.replace("[dynamics.let]", "[dynamics.error]\nheat = 1\n[dynamics.let]"),
        "a mode has no error",
    ),
    "one value": (CASES.replace("choice(-1[K], 1[K])", "choice(1[K])"), "a choice has 2 to 64 values"),
    "choice of units": (CASES.replace("choice(-1[K], 1[K])", "choice(1[K], 1[m])"), "units do not fit"),
    "many": (CASES.replace("+ noise", "+ noise" + "+ choice(0[K], 1[K])" * 8), "512 ways to choose"),
    "region": (
        CASES + '[[property]]\nname = "avoids"\nregion = { box = { heat = "hot" } }\n',
        "unknown mode of heat 'hot'",
    ),
    "claim": (CASES + '[[property]]\nformula = "heat >= 1 implies acts(a) == high"\n', "not ordered by >="),
    "claimed sum": (CASES + '[[property]]\nformula = "heat + 1 >= 1"\n', "heat is a mode, and no number"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused_says_where(name):
    text, words = REFUSED[name]
    told = refused(HEATER + text)
    assert words in told and "world.toml, line" in told, told


def test_heads_that_are_refused():
    assert "nothing is chosen here" in refused(HEATER.replace('x = "x"', 'x = "choice(x, 1)"') + CASES)
    assert "2 to 256 different modes" in refused(HEATER.replace('["off", "low", "high"]', '["off", "off"]') + CASES)
    assert "unknown mode of heat 'warm'" in refused(HEATER.replace('heat = "off"', 'heat = "warm"') + CASES)
    assert "the action high, which is no mode" in refused(
        HEATER.replace('"high"]', '"hot"]').replace("heat == high", "heat == hot")
        + CASES.replace("heat == high", "heat == hot")
    )
    assert "every episode starts at step 0" in refused(HEATER.replace("x = [-1, 1]", "x = [-1, 1], step = 1") + STEP)
    with pytest.raises(UnknownNameError):
        read(HEATER.replace("heat == high", "heat == hi") + CASES)
