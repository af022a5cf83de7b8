"""Claims for ever that assume something, begin late, or hold by regions: what is shown is true."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, of_hashes
from tests.support.covers import always, answered, attack_invariants, thermostat
from tests.support.system_cases import box, double_integrator, form, policy, switching, team
from tests.verify.reach import random_systems
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.covers import boxes, invariants
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Invariant, InvariantPart, InvariantRegion, from_json
from verify.reach.unbounded import InvariantSearch
from verify.result import Verdict
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import HalfSpace, Piece, System, Variable

BOX = box(x=(F(-1), F(1)), y=(F(-1), F(1)))
WIDE = box(x=(F(-3, 2), F(3, 2)), y=(F(-3, 2), F(3, 2)))


def moving(x, y, begun=BOX, error=None):
    """Two variables without agents' help: their next values as sums."""
    variables = tuple(Variable(name, "1", (F(-4), F(4))) for name in "xy")
    system = System("moving", variables, {"a": {}}, begun, (Piece({}, {"x": x, "y": y}, {}, error or {}),), 9)
    return system, team(policy("a", [], ["rest"], 0))


def turning(error=None):
    """An eighth of a turn, and closer to 0 by 1 over the root of 2."""
    return moving(form(x=F(1, 2), y=F(-1, 2)), form(x=F(1, 2), y=F(1, 2)), error=error)


def shifting():
    """y becomes x, and half of x becomes y: a box twice as high as wide leaves itself, and is back after two steps."""
    return moving(form(y=1), form(x=F(1, 2)), box(x=(-1, 1), y=(F(-1, 2), F(1, 2))))


def ever(region, **more):
    return SystemClaim(Pattern.ALWAYS, (region,), 60, **more)


# --- a region that is given


def test_a_given_invariant():
    found = answered(turning(), ever(WIDE, invariant=(BOX,)))
    assert found.verdict is Verdict.PROVED
    (part,) = found.certificate.proof.parts
    assert part.regions[0].region == BOX and part.steps == 1 and not part.cells
    assert part.regions[0].walk is not None
    halves = box(x=(F(-1), F(0)), y=(F(-1), F(1))), box(x=(F(0), F(1)), y=(F(-1), F(1)))
    found = answered(turning(), ever(WIDE, invariant=halves))
    assert len(found.certificate.proof.parts[0].regions) == 2
    assert from_json(to_json(found.certificate)) == found.certificate


def test_a_region_that_is_none_says_which_state_leaves_and_where_it_goes():
    slim = box(x=(F(-1), F(1)), y=(F(-2), F(2)))
    widened = replace(turning()[0], start=box(x=(-1, 1), y=(-2, 2)))
    claim = ever(box(x=(-2, 2), y=(F(-5, 2), F(5, 2))), invariant=(slim,))
    found = answered((widened, turning()[1]), claim)
    assert found.verdict is Verdict.PROVED and found.certificate.proof.parts[0].cells  # by one that was found
    found = answered((widened, turning()[1]), claim, max_boxes=1, samples=0)
    assert found.verdict is Verdict.UNKNOWN and "the one that is given is none" in found.reason
    assert " goes to x " in found.reason and set(found.open.bounds) == {"x", "y"}
    state = {name: F(low) for name, (low, _) in found.open.bounds.items()}
    after = turning()[0].pieces[0].step(state, {"a": "rest"}, {})
    assert all(half.holds(state) for half in slim) and not all(half.holds(after) for half in slim)


def test_states_in_a_row():
    """Where plain induction fails, two states in a row are enough; the first ones are asked for themselves."""
    tall = box(x=(F(-1), F(1)), y=(F(-2), F(2)))
    system, profile = shifting()
    search = InvariantSearch(profile, system, ever(tall), 20_000)
    assert next(search.iterate_invariants())[0].cells  # those are found as well
    made = InvariantPart({}, 2, b"", (InvariantRegion(tall, bytes(1)),))
    claim = ever(tall)
    sealed = of_hashes(
        content_hash(profile), documents.content_hash(system), claim, {"x": 0, "y": 0}, Invariant((made,))
    )
    assert accept(sealed, profile, system) > 0
    with pytest.raises(RejectedError, match="may leave it"):
        accept(altered(sealed, parts=(altered(made, steps=1),)), profile, system)
    wide = replace(system, start=box(x=(-1, 1), y=(-2, 2)))
    sealed = altered(sealed, system=documents.content_hash(wide))
    with pytest.raises(RejectedError, match="at the first steps"):
        accept(sealed, profile, wide)


def test_many_coupled_variables_need_a_region():
    """Cells of six variables are too many; the claim's own region is shown in one piece."""
    names = [f"x{number}" for number in range(6)]
    variables = tuple(Variable(name, "1", (F(-4), F(4))) for name in names)
    move = {
        name: form(**{other: F((-1) ** (i * j), 7) for j, other in enumerate(names)}) for i, name in enumerate(names)
    }
    whole = box(**dict.fromkeys(names, (F(-1), F(1))))
    system = System("coupled", variables, {"a": {}}, whole, (Piece({}, move),), 9)
    found = answered((system, team(policy("a", [], ["rest"], 0))), ever(whole))
    assert found.verdict is Verdict.PROVED and found.boxes < 100


def test_a_border_that_is_met_exactly():
    """What rests stays where it is, so the border of a region is met exactly: exact rows show that, boxes cannot."""
    coasting = moving(form(x=1, y=F(1, 10)), form(y=F(3, 4)))
    halves = [HalfSpace(form(-2, x=sign, y=sign * F(2, 5))) for sign in (1, -1)]
    region = (*box(x=(F(-14, 5), F(14, 5)), y=(F(-2), F(2))), *halves)
    claim = ever(box(x=(F(-3), F(3))), invariant=(region,))
    found = answered(coasting, claim)
    assert found.verdict is Verdict.PROVED and from_json(to_json(found.certificate)) == found.certificate
    (part,) = found.certificate.proof.parts
    assert part.regions[0].walk
    (one,) = part.regions
    for steps, regions in (
        (2, (one,)), (1, (one, altered(one, walk=None))), (1, (altered(one, walk=None),)),
        (1, (altered(one, walk=b"\0"),)), (1, (altered(one, region=region[:-1]),)),
    ):  # fmt: skip
        with pytest.raises(RejectedError):
            made = altered(found.certificate, parts=(altered(part, steps=steps, regions=regions),))
            accept(made, coasting[1], coasting[0])


# --- a later step, and what is assumed


def test_reached_and_then_kept():
    """Warm rooms cool down, and then stay between two bounds for ever."""
    later = replace(always(warm=(F(35, 2), F(41, 2))), by=12)
    assert "by step 12, and from then on always" in later.sentence
    assert answered(thermostat(), later).verdict is Verdict.PROVED
    assert answered(thermostat(), replace(later, by=2)).verdict is Verdict.VIOLATED
    assert answered(thermostat(), replace(later, by=0)).verdict is Verdict.VIOLATED
    integrator = double_integrator(axes=1), switching(1)
    late = replace(always(x=(F(-2, 5), F(2, 5))), by=10)
    assert answered(integrator, late).verdict is not Verdict.VIOLATED


def test_what_is_assumed():
    """With an error an episode may drift away; as long as the other variable is small, it does not."""
    drift = moving(form(x=F(1, 2), y=1), form(y=1), box(x=(0, 1), y=(0, 2)))
    claim = ever(box(x=(F(-1), F(3, 2))))
    assert answered(drift, claim).verdict is Verdict.VIOLATED
    small = box(y=(F(0), F(1, 2)))
    assumed = replace(claim, assuming=(small,), assumed="y small")
    assert "as long as it stays in y small" in assumed.sentence
    found = answered(drift, assumed)
    assert found.verdict is Verdict.PROVED and "assuming" in to_json(found.certificate)
    with pytest.raises(RejectedError):
        accept(altered(found.certificate, claim=claim), drift[1], drift[0])
    nobody = replace(claim, assuming=(box(y=(F(5), F(6))),))
    assert answered(drift, nobody, samples=0).verdict is Verdict.VACUOUS
    with pytest.raises(InputError, match="assumes nothing"):
        replace(assumed, pattern=Pattern.STAYS_IN).ensure()


# --- forgeries


def forged(random, names):
    """A random region with random cuts, of random variables."""
    used = [name for name in names if random.random() < 0.8] or names[:1]
    sizes = {name: random.choice([F(1, 2), F(1), F(2), F(4), F(8)]) for name in used}
    region = box(**{name: (-size, size) for name, size in sizes.items()})
    if random.random() < 0.3:
        region += (HalfSpace(random_systems.affine(random, used)),)
    times = int(random.integers(0, 4))
    cuts, pending = list[int](), 1
    while pending:
        split = len(cuts) < 2**times - 1
        cuts.append(int(random.integers(1, len(names) + 1)) if split else 0)
        pending += 1 if split else -1
    return InvariantRegion(region, encode_numbers(cuts))


def attacked(seeds, each=4):
    def claimed(random, system, regions):
        first = system.variables[0].name
        assuming = (random_systems.polytope(random, [first]),) if random.random() < 0.4 else ()
        by = int(random.integers(0, 4)) if random.random() < 0.4 else 0
        return SystemClaim(Pattern.ALWAYS, regions, 12, by, assuming=assuming)

    def forge(random, system, each):
        names = [one.name for one in system.variables]
        for count in random.integers(1, 3, each):
            steps = int(random.integers(1, 4))
            yield (InvariantPart({}, steps, b"", tuple(forged(random, names) for _ in range(count))),)

    return attack_invariants(17, seeds, each, 2_000, claimed, forge)


def test_what_is_shown_is_true():
    met = attacked(range(10), 3)
    assert met["forgeries"] >= 6 and met["proved"] >= 1, met


@pytest.mark.parametrize(
    "seeds", [pytest.param(100, marks=pytest.mark.slow), pytest.param(1_000, marks=pytest.mark.nightly)]
)
def test_thousands_of_forgeries(seeds):
    met = attacked(range(1_000, 1_000 + seeds), 6)
    assert met["forgeries"] >= seeds and met["proved"] >= seeds / 16, met


def test_what_is_refused():
    system, profile = turning()
    found = answered((system, profile), ever(WIDE, invariant=(BOX,))).certificate
    assert found is not None
    (part,) = found.proof.parts
    unbounded = InvariantRegion((*box(x=(-1, 1)), HalfSpace(form(-1, y=1))), bytes(1))
    outside = InvariantRegion(box(x=(-2, 2), y=(-2, 2)), bytes(1))
    for other in (
        altered(part, regions=()), altered(part, widths={"x": F(1), "y": F(1)}), altered(part, cells=bytes(5)),
        altered(part, regions=(unbounded,)), altered(part, regions=(outside,)), altered(part, steps=9),
        altered(part, regions=(InvariantRegion(BOX, bytes(2)),)), altered(part, cuts=b"\5"),
        altered(part, regions=(InvariantRegion(box(x=(F(-1, 2), F(1, 2)), y=(-1, 1)), bytes(1)),)),
        altered(part, regions=(InvariantRegion(box(x=(-1, 1)), bytes(1)),)), altered(part, joined={"x": F(2) ** 300}),
    ):  # fmt: skip
        with pytest.raises(RejectedError):
            accept(altered(found, parts=(other,)), profile, system)
    with pytest.raises(RejectedError, match="depends on y"):
        invariants.RegionSweep(profile, system, found.claim, [box(x=(-1, 1))], 1)
    alone = moving(form(x=F(1, 2)), form(y=1))
    about = content_hash(alone[1]), documents.content_hash(alone[0]), ever(WIDE), {"x": F(0), "y": F(0)}
    with pytest.raises(RejectedError, match="shows some"):
        accept(
            of_hashes(*about, Invariant((InvariantPart({}, 1, b"", (InvariantRegion(box(x=(-1, 1)), bytes(1)),)),))),
            *alone[::-1],
        )
    with pytest.raises(InputError):
        accept(altered(found, parts=(altered(part, joined={"q": F(1)}),)), profile, system)


# --- planted faults

FAULTS = [
    (invariants.RegionSweep, "find_open_parts", lambda f: lambda self, boxes: np.zeros(0, dtype=np.int64)),
    (invariants.FollowedMotion, "find_breaking", lambda f: lambda self, boxes: boxes.take(slice(0, 0))),
    (invariants.FollowedMotion, "arriving", lambda f: lambda self, *given: iter(())),
    (invariants.FollowedMotion, "is_unstated", lambda f: lambda self, boxes: np.zeros(boxes.size, dtype=np.bool_)),
    (boxes.Regions, "outside", lambda f: lambda self, listed: listed.take(slice(0, 0))),
    (invariants, "_ensure_closed", lambda f: lambda system, followed: None),
    (invariants, "ensure_shown", lambda f: lambda claim, parts: None),
    (invariants.FollowedMotion, "restrict_boxes", lambda f: lambda self, boxes: f(self, boxes.take(slice(0, 1)))),
]


def wrong():
    try:
        test_what_is_refused()
        test_states_in_a_row()
        test_what_is_assumed()
        test_unstated()
        attacked(range(8), 2)
    except (AssertionError, pytest.fail.Exception, ValueError, KeyError, RejectedError):
        return True
    return False


def test_unstated():
    """Where dynamics end, a region ends."""
    system, profile = turning()
    short = replace(system, pieces=(replace(system.pieces[0], where={"x": (F(-1, 2), F(1, 2))}),))
    narrow = replace(short, start=box(x=(0, F(1, 4)), y=(0, F(1, 4))))
    made = InvariantPart({}, 1, b"", (InvariantRegion(BOX, bytes(1)),))
    about = content_hash(profile), documents.content_hash(narrow), ever(WIDE), {"x": F(0), "y": F(0)}
    with pytest.raises(RejectedError):
        accept(of_hashes(*about, Invariant((made,))), profile, narrow)


@pytest.mark.parametrize("number", range(len(FAULTS)))
def test_planted_faults_are_caught(number, monkeypatch):
    owner, name, change = FAULTS[number]
    monkeypatch.setattr(owner, name, change(getattr(owner, name)))
    assert wrong()
