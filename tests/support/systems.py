"""World's files for tests."""

from dataclasses import replace


def with_piece(statement, number, **changes):
    """A statement in which one piece says something else."""
    pieces = list(statement.system.pieces)
    pieces[number] = replace(pieces[number], **changes)
    return replace(statement, system=replace(statement.system, pieces=tuple(pieces)))


CART = """
name = "cart"
steps = 10
dt = "0.2 s"

[constants]
push = "1/2 m/s^2"

[variables]
x = { unit = "m", range = [-10, 10] }
v = { unit = "m/s", range = [-5, 5] }

[agents.cart.features]
place = "x"
ahead = "x + 1[s]*v"
side = "sign(x - 0.1)"
moving = "positive(v)"
near = "clip(x, -1, 1)"

[agents.cart.actions]
stay = {}
left = { a = "-0.5 m/s^2" }
right = { a = "push" }

[start]
box = { x = [-1, 1], v = [0, 0] }

[dynamics.next]
x = "x + dt*v"
v = "v + dt*cart.a"
"""

MOUNTAIN = """
name = "MountainCar"
steps = 30
reference = "gymnasium:MountainCar-v0"
state = "state"

[variables]
position = { range = [-1.1, 0.53] }
velocity = { range = [-0.065, 0.065] }

[agents.agent.features]
position = "position"
velocity = "velocity"

[agents.agent.actions]
accelerate_left = { push = -1 }
coast = {}
accelerate_right = { push = 1 }

[start]
box = { position = [-0.55, -0.45], velocity = 0 }

[dynamics.let]
after = "velocity + 0.001*agent.push - 0.0025*cos(3*position)"

[dynamics.next]
position = "position + after"
velocity = "after"

[dynamics.error]
position = 1e-12
velocity = 1e-12

[dynamics.cuts]
position = 10
"""

CURVED = """
name = "curved"
steps = 5

[variables]
x = { range = [-1, 2] }
y = { range = [0.5, 1.5] }

[agents.one.features]
x = "x"

[agents.one.actions]
less = { u = "-0.1" }
more = { u = "y*x" }

[agents.two.features]
y = "y"

[agents.two.actions]
stay = {}
turn = { w = "1/5" }

[start]
box = { x = [0, 1], y = 1 }

[dynamics.next]
x = "x*y + one.u*sin(x)/(2 + y**2) + two.w"
y = "clip(y + 0.1*x**3, 0.6, 1.4) + 0.5*two.w"

[dynamics.cuts]
x = 3
y = 2
"""
