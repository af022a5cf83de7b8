"""World's files for tests."""

from dataclasses import replace
from pathlib import Path

from verify.systems.files import statement_of


def with_piece(statement, number, **changes):
    """A statement in which one piece says something else."""
    pieces = list(statement.system.pieces)
    pieces[number] = replace(pieces[number], **changes)
    return replace(statement, system=replace(statement.system, pieces=tuple(pieces)))


def read(text, name="world.toml"):
    return statement_of(text, name)


def world(name):
    """A world file of tests/worlds, from its second line on."""
    return "\n" + (Path(__file__).parent.parent / "worlds" / f"{name}.toml").read_text()


CART, MOUNTAIN, CURVED, HEATER, TANK = map(world, ("cart", "mountain_car", "curved", "heater", "tank"))
CASES = """
[dynamics.let]
noise = "choice(-1[K], 1[K])"
[[dynamics.piece]]
when = "heat == high and x >= 1[K]"
next = { x = "x + a.power", heat = "low" }
[[dynamics.piece]]
when = "otherwise"
next = { x = "x + a.power + noise", heat = "acts(a)" }
"""
