"""Verdicts: brute force on small worlds, counterexamples that replay, proofs that mean something."""

import contextlib
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import DisagreementError
from tests.support.teams import RIGHT, STAY, team, towards, tree
from verify.checker.decisions import check_certificate
from verify.claims.catalogue import find_property
from verify.claims.decisions import Aligned
from verify.claims.formula import below, conjunction, disjunction
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.question import Budgets, Question, from_start
from verify.result import Opinion, Verdict
from verify.solver.solve import SolverDecision, decide
from verify.states import shares
from verify.states.state import State, inside, sample, violates
from verify.subjects import Game
from verify.verdicts import decisions
from verify.verdicts.decisions import Zoned, verify
from verify.zones import engine as zones

pytestmark = pytest.mark.solver


@pytest.fixture
def claim(profile):
    return find_property("distinct_targets", profile)


def test_fixed_roles_are_proved_everywhere(profile, claim):
    roles = team(profile, towards(0, 0), towards(1, 1))
    result = verify(Question(Game(roles), claim, start_region(roles.world)), {})
    assert result.verdict is Verdict.PROVED
    assert result.evidence.control.verdict is Verdict.VIOLATED
    assert 0.34 < result.evidence.shares.conflict.value < 0.38  # 36 % of the start region, see the definitions
    assert result.evidence.shares.contested is not None and 0.026 < result.evidence.shares.contested.value < 0.031
    assert result.evidence.shares.violating.hits == 0


def test_both_at_the_same_target_is_refuted(profile, claim):
    same = team(profile, towards(0, 0), towards(0, 1))
    result = verify(Question(Game(same), claim, start_region(same.world)), {})
    assert result.verdict is Verdict.VIOLATED
    state = result.evidence.counterexample.state
    assert violates(from_start(same, claim), state) and inside(result.region, state)
    assert all(len(repr(value)) <= 6 for value in state.position.values()), "not shrunk"


def test_an_empty_region_is_vacuous(profile, claim):
    start = start_region(profile.world)
    high = Region(start.box, start.goals, differences=(("agent_0.x", "agent_1.x", (Fraction(3), Fraction(4))),))
    result = verify(Question(Game(profile), claim, high), {})
    assert result.verdict is Verdict.VACUOUS and result.evidence.control.verdict is Verdict.SKIPPED
    apart = Region(start.box, start.goals, apart=(("agent_0", "agent_1", Fraction(5)),))
    assert verify(Question(Game(profile), claim, apart), {}).verdict is Verdict.VACUOUS


def test_a_replay_that_acts_differently_is_no_verdict(profile, claim):
    same = team(profile, towards(0, 0), towards(0, 1))
    with pytest.raises(DisagreementError, match="compiled C"):
        verify(Question(Game(same), claim, start_region(same.world)), {"compiled C": lambda state: [STAY, STAY]})


def test_violation_only_between_neighbouring_floats(profile, claim):
    """A violating sliver one float32 wide is found, and the point replays in float64."""
    t = np.float32(0.3)
    sliver = tree((2, float(np.nextafter(t, np.float32(0))), 1, 2), RIGHT, (2, float(t), 3, 4), STAY, RIGHT)
    other = towards(1, 1)
    box = dict(start_region(profile.world).box)
    one = Fraction(1)
    box |= {"landmark_0.x": (one, one), "landmark_0.y": (one, one), "agent_0.x": (-one, Fraction(8, 10))}
    box |= {"landmark_1.x": (-one, -one), "landmark_1.y": (-one, -one), "agent_0.y": (-one, Fraction(0))}
    box |= {"agent_1.x": (Fraction(-1, 2), Fraction(-1, 4)), "agent_1.y": (Fraction(1, 4), one)}
    region = Region(box, ("landmark_0",))
    lopsided = team(profile, sliver, other)
    result = verify(Question(Game(lopsided), claim, region), {})
    assert result.verdict is Verdict.VIOLATED
    assert violates(from_start(lopsided, claim), result.evidence.counterexample.state)
    # the same region is proved once the sliver is gone
    assert decide(Question(Game(team(profile, tree(RIGHT), other)), claim, region)).verdict is Verdict.PROVED


def test_proved_against_samples_is_our_bug(profile, claim, monkeypatch):
    same = team(profile, towards(0, 0), towards(0, 1))
    monkeypatch.setattr(decisions, "decide", lambda *given: SolverDecision(Verdict.PROVED, 0))
    monkeypatch.setattr(decisions.Stronger, "answers", lambda self: iter(()))
    with pytest.raises(AssertionError, match=r"engines disagree: zones VIOLATED, Z3 .* PROVED"):
        verify(Question(Game(same), claim, start_region(same.world)), {})
    silent = Zoned(Opinion("zones", Verdict.SKIPPED, 0, "search nodes"))
    monkeypatch.setattr(decisions, "by_zones", lambda *given: silent)
    with pytest.raises(AssertionError, match="proved, yet"):
        verify(Question(Game(same), claim, start_region(same.world)), {})


def test_a_verdict_names_its_engines_and_a_proof_its_certificate(profile, claim):
    roles = team(profile, towards(0, 0), towards(1, 1))
    proved = verify(Question(Game(roles), claim, start_region(roles.world)), {})
    assert [opinion.verdict for opinion in proved.evidence.opinions] == [Verdict.PROVED] * 2
    assert (
        proved.evidence.certificate is not None
        and proved.evidence.branches == check_certificate(proved.evidence.certificate, roles) > 10
    )
    same = team(profile, towards(0, 0), towards(0, 1))
    refuted = verify(Question(Game(same), claim, start_region(same.world)), {})
    assert [opinion.verdict for opinion in refuted.evidence.opinions] == [Verdict.VIOLATED] * 2
    assert refuted.evidence.certificate is None
    beyond = verify(Question(Game(roles), Aligned(claim.team), start_region(roles.world)), {})
    assert (
        beyond.evidence.opinions[0].verdict is Verdict.SKIPPED and beyond.evidence.opinions[1].verdict is beyond.verdict
    )


def test_zones_answer_where_the_solver_does_not(profile, claim, monkeypatch):
    monkeypatch.setattr(decisions, "decide", lambda *given: SolverDecision(Verdict.UNKNOWN, 0, reason="spent"))
    for roles, wanted in ((towards(1, 1), Verdict.PROVED), (towards(0, 1), Verdict.VIOLATED)):
        found = verify(Question(Game(team(profile, towards(0, 0), roles)), claim, start_region(profile.world)), {})
        assert found.verdict is wanted and (found.evidence.counterexample is None) == (wanted is Verdict.PROVED)


def test_a_refused_proof_is_our_bug(profile, claim, monkeypatch):
    roles = team(profile, towards(0, 0), towards(1, 1))
    right = zones.decide

    def damaged(*given, **more):
        found = right(*given, **more)
        return replace(found, proofs={goal: proof[:-1] for goal, proof in found.proofs.items()})

    monkeypatch.setattr(zones, "decide", damaged)
    with pytest.raises(AssertionError, match="checker refuses"):
        verify(Question(Game(roles), claim, start_region(roles.world)), {})


@pytest.mark.parametrize("bound", ["0.9", "0.8", "0.1", "0.3", "1/3"])
def test_bounds_that_no_float64_meets_still_give_counterexamples(profile, claim, bound):
    """A model sits on the faces of the box; the float64 nearest to a face may lie outside."""
    start = start_region(profile.world)
    limit = Fraction(bound)
    region = Region(dict.fromkeys(start.box, (-limit, limit)), start.goals)
    same = team(profile, towards(0, 0), towards(0, 1))
    result = verify(Question(Game(same), claim, region), {})
    assert result.verdict is Verdict.VIOLATED
    assert inside(region, result.evidence.counterexample.state) and violates(
        from_start(same, claim), result.evidence.counterexample.state
    )


def test_a_state_on_a_boundary_that_sampling_misjudges(profile, claim):
    """Exactly 1/10 away is at; in float64, 0.4 - 0.3 is more. The proof stands and nothing crashes."""
    place = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    place |= {"agent_0.x": (Fraction(3, 10),) * 2, "landmark_0.x": (Fraction(4, 10),) * 2}
    still = team(profile, tree(STAY), tree(STAY))
    result = verify(Question(Game(still), claim, Region(place, ("landmark_0",))), {})
    assert result.verdict is Verdict.PROVED and result.evidence.shares.violating.hits > 0


def test_the_control_is_asked_not_assumed(profile, claim):
    """Where both agents are at their landmarks, any team satisfies the claim, shuffled or not."""
    place = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    place |= {f"{name}.x": (Fraction(1), Fraction(1)) for name in ("agent_1", "landmark_1")}
    result = verify(
        Question(Game(team(profile, towards(0, 0), towards(1, 1))), claim, Region(place, ("landmark_0",))), {}
    )
    assert result.verdict is Verdict.PROVED and result.evidence.control.verdict is Verdict.PROVED
    assert result.evidence.shares.conflict.hits == 0


@pytest.mark.parametrize("few", [0, decisions.FEW])
def test_controls_are_decided_alike_by_sampled_states_and_by_engines(profile, claim, few, monkeypatch):
    """The nearest landmark is nobody's own: of its shuffled copies some break the claim, some do not."""
    monkeypatch.setattr(decisions, "FEW", few)
    place = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    place |= {"agent_0.x": (Fraction(-1), Fraction(0)), "landmark_0.x": (Fraction(1, 2), Fraction(1))}
    question = Question(
        Game(team(profile, towards(0, 0), tree(STAY))), claim, Region(place, ("landmark_0", "landmark_1"))
    )
    found = verify(question, {}).evidence.control
    assert (found.fulfil, found.broken, found.asked) == (5, 18, 23)


def test_shrinking_keeps_the_violation_and_drops_the_digits(profile, claim):
    from verify.counterexamples.search import shrink

    same = team(profile, towards(0, 0), towards(0, 1))
    region = start_region(profile.world)
    coordinates, goals = sample(region, profile.world, 200, 3)
    names = profile.world.coordinates()
    shrunk = 0
    for row in np.flatnonzero(shares.violating(from_start(same, claim), coordinates))[:10]:
        state = State(
            {name: float(coordinates[row, names.index(name)]) for name in region.box}, f"landmark_{goals[row]}"
        )
        small = shrink([Question(Game(same), claim, region)], state)
        assert violates(from_start(same, claim), small) and inside(region, small) and small.goal == state.goal
        shrunk += all(len(repr(value)) <= 5 for value in small.position.values())
    assert shrunk >= 8


@pytest.mark.parametrize(
    ("margin", "radius", "wanted"),
    [
        ("0", "3/50", Verdict.PROVED),
        ("1/40", "3/50", Verdict.PROVED),
        ("1/10", "3/50", Verdict.VIOLATED),  # between 0.05 and 0.1 away on x an agent is not ahead by more than 0.1
        # the trees turn where float32 observations do, 2.6e-9 above 1/20: that sliver is neither at nor closing
        ("0", "1/20", Verdict.VIOLATED),
        ("0", "0.0500000026", Verdict.VIOLATED),
        ("0", "0.0500000027", Verdict.PROVED),
    ],
)
def test_margin_and_radius_are_exact(profile, claim, margin, radius, wanted):
    roles = team(profile, towards(0, 0), towards(1, 1))
    asked = replace(claim, margin=Fraction(margin), radius=Fraction(radius))
    assert decide(Question(Game(roles), asked, start_region(profile.world))).verdict is wanted


def test_ctrl_c_during_the_search_is_no_verdict():
    """The solver catches the signal itself and answers unknown; that must not pass for an answer."""
    import signal
    import subprocess
    import sys
    import time

    pigeons = """
import sys, z3
from verify.solver.encode import Query
from verify.solver.solve import ask
n = 18
hole = [[z3.Bool(f"{i} {j}") for j in range(n - 1)] for i in range(n)]
rules = [z3.Or(row) for row in hole]
rules += [z3.Or(z3.Not(hole[i][k]), z3.Not(hole[j][k])) for k in range(n - 1) for i in range(n) for j in range(i)]
print("ready", file=sys.stderr, flush=True)
ask(Query("", {}, rules), 2**32 - 1)
"""
    process = subprocess.Popen([sys.executable, "-c", pigeons], stderr=subprocess.PIPE, text=True)
    assert process.stderr.readline() == "ready\n"
    try:
        for _ in range(30):  # on a busy machine the first may come before the search, where nobody waits for it
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                _, err = process.communicate(timeout=2)
                break
        assert process.returncode and "KeyboardInterrupt" in err
    finally:
        process.kill()


def test_a_proof_under_an_assumption_that_nobody_meets_is_no_proof(profile):
    """When the budget ends before the assumption is settled, zones alone may have proved the claim about nothing."""
    roles = team(profile, towards(0, 0), towards(1, 1))
    names = ["adversary_0", "agent_0", "agent_1", "landmark_0", "landmark_1"]
    far = Fraction(101, 100)

    def apart(a, b):
        sides = [below({f"{p}.{axis}": 1, f"{q}.{axis}": -1}, -far) for axis in "xy" for p, q in ((a, b), (b, a))]
        return disjunction(*sides)

    assume = conjunction(*(apart(a, b) for place, a in enumerate(names) for b in names[place + 1 :]))
    claim = replace(find_property("own_target", roles), assume=assume)
    for budget in (20_000, 2_000_000):
        found = verify(Question(Game(roles), claim, start_region(roles.world), budgets=Budgets(budget)), {})
        assert found.verdict in (Verdict.UNKNOWN, Verdict.VACUOUS) and found.evidence.certificate is None
