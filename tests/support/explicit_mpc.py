"""A double integrator's explicit model predictive controller, as if/else Python, and the program that it solves.

Source: Bemporad, Morari, Dua, Pistikopoulos, The explicit linear quadratic regulator for constrained systems (2002).
Each control is free or at one of its bounds. Each choice that is optimal somewhere is so in a polygon of states, where
the first control is affine in the state. The numbers below are the nearest doubles of that.
"""

import numpy as np
from scipy.optimize import lsq_linear

from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from codegen.policy_json import dumps
from maviper.cli import main

CONTROLLER = """\
def cart(x, v):
    if -0.8695652173913043 * x + -1.5217391304347827 * v <= 0.6413043478260869:
        if 0.09956211108550357 * x + -0.4618575708688638 * v <= 1.0:
            if 0.9052777137589306 * x + 1.3560728278405163 * v <= 1.0:
                if -0.09956211108550357 * x + 0.4618575708688638 * v <= 1.0:
                    return -0.9052777137589306 * x + -1.3560728278405163 * v
                if 0.8695652173913043 * x + 1.5217391304347827 * v <= 1.358695652173913:
                    return -0.8695652173913043 * x + -1.5217391304347827 * v + 0.358695652173913
                return -1.0
            return -1.0
        if 0.8695652173913043 * x + 1.5217391304347827 * v <= 0.6413043478260869:
            return -0.8695652173913043 * x + -1.5217391304347827 * v + -0.358695652173913
        return -1.0
    if -0.9052777137589306 * x + -1.3560728278405163 * v <= 1.0:
        if 0.09956211108550357 * x + -0.4618575708688638 * v <= 1.0:
            return -0.9052777137589306 * x + -1.3560728278405163 * v
        if -0.8695652173913043 * x + -1.5217391304347827 * v <= 1.358695652173913:
            return -0.8695652173913043 * x + -1.5217391304347827 * v + -0.358695652173913
        return 1.0
    return 1.0
"""
MOVED, PUSHED = np.array([[1, 0.5], [0, 1]]), np.array([0.125, 0.5])  # x and v a step of half a second on


def solved(state):
    """The first of two controls within [-1, 1] that make the sum over both steps of x^2 + v^2/2 + u^2/2 least; the
    state after the last weighs three times as much.
    """
    one, two = np.array([PUSHED, np.zeros(2)]).T, np.array([MOVED @ PUSHED, PUSHED]).T  # states by the controls
    weights = np.sqrt([1, 0.5, 3, 1.5, 0.5, 0.5])[:, None]
    by_controls = weights * np.vstack([one, two, np.eye(2)])
    left = weights[:, 0] * np.concatenate([MOVED @ state, MOVED @ MOVED @ state, np.zeros(2)])
    return lsq_linear(by_controls, -left, (-1, 1), method="bvls", tol=1e-14).x[0]


WORLD = """
name = "double integrator"
steps = 12
dt = "0.5 s"
[variables]
x = { unit = "m", range = [-4, 4] }
v = { unit = "m/s", range = [-3, 3] }
[agents.cart.features]
x = "x"
v = "v"
[agents.cart.outputs]
push = "m/s^2"
[start]
box = { x = [-1, 1], v = [-0.5, 0.5] }
[dynamics.next]
x = "x + dt*v + 0.5*dt**2*cart.push"
v = "v + dt*cart.push"
"""
# within it no control is at a bound, and the linear law of the controller leads back into it
LASTING = """
[[property]]
label = "stays for ever"
name = "always"
region = { box = { x = [-1, 1], v = [-1, 1] } }
invariant = { box = { x = [-1, 1], v = [-1, 1] }, where = [
  "0.9053*x + 1.3561[s]*v <= 1[m]", "-0.9053*x - 1.3561[s]*v <= 1[m]",
] }
"""


def controller():
    said = Said(arrays="float64", outputs=("push",))
    return profile_of(from_python(CONTROLLER.encode(), "cart.py", said), Names(outputs=("push",)))


def prove_lasting(folder):
    """The certificate that the controller stays in a region for ever, with profile and world file beside it."""
    start, inside = "x = [-1, 1], v = [-0.5, 0.5]", "x = [-0.5, 0.5], v = [-0.2, 0.2]"
    (folder / "cart.json").write_text(dumps(controller()))
    (folder / "world.toml").write_text(WORLD.replace(start, inside) + LASTING)
    asked = ["verify", str(folder / "cart.json"), "--system", str(folder / "world.toml"), "--set", "max_boxes=300000"]
    assert main.run([*asked, "-o", str(folder / "out")]) == 0
    (path,) = (folder / "out").glob("certificate-*.json")
    return path
