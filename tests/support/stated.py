"""What several tests use of `maviper.verification.test_stated`."""

from dataclasses import replace

from codegen.dynamics import motionless
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from tests.support.system_cases import policy, team

PROPERTIES = """
[[property]]
label = "it stays near"
name = "stays_in"
region = { box = { x = [-2, 2] } }

[[property]]
label = "it stays slow"
name = "stays_in"
region = { box = { v = [-0.15, 0.15] } }

[[property]]
region = { where = ["v <= 0"] }
formula = "x <= -1/2 implies not acts(cart) == left"
"""
CAR = """
[[property]]
label = "it stays in the valley"
name = "stays_in"
steps = 4
region = { box = { position = [-0.9, 0.1] } }

[[property]]
label = "it stays left"
name = "stays_in"
steps = 8
region = { box = { position = [-0.9, -0.46] } }
"""
BRAKES = policy("cart", ["ahead"], ["stay", "left", "right"], ((0, 0.0), 2, 1))
DRIVES = policy("agent", ["velocity"], ["accelerate_left", "coast", "accelerate_right"], ((0, -0.001), 0, 2))


def profile(own):
    """The text of a profile with one agent."""
    return dumps(replace(team(own), world=motionless("stated", "", (own.agent,), 10, {})))


def verify(folder, *more, world="cart.toml"):
    return command(["verify", str(folder / "profile.json"), "--system", str(folder / world), *more])
