"""The checker of covers against episodes in exact numbers: what it takes for a proof holds, with any recipe.

Certificates that are covers: their text, what they are refused for, and forgeries of false claims.
"""

import json
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support import covers
from tests.support.altered import altered, of_hashes
from tests.support.covers import CASES, PLAIN, after, claimed, line, question, recipe, shown
from tests.support.exact_play import refuted, start
from tests.support.system_cases import box, double_integrator, form, policy, stays, switching, team
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.covers import boxes, images, rounding, sweep, trees
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Cover, from_json
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, Piece, System, Variable

CELLS = (PLAIN, ((0,), {0: 0.5}), ((1, 0, 1, 0, 0), {0: 2.0}))


def attacked(seeds, episodes):
    return covers.attacked(7, seeds, episodes, 3, lambda random, seed: question(random))


def test_what_is_shown_is_true():
    met = attacked(range(80), 40)
    for kind in {pattern for pattern, _, _ in met}:
        assert met[kind, True, False] >= 2 and met[kind, False, True] >= 2, met


@pytest.mark.slow
def test_what_is_shown_is_true_of_thousands():
    met = attacked(range(100_000, 103_000), 60)
    assert sum(count for (_, proved, _), count in met.items() if proved) > 600


# --- questions whose answers hang on a single number


@pytest.mark.parametrize(("asked", "claim", "holds"), [each[1:] for each in CASES], ids=[each[0] for each in CASES])
def test_single_numbers(asked, claim, holds):
    for cells in CELLS:
        assert shown((*asked, claim), cells) == holds


def test_two_pieces_and_borders():
    """On a border each piece may be taken; without the second one something is left unstated."""
    low = Piece({"x": (F(-9), F(0))}, {"x": form(-1, x=1)})
    high = Piece({"x": (F(0), F(9))}, {"x": form(1, x=1)})
    system, profile = line((0, 0), -5.0)
    both = replace(system, pieces=(low, high))
    assert not shown((both, profile, claimed("stays_in", 1, x=(0, 1))), PLAIN)
    assert not shown((both, profile, claimed("stays_in", 1, x=(-1, 0))), PLAIN)
    assert shown((both, profile, claimed("stays_in", 1, x=(-1, 1))), PLAIN)
    gap = replace(system, pieces=(low, replace(high, where={"x": (F(1), F(9))})))
    assert not shown((gap, profile, claimed("stays_in", 1, x=(-1, 1))), PLAIN)


@pytest.mark.parametrize(("move", "most"), [(form(x=F(1, 2)), 2), (form(1), 2), (form(5, x=-1), 5)])
def test_each_piece_moves_its_own_boxes(move, most):
    """One turns [-1, 0] into [0, 2], the other moves [0, 4] otherwise."""
    turned, other = Piece({"x": (F(-9), F(0))}, {"x": form(x=-2)}), Piece({"x": (F(0), F(9))}, {"x": move})
    system, profile = line((-1, 4), -5.0)
    both = replace(system, pieces=(turned, other))
    assert shown((both, profile, claimed("reaches_and_stays", 1, by=1, x=(0, most))), PLAIN)
    assert not shown((both, profile, claimed("reaches_and_stays", 1, by=1, x=(0, most - F(1, 8)))), PLAIN)


def test_a_sum_of_two_variables_is_cut():
    """An agent that sees x + y keeps it at most 1, which no box knows before it is cut."""
    pair = tuple(Variable(name, "1", (F(-9), F(9))) for name in "xy")
    feature = {"a": {"f": Feature(form(x=1, y=1))}}
    push = {("a", "go"): {"x": form(1)}}
    system = System(
        "sum", pair, feature, box(x=(0, 4), y=(0, 0)), (Piece({}, {"x": form(x=1), "y": form(y=1)}, push),), 1
    )
    profile = team(policy("a", ["f"], ["go", "rest"], ((0, 1.0), 0, 1)))
    assert shown((system, profile, claimed("stays_in", 1, x=(0, 4))), PLAIN)
    assert not shown((system, profile, claimed("avoids", 1, x=(F(3, 2), 2))), PLAIN)
    assert not shown((system, profile, claimed("stays_in", 1, x=(0, F(7, 2)))), PLAIN)


def test_recipes_that_name_what_there_is_not():
    asked = (*line((0, 1), -5.0), claimed("stays_in", 1, x=(0, 1)))
    for bad in (((), {}), ((1, 0), {}), ((2, 0, 0), {}), ((0, 0), {}), ((0,), {0: 1e-300})):
        assert not shown(asked, bad)


def test_numbers_beyond_floats_are_refused():
    far = line((0, 1), -5.0, move={"x": form(x=F(10) ** 300)})
    assert not shown((*far, claimed("avoids", 3, x=(-2, -1))), PLAIN)


def test_boxes_that_are_alike_become_one():
    random = np.random.default_rng(5)
    low = np.repeat(random.uniform(-3, 3, size=(50, 4)), 6, axis=0)
    near = low + random.choice([0, 1e-15, -1e-15], size=low.shape)
    listed = boxes.BoxList.of(near, near + 1, np.repeat(np.arange(2), 150), np.zeros(300, dtype=np.int64))
    joined = boxes.alike_joined(listed)
    assert 50 <= joined.size < 150
    assert (joined.high - joined.low < 1 + 1e-14).all()
    for number in range(300):
        holds = (joined.low <= listed.low[number]) & (joined.high >= listed.high[number])
        assert holds.all(axis=1).any()


# --- planted faults: each makes a question's answer wrong


FAULTS = [
    (sweep.BoxSweep, "_ask_claim", lambda f: lambda self, listed, step: listed),
    (sweep.BoxSweep, "_leave", lambda f: lambda *given: None),
    (sweep.BoxSweep, "_region", lambda f: lambda self, region: f(self, region[:1])),
    (images.StatedStates, "beyond", lambda f: lambda self, low, high: np.zeros(len(low), dtype=np.bool_)),
    (boxes.Parts, "box_starts", after(lambda found: found.take(np.arange(found.size) < 0))),
    (images, "split_by_trees", lambda f: lambda grown, listed: f(grown, listed).take(slice(0, 1))),
    (images.BoxPieces, "cut_boxes", after(lambda found: (found[0].take(slice(0, -1)), found[1][:-1]))),
    (trees.LeafWays, "split_at_leaves", after(lambda found: (found[0], found[1][::-1].copy()))),
    (trees.LeafWays, "_pairs", after(lambda found: tuple(each[:1] for each in found))),
    (trees.WayDown, "on", lambda f: lambda self, lines, node: f(self, lines[:0], node)),
    (trees.LeafWays, "_pairs", lambda f: lambda self, columns, least, most: f(self, columns, least + 1.0, most)),
    (boxes.LineCuts, "within", after(lambda found: found.take(slice(0, 0)))),
    (trees, "half_line", after(lambda line: line and line._replace(end=line.end._replace(last=line.down - 2.0**-30)))),
    (trees, "_sides", lambda f: lambda tests, *to: f([(test, test) for test, _ in tests], *to)),
    (boxes.Cut, "_by_one", lambda f: lambda self, listed, line: f(listed, line).take(slice(0, 0))),
    (boxes.RegionCut, "outside", lambda f: lambda self, listed: listed.take(slice(0, 0))),
    (boxes.RegionCut, "within", lambda f: lambda self, listed: listed.take(slice(0, 0))),
    (images, "choices_of", lambda f: lambda joint, policies: []),
    (images.BoxPieces, "cut_boxes", after(lambda found: (found[0].take(slice(0, 0)), found[1][:0]))),
    (images._BoxMotions, "move_bounds", lambda f: lambda self, bounds, shift, of: f(self, bounds, np.abs(shift), of)),
    (images._BoxMotions, "move_bounds", lambda f: lambda self, bounds, shift, of: f(self, np.abs(bounds), shift, of)),
    (images._BoxMotions, "move_bounds", lambda f: lambda self, bounds, shift, of: f(self, bounds, shift, 0 * of)),
    (trees.PairNumbers, "find", after(lambda numbers: 0 * numbers)),
    (rounding.Factor, "times_down", lambda f: lambda self, values, at=None: f(self, values, at) / 2),
    (boxes, "join_by_cell", lambda f: lambda listed, cells: f(listed, cells).take(slice(0, 1))),
    (boxes, "cut", lambda f: lambda *given: (lambda found: (found[0].take(slice(0, 1)), found[1][:1]))(f(*given))),
    (trees.LeafWays, "may_meet", lambda f: lambda self, least: f(self, least + 1.0)),
]  # fmt: skip


def wrong():
    """Whether some answer is wrong: of the questions above, or of random ones."""
    for _, asked, claim, holds in CASES:
        if any(shown((*asked, claim), cells) != holds for cells in CELLS):
            return True
    try:
        test_two_pieces_and_borders()
        test_each_piece_moves_its_own_boxes(form(1), 2)
        test_a_sum_of_two_variables_is_cut()
        attacked(range(30), 20)
    except AssertionError:
        return True
    return False


@pytest.mark.parametrize("number", range(len(FAULTS)))
def test_planted_faults_are_caught(number, monkeypatch):
    owner, name, change = FAULTS[number]
    monkeypatch.setattr(owner, name, change(getattr(owner, name)))
    assert wrong()


def certificate(profile, system, claim, state, cells):
    names = [one.name for one in system.variables]
    widths = {names[column]: F(width) for column, width in cells[1].items()}
    hashes = content_hash(profile), documents.content_hash(system)
    return of_hashes(*hashes, claim, state, Cover(widths, encode_numbers(cells[0])))


@pytest.fixture(scope="module")
def proved():
    system, profile = double_integrator(axes=1), switching(1)
    claim = stays(system, 20, x=(F(-1), F(1)))
    hashes = content_hash(profile), documents.content_hash(system)
    found = of_hashes(*hashes, claim, {"x": F(0), "vx": F(0)}, Cover({"vx": F(1, 16)}, b"\0"))
    return found, profile, system


def test_the_text(proved):
    found, profile, system = proved
    assert accept(found, profile, system) > 20
    text = to_json(found)
    assert from_json(text) == found and to_json(from_json(text)) == text
    assert "maviper-system-certificate-2" in text and len(text) < 2_000


def test_the_text_of_forms(proved):
    found, profile, system = proved
    of_forms = altered(found, cells={}, sets="forms", claim=replace(found.claim, regions=(box(x=(F(-2), F(2))),)))
    assert accept(of_forms, profile, system) > 20
    text = to_json(of_forms)
    assert from_json(text) == of_forms and json.loads(text)["sets"] == "forms"
    assert "sets" not in json.loads(to_json(found))
    with pytest.raises(RejectedError, match="cells"):
        accept(altered(of_forms, cells=found.proof.cells), profile, system)


def test_what_is_refused(proved):
    found, profile, system = proved
    for change in (
        {"cells": {"vx": F(-1)}}, {"cells": {"vx": F(0)}}, {"cells": {"vx": F(2) ** 300}}, {"cuts": b""},
        {"cuts": b"\3\0\0"}, {"cuts": b"\x80"}, {"inhabitant": {"x": F(9), "vx": F(0)}},
        {"claim": replace(found.claim, regions=(box(x=(F(-1, 2), F(1, 4))),))},
        {"claim": replace(found.claim, pattern=Pattern.DECIDES)},
        {"claim": SystemClaim(Pattern.AVOIDS, (box(x=(F(1, 4), F(1, 2))),), 20)},
    ):  # fmt: skip
        with pytest.raises(RejectedError):
            accept(altered(found, **change), profile, system)
    for change in ({"cells": {"y": F(1)}}, {"inhabitant": {"x": F(0)}}, {"profile": "0" * 64}, {"system": "0" * 64}):
        with pytest.raises(InputError):
            accept(altered(found, **change), profile, system)


def forged(seeds, each):
    """How many forgeries of claims that some episode breaks there were. AssertionError where one is accepted."""
    tried = 0
    for seed in seeds:
        random = np.random.default_rng([8, seed])
        asked = question(random)
        system, profile, claim = asked
        state = next((found for found in (start(random, system) for _ in range(20)) if found), None)
        if state is None or not refuted(random, asked, 40):
            continue
        for _ in range(each):
            found = certificate(profile, system, claim, state, recipe(random, system))
            for forgery in (found, altered(found, cells={}, sets="forms")):
                with pytest.raises(RejectedError):
                    accept(forgery, profile, system)
            tried += 2
    return tried


def test_forgeries_of_false_claims():
    assert forged(range(20), 5) >= 50


@pytest.mark.slow
def test_thousands_of_forgeries_of_false_claims():
    assert forged(range(1_000, 1_400), 8) >= 2_000
