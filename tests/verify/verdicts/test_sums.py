"""Features that add more than two coordinates: Z3 decides alone, rounding is covered, and nothing else guesses."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from maviper.verification.run import question_files
from maviper.worlds import find
from tests.faults import EDGE, SUM, pinned_states, sums_wrong
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, tree
from verify.checker.reading import Reading, RejectedError
from verify.claims.catalogue import find_episode_claim, find_property
from verify.claims.formula import Acts, Not
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import AliveLeaves, OwnFormula
from verify.episodes import composition
from verify.extent.largest import BEYOND, where
from verify.kinds import REAL, Semantics
from verify.question import Question, from_start
from verify.repair import repair
from verify.reports import report
from verify.result import Verdict
from verify.solver.solve import decide
from verify.states.real import comparable, measure_feature
from verify.states.state import violates
from verify.subjects import Game
from verify.verdicts.decisions import verify
from verify.verdicts.episodes import verify_episodes
from verify.zones import engine as zones
from verify.zones.tables import BeyondZonesError

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
WORLD = find("physical-deception,features=ahead")


def placed(features, name):
    return next(place for place, feature in enumerate(features) if feature.name == name)


def headed(k, agent, ways=(LEFT, DOWN, UP, RIGHT)):
    """Goes to landmark k along the axis that is ahead, by two tests."""
    features = WORLD.features[agent]
    plus, less = (placed(features, f"landmark_{k}_dx_{name}_dy") for name in ("plus", "less"))
    left, down, up, right = ways
    return tree((plus, 0.0, 1, 4), (less, 0.0, 2, 3), left, down, (less, 0.0, 5, 6), up, right)


def profile_of(*trees):
    policies = [
        ir.AgentPolicy(agent, WORLD.team_of(agent), features, actions, one)
        for agent, features, actions, one in zip(
            WORLD.agents, WORLD.features, WORLD.actions, (tree(STAY), *trees), strict=True
        )
    ]
    return ir.PolicyProfile(WORLD.spec, tuple(policies), ir.Provenance("none", "none", 0, "", "tests"))


def roles():
    return profile_of(headed(0, 1), headed(1, 2))


@pytest.mark.parametrize("semantics", ["machine", REAL])
def test_z3_decides_alone_and_says_so(semantics):
    profile = roles()
    found = verify(from_start(profile, find_property("distinct_targets", profile), semantics), {})
    assert found.verdict is Verdict.PROVED and found.evidence.certificate is None
    assert [opinion.verdict for opinion in found.evidence.opinions] == [Verdict.SKIPPED, Verdict.PROVED]
    assert "adds more than two coordinates" in found.evidence.alone
    facts = report.document(profile, [found], [""])
    assert "Z3 decides alone" in facts["results"][0]["alone"]
    assert ("rounded after each addition" in facts["semantics"]) == (semantics == "machine")
    assert "Z3 decides alone" in report.as_text(report.document(profile, [found], [""]))


@pytest.mark.parametrize("semantics", ["machine", REAL])
def test_a_violation_is_confirmed_and_explained_as_far_as_it_can_be(semantics):
    profile = profile_of(headed(0, 1, (LEFT, UP, DOWN, RIGHT)), headed(1, 2))
    question = from_start(profile, find_property("distinct_targets", profile), semantics)
    found = verify(question, {})
    assert found.verdict is Verdict.VIOLATED and violates(question, found.evidence.counterexample.state)
    says = {span.name: str(span) for span in found.evidence.explanation.spans}
    assert says["adversary_0.x"] == "does not matter"
    assert ("not determined" in says["agent_0.x"]) == (semantics == "machine")
    assert "not determined" in report.as_text(report.document(profile, [found], [""])) or semantics == REAL


def test_what_rounding_does_is_never_proved_away(profile):
    """States in which the exact sum lies on one side of a test and the float64 sum on the other."""
    assert not sums_wrong(profile)
    assert len(list(pinned_states())) >= 5


def rounded(profile, *leaves):
    """The question, at one state, whether agent_0 never goes up, where rounding alone takes it to the second leaf."""
    state = next(pinned_states())
    meaning, before = ir.Meaning(tuple(zip((1, -1, 1, -1), SUM, strict=True))), profile.policy("agent_0")
    place = len(before.features)
    features = (*before.features, ir.FeatureSpec("sum", "length", -9.0, 9.0, meaning))
    policy = replace(before, features=features, tree=tree((place, EDGE, 1, 2), leaves[0], (0, 9.0, 3, 4), *leaves[1:]))
    agents = tuple(policy if one is before else one for one in profile.agents)
    box = {name: (Fraction(value), Fraction(value)) for name, value in state.position.items()}
    region = replace(start_region(profile.world), box=box, goals=(state.goal,))
    claim = OwnFormula("defenders", statement=Not(Acts("agent_0", UP)))
    return Question(Game(replace(profile, agents=agents)), claim, region), state


def test_what_rounding_only_may_do_is_called_no_violation(profile):
    question, state = rounded(profile, UP, STAY, STAY)
    assert not violates(question, state) and not violates(question.by(REAL), state)
    for asked in (question, rounded(profile, STAY, STAY, UP)[0]):
        found = verify(asked, {})
        assert "real-valued world state violates" not in found.reason
    opposite = rounded(profile, STAY, UP, STAY)[0]
    assert verify(opposite, {}).verdict is Verdict.VIOLATED
    leaves = verify(question.about(AliveLeaves("defenders")), {})
    assert "rounding within sums may take" in leaves.reason and "real-valued" not in leaves.reason
    texts = question_files([question, from_start(roles(), find_property("distinct_targets", roles()))]).values()
    assert all("rounding within sums may" in text and "real-valued" not in text for text in texts)


def test_a_control_is_violated_only_where_its_own_state_is_confirmed(profile):
    """Shuffled, the leaf that the state reaches is good, and the one that it cannot be kept from is bad."""
    question, state = rounded(profile, STAY, UP, UP)
    assert violates(question, state) and not all(violates(each, state) for each in question.controls)
    found = verify(question, {})
    control = found.evidence.control
    assert found.verdict is Verdict.VIOLATED and not control.fulfil and 0 < control.broken < control.asked


def test_zones_repair_and_where_refuse():
    profile = profile_of(headed(0, 1, (LEFT, UP, DOWN, RIGHT)), headed(1, 2))
    question = from_start(profile, find_property("distinct_targets", profile))
    assert where(question, Verdict.VIOLATED).reason == BEYOND
    with pytest.raises(InputError, match="difference bounds"):
        repair(question)


def test_episodes_are_left_open_or_violated_by_play():
    profile = roles()
    claim = find_episode_claim("covers", profile)
    open_ = verify_episodes(
        Question(Game(profile), replace(claim, radius=Fraction(3)), start_region(profile.world)), {}
    )
    assert open_.verdict is Verdict.UNKNOWN and "zones cannot follow" in open_.reason
    still = profile_of(tree(STAY), tree(STAY))
    assert verify_episodes(from_start(still, claim), {}).verdict is Verdict.VIOLATED


def test_leaves_are_asked_about_too():
    profile = roles()
    found = verify(from_start(profile, find_property("alive_leaves", profile)), {})
    assert found.verdict is Verdict.PROVED and len(found.evidence.leaves) == 8


def test_the_checker_accepts_no_proof_about_long_sums():
    profile = roles()
    reading = Reading(["agent_0"], "landmark_0")
    with pytest.raises(RejectedError, match="not a coordinate or a difference"):
        reading.tree(profile.policy("agent_0"), Semantics())


def test_sums_of_any_length_compare_exactly():
    """Beside an account by fractions, with numbers that cancel."""
    rng = np.random.default_rng(0)
    spec, names = WORLD.spec, WORLD.spec.coordinates()
    signs = [1, -1, 1, -0.25, -1, 0.5]
    meanings = [
        ir.Meaning(tuple(zip(signs[:count], rng.choice(names, count).tolist(), strict=True)))
        for count in (3, 4, 5, 6) * 5
    ]
    features = [ir.FeatureSpec(f"f{k}", "none", -9.0, 9.0, meaning) for k, meaning in enumerate(meanings)]
    rows = rng.uniform(-1, 1, (200, len(names))) * 2.0 ** rng.integers(-40, 40, (200, len(names)))
    rows[::2, 1::2] = -rows[::2, ::2] * (1 + rng.integers(-1, 2, rows[::2, ::2].shape) * 2.0**-52)
    found = comparable(features, rows, spec)
    for row, numbers in zip(rows, found, strict=True):
        at = {name: Fraction(value) for name, value in zip(names, row, strict=True)}
        for feature, number in zip(features, numbers, strict=True):
            exact = measure_feature(feature.meaning, at)
            near = float(exact)
            for threshold in (np.nextafter(near, -np.inf), near, np.nextafter(near, np.inf)):
                assert (number <= threshold) == (exact <= Fraction(float(threshold)))


def test_a_region_of_one_state_has_the_referees_verdict():
    """Every state is a region of its own: Z3's word is the referee's there, or it says that it does not know."""
    profile = profile_of(headed(0, 1, (LEFT, UP, DOWN, RIGHT)), headed(1, 2))
    claim, rng = find_property("distinct_targets", profile), np.random.default_rng(1)
    box = start_region(profile.world).box
    for _ in range(4):
        values = {name: Fraction(float(np.round(rng.uniform(-1, 1), rng.integers(1, 4)))) for name in box}
        region = Region({name: (value, value) for name, value in values.items()}, ("landmark_0",))
        question = Question(Game(profile), claim, region)
        found = verify(question, {})
        wanted = found.evidence.shares.violating.hits > 0
        assert found.verdict in ((Verdict.VIOLATED if wanted else Verdict.PROVED), Verdict.UNKNOWN)
        assert (decide(question).verdict is Verdict.VIOLATED) or not wanted


@pytest.mark.parametrize(
    "terms",
    [
        ((0.5, "landmark_0.x"), (-1, "agent_0.x")),
        ((2, "agent_0.x"),),
        ((1, "landmark_0.x"), (-0.25, "agent_0.vx")),
        ((1, "agent_0.x"), (1, "agent_0.y")),
    ],
)
def test_weights_and_both_axes_are_beyond_zones_too(terms):
    """Two coordinates round once, so Z3's question is exact; zones still bound differences alone."""
    feature = ir.FeatureSpec("mixed", "length", -9.0, 9.0, ir.Meaning(terms))
    plain = profile_of(tree(STAY), tree(STAY))
    agents = tuple(replace(policy, features=(*policy.features, feature)) for policy in plain.agents)
    place = len(agents[1].features) - 1
    mixed = replace(agents[1], tree=tree((place, 0.1, 1, 2), LEFT, RIGHT))
    profile = replace(plain, agents=(agents[0], mixed, agents[2]))
    question = from_start(profile, find_property("distinct_targets", profile))
    found = decide(question)
    assert found.verdict is Verdict.VIOLATED
    if terms != ((2, "agent_0.x"),):  # half of a bound is a bound
        with pytest.raises(BeyondZonesError):
            zones.decide(question)
    claim = find_episode_claim("reaches", profile)
    assert composition.decide(Question(Game(profile), claim, start_region(profile.world))).verdict is not Verdict.PROVED
