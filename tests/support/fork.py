"""A referee for the physics of the authors' fork: one game in plain Python, written from its description.

Does: one game at a time, in Gymnasium's steps: `reset(state)`, then `step(actions)`.
Assumes: the fork's order: an action's force, pushes of all pairs, then velocity, its limit, and the position.
Does not: share code with the simulator, so that each is a check of the other.
"""

import math

import numpy as np

MOVES = ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))
TIME_STEP, DAMPING, STIFFNESS, SOFTNESS = 0.1, 0.25, 100.0, 1e-3
SENSITIVITY = 5.0  # of an agent without an acceleration


class Body:
    """A disc. `accel`: None where a game states none."""

    def __init__(self, size, movable, collides, accel=None, limit=None):
        self.size, self.movable, self.collides, self.accel, self.limit = size, movable, collides, accel, limit
        self.x = self.y = self.vx = self.vy = 0.0


def tag(predators=2, prey=2, obstacles=2):
    """The bodies of predator-prey."""
    hunters = [Body(0.075, True, True, 3.0, 1.0) for _ in range(predators)]
    return [*hunters, *(Body(0.05, True, True, 4.0, 1.3) for _ in range(prey))] + [
        Body(0.2, False, True) for _ in range(obstacles)
    ]


def spread(agents=3):
    """The bodies of cooperative navigation."""
    return [Body(0.15, True, True) for _ in range(agents)] + [Body(0.05, False, False) for _ in range(agents)]


def adversary(defenders=2):
    """The bodies of physical deception."""
    return [Body(0.15, True, False) for _ in range(defenders + 1)] + [
        Body(0.08, False, False) for _ in range(defenders)
    ]


class ForkEnv:
    """A game of the fork. `velocity_first` and `twice` can be switched off, to see what each of them does."""

    def __init__(self, bodies, velocity_first=True, twice=True):
        self.bodies, self.velocity_first, self.twice = bodies, velocity_first, twice

    def reset(self, positions, velocities):
        """[n_bodies, 2] and [n_agents, 2]."""
        for body, (x, y) in zip(self.bodies, positions, strict=True):
            body.x, body.y = float(x), float(y)
        for body, (vx, vy) in zip(self.bodies, velocities, strict=False):
            body.vx, body.vy = float(vx), float(vy)
        return self.state()

    def state(self):
        """Positions of all bodies, velocities of those that move."""
        moving = [body for body in self.bodies if body.movable]
        return np.array([(each.x, each.y) for each in self.bodies]), np.array([(each.vx, each.vy) for each in moving])

    def step(self, actions):
        """One step; `actions`: the index of each agent's."""
        forces = [[0.0, 0.0] for _ in self.bodies]
        for force, body, action in zip(forces, self.bodies, actions, strict=False):
            often = 2 if self.twice else 1
            strength = SENSITIVITY if body.accel is None else body.accel**often
            force[0], force[1] = (part * strength for part in MOVES[int(action)])
        for one, first in enumerate(self.bodies):
            for other in range(one + 1, len(self.bodies)):
                self.push(forces, one, other, first, self.bodies[other])
        for force, body in zip(forces, self.bodies, strict=True):
            if body.movable:
                self.move(body, *force)
        return self.state()

    @staticmethod
    def push(forces, one, other, first, second):
        """Both are pushed apart, where both collide and one of them moves."""
        if not (first.collides and second.collides and (first.movable or second.movable)):
            return
        dx, dy = first.x - second.x, first.y - second.y
        apart = math.sqrt(dx * dx + dy * dy)
        depth = float(np.logaddexp(0, -(apart - (first.size + second.size)) / SOFTNESS)) * SOFTNESS
        for axis, gap in enumerate((dx, dy)):
            push = STIFFNESS * gap / apart * depth
            forces[one][axis] += push
            forces[other][axis] -= push

    def move(self, body, fx, fy):
        """Velocity, its limit, position."""
        old = body.vx, body.vy
        body.vx = body.vx * (1 - DAMPING) + fx * TIME_STEP
        body.vy = body.vy * (1 - DAMPING) + fy * TIME_STEP
        speed = math.sqrt(body.vx * body.vx + body.vy * body.vy)
        if body.limit is not None and speed > body.limit:
            body.vx, body.vy = body.vx / speed * body.limit, body.vy / speed * body.limit
        vx, vy = (body.vx, body.vy) if self.velocity_first else old
        body.x, body.y = body.x + vx * TIME_STEP, body.y + vy * TIME_STEP
