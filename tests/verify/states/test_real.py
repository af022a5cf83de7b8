"""Real arithmetic: states that are shown, leaves that are reached, what is said; test_hunt.py judges its verdicts."""

from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import DisagreementError
from tests.support.teams import RIGHT, STAY, UP, team, tree
from verify.claims.catalogue import find_property
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import AliveLeaves
from verify.kinds import REAL
from verify.question import Question, from_start
from verify.reports import report
from verify.result import Verdict
from verify.solver.solve import leaf_findings
from verify.states import noise, shares
from verify.states.state import State, measurements, violates
from verify.subjects import Game
from verify.verdicts import decisions
from verify.verdicts.decisions import verify

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
MEASURE = decisions.measure
T = Fraction(float(np.float32(0.1)))
ABOVE = Fraction(float(np.nextafter(np.float32(0.1), np.float32(1))))
THIRD = Fraction(1, 3)


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    """Sampled states are fewer, for speed."""
    monkeypatch.setattr("verify.counterexamples.search.SAMPLES", 2_000)
    monkeypatch.setattr(
        "verify.verdicts.decisions.measure", lambda *given, **named: MEASURE(*given, **named, count=500)
    )


def exactly(state):
    return {name: Fraction(value) for name, value in state.position.items()}


# --- states that are chosen


def settled(profile, **given):
    """World states in which all is settled but what is given: coordinate -> bounds."""
    box = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    box |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    return Region(box | {name.replace("__", "."): bounds for name, bounds in given.items()}, ("landmark_0",))


def test_the_state_shown_fails_by_the_arithmetic_asked(profile):
    """Just above a threshold the machine still stays where on paper the agent goes right: no state to end in."""
    one = team(profile, tree((2, float(T), 1, 2), RIGHT, (2, float(ABOVE), 3, 4), STAY, RIGHT), tree(UP))
    claim = find_property("own_target", one, radius=Fraction(0))
    sliver = settled(one, landmark_0__x=(ABOVE, ABOVE + Fraction(1, 10**9)))
    found = verify(Question(Game(one), claim, sliver, REAL), {})
    state = found.evidence.counterexample.state
    assert found.verdict is Verdict.VIOLATED and Fraction(state.position["landmark_0.x"]) == ABOVE
    assert found.evidence.counterexample.deployed.violated and found.evidence.counterexample.replayed == ("reference",)
    nearly = settled(one, landmark_0__x=(ABOVE + Fraction(1, 10**12), ABOVE + Fraction(1, 10**9)))
    assert verify(Question(Game(one), claim, nearly, REAL), {}).verdict is Verdict.PROVED
    assert verify(Question(Game(one), claim, nearly), {}).verdict is Verdict.VIOLATED


def test_a_region_without_float64_states_is_violated_by_a_rational_one(profile):
    """Where it is UNKNOWN for the deployed arithmetic; a box, and a difference that is pinned."""
    still = team(profile, tree(STAY), tree(STAY))
    claim = find_property("own_target", still)
    box = settled(still, agent_0__x=(THIRD, THIRD))
    start = start_region(still.world)
    pinned = Region(start.box, ("landmark_0",), (("agent_0.x", "agent_1.x", (THIRD, THIRD)),))
    for region in (box, pinned):
        unknown = verify(Question(Game(still), claim, region), {})
        assert unknown.verdict is Verdict.UNKNOWN and "real-valued" in unknown.reason
        found = verify(Question(Game(still), claim, region, REAL), {})
        position = exactly(found.evidence.counterexample.state)
        assert found.verdict is Verdict.VIOLATED and not found.evidence.counterexample.state.floats
        assert position["agent_0.x"] - position["agent_1.x"] == THIRD
        assert all(value.denominator <= 10 for value in position.values()), "few digits"
    with pytest.raises(AssertionError, match="no float64 state"):
        violates(from_start(still, claim), found.evidence.counterexample.state)


def test_replays_are_asked_about_float64_states_alone(profile):
    """And a replay that differs from the reference is an error, whatever real arithmetic says."""
    still = team(profile, tree(STAY), tree(STAY))
    claim = find_property("own_target", still)
    asked = []

    def replay(state, actions=(STAY, STAY)):
        asked.append(state)
        return list(actions)

    third = settled(still, agent_0__x=(THIRD, THIRD))
    found = verify(Question(Game(still), claim, third, REAL), {"other": replay})
    assert found.verdict is Verdict.VIOLATED and not asked and found.evidence.counterexample.replayed == ()
    half = settled(still, agent_0__x=(Fraction(1, 2), Fraction(1, 2)))
    found = verify(Question(Game(still), claim, half, REAL), {"other": replay})
    assert len(asked) == 1 and found.evidence.counterexample.replayed == ("reference", "other")
    with pytest.raises(DisagreementError):
        verify(Question(Game(still), claim, half, REAL), {"other": lambda state: [STAY, UP]})


def test_leaves_are_reached_by_rational_states(profile):
    third = Region(dict.fromkeys(start_region(profile.world).box, (THIRD, THIRD)), ("landmark_0",))
    one = team(profile, tree((2, 0.0, 1, 2), UP, STAY), tree(STAY))
    found, _ = leaf_findings(Question(Game(one), AliveLeaves("defenders"), third, REAL))
    assert [finding.verdict for finding in found] == [Verdict.PROVED, Verdict.VIOLATED, Verdict.PROVED]
    assert found[0].witness.position["agent_0.x"] == THIRD
    result = verify(Question(Game(one), find_property("alive_leaves", one), third, REAL), {})
    assert result.verdict is Verdict.VIOLATED and result.semantics == REAL
    document = report.document(one, [result], [""])
    assert document["results"][0]["leaves"][0]["state"]["position"]["agent_0.x"] == "1/3"


def test_a_leaf_between_the_machines_thresholds_is_reached_on_paper(profile):
    """From the threshold to where the machine turns: by float64 states, that the reference takes elsewhere."""
    one = team(profile, tree((2, float(T), 1, 2), UP, STAY), tree(STAY))
    sliver = settled(one, landmark_0__x=(T + Fraction(1, 2**40), T + Fraction(1, 2**39)))
    for semantics, dead in (("machine", [2]), (REAL, [1])):
        found, _ = leaf_findings(Question(Game(one), AliveLeaves("defenders"), sliver, semantics))
        assert [f.leaf for f in found if f.agent == "agent_0" and f.verdict is Verdict.VIOLATED] == dead


# --- batches


def test_shares_are_judged_by_the_arithmetic_asked(profile):
    """In a region between the threshold and where the machine turns, all states fail on paper and none as deployed."""
    one = team(profile, tree((2, float(T), 1, 2), RIGHT, STAY), tree(UP))
    claim = find_property("own_target", one, radius=Fraction(0))
    sliver = settled(one, landmark_0__x=(T + Fraction(1, 2**40), T + Fraction(1, 2**30)))
    for semantics, share in (("machine", 0), (REAL, 1)):
        assert shares.measure(Question(Game(one), claim, sliver, semantics), 0, 200).violating.value == share
    off = find_property("steady", one, of="own_target", radius=Fraction(0), eps=Fraction(1, 2**50))
    found = shares.measure(Question(Game(one), off, sliver, REAL), 0, 200)
    assert found.violating.value == 1 and found.changing.value == 0


def test_errors_that_lead_elsewhere_are_found_exactly(profile):
    """A third below the threshold, an error of a third leads to the right of it by nothing, and one more by a hair."""
    one = team(profile, tree((2, 0.5, 1, 2), RIGHT, STAY), tree(UP))
    hair = Fraction(1, 2**90)
    for eps, found in ((THIRD, False), (THIRD + hair, True)):
        claim = find_property("steady", one, of="own_target", radius=Fraction(0), eps=eps)
        at = {name: float(low) for name, (low, _) in settled(one).box.items()}
        state = State(at | {"agent_0.x": Fraction(5, 6)}, "landmark_0")
        wrong = noise.mistaken(from_start(one, claim, REAL), state)
        assert (wrong is not None) == found
        if wrong is not None:
            (error,) = wrong.errors.values()
            assert THIRD < Fraction(error) <= eps and violates(from_start(one, claim, REAL), wrong)
            assert measurements(one, one.policy("agent_0"), wrong)[2] > Fraction(1, 2)
