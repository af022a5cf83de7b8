"""A heater: a world file with a mode, cases and a choice."""

from verify.systems.files import statement_of

HEAD = """
name = "heater"
steps = 6
[variables]
x = { unit = "K", range = [-50, 50] }
heat = { modes = ["off", "low", "high"] }
[agents.a.features]
x = "x"
high = "heat == high"
number = "heat"
[agents.a.actions]
off = {}
high = { power = "2 K" }
[start]
box = { x = [-1, 1], heat = "off" }
"""
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


def read(text, name="world.toml"):
    return statement_of(text, name)
