"""Turned sets in the plane: whoever is vouched for lies in a set, by exact arithmetic."""

import subprocess

import numpy as np
import pytest

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.errors import InputError
from codegen.lowering.covering import Cover, Variable
from codegen.lowering.lower import lower
from codegen.lowering.searching import Boxes
from codegen.lowering.turning import MAX_SETS, ensure_few_sets, turn_sets
from codegen.lowering.watching import watch_cover
from codegen.targets import emit, monitor
from tests.support.frames import is_in_frame
from tests.support.monitors import OK, OUTSIDE
from tests.support.small import small_profile


def drawn(rng, scale):
    """A set in the plane: its box, and a frame whose rest is about `scale` of it."""
    angle = rng.uniform(0, 7)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    matrix, centre = rng.normal(size=(2, 2)), rng.normal(size=2)
    rest = scale * rng.random(2)
    reach = (np.abs(matrix).sum(axis=1) + np.abs(turned) @ rest) * rng.uniform(0.7, 1.4, 2)
    return Boxes((centre - reach)[None], (centre + reach)[None]), centre, matrix, rest, turned


def find_corners(made, centre, matrix):
    """The points whose z, as code computes it, are as large as they may be, or within a few roundings of that."""
    signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1], [1, 0], [0, 1]])
    near = 1.0 + np.array([-4, -1, 0, 1, 4])[:, None, None] * 2.0**-53
    points = centre + (signs * made.well[0] * near).reshape(-1, 2) @ matrix.T
    z = (points - centre) @ made.inverse[0].T
    return points[(np.abs(z) <= made.well[0]).all(axis=1)]


@pytest.mark.parametrize("scale", [0.0, 1e-15, 1e-9, 0.5])
@pytest.mark.parametrize("count", [6, pytest.param(200, marks=pytest.mark.slow)])
def test_who_is_vouched_for_is_in_the_set(scale, count):
    """Points within, at the border, and a few roundings beyond; of the parallelepiped nearly all are vouched for."""
    rng = np.random.default_rng(int(-np.log10(scale + 1e-30)))
    vouched = beyond = inscribed = 0
    for _ in range(count):
        boxes, centre, matrix, rest, turned = drawn(rng, scale)
        made = turn_sets(boxes, centre[None], matrix[None], rest[None], turned[None], "here")
        z, r = rng.uniform(-1, 1, (60, 2)), rng.uniform(-1, 1, (60, 2))
        z[::2, 0], r[::2] = rng.choice([-1, 1], 30), np.sign(r[::2])  # on an edge
        points = centre + z @ matrix.T + (r * rest) @ turned.T
        outward = (1 + rng.choice([0.0, 1e-16, 1e-15, 1e-13], 60))[:, None]
        points = np.concatenate([points, centre + (points - centre) * outward])
        inside = ((points >= boxes.low) & (points <= boxes.high)).all(axis=1)
        held = made.holds(points)
        assert not (held & ~inside).any()
        for point in points[held]:
            assert is_in_frame(point, centre, matrix, rest, turned)
        beyond += sum(not is_in_frame(point, centre, matrix, rest, turned) for point in points[inside & ~held])
        well = centre + rng.uniform(-0.999, 0.999, (40, 2)) @ matrix.T
        assert made.holds(well[((well >= boxes.low) & (well <= boxes.high)).all(axis=1)]).all()
        vouched += int(held.sum())
        for point in find_corners(made, centre, matrix) if made.inscribed[0] else ():  # whose box is not compared
            assert ((point >= boxes.low[0]) & (point <= boxes.high[0])).all()
            assert is_in_frame(point, centre, matrix, rest, turned)
            inscribed += 1
    assert vouched > 20 * count
    assert inscribed  # there were boxes that need not be compared
    assert beyond  # there were points beyond the border


def test_a_start_is_its_box_and_what_is_flat_is_refused():
    """A frame that holds its whole box is that box, to the last float, even if it is a point along a variable."""
    boxes = Boxes(np.array([[0.1, 0.3]]), np.array([[0.7, 0.3]]))
    centre, straight, none = np.array([[0.4, 0.3]]), np.eye(2)[None], np.zeros((1, 2))
    made = turn_sets(boxes, centre, np.array([[[0.31, 0.0], [0.0, 0.0]]]), none, straight, "here")
    assert not made.inscribed.any()
    corners = np.array([[0.1, 0.3], [0.7, 0.3], [np.nextafter(0.7, 1), 0.3], [0.4, np.nextafter(0.3, 1)]])
    assert made.holds(corners).tolist() == [True, True, False, False]
    wide = Boxes(boxes.low - 1.0, boxes.high + 1.0)
    bent = np.array([[[0.6, -0.8], [0.8, 0.6]]])
    for matrix, turned in (([[0.31, 0.0], [0.31, 0.0]], straight), ([[0.31, 0.0], [0.0, 1e-13]], bent)):
        with pytest.raises(InputError, match="so flat that rounding hides"):
            turn_sets(wide, centre, np.array([matrix]), none, turned, "here")


NONE = 2.0**-1000
FLAT = {  # of a variable: its row of A, its bound of r, and whether it is more than its centre
    "a constant": ([0.0, NONE], 0.0, False),
    "a start that is a point": ([0.0, NONE], 1e-15, True),
    "what nearly nothing moves": ([NONE, NONE], 1e-15, True),
    "thinner than rounding": ([0.0, 1e-15], 1e-30, True),
}


@pytest.mark.parametrize("name", FLAT)
@pytest.mark.parametrize("crossed", [False, True])
def test_a_variable_that_its_frame_sets_apart_may_be_flat(name, crossed):
    """Exactly what is in the set is vouched for, to a rounding of its width, in both orders of the columns of B."""
    rng, (row, most, wide) = np.random.default_rng(3), FLAT[name]
    turned = np.array([[0.0, -1.0], [1.0, 0.0]]) if crossed else np.eye(2)
    rest = np.array([most, 0.01] if crossed else [0.01, most])
    coupling = 0.2 * NONE if most == 1e-15 else 0.0
    centre, matrix = np.array([0.3, 0.7]), np.array([[0.25, coupling], row])
    boxes = Boxes(centre[None] - 1.0, centre[None] + 1.0)
    made = turn_sets(boxes, centre[None], matrix[None], rest[None], turned[None], "here")
    assert not made.inscribed.any()  # its box is compared
    x = rng.uniform(0.0, 0.6, (300, 2))
    x[:, 1] = centre[1] + rng.integers(-12, 13, 300) * 2.0**-53
    x[::3, 1] = centre[1]
    held = made.holds(x)
    inside = np.array([is_in_frame(each, centre, matrix, rest, turned) for each in x])
    assert not (held & ~inside).any() and held.sum() > 50
    assert (inside & ~held).sum() <= 0.12 * inside.sum()  # a float at either end
    assert (x[held, 1] != centre[1]).any() == wide


def test_more_sets_than_there_is_room_for_are_refused():
    """Counted before any is made."""
    ensure_few_sets(MAX_SETS, "here")
    with pytest.raises(InputError, match="5,001 turned boxes, and a monitor has room for 5,000"):
        ensure_few_sets(MAX_SETS + 1, "here")


SANITIZED = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
READ_STATES = """#include "{p}_monitor.h"
#include <stdio.h>
int main(void)
{{
    double w[2];
    {p}_monitor m;
    while (fread(w, sizeof w, 1, stdin) == 1) {{
        {p}_monitor_start(&m);
        {p}_monitor_renew(&m, 0);
        {p}_monitor_renew(&m, 1);
        putchar('0' + {p}_monitor_step(&m, w, 1.0));
    }}
    return 0;
}}
"""


def scatter_sets(rng):
    """Twelve turned sets that are far from each other, in boxes that reach beyond them."""
    places = rng.permutation(256)[:12]
    centre = np.stack([places % 16, places // 16], axis=1) - 7.5
    matrix = np.eye(2) * 0.2 + rng.uniform(-0.05, 0.05, (12, 2, 2))
    turned, rest = np.broadcast_to(np.eye(2), (12, 2, 2)).copy(), np.full((12, 2), 1e-9)
    reach = 1.01 * np.abs(matrix).sum(axis=2) + rest
    return turn_sets(Boxes(centre - reach, centre + reach), centre, matrix, rest, turned, "here")


def say_in_c(watched, texts, states, folder):
    """The words of the monitor in C for each state alone, under sanitizers."""
    p = watched.model.prefix
    for name, text in {**texts, "run.c": READ_STATES.format(p=p)}.items():
        (folder / name).write_text(text)
    command = [*find_compiler(), *STRICT, *SANITIZED, "-ffp-contract=off", "run.c", "-o", "run"]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if "cannot find" in built.stderr or "libclang_rt" in built.stderr:
        pytest.skip("the compiler has no sanitizer runtime here")
    assert built.returncode == 0, built.stderr
    ran = subprocess.run([str(folder / "run")], input=states.tobytes(), capture_output=True, check=False)
    assert ran.returncode == 0, ran.stderr.decode()
    return [int(word) for word in ran.stdout.decode()]


@pytest.mark.compile
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_cells_without_a_set_vouch_for_nothing(tmp_path):
    """Where no box is compared first, the code of an empty cell asks a frame too: one that holds no state."""
    rng = np.random.default_rng(2)
    made, profile = scatter_sets(rng), small_profile()
    cover = Cover((Variable("x", -9.0, 9.0), Variable("y", -9.0, 9.0)), ((made,),), True, False, 1.0)
    watched = watch_cover(profile, lower(profile), cover, "0" * 64, "nothing")
    assert watched.lookup.inscribed
    assert watched.lookup.firsts.count(12) > 50  # cells without a set
    near = made.centre[rng.integers(12, size=3_000)] + rng.uniform(-0.3, 0.3, (3_000, 2))
    states = np.concatenate([rng.uniform(-9.0, 9.0, (6_000, 2)), near])
    wanted = np.where(made.holds(states), OK, OUTSIDE).tolist()
    assert wanted.count(OK) > 1_000 < wanted.count(OUTSIDE)
    texts = {**emit(profile, ["c"]), **monitor.emit(watched, ["c", "python"])}
    space = {}
    exec(compile(texts[f"{watched.model.prefix}_monitor.py"], "monitor", "exec"), space)
    python = space["Monitor"]()

    def say_in_python(state):
        python.start()
        python.renew_all()
        return int(python.step(state, 1.0))

    assert [say_in_python(state) for state in states.tolist()] == wanted
    assert say_in_c(watched, texts, states, tmp_path) == wanted
