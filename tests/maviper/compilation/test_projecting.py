"""Turned boxes without a variable that nothing reads: whoever is vouched for lies in the set, by exact arithmetic."""

from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.importers.origin import Names, Said, profile_of
from codegen.importers.python.source import from_python
from codegen.lowering.lower import lower
from codegen.lowering.searching import Boxes
from codegen.policy_json import dumps
from codegen.targets import emit, monitor
from maviper import load, verify_system
from maviper.compilation import projecting
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.compilation.projecting import Frames, list_unread, turn_without
from maviper.worlds.stated.certified import read_certificate
from tests.support import monitors
from tests.support.generated import FOLDER
from tests.support.monitors import OK, OUTSIDE, asked_of_cover, said_of_cover
from tests.support.stated_play import Played
from verify.systems.language.expressions import Name
from verify.systems.system import Affine, Feature, FlowCase, HalfSpace

CART_POLE = FOLDER.parent / "arch" / "cart_pole" / "certificate-1-reaches_and_stays.json"


def drawn(rng):
    """A set of three variables, the last of which another one tells, and rests of many sizes."""
    matrix, rest = np.zeros((3, 3)), 10.0 ** -rng.uniform(0.5, 7.0, 3)
    matrix[:, :2] = rng.normal(size=(3, 2)) * 10.0 ** -rng.uniform(0.0, 3.0, 2)
    turned, centre = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3)
    reach = np.abs(matrix).sum(axis=1) + np.abs(turned) @ rest
    reach *= [1.5, 1.5, rng.choice([0.6, 0.99, 1.3])]
    box = Boxes((centre - reach)[None], (centre + reach)[None])
    return Frames(box, centre[None], matrix[None], rest[None], turned[None])


def is_in_set(x, sets):
    """Whether a state is one of a set with some third number, exactly."""
    import z3

    def exact(value):
        return z3.RealVal(str(float(value).as_integer_ratio()[0])) / z3.RealVal(str(float(value).as_integer_ratio()[1]))

    solver, names = z3.Solver(), [z3.Real(f"a{at}") for at in range(6)]
    u, columns = z3.Real("u"), np.concatenate([sets.matrix[0], sets.turned[0]], axis=1)
    for name, most in zip(names, [1.0] * 3 + sets.rest[0].tolist(), strict=True):
        solver.add(name <= exact(most), name >= -exact(most))
    for at, value in enumerate([exact(x[0]), exact(x[1]), u]):
        terms = [exact(factor) * name for factor, name in zip(columns[at], names, strict=True)]
        solver.add(value == exact(sets.centre[0, at]) + z3.Sum(terms))
        solver.add(value >= exact(sets.boxes.low[0, at]), value <= exact(sets.boxes.high[0, at]))
    return solver.check() == z3.sat


def ask(count):
    """How many states within sets are vouched for, and whether all states are in their sets that are."""
    rng, shown, right = np.random.default_rng(7), [], True
    for _ in range(count):
        sets = drawn(rng)
        made = turn_without(sets, [2], "here")
        ends = rng.choice([0.5, 1.0, 1.0 + 1e-6], (16, 1))
        z, r = rng.uniform(-1.0, 1.0, (2, 16, 3))
        z[::2], r[::2] = np.sign(z[::2]), np.sign(r[::2])
        points = sets.centre + (ends * z) @ sets.matrix[0].T + (ends * r * sets.rest) @ sets.turned[0].T
        edges = made.centre + rng.choice([-1.0, 1.0], (16, 2)) * ends @ made.matrix[0].T
        edges = edges + rng.choice([-1.0, 0.0, 1.0], (16, 2)) * made.rest @ made.turned[0].T
        well = sets.centre + rng.uniform(-0.5, 0.5, (40, 3)) @ sets.matrix[0].T
        shown.append(made.holds(well[:, :2]).mean())
        asked = np.concatenate([points[:, :2], edges])
        right = right and all(is_in_set(x, sets) for x in asked[made.holds(asked)])
    return np.mean(shown), right


@pytest.mark.solver
def test_who_is_vouched_for_is_in_the_set_with_some_other_number():
    shown, right = ask(25)
    assert right and shown > 0.8


@pytest.mark.solver
@pytest.mark.parametrize("fault", ["the box", "the rest", "the frame"])
def test_a_planted_fault_is_noticed(fault, monkeypatch):
    fit, drop = projecting._fit, projecting._drop_from_frame
    name, planted = {
        "the box": ("_share_box", lambda *given: (1.0, 1.0)),
        "the rest": ("_fit", lambda *given: (3.0 * fit(*given)[0], fit(*given)[1])),
        "the frame": ("_drop_from_frame", lambda *given: (1.01 * drop(*given)[0], *drop(*given)[1:])),
    }[fault]
    monkeypatch.setattr(projecting, name, planted)
    assert not ask(25)[1]


def test_a_set_whose_centre_is_none_of_its_states_is_left_out():
    """What is left of a box that was cut may lie beside the middle of its frame: then so do all that are like this."""
    rng = np.random.default_rng(3)
    sets = [drawn(rng) for _ in range(8)]
    for beyond in sets[::2]:
        beyond.boxes.low[0, 2] = beyond.centre[0, 2] + 1e-9
    both = Frames(
        Boxes(*(np.concatenate(of) for of in zip(*(each.boxes for each in sets), strict=True))),
        *(np.concatenate(of) for of in zip(*(each[1:] for each in sets), strict=True)),
    )
    made = turn_without(both, [2], "here")
    assert made.holds(both.centre[:, :2]).tolist() == [False, True] * 4
    with pytest.raises(InputError, match=r"elsewhere .* than in the middle of their frames"):
        turn_without(sets[0], [2], "here")


HELD = """
name = "held"
steps = 3
[variables]
x = { unit = "1", range = [-3, 3] }
u = { unit = "1", range = [-9, 9] }
[agents.a.features]
x = "x"
[agents.a.actions]
down = { force = -0.3 }
up = { force = 0.3 }
[start]
box = { x = [0.4, 0.6], u = [0, 1] }
[dynamics]
period = "0.25 s"
flow = { x = "(u - x)/1[s]", u = 0 }
next = { u = "a.force" }
[[property]]
name = "stays_in"
region = { box = { x = [-2, 2] } }
"""


def test_episodes_are_vouched_for_though_a_sample_sets_one_number(tmp_path):
    """A force that an action sets is a point of its own: what only it may be off takes nothing from the others."""
    source = from_python(b"def a(x):\n    return 1 if x <= 0.0 else 0\n", "a.py", Said(arrays="float64"))
    (tmp_path / "profile.json").write_text(dumps(profile_of(source, Names(actions=("down", "up")))))
    (tmp_path / "world.toml").write_text(HELD)
    profile = load(tmp_path / "profile.json")
    ((_, text),) = verify_system(profile, tmp_path / "world.toml").certificates.items()
    (tmp_path / "certificate.json").write_text(text)
    cover = load_proof(tmp_path / "certificate.json", profile).region
    played, rng = Played(read_certificate(tmp_path / "certificate.json")[1], profile), np.random.default_rng(2)
    assert [one.name for one in cover.variables] == ["x"]
    w = played.starts(rng, 50)
    for step in range(len(cover.steps)):
        assert cover.holds(w[:, :1], step).all()
        w = played.moved(w, rng)


@pytest.fixture(scope="module")
def cart_pole():
    """The profile, what is proved, and the statement."""
    profile = load(CART_POLE.parent / "profile.json")
    return profile, load_proof(CART_POLE, profile), read_certificate(CART_POLE)


def test_episodes_are_vouched_for_though_their_force_is_told_by_the_rest(cart_pole):
    """From near the ends of the start too; who is pushed off is refused, whatever the force is said to be."""
    profile, proved, (_, statement) = cart_pole
    cover, rng = proved.region, np.random.default_rng(5)
    played = Played(statement, profile)
    assert [one.name for one in cover.variables] == ["x1", "x2", "x3", "x4"] == played.names[:4]
    w = played.starts(rng, 60)
    row, ends = np.arange(40), np.array([0.1, 0.05, 0.1, 0.05]) * (1.0 - 1e-6)
    w[row, row % 4] = ends[row % 4] * np.where(row // 4 % 2, 1.0, -1.0)
    for step in range(len(cover.steps)):
        assert cover.holds(w[:, :4], step).all()
        if step % 100 == 99:
            assert not cover.holds(w[:, :4] + [0.0, 0.0, 0.0, 0.2], step).any()
        w = played.moved(w, rng)


@pytest.mark.compile
@pytest.mark.slow
def test_all_languages_say_the_same(cart_pole, tmp_path):
    profile, proved, _ = cart_pole
    cover = replace(proved.region, steps=proved.region.steps[30:70])
    watched = lower_monitor(profile, lower(profile), replace(proved, region=cover))
    assert watched.lookup.skewed and watched.lookup.alone
    texts = {**emit(profile, monitors.LANGUAGES), **monitor.emit(watched, monitors.LANGUAGES)}
    rows = asked_of_cover(cover, 1_500, 5)
    wanted = said_of_cover(cover, rows)
    assert min(wanted.count(OK), wanted.count(OUTSIDE)) > 50
    n, rest = len(watched.model.agents[0].actions), watched.fallbacks[0].action
    acted = [i % n if word < OUTSIDE else rest for i, word in enumerate(wanted)]
    monitors.ensure_said_by_all(texts, watched, tmp_path, rows, (wanted, acted))


def test_what_anything_reads_is_kept(cart_pole):
    """Not what an agent observes, the claim names, a sample makes something of, a case asks or a delay keeps."""
    _, _, (proof, statement) = cart_pole
    system, claim, form = statement.system, proof.claim, Affine.of({"u": 1})
    flow = system.flow
    assert list_unread(system, claim) == ["u"]
    assert list_unread(replace(system, flow=None), claim) == []
    case = FlowCase({}, (), flow.rates, {}, flow.jumps)
    held = {"cart": system.features["cart"] | {"u": Feature(form)}}
    read = {
        "observed": (replace(system, features=held), claim),
        "claimed": (system, replace(claim, regions=((*claim.regions[0], HalfSpace(form)),))),
        "assumed": (system, replace(claim, assuming=((HalfSpace(form),),))),
        "jumps": (replace(system, flow=replace(flow, jumps={**flow.jumps, "x1": Name("u")})), claim),
        "kept": (replace(system, flow=replace(flow, kept={"u": "x1"})), claim),
        "seen": (replace(system, flow=replace(flow, seen=({"x1": "u"},))), claim),
        "where": (replace(system, flow=replace(flow, cases=(replace(case, where={"u": (0, 1)}),))), claim),
        "when": (replace(system, flow=replace(flow, cases=(replace(case, when=(HalfSpace(form),)),))), claim),
        "another case": (replace(system, flow=replace(flow, cases=(case, replace(case, jumps={})))), claim),
    }
    assert {name: list_unread(*given) for name, given in read.items()} == {name: [] for name in read}
    assert list_unread(replace(system, flow=replace(flow, cases=(case, case))), claim) == ["u"]
