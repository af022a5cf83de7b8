"""Property files: claims read back, with the line and column of what is wrong; nothing in a file makes a traceback."""

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen.errors import InputError
from tests.support.teams import STAY, team, team_in, towards, tree
from verify.claims.catalogue import find_property
from verify.claims.decisions import OWN, PLAIN, DistinctTargets
from verify.claims.episodes import Covers, Reaches
from verify.claims.files import read_properties
from verify.claims.formula import TRUE
from verify.claims.region_files import everywhere, read_region
from verify.question import Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.verdicts.decisions import verify


def read(source, profile, find=None):
    def missing(name):
        if name == "start":
            return everywhere(profile)
        raise InputError("cannot read the file", name)

    return [(one.claim, one.region) for one in read_properties(source, profile, "p.toml", find or missing)]


def test_built_in_properties_with_their_parameters(profile):
    source = """
    [[property]]
    label = "apart"
    name = "distinct_targets"
    margin = 0.025
    radius = "1/3"
    region = "near.toml"

    [[property]]
    name = "own_target"
    team = "defenders"
    landmarks = ["landmark_1", "landmark_0"]
    [property.region]
    default = [-0.5, 0.5]
    goals = ["landmark_1"]
    [property.region.apart]
    "agent_0 - agent_1" = 0.2

    [[property]]
    name = "steady"
    of = "aligned"
    kappa = 1
    eps = 0.01
    assume = "agent_0.x < agent_1.x"
    """
    near = read_region("default = [0, 1]", profile.world, "near.toml")
    first, second, third = read(source, profile, {"near.toml": near}.__getitem__)
    assert first == (DistinctTargets("defenders", Fraction(1, 40), Fraction(1, 3)), near)
    assert first[0].label == "apart" and first[0].shown == "apart"
    marks = ("landmark_1", "landmark_0")
    assert second[0] == find_property("own_target", profile, landmarks=marks) and second[0].landmarks == marks
    wanted = read_region(
        'default=[-0.5,0.5]\ngoals=["landmark_1"]\n[apart]\n"agent_0 - agent_1"=0.2', profile.world, ""
    )
    assert second[1] == wanted and second[1].name == "of property 2"
    assert (third[0].eps, third[0].of, third[0].kappa) == (Fraction(1, 100), "aligned", 1)
    assert third[0].assume != TRUE and third[1] == everywhere(profile)


def test_claims_about_episodes_beside_others(profile):
    source = """
    [[property]]
    label = "all arrive"
    name = "reaches"
    steps = 12
    radius = "1/3"
    landmarks = ["landmark_1", "landmark_0"]
    zones = 1_000
    [property.region]
    default = [-0.5, 0.5]

    [[property]]
    name = "covers"
    team = "defenders"
    [[property]]
    name = "no_double"
    """
    first, second, third = read(source, profile)
    marks = ("landmark_1", "landmark_0")
    assert first[0] == Reaches("defenders", 12, Fraction(1, 3), marks)
    assert (first[0].label, first[0].shown) == ("all arrive", "all arrive")
    assert first[1].name == "of property 1" and first[1].box["agent_0.x"] == (Fraction(-1, 2), Fraction(1, 2))
    assert second == (Covers("defenders", 25), everywhere(profile))
    assert second[0].shown == "covers"
    spent = [one.max_zones for one in read_properties(source, profile, "p.toml", lambda name: None)]
    assert spent == [1_000, None, None]
    assert third[0] == find_property("no_double", profile)


def test_formulas_know_their_team_and_their_parameters(profile):
    source = """
    [[property]]
    formula = "closes(agent_0, landmark_0) or at(agent_0, landmark_0)"
    margin = 0.1
    [[property]]
    formula = "engaged(agent_0, landmark_0)"
    margin = 0.1
    [[property]]
    formula = "acts(adversary_0) != stay"
    """
    (first, _), (second, _), (third, _) = read(source, profile)
    assert first.statement == second.statement and first == second and hash(first) == hash(second)
    assert (first.name, first.team, third.team) == (OWN, "defenders", "adversaries")


@pytest.mark.solver
def test_a_formula_that_says_a_built_in_property_has_its_verdict(profile):
    matched = " or ".join(f"(engaged(agent_0, landmark_{k}) and engaged(agent_1, landmark_{1 - k}))" for k in (0, 1))
    ((own, region),) = read(f'[[property]]\nformula = "{matched}"', profile)
    built_in = find_property("distinct_targets", profile)
    for one, verdict in ((team(profile, towards(0, 0), towards(1, 1)), Verdict.PROVED),
                         (team(profile, towards(0, 0), towards(0, 1)), Verdict.VIOLATED)):  # fmt: skip
        assert (
            decide(Question(Game(one), own, region)).verdict
            is decide(Question(Game(one), built_in, region)).verdict
            is verdict
        )
        found, wanted = verify(Question(Game(one), own, region), {}), verify(Question(Game(one), built_in, region), {})
        assert (
            found.evidence.shares.violating == wanted.evidence.shares.violating
            and found.evidence.shares.conflict == wanted.evidence.shares.conflict
        )
        assert found.evidence.control.verdict is Verdict.VIOLATED


@pytest.mark.solver
@pytest.mark.parametrize(
    "assume",
    [
        "agent_0.x < agent_1.x and agent_1.x < agent_0.x",
        "distance(agent_0, agent_1) > 2",
        "goal == landmark_0 and goal == landmark_1",
        "goal != landmark_0 and goal != landmark_1",
        "false",
        "agent_0.x > 1/2 and agent_0.x < 1/3 or |landmark_0.y| >= 1.01",
    ],
)
def test_contradictory_assumptions_are_vacuous_and_never_proved(profile, assume):
    source = f'[[property]]\nname = "distinct_targets"\nassume = "{assume}"'
    ((claim, region),) = read(source, profile)
    result = verify(Question(Game(profile), claim, region), {})
    assert result.verdict is Verdict.VACUOUS and "assumption" in result.reason
    assert result.evidence.control.verdict is Verdict.SKIPPED and result.evidence.shares.conflict.count == 0


@pytest.mark.solver
def test_assumptions_restrict_the_claim_and_its_shares(profile):
    """Both go to landmark 0: that fails, but not where it is not claimed."""
    same = team(profile, towards(0, 0), towards(0, 1))
    texts = {
        "": Verdict.VIOLATED,
        "distance(landmark_0, landmark_1) <= 0.01 and distance(agent_0, agent_1) <= 2": Verdict.PROVED,
        "distance(landmark_0, landmark_1) >= 0.5": Verdict.VIOLATED,
    }
    for assume, verdict in texts.items():
        ((claim, region),) = read(
            '[[property]]\nname = "distinct_targets"\nradius = 0.2' + (f'\nassume = "{assume}"' if assume else ""),
            profile,
        )
        result = verify(Question(Game(same), claim, region), {})
        assert result.verdict is verdict, assume
        if "0.5" in assume:
            state = result.evidence.counterexample.state.position
            gap = max(abs(state[f"landmark_0.{axis}"] - state[f"landmark_1.{axis}"]) for axis in "xy")
            assert gap >= 0.5 and 0 < result.evidence.shares.conflict.count < 100_000


@pytest.mark.solver
def test_the_goal_is_the_goal_even_where_landmarks_coincide(profile):
    """`goal == landmark_0` is about the name: with another goal allowed only, nothing is left."""
    source = '[[property]]\nformula = "acts(agent_0) == stay"\nassume = "goal == landmark_0"\n[property.region]\n'
    ((claim, region),) = read(source + 'goals = ["landmark_1"]', profile)
    assert decide(Question(Game(profile), claim, region)).verdict is Verdict.VACUOUS
    ((claim, region),) = read(source + 'goals = ["landmark_0", "landmark_1"]', profile)
    still = team(profile, tree(STAY), tree(STAY))
    assert decide(Question(Game(still), claim, region)).verdict is Verdict.PROVED


ERRORS = [
    ("[[property]", "not a readable file of claims", "line 1"),
    ("", "no claim in the file", "p.toml"),
    ("property = 3", "no claim in the file", "p.toml"),
    ("[[clam]]\n", "did you mean 'claim'", "p.toml"),
    ("[[property]]\n", "a name or a formula", "line 1: property 1"),
    ('[[property]]\nname = "distinct_target"', "did you mean 'distinct_targets'", "line 2: property 1, name"),
    ('[[property]]\nnme = "x"', "did you mean 'name'", "line 2: property 1, nme"),
    ('# x\n\n[[property]]\nname = "own_target"\nteam = "defender"', "mean 'defenders'", "line 5: property 1, team"),
    ('[[property]]\nname = "own_target"\nlandmarks = ["landmrk_0"]', "mean 'landmark_0'", "line 3: property 1, landm"),
    ('[[property]]\nname = "own_target"\nlandmarks = "landmark_0"', "list of names", "line 3"),
    ('[[property]]\nname = "own_target"\nkappa = 1', "own_target has no parameter kappa", "line 3: property 1, kappa"),
    ('[[property]]\nname = "no_double"\nmargin = -1', "margin must be between", "line 3: property 1, margin"),
    ('[[property]]\nname = "no_double"\nmargin = nan', "not a number", "line 3: property 1, margin"),
    ('[[property]]\nname = "no_double"\nmargin = true', "not a number", "line 3"),
    ('[[property]]\nname = "steady"\nof = "stedy"', "property", "line 3: property 1, of"),
    ('[[property]]\nname = "steady"\neps = 0', "eps above 0", "line 3: property 1, eps"),
    ('[[property]]\nname = "no_double"\nformula = "true"', "has no name", "line 2"),
    ('[[property]]\nformula = "true"\nlabel = "a\\nb"', "one line", "line 3: property 1, label"),
    ('[[property]]\nformula = 3', "formula must be a text", "line 2"),
    ('[[property]]\nformula = " "', "formula must be a text", "line 2"),
    ('[[property]]\nlabel = "x"\nformula = "agent_9.x > 0"', "unknown", "line 3: property 1, formula, column 1"),
    ('[[property]]\nformula = """\ntrue and\nagent_9.x > 0"""', "unknown", "line 4: property 1, formula, column 1"),
    ('[[property]]\nformula = "true"\n\n[[property]]\nformula = "  ="', "read", "line 5: property 2, formula, column"),
    ('[[property]]\nformula = "true"\nassume = "acts(agent_0) == left"', "not mention", "line 3: property 1, assume"),
    ('[[property]]\nformula = "acts(agent_0) == acts(adversary_0)"', "about one team", "line 2: property 1, formula"),
    ('[[property]]\nformula = "acts(agent_0) == left"\nteam = "adversaries"', "about one team", "line 2"),
    ('[[property]]\nformula = "true"\nregion = 3', "region must be", "line 3: property 1, region"),
    ('[[property]]\nformula = "true"\nregion = "none.toml"', "cannot read the file", "line 3: property 1, region"),
    ('[[property]]\nformula = "true"\n[property.region.box]\n"agent_0.z" = [0, 1]', "mean 'agent_0.", "1, region"),
    ('property = [{name = "x"}]', "unknown claim", "p.toml, line 1: property 1, name"),
    ('[[property]]\nname = "reaches"\nmargin = 1', "reaches has no parameter margin", "line 3: property 1, margin"),
    ('[[property]]\nname = "reaches"\nsteps = 2.5', "a whole number", "line 3: property 1, steps"),
    ('[[property]]\nname = "reaches"\nsteps = true', "a whole number", "line 3: property 1, steps"),
    ('[[property]]\nname = "covers"\nsteps = 1001', "steps must be between", "line 3: property 1, steps"),
    ('[[property]]\nname = "covers"\nzones = 0', "zones must be between 1", "line 3: property 1, zones"),
    ('[[property]]\nname = "covers"\nradius = -1', "radius must be between", "line 3: property 1, radius"),
    ('[[property]]\nname = "covers"\nlandmarks = ["landmark_0"]', "different landmark", "line 3: property 1, landm"),
    ('[[property]]\nname = "covers"\nassume = "true"', "has no assumption", "line 3: property 1, assume"),
    ('[[property]]\nname = "covers"\nlabel = "a\\nb"', "one line", "line 3: property 1, label"),
    ('[[property]]\nname = "cover"', "did you mean 'covers'", "line 2: property 1, name"),
    ('[[property]]\nname = "no_double"\nsteps = 3', "no_double has no parameter steps", "line 3: property 1, steps"),
    ('[[property]]\nformula = "true"\nzones = 3', "has no zones", "line 3: property 1, zones"),
    ("[[property]]\nformula = 'true'\n" * 201, "at most 200", "p.toml"),
]  # fmt: skip


@pytest.mark.parametrize(("source", "message", "place"), ERRORS)
def test_bad_files_are_refused_with_the_place(profile, source, message, place):
    with pytest.raises(InputError) as error:
        read(source, profile)
    assert message in str(error.value) and place in error.value.where, str(error.value)


def test_all_that_is_wrong_is_told_at_once(profile):
    source = "[[property]]\nname = 'no_doubl'\n[[property]]\nformula = 'true'\n[[property]]\nformula = 'agent_0.x >'\n"
    with pytest.raises(InputError) as error:
        read(source, profile)
    assert error.value.what == "2 of 3 claims cannot be read"
    for told in ("p.toml, line 2: property 1, name", "did you mean 'no_double'", "p.toml, line 6: property 3, formula"):
        assert told in error.value.where, error.value.where
    assert "    agent_0.x >\n" in error.value.where


LINES = st.sampled_from([
    "[[property]]", "[property.region]", "[property.region.box]", 'name = "distinct_targets"', 'name = "steady"',
    'name = "covers"', "steps = 3", "steps = -1", "zones = 0",
    'of = "aligned"', 'formula = "acts(agent_0) == left"', 'formula = "agent_0.x"', 'assume = "goal == landmark_0"',
    'assume = "("', "margin = 0.1", "margin = 1e400", "kappa = true", "eps = 0.1", 'team = "defenders"', "team = 3",
    'landmarks = ["landmark_0"]', 'region = "start"', "region = []", '"agent_0.x" = [0, 1]', "goals = []",
    'label = "\\u0000"', "label = 'x'", "formula = '''", "'''", '"""', "[", "=", "\x00",
])  # fmt: skip


@settings(max_examples=400)
@given(st.one_of(st.text(max_size=80), st.lists(LINES, max_size=12).map("\n".join)))
def test_any_text_is_claims_or_an_error_in_words(profile, source):
    try:
        found = read(source, profile)
    except InputError as error:
        assert error.what and "p.toml" in error.where
        return
    for claim, region in found:
        assert (
            claim.team in ("defenders", "adversaries")
            and region.box
            and claim.name in (*PLAIN, "steady", OWN, "covers")
        )


def test_velocities_can_be_spoken_of_where_they_are_observed():
    """Navigation's agents see their velocities; a deception agent's is not bounded, so it is no known coordinate."""
    navigation = team_in("cooperative-navigation", [tree(STAY)] * 3)
    agents = navigation.agents
    ((claim, region),) = read('[[property]]\nformula = "agent_0.vx > 0 implies acts(agent_0) == stay"', navigation)
    assert decide(Question(Game(navigation), claim, region)).verdict is Verdict.PROVED
    with pytest.raises(InputError, match="this world has no goal"):
        read('[[property]]\nformula = "goal == landmark_0"', navigation)
    with pytest.raises(InputError, match="no meaning"):
        blind = replace(agents[0], features=tuple(replace(one, meaning=None) for one in agents[0].features))
        decide(Question(Game(replace(navigation, agents=(blind, *agents[1:]))), claim, region))
