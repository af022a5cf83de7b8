"""World files in continuous time, and small trees for them."""

PENDULUM = """
name = "pendulum"
steps = 20
[variables]
angle = { unit = "rad", range = [-4, 4] }
spin = { unit = "rad/s", range = [-8, 8] }
[agents.motor.features]
angle = "angle"
spin = "spin"
[agents.motor.actions]
left = { torque = "-8 1/s^2" }
off = {}
right = { torque = "8 1/s^2" }
[start]
box = { angle = [1, 1.175], spin = [0, 0.2] }
[dynamics]
period = "0.05 s"
[dynamics.flow]
angle = "spin"
spin = "2[1/s^2]*sin(angle) + motor.torque"
"""
