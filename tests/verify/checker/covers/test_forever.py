"""Claims for ever: what invariants show holds in long episodes; forgeries and faults are caught."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from tests.support.altered import altered, of_hashes
from tests.support.covers import always, answered, attack_invariants, thermostat
from tests.support.system_cases import box, double_integrator, form, policy, switching, team
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.covers import invariants
from verify.checker.covers.invariants import InvariantSweep
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Cover, InvariantPart, Walks, from_json
from verify.reach import unbounded
from verify.reach.unbounded import CellSearch
from verify.result import Verdict
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Piece, System, Variable


@pytest.fixture(scope="module")
def proved():
    system, profile = double_integrator(axes=2), switching(2)
    found = answered((system, profile), always(x=(F(-1), F(1)), y=(F(-1), F(1))))
    assert found.verdict is Verdict.PROVED
    return found.certificate, profile, system


def test_new_worlds_for_ever(proved):
    found, profile, system = proved
    assert [list(part.widths) for part in found.proof.parts] == [["x", "vx"], ["y", "vy"]]
    assert accept(found, profile, system) < 2_000
    assert answered(thermostat(), always(warm=(F(14), F(25)))).verdict is Verdict.PROVED


def test_false_invariants():
    """A counterexample comes before a proof; what has neither says which cell leaves, and where it goes."""
    found = answered(thermostat(), always(warm=(F(15), F(20))))
    assert found.verdict is Verdict.VIOLATED and found.counterexample.step <= 60
    integrator = double_integrator(axes=1), switching(1)
    found = answered(integrator, always(x=(F(-1, 2), F(1, 4))))
    assert found.verdict is Verdict.VIOLATED
    late = answered(thermostat(), always(steps=1, warm=(F(18), F(25))), samples=0)
    assert late.verdict is Verdict.UNKNOWN and "may go to warm in" in late.reason
    assert late.open is not None and set(late.open.bounds) == {"warm"}


def test_steps_out_of_the_list():
    """A point that turns about 0 leaves wide cells, and is back in them some steps later."""
    move = {"x": form(y=-1), "y": form(x=1)}
    variables = tuple(Variable(name, "1", (F(-4), F(4))) for name in "xy")
    system = System("turning", variables, {"a": {}}, box(x=(1, 2), y=(0, 0)), (Piece({}, move),), 9)
    profile = team(policy("a", [], ["rest"], 0))
    sweep = InvariantSweep(profile, system, always(x=(F(-5), F(5)), y=(F(-5), F(5))), {"x": 1.0, "y": 1.0})
    cells = np.array([[x, y] for x in (1, 2) for y in (0,)])
    for steps in (1, 2, 3):
        with pytest.raises(RejectedError, match="out of the invariant"):
            sweep.check(sweep.motion.arriving([0], {}), cells, steps)
    assert sweep.check(sweep.motion.arriving([0], {}), cells, 4) > 0


# --- forgeries


def forged(random, system):
    """A random list of cells, of random variables."""
    names = [one.name for one in system.variables if random.random() < 0.8] or [system.variables[0].name]
    modes = {one.name for one in system.variables if one.modes}
    widths = {name: F(1) if name in modes else random.choice([F(1, 4), F(1), F(4)]) for name in names}
    spans = [int(random.integers(1, 12)) for _ in names]
    heads = [number for span in spans for number in (int(random.integers(0, 20)), span)]
    whole = int(np.prod(spans))
    held = sorted(random.choice(whole, size=int(random.integers(1, whole + 1)), replace=False).tolist())
    numbers = [*heads, held[0], *np.diff(held).tolist()]
    return InvariantPart(widths, int(random.integers(1, 9)), encode_numbers(numbers))


def attacked(seeds, each=4):
    def claimed(random, system, regions):
        return SystemClaim(Pattern.ALWAYS, regions, 12)

    return attack_invariants(
        13, seeds, each, 4_000, claimed, lambda random, system, count: [(forged(random, system),) for _ in range(count)]
    )


def test_what_is_shown_is_true():
    met = attacked(range(24))
    assert met["forgeries"] >= 28 and met["proved"] >= 2, met


@pytest.mark.parametrize(
    "seeds", [pytest.param(100, marks=pytest.mark.slow), pytest.param(800, marks=pytest.mark.nightly)]
)
def test_thousands_of_forgeries(seeds):
    met = attacked(range(1_000, 1_000 + seeds), 6)
    assert met["forgeries"] >= 2.5 * seeds and met["proved"] >= seeds / 16, met


def test_other_forms_show_nothing_for_ever(proved):
    found, profile, system = proved
    about = found.header.profile, found.header.system, found.claim, found.header.inhabitant
    for other in (of_hashes(*about, Cover({}, b"\0")), of_hashes(*about, Walks(()))):
        with pytest.raises(RejectedError, match="all steps"):
            accept(other, profile, system)
    steps = altered(found.claim, pattern=Pattern.STAYS_IN)
    with pytest.raises(RejectedError, match="all steps"):
        accept(altered(found, claim=steps), profile, system)


def test_what_is_refused(proved):
    found, profile, system = proved
    one, other = found.proof.parts
    for parts in (
        (one,), (one, one), (), (one, altered(other, cells=b"")), (one, altered(other, steps=9)),
        (one, altered(other, cells=other.cells[:-1])), (one, altered(other, widths={"y": F(1), "vy": F(2) ** 300})),
        (one, altered(other, widths={"y": F(1)})), (one, altered(other, cells=encode_numbers([0, 1, 0, 1, 0, 2**63]))),
        (one, altered(other, cells=encode_numbers([2**63, 1, 0, 1, 0]))), (one, altered(other, cells=b"\0\0\0\0\0")),
    ):  # fmt: skip
        with pytest.raises(RejectedError):
            accept(altered(found, parts=parts), profile, system)
    with pytest.raises(RejectedError, match="depends on vy"):
        InvariantSweep(profile, system, found.claim, {"y": 1.0})
    with pytest.raises(InputError):
        accept(altered(found, parts=(altered(one, widths={"q": F(1)}),)), profile, system)


def test_the_text(proved):
    found, _, _ = proved
    text = to_json(found)
    assert from_json(text) == found and "maviper-system-certificate-4" in text and len(text) < 4_000


# --- planted faults

FAULTS = [
    (invariants.FollowedMotion, "find_breaking", lambda f: lambda self, boxes: boxes.take(slice(0, 0))),
    (invariants.FollowedMotion, "move_boxes", lambda f: lambda self, boxes: boxes),
    (invariants.FollowedMotion, "arriving", lambda f: lambda self, *given: iter(())),
    (invariants.InvariantSweep, "in_cells", lambda f: lambda self, boxes: _first(f(self, boxes))),
    (invariants.Known, "holds", lambda f: lambda self, cells: np.ones(len(cells), dtype=np.bool_)),
    (invariants, "_ensure_closed", lambda f: lambda system, followed: None),
    (invariants, "ensure_shown", lambda f: lambda claim, parts: None),
    (invariants, "find_shown_halves", lambda f: lambda claim, followed: frozenset(range(9))),
    (invariants, "ensure_asked", lambda f: lambda *given, **named: None),
    (invariants.StatedStates, "beyond", lambda f: lambda self, low, high: np.zeros(len(low), dtype=np.bool_)),
]


def _first(found):
    boxes, cells = found
    return boxes.take(slice(0, 1)), cells[:1]


def wrong(proved):
    try:
        test_what_is_refused(proved)
        test_false_invariants()
        test_steps_out_of_the_list()
        test_other_forms_show_nothing_for_ever(proved)
        test_unstated()
        attacked(range(20))
    except (AssertionError, pytest.fail.Exception, ValueError, KeyError):
        return True
    return False


def test_unstated():
    """Where dynamics end, an invariant ends."""
    system, profile = thermostat()
    short = replace(system, pieces=(replace(system.pieces[0], where={"warm": (F(16), F(30))}),))
    assert answered((short, profile), always(warm=(F(0), F(40))), samples=0).verdict is Verdict.UNKNOWN
    spent = answered((short, profile), always(warm=(F(0), F(40))), max_boxes=60_000)
    assert spent.verdict is Verdict.UNKNOWN and "no invariant was found" in spent.reason


def test_lists_of_cells_obey_the_budget(monkeypatch):
    """Lists that end at once count too, and so do the episodes that show how far variables range."""
    system, profile = thermostat()
    tried, played = [], []
    monkeypatch.setattr(CellSearch, "_close_cells", lambda self, *of: tried.append(of) or no_list())
    own = unbounded.estimate_ranges
    monkeypatch.setattr(unbounded, "estimate_ranges", lambda *given: played.append(given[2]) or own(*given))
    for most, lists in ((1_000, 2), (60_000, 18)):
        tried.clear()
        assert CellSearch(profile, system, always(warm=(F(0), F(40))), most).part(["warm"]) is None
        assert len(tried) == lists
    assert played[0] < played[1] <= 128


def no_list():
    raise RejectedError("none")


@pytest.mark.parametrize("number", range(len(FAULTS)))
def test_planted_faults_are_caught(number, proved, monkeypatch):
    owner, name, change = FAULTS[number]
    monkeypatch.setattr(owner, name, change(getattr(owner, name)))
    assert wrong(proved)
