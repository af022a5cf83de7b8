"""Claims over observations against enumeration of all cells: formulas, two agents, a feature raised; planted leaves."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, read_game
from tests.support.brute import action_of
from tests.support.observations import ACTIONS, NAMES, blind, blind_tree, breaks, cells, doubled, representatives
from tests.support.teams import tree
from verify.certificates.games import to_json
from verify.checker.decisions import check_certificate
from verify.checker.reading import RejectedError
from verify.claims.formula import Acts, below, conjunction, disjunction, negate
from verify.claims.observed import Mirrored, View, view_from
from verify.claims.region_files import everywhere
from verify.claims.relations import DECREASING, INCREASING, Agree, Differ, Ignores, Monotone, Symmetric
from verify.claims.views import Viewed, carry_region
from verify.claims.wording import OwnFormula, view_document
from verify.question import Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.verdicts.decisions import by_zones

pytestmark = pytest.mark.solver
SIDE, VIEW = 2.0, View()


def asked(profile, claim, view=VIEW):
    """The question over the ranges of all features."""
    viewed = Viewed(profile, claim.of_view(view))
    region = carry_region(everywhere(Viewed(profile, view).profile), viewed)
    return Question(Game(viewed.profile, viewed=viewed), claim, region)


def verdicts(question):
    """Those of both engines; a proof's certificate is accepted, its text comes back."""
    zoned, second = by_zones(question), decide(question)
    if zoned.certificate is not None:
        assert read_game(to_json(zoned.certificate)) == zoned.certificate
        assert check_certificate(zoned.certificate, question.origin) == zoned.branches
        assert zoned.certificate.header.profile == content_hash(question.origin)
    return {zoned.opinion.verdict, second.verdict}


def typed(grown, numbers):
    """The tree with these numbers; equal trees stay equal."""
    return grown if numbers == "float32" else doubled(grown, np.random.default_rng(0))


def expected(holds):
    return {Verdict.PROVED if holds else Verdict.VIOLATED}


@pytest.mark.parametrize("numbers", ["float32", "float64"])
@pytest.mark.parametrize("seed", range(16))
def test_a_formula_about_one_agent(seed, numbers):
    rng = np.random.default_rng(seed)
    grown = typed(blind_tree(rng, 2, 4), numbers)
    profile = blind({"agent": grown}, {"agent": NAMES[:2]})
    low, high = sorted(Fraction(int(n), 8) for n in rng.integers(-12, 13, 2))
    most, allowed = Fraction(int(rng.integers(-12, 13)), 8), {0, int(rng.integers(3))}
    where = conjunction(negate(below({"angle": 1}, low)), below({"angle": 1}, high), below({"spin": 1}, most, True))
    statement = disjunction(negate(where), *(Acts("agent", action) for action in allowed))
    more = {0: [float(low), float(high), float(low) + 1e-6], 1: [float(most), float(most) - 1e-6]}
    holds = all(
        action_of(grown, [angle, spin]) in allowed
        for angle, spin in cells(grown, 2, -SIDE, SIDE, more)
        if low < angle <= high and spin < most
    )
    claim = OwnFormula("team", statement=statement)
    assert verdicts(asked(profile, claim)) == expected(holds)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("shared", [(), ("angle",), ("angle", "spin")])
@pytest.mark.parametrize("numbers", [("float32", "float32"), ("float64", "float64"), ("float32", "float64")])
def test_two_agents_agree_or_differ(seed, shared, numbers):
    rng = np.random.default_rng(100 + seed)
    first = blind_tree(rng, 2)
    second = first if seed % 3 == 0 else blind_tree(rng, 2)
    first, second = typed(first, numbers[0]), typed(second, numbers[1])
    profile = blind({"a": first, "b": second}, {"a": NAMES[:2], "b": NAMES[:2]})
    both = [sorted({*breaks([(first, 0), (second, 0)], 0)}), sorted({*breaks([(first, 1), (second, 1)], 1)})]
    lines = [representatives(line, -SIDE, SIDE) for line in both]
    others = [[None] if name in shared else line for name, line in zip(NAMES, lines, strict=False)]
    mine, theirs = ({one: action_of(each, one) for one in product(*lines)} for each in (first, second))
    alike = {
        mine[one] == theirs[tuple(a if b is None else b for a, b in zip(one, other, strict=True))]
        for one in product(*lines)
        for other in product(*others)
    }
    for claim, holds in ((Agree, alike == {True}), (Differ, alike == {False})):
        assert verdicts(asked(profile, claim("team", agents=("a", "b")), View(shared))) == expected(holds)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("direction", [INCREASING, DECREASING])
@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_a_feature_is_raised_alone(seed, direction, numbers):
    rng = np.random.default_rng(200 + seed)
    grown = typed(blind_tree(rng, 2), numbers)
    order = [int(n) for n in rng.permutation(3)] if seed % 2 else [0, 1, 2]
    profile = blind({"agent": grown}, {"agent": NAMES[:2]})
    sign = 1 if direction == INCREASING else -1
    angles, spins = (representatives(breaks([(grown, k)], k), -SIDE, SIDE) for k in (0, 1))
    ranks = [[order.index(action_of(grown, [angle, spin])) * sign for angle in angles] for spin in spins]
    holds = all(rank == sorted(rank) for rank in ranks)
    claim = Monotone(
        "team", agent="agent", feature="angle", direction=direction, order=tuple(ACTIONS[n] for n in order)
    )
    assert verdicts(asked(profile, claim)) == expected(holds)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_a_feature_is_ignored(seed, numbers):
    rng = np.random.default_rng(250 + seed)
    grown = typed(blind_tree(rng, 2), numbers)
    if seed % 2:  # a tree that tests the feature, of which one side acts as the other
        grown = replace(grown, action=np.where(grown.action < 0, grown.action, rng.integers(3)))
    profile = blind({"agent": grown}, {"agent": NAMES[:2]})
    angles, spins = (representatives(breaks([(grown, k)], k), -SIDE, SIDE) for k in (0, 1))
    taken = [[action_of(grown, [angle, spin]) for angle in angles] for spin in spins]
    holds = all(len(set(line)) == 1 for line in taken)
    assert holds or not seed % 2
    claim = Ignores("team", agent="agent", feature="angle")
    assert verdicts(asked(profile, claim)) == expected(holds)
    group = {0, 1 + seed // 2 % 2}
    together = all(len({action in group for action in line}) == 1 for line in taken)
    named = replace(claim, actions=tuple(ACTIONS[k] for k in group))
    assert verdicts(asked(profile, named)) == expected(together)


def test_a_proof_that_a_feature_is_ignored_shows_no_other_claim():
    grown = tree((1, 0.5, 1, 2), 0, 2)
    profile = blind({"agent": grown}, {"agent": NAMES[:2]})
    certificate = by_zones(asked(profile, Ignores("team", agent="agent", feature="angle"))).certificate
    assert check_certificate(certificate, profile) > 0
    for claim in (
        Ignores("team", agent="agent", feature="spin"),
        Ignores("team", agent="agent", feature="angle", actions=("left",)),
        Monotone("team", agent="agent", feature="angle"),
    ):
        with pytest.raises((RejectedError, InputError)):
            check_certificate(altered(certificate, property=claim), profile)
        viewed = asked(profile, claim)
        with pytest.raises((RejectedError, InputError)):
            check_certificate(altered(certificate, property=claim, view=viewed.viewed.view), profile)
    other = blind({"agent": tree((0, 0.5, 1, 2), 0, 2)}, {"agent": NAMES[:2]})
    with pytest.raises(RejectedError):
        check_certificate(altered(certificate, profile=content_hash(other)), other)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("mirrored", [(), ("angle",)])
@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_mirrored_features_have_mirrored_actions(seed, mirrored, numbers):
    rng = np.random.default_rng(300 + seed)
    grown = typed(blind_tree(rng, 2) if seed % 4 else odd_tree(seed), numbers)
    order = [int(n) for n in rng.permutation(3)] if seed % 4 else [0, 1, 2]
    opposite = {order[k]: order[-1 - k] for k in range(3)}
    signs = [-1 if name in (mirrored or NAMES[:2]) else 1 for name in NAMES[:2]]
    more = {k: [-each for each in breaks([(grown, k)], k)] for k in (0, 1)}
    holds = all(
        opposite[action_of(grown, [angle, spin])] == action_of(grown, [signs[0] * angle, signs[1] * spin])
        for angle, spin in cells(grown, 2, -SIDE, SIDE, more)
    )
    claim = Symmetric("team", agent="agent", features=mirrored, order=tuple(ACTIONS[n] for n in order))
    profile = blind({"agent": grown}, {"agent": NAMES[:2]})
    assert verdicts(asked(profile, claim)) == expected(holds)
    assert holds or seed % 4 or numbers == "float64"


def test_a_proof_about_some_mirrored_features_is_none_about_others():
    """The formula is the same whichever features are mirrored: the view says which."""
    profile = blind({"agent": odd_tree(0)}, {"agent": NAMES[:2]})
    claim = Symmetric("team", agent="agent", features=("angle",), order=ACTIONS)
    certificate = by_zones(asked(profile, claim)).certificate
    assert check_certificate(certificate, profile) > 0
    for features in ((), ("spin",), ("angle", "spin")):
        with pytest.raises(RejectedError, match="the view is not the one"):
            check_certificate(altered(certificate, property=replace(claim, features=features)), profile)


def odd_tree(seed):
    """Left below -t, right above t, else stay; the float32 number below t ends the right side."""
    end = float(np.float32(0.25 + seed / 8))
    inner = float(np.nextafter(np.float32(end), np.float32(-9)))
    return tree((0, -end, 1, 2), 0, (0, inner, 3, 4), 1, 2)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_claims_that_compare_decisions_are_steady_or_not(seed, numbers):
    """Both engines agree, certificates are accepted, and what holds in spite of errors holds without them."""
    grown = typed(blind_tree(np.random.default_rng(400 + seed), 2), numbers)
    profile = blind({"agent": grown}, {"agent": NAMES[:2]})
    away = negate(conjunction(below({"angle": 1}, 1), below({"angle": -1}, 1)))
    for claim in (Monotone("team", agent="agent", feature="angle"), Symmetric("team", agent="agent", assume=away)):
        plain, steady = (verdicts(asked(profile, replace(claim, eps=eps))) for eps in (Fraction(0), Fraction(1, 50)))
        assert len(plain) == len(steady) == 1 and (steady != {Verdict.PROVED} or plain == steady)


CART = tree((2, 0.05, 1, 4), (3, 0.5, 2, 3), 0, 2, (3, -0.5, 5, 6), 0, 2)
RIGHT_WHEN_LEANING = disjunction(
    negate(conjunction(negate(below({"place": 1}, Fraction(1, 10))), negate(below({"speed": 1}, 0)))),
    Acts("cart", ACTIONS.index("right")),
)


@pytest.mark.parametrize(
    "claim", [OwnFormula("team", statement=RIGHT_WHEN_LEANING), Monotone("team", agent="cart", feature="speed")]
)
def test_a_planted_leaf_is_found_and_its_old_certificate_refused(claim):
    good = blind({"cart": CART})
    made = by_zones(asked(good, claim)).certificate
    assert made is not None and verdicts(asked(good, claim)) == {Verdict.PROVED}
    bad = blind({"cart": tree((2, 0.05, 1, 4), (3, 0.5, 2, 3), 0, 2, (3, -0.5, 5, 6), 2, 0)})
    assert verdicts(asked(bad, claim)) == {Verdict.VIOLATED}
    with pytest.raises(RejectedError):
        check_certificate(altered(made, profile=content_hash(bad)), bad)


def test_a_certificate_about_another_mirror_is_refused():
    even = tree((2, 0.0, 1, 2), 1, 1)
    profile = blind({"cart": even}, {"cart": NAMES})
    claim = Symmetric("team", agent="cart", features=("speed",))
    made = by_zones(asked(profile, claim)).certificate
    assert made is not None and check_certificate(made, profile)
    crooked = blind({"cart": CART})
    for changed in (
        (altered(made, profile=content_hash(crooked)), crooked),
        (altered(made, property=replace(claim, order=("right", "left", "stay"))), profile),
        (altered(made, property=replace(claim, agent="cart_mirrored")), profile),
        (altered(made, view=View()), profile),
        (altered(made, view=View((), None, Mirrored("cart", ("wheel",)))), profile),
    ):
        with pytest.raises((InputError, RejectedError)):
            check_certificate(*changed)


def test_a_view_has_one_copy_at_most():
    opposite = View(mirrored=Mirrored("cart", ("speed",)))
    assert view_from(view_document(opposite)) == opposite and view_from(view_document(View())) == View()
    for document in (
        {"shared": [], "raised": [], "mirrored": []},
        {"shared": [], "raised": ["cart", "speed"], "mirrored": ["cart"]},
        {"shared": [], "mirrored": ["cart"]},
    ):
        with pytest.raises(ValueError, match="view"):
            view_from(document)


def test_a_certificate_about_another_view_or_region_is_refused():
    profile = blind({"cart": CART})
    claim = Monotone("team", agent="cart", feature="speed")
    made = by_zones(asked(profile, claim)).certificate
    assert made is not None and made.header.view is not None
    for claimed in (
        replace(claim, feature="place"),
        replace(claim, direction=DECREASING),
        replace(claim, order=("right", "stay", "left")),
    ):
        with pytest.raises((InputError, RejectedError), match=r"formula|names what"):
            check_certificate(altered(made, property=claimed), profile)
    for view in (None, View(), View((), made.header.view.raised._replace(feature="place"))):
        with pytest.raises((InputError, RejectedError), match="names what the profile does not have"):
            check_certificate(altered(made, view=view), profile)
    without = {name: bounds for name, bounds in made.header.region.box.items() if name != "speed"}
    with pytest.raises((InputError, RejectedError), match=r"do not fit together|not a state|names what"):
        check_certificate(altered(made, region=replace(made.header.region, box=without)), profile)


def test_mutated_proofs_are_refused():
    """A proof with one byte changed is refused, unless it still closes every branch by other bounds."""
    profile = blind({"cart": CART})
    made = by_zones(asked(profile, OwnFormula("team", statement=RIGHT_WHEN_LEANING))).certificate
    assert made is not None
    bad = blind({"cart": tree((2, 0.05, 1, 4), (3, 0.5, 2, 3), 0, 2, (3, -0.5, 5, 6), 2, 1)})
    proof, rng = made.proof.proofs[""], np.random.default_rng(0)
    refused = 0
    for _ in range(150):
        changed = bytearray(proof)
        changed[rng.integers(len(proof))] = int(rng.integers(256))
        forged = altered(made, proofs={"": bytes(changed)}, profile=content_hash(bad))
        with pytest.raises(RejectedError):  # of a false claim no proof holds
            check_certificate(forged, bad)
        refused += 1
    assert refused == 150
