"""Cases, clips and modes of a world file that name what an action sets: beside the file, read by hand."""

from fractions import Fraction as F
from random import Random

import pytest

import maviper
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from verify.checker.accept import accept
from verify.systems.files import statement_of
from verify.systems.observing import as_played

WORLD = """name = "valve"
steps = 60
[variables]
level = { range = [0, 4] }
open = { range = [0, 1] }
pump = { modes = ["off", "slow", "fast"] }
[agents.a.features]
level = "level"
[agents.a.actions]
shut = { turn = -0.5, pump = "off" }
hold = { pump = "slow" }
fast = { turn = 0.25 }
[start]
box = { level = [1, 2], open = 0, pump = "off" }
[[dynamics.piece]]
when = "open + a.turn > 0.75 and level < 3"
next = { level = "level + 0.5 - clip(level + 2*a.turn, 0, 0.5)", open = "min(open + a.turn, 1)", pump = "acts(a)" }
[[dynamics.piece]]
when = "otherwise"
next = { level = "0.75*level + 0.25", open = "clip(open + a.turn, 0, 1)", pump = "pump" }
[[claim]]
name = "always"
region = { box = { open = [0, 1], level = [0, 3.5] } }
"""
TURNS, MODES = {"shut": F(-1, 2), "hold": F(0), "fast": F(1, 4)}, {"shut": 0, "hold": 1, "fast": 2}


def cut(value, low, high):
    return min(max(value, low), high)


def moved(level, valve, pump, action):
    """The file by hand."""
    turn = TURNS[action]
    if valve + turn > F(3, 4) and level < 3:
        return level + F(1, 2) - cut(level + 2 * turn, F(0), F(1, 2)), min(valve + turn, F(1)), MODES[action]
    return F(3, 4) * level + F(1, 4), cut(valve + turn, F(0), F(1)), pump


def states():
    random, quarters = Random(0), [F(k, 8) for k in range(9)]
    for _ in range(400):
        level = random.choice([F(3), F(1, 2), F(0), F(4), F(random.randrange(4001), 1000)])
        yield level, random.choice([*quarters, F(random.randrange(1001), 1000)]), random.randrange(3)


def ensure_as_by_hand(system, actions):
    assert not any(piece.error for piece in system.pieces), "exact"
    for level, valve, pump in states():
        state = {"level": level, "open": valve, "pump": F(pump)}
        for action in actions:
            (piece,) = (each for each in system.pieces if each.holds(state))
            after = piece.step(state, {"a": action}, {})
            assert (after["level"], after["open"], after["pump"]) == moved(level, valve, pump, action), (state, action)


def test_an_action_takes_one_case_and_one_side_of_a_clip_in_each_state():
    ensure_as_by_hand(statement_of(WORLD, "valve.toml").system, TURNS)


CONTROLLER = """#include <stdint.h>
typedef enum { shut, hold, fast } move_t;
static uint8_t wait = 0;
move_t a(float level) {
    if (level > 2.0f) { wait = 3; return shut; }
    if (wait > 0) { wait--; return hold; }
    return fast;
}"""


def test_proofs_and_memory_know_such_cases(tmp_path):
    profile = profile_of(from_c(CONTROLLER.encode(), "a.c", Said(run=False)), Names())
    (tmp_path / "valve.toml").write_text(WORLD)
    (result,) = maviper.verify_system(profile, tmp_path / "valve.toml").results
    statement, played = as_played(statement_of(WORLD, "valve.toml"), profile)
    assert str(result.verdict) == "PROVED" and accept(result.evidence.certificate, played, statement.system) > 0
    for piece in statement.system.pieces:
        taken = {name for _, name in piece.effect}
        assert taken <= {*statement.agents[0].actions}


REFUSED = {
    "a case that no action takes": (('"open + a.turn > 0.75 and', '"open + a.turn > 2 and'), "case 1 holds no state"),
    "overlap": (('"otherwise"', '"open + a.turn <= 0.8 or level >= 3"'), "cases 1 and 2 overlap"),
    "gap": (('"otherwise"', '"open + a.turn <= 0.5 or level >= 3"'), "leave a gap"),
    "errors": (('"otherwise"', '"otherwise"\nerror = { level = 0.1 }'), "other errors"),
    "choices": (('"0.75*level + 0.25"', '"0.75*level + choice(0, 0.25)"'), "choices"),
    "no mode": (('pump = "slow"', 'pump = "quick"'), "quick"),
    "unsaid": (('hold = { pump = "slow" }', "hold = { turn = 0 }"), "the action hold, which is no mode of pump"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_an_action_cannot_choose_is_refused(name):
    change, said = REFUSED[name]
    assert WORLD.count(change[0]) >= 1
    with pytest.raises(InputError, match=said):
        statement_of(WORLD.replace(*change, 1), "valve.toml")
