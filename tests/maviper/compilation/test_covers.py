"""Monitors of proofs about stated systems: they vouch for the states of the proof, in all languages alike."""

import functools
import json
import math
import shutil
from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError, RefusedError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from codegen.lowering import covering
from codegen.lowering.covering import Boxes, Cover, Variable, lookup, merge_boxes
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch
from codegen.policy_json import dumps
from maviper import load, verify_system
from maviper.compilation import covers
from maviper.compilation.covers import split_modes
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.worlds.stated.certified import read_certificate
from maviper.worlds.stated.systems import read
from tests.support import monitors
from tests.support.altered import altered, sealed
from tests.support.generated import FOLDER
from tests.support.monitors import INVALID, LEAVING, OK, OUTSIDE, CoverTwin, asked_of_cover, module_of
from tests.support.stated_play import Played
from verify.checker.accept import accept
from verify.checker.systems import proofs
from verify.systems.files import statement_of

WORLDS = FOLDER.parent / "worlds"
ARCH = FOLDER.parent / "arch"
TWO = ("c", "python")
ALWAYS = """name = "always"
region = { box = { angle = [-0.15, 0.15] } }"""


@pytest.fixture(scope="module")
def for_ever(tmp_path_factory):
    """A folder with the proof that the pole of a committed world stays up for ever."""
    return monitors.certify(tmp_path_factory.mktemp("always"), "pendulum", ALWAYS).parent


@functools.cache
def made(folder, certificate):
    """Of a certificate the profile, what is proved, and the lowered monitor; many tests ask about the same proof."""
    profile = load(folder / "profile.json")
    proved = load_proof(folder / certificate, profile)
    return profile, proved, lower_monitor(profile, lower(profile), proved)


@pytest.mark.compile
@pytest.mark.parametrize(
    ("form", "languages"),
    [
        ("for ever", monitors.LANGUAGES),
        ("cover", TWO),
        *(pytest.param(form, monitors.LANGUAGES, marks=pytest.mark.slow) for form in ("cover", "decisions")),
    ],
)
def test_all_languages_say_what_the_proof_says(form, languages, for_ever, tmp_path):
    folder, name = {
        "for ever": (for_ever, "certificate.json"),
        "cover": (WORLDS / "crossing", "certificate-1-stays_in.json"),
        "decisions": (WORLDS / "pendulum", "certificate-2-decides.json"),
    }[form]
    profile, proved, watched = made(folder, name)
    rows = asked_of_cover(proved.region, 1_500, 5)
    wanted = CoverTwin(proved.region).said(rows)
    assert {OK, OUTSIDE, INVALID} <= set(wanted) and wanted.count(OK) > 500
    assert (LEAVING in wanted) is not proved.region.ever
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path, languages)


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        pytest.param(WORLDS / "cart_pole", "certificate-2-stays_in.json", marks=pytest.mark.slow),
        (WORLDS / "corridor", "certificate-1-avoids.json"),
        pytest.param(WORLDS / "quadrotor", "certificate-2-reaches_and_stays.json", marks=pytest.mark.slow),
        (None, "certificate.json"),
    ],
    ids=["cart_pole", "corridor", "quadrotor", "for ever"],
)
def test_it_vouches_for_all_that_moves_as_stated(folder, name, for_ever):
    """Episodes from the start, and from any state that is vouched for: until the proof ends they stay vouched for."""
    folder = folder or for_ever
    profile, proved, _ = made(folder, name)
    cover, rng = proved.region, np.random.default_rng(3)
    played = Played(read(folder / "world.toml"), profile)
    w = played.starts(rng, 60)
    steps = 40 if cover.ever else len(cover.steps)
    for step in range(steps):
        assert cover.holds(w, step).all()
        # a pole, a wheel or a car is put somewhere else, and is followed where that is still vouched for
        moved = w + rng.normal(scale=0.02, size=w.shape)
        w = np.where(cover.holds(moved, step)[:, None], moved, w)
        w = played.moved(w, rng)
    assert cover.ever or not cover.holds(w, steps).any()


def test_a_forged_or_strange_certificate_is_refused(for_ever, tmp_path):
    profile = load(for_ever / "profile.json")
    for name in ("profile.json", "world.toml"):
        shutil.copy(for_ever / name, tmp_path)
    body = json.loads((for_ever / "certificate.json").read_text())

    def taken(**changed):
        (tmp_path / "edited.json").write_text(sealed(body | changed))
        return load_proof(tmp_path / "edited.json", profile)

    assert taken().region.ever
    with pytest.raises(RefusedError, match="refused"):  # half of the cells are no invariant
        taken(parts=[{**part, "widths": dict.fromkeys(part["widths"], "1/1024")} for part in body["parts"]])
    with pytest.raises(InputError, match="profile"):
        taken(profile="0" * 64)
    with pytest.raises(InputError, match="system"):
        taken(system="0" * 64)
    shutil.copy(WORLDS / "quadrotor" / "world.toml", tmp_path)  # of another world
    with pytest.raises(InputError):
        taken()


def test_sets_that_no_few_comparisons_know_are_refused_with_the_reason(tmp_path):
    with pytest.raises(InputError, match="turned boxes, and a box around one holds states of which nothing is proved"):
        made(ARCH / "tora_reach", "certificate-1-reaches_and_stays.json")
    body = json.loads((WORLDS / "crossing" / "certificate-1-stays_in.json").read_text())
    for name in ("profile.json", "world.toml"):
        shutil.copy(WORLDS / "crossing" / name, tmp_path)
    (tmp_path / "forms.json").write_text(sealed(body | {"sets": "forms"}))
    with pytest.raises(InputError, match="affine forms"):
        made(tmp_path, "forms.json")


def proved_for(folder, world, text):
    """Of a claim about a committed world the profile, what is proved, and the lowered monitor."""
    return made(folder, monitors.certify(folder, world, text).name)


ASSUMING = f"{ALWAYS}\nassuming = {{ box = {{ x = [-0.3, 0.3] }} }}"


def test_what_a_claim_assumes_is_watched(tmp_path):
    """Where the cart is as the claim assumes, the words are those without; elsewhere the monitor never vouches."""
    _, proved, watched = proved_for(tmp_path, "pendulum", ASSUMING)
    assert "as long as it stays in" in proved.claim and watched.check.parts == len(proved.region.steps[0]) == 2
    space = module_of(watched)
    beyond = math.nextafter(0.3, 1.0)
    said = []
    for x in (0.0, 0.3, -0.3, beyond, -beyond):
        found = space["Monitor"]()
        found.renew_all()
        said.append(int(found.step([x, 0.0, 0.0, 0.0], 0.05)))
    assert said == [OK, OK, OK, OUTSIDE, OUTSIDE]
    assert proved.region.holds(np.array([[0.0, 0.0, 0.2, 0.0]]), 0).tolist() == [False]
    single = np.array([0.3, 0.0, 0.0, 0.0], dtype=np.float32)
    assert float(single[0]) > 0.3 and not space["within"](single) and space["within"]([0.3, 0.0, 0.0, 0.0])


def test_what_one_state_does_not_show_is_refused_with_the_reason(tmp_path):
    with pytest.raises(InputError, match="is fulfilled once"):
        proved_for(tmp_path, "pendulum", 'name = "reaches"\nsteps = 1\nregion = { box = { angle = [-0.2, 0.2] } }')


def test_invariants_by_regions_and_symbolic_states_are_refused_with_the_reason(for_ever, monkeypatch):
    """Their sets are no boxes: the certificates are those of other proofs, with sets of these kinds in them."""
    ever, world = read_certificate(for_ever / "certificate.json")
    regions = altered(ever, parts=tuple(altered(part, regions=(None,), steps=2) for part in ever.proof.parts))
    stays, tanks = read_certificate(WORLDS / "tanks" / "certificate-1-stays_in.json")
    decides, _ = read_certificate(WORLDS / "tanks" / "certificate-3-decides.json")
    symbolic = replace(decides, claim=stays.claim)
    for found, statement, said in ((regions, world, "knows one"), (symbolic, tanks, "symbolic states")):
        with monkeypatch.context() as patched, pytest.raises(InputError, match=said):
            patched.setattr(covers, "read_certificate", lambda _, answer=(found, statement): answer)
            covers.load_cover(for_ever / "certificate.json", load(for_ever / "profile.json"))


def test_nothing_is_rounded_where_boxes_are_joined():
    """Random closed boxes with common ends: the rows hold the same float64 states, ends and neighbours included."""
    rng = np.random.default_rng(11)
    for _ in range(30):
        ends = rng.choice([0.0, 0.1, 0.25, 1 / 3, 0.5, 1.0], (int(rng.integers(1, 40)), 2, 2))
        low, high = ends.min(axis=1), ends.max(axis=1)
        beside = np.nextafter(high, np.inf)  # a box that begins with the next float
        boxes = Boxes(np.concatenate([low, beside]), np.concatenate([high, beside + 0.2]))
        pool = np.unique(np.concatenate([boxes.low, boxes.high]))
        pool = np.concatenate([pool, np.nextafter(pool, -np.inf), np.nextafter(pool, np.inf)])
        states = rng.choice(pool, (400, 2))
        wanted = boxes.holds(states)
        assert (merge_boxes(boxes).holds(states) == wanted).all() and wanted.any()
        found = lookup([[boxes]], "here")
        told = [searched(found, state) for state in states]
        assert [inside for inside, _ in told] == wanted.tolist()
        assert max(compared for _, compared in told) <= found.comparisons  # no path is longer than is said


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_parts_of_which_one_is_told_apart_along_one_variable_hold_what_they_hold(order):
    """The second part of an invariant may lie in a row where the first is scattered."""
    rng = np.random.default_rng(4)
    corner = rng.permutation(16 * 16)[:64]
    scattered = np.stack([corner % 16, corner // 16], axis=1).astype(np.float64)
    row = np.stack([np.arange(0.0, 64.0, 2.0), np.zeros(32)], axis=1)
    both = [Boxes(scattered, scattered + 0.5), Boxes(row, row + np.array([1.0, 64.0]))]
    parts = [both[place] for place in order]
    found = lookup([parts], "here")
    states = np.concatenate([rng.uniform(-1.0, 64.0, (300, 2)), scattered + 0.25, row + 0.5])
    for place, part in enumerate(parts):
        assert [searched(found, state, place)[0] for state in states] == part.holds(states).tolist()


def test_boxes_that_bound_other_variables_each_hold_what_they_hold():
    """As of a claim that assumes one of several regions: what a box does not bound has no width that floats know."""
    inf = np.inf
    boxes = Boxes(np.array([[-1.0, -inf], [-inf, 2.0], [5.0, -inf]]), np.array([[1.0, inf], [inf, 3.0], [inf, inf]]))
    states = np.random.default_rng(2).uniform(-8.0, 8.0, (400, 2))
    wanted = boxes.holds(states).tolist()
    assert [searched(lookup([[boxes]], "here"), state)[0] for state in states] == wanted and 0 < sum(wanted) < 400


def searched(found, state, part=0):
    """What a reader of the search says, for a part of the first list, and how many numbers it compared."""
    grid, axes, columns = found.grids[part], found.axes[part], found.columns[part]
    cell, compared = grid.begin, 0
    for low, high, scale, stride, axis in zip(*grid[:4], axes, strict=True):
        place = min(max(state[axis], float(low.decimal)), float(high.decimal))
        cell += stride * int((place - float(low.decimal)) * float(scale.decimal))
        compared += 2
    end = found.order.index(-1, found.rests[cell])
    for at in (found.firsts[cell], *found.order[found.rests[cell] : end]):
        compared += 2 * found.width
        box = found.boxes[at]
        ends = [(float(low.decimal), float(high.decimal)) for low, high in zip(*box, strict=True)]
        if all(low <= state[column] <= high for column, (low, high) in zip(columns, ends, strict=True)):
            return True, compared
    return False, compared


def test_too_many_boxes_and_names_that_meet_are_refused(monkeypatch):
    low = np.arange(30.0)[:, None] * 2.0
    for limit in ("MAX_BOXES", "MAX_GIVEN"):
        with monkeypatch.context() as patched, pytest.raises(InputError, match="are 30 boxes"):
            patched.setattr(covering, limit, 29)
            lookup([[Boxes(low, low + 1.0)]], "certificate")
    boxes = Boxes(np.zeros((1, 2)), np.ones((1, 2)))
    cover = Cover((Variable("a.x", 0.0, 1.0), Variable("a_x", 0.0, 1.0)), ((boxes,),), True, True, 1.0)
    with pytest.raises(InputError, match="one name in code"):
        profile = load(WORLDS / "pendulum" / "profile.json")
        watch(profile, lower(profile), cover, "0" * 64, "nothing")


def test_a_list_is_kept_as_it_is_asked_about():
    """The boxes of each step are those of the checker's sweep, which counts them."""
    folder = WORLDS / "crossing"
    profile, proved, _ = made(folder, "certificate-1-stays_in.json")
    found = proofs.from_json((folder / "certificate-1-stays_in.json").read_bytes())
    swept = accept(found, profile, read(folder / "world.toml").system)
    assert swept == sum(len(part.low) for parts in proved.region.steps for part in parts)


# --- modes: a number between the values of a mode is no state, and nothing is proved of it

TREE = """
def a(x, number):
    if number <= 0.2:
        if x <= 0.25:
            return 1
        return 0
    if number <= 0.7:
        return 2
    return 0
"""  # never high in a mode, but between two
HEATER = """
name = "heater"
steps = 4
[variables]
x = { unit = "1", range = [-50, 50] }
heat = { modes = ["off", "low", "high"] }
[agents.a.features]
x = "x"
number = "heat"
[agents.a.actions]
off = {}
low = { power = 0.2 }
high = { power = 40 }
[start]
box = { x = [-1, 1], heat = "off" }
"""
STEPS = """
[[dynamics.piece]]
when = "heat == high"
next = { x = "0.5*x + 40", heat = "acts(a)" }
[[dynamics.piece]]
when = "otherwise"
next = { x = "0.5*x + a.power", heat = "acts(a)" }
"""
FLOW = """
[dynamics]
period = "0.5 s"
flow = { x = "(a.power - x)/1[s]" }
next = { heat = "acts(a)" }
"""
WITHIN = "region = { box = { x = [-1.5, 1.5] } }"
WARM = 'where = ["x >= -1", "x <= 1", "heat == '
CLAIMS = {
    "decides": (STEPS, 'formula = "not acts(a) == high"'),
    "stays": (STEPS, f'name = "stays_in"\n{WITHIN}'),
    "always": (STEPS, f'name = "always"\n{WITHIN}'),
    "a region": (STEPS, f'name = "always"\n{WITHIN}\ninvariant = [{{ {WARM}off"] }}, {{ {WARM}low"] }}]'),
    "flow": (FLOW, f'name = "stays_in"\n{WITHIN}'),
}


@pytest.mark.parametrize("name", CLAIMS)
def test_what_is_no_mode_is_vouched_for_nowhere(name, tmp_path):
    moves, claim = CLAIMS[name]
    (tmp_path / "world.toml").write_text(HEATER + moves)
    (tmp_path / "properties.toml").write_text(f"[[property]]\n{claim}\n")
    said, names = Said(arrays="float64"), Names(actions=("off", "low", "high"))
    (tmp_path / "profile.json").write_text(dumps(profile_of(from_python(TREE.encode(), "a.py", said), names)))
    profile = load(tmp_path / "profile.json")
    found = verify_system(profile, tmp_path / "world.toml", tmp_path / "properties.toml")
    ((_, certificate),) = found.certificates.items()
    if name == "flow":  # its sets are turned boxes; joined in cells they are boxes
        certificate = sealed(json.loads(certificate) | {"cells": {"x": "1/8", "heat": "1"}})
    (tmp_path / "certificate.json").write_text(certificate)
    cover = load_proof(tmp_path / "certificate.json", profile).region
    x, heat = (each.ravel() for each in np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(-0.5, 2.5, 25)))
    w, whole = np.column_stack([x, heat]), np.isin(heat, [0.0, 1.0, 2.0])
    held = [cover.holds(w, step) for step in range(len(cover.steps))]
    assert not any(each[~whole].any() for each in held)
    assert all(each[whole].any() for each in held)


def test_boxes_are_cut_to_the_values_of_modes(monkeypatch):
    """Not where a mode may be any number, and not into more than there is room for."""
    statement = statement_of(HEATER + STEPS, "world.toml")
    low, high = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, -np.inf]]), np.array([[9.0, 2.0], [9.0, 1.0], [9.0, np.inf]])
    boxes = split_modes(statement, Boxes(low, high), "here")
    assert boxes.low[:, 0].tolist() == [0.0, 0.0, 0.0, 1.0, 2.0]
    assert list(zip(boxes.low[:, 1].tolist(), boxes.high[:, 1].tolist(), strict=True)) == [
        (0.0, 0.0),
        (1.0, 1.0),
        (2.0, 2.0),
        (1.0, 1.0),
        (-np.inf, np.inf),
    ]
    monkeypatch.setattr(covers, "MAX_GIVEN", 4)
    with pytest.raises(InputError, match="more than 4 boxes, one for each value of its modes"):
        split_modes(statement, Boxes(low, high), "here")
