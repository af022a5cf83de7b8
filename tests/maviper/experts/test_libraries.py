"""The manual's lines for policies of other libraries: each trains for real, little, and a team acts in its place.

Each runs in the interpreter of these tests, where its library is installed; developing.md says how to give each library
an environment of its own.
"""

import re
import subprocess
import sys
from importlib.util import find_spec

import pytest

from maviper import manual

SECTION = "## Policies of other libraries"
CARTPOLE = """
import gymnasium
env, world = gymnasium.make("CartPole-v1"), "gymnasium:CartPole-v1"
"""
SPREAD = """
from mpe2 import simple_spread_v3
env, world = simple_spread_v3.parallel_env(), simple_spread_v3.parallel_env
"""
CLONE = """
import torch

def clone(module, draw, rule, forward=None):
    torch.manual_seed(0)
    fit, loss = torch.optim.Adam(module.parameters(), 0.01), torch.nn.CrossEntropyLoss()
    for _ in range(200):
        seen = draw(256)
        fit.zero_grad()
        loss((forward or module)(seen), rule(seen)).backward()
        fit.step()
    return module
"""
TRAINING = {  # heading -> the packages it needs; a program that trains, writes what the lines read, names a world
    "Stable-Baselines3": (
        ("stable_baselines3",),
        CARTPOLE
        + """
from stable_baselines3 import PPO
learner = PPO("MlpPolicy", "CartPole-v1", n_steps=256, batch_size=256, seed=0, device="cpu")
learner.learn(4_096).save("cartpole.zip")
""",
    ),
    "RLlib": (
        ("ray", "torch"),
        SPREAD
        + """
import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env
register_env("spread", lambda _: ParallelPettingZooEnv(simple_spread_v3.parallel_env()))
config = PPOConfig().environment("spread").env_runners(num_env_runners=0)
config = config.multi_agent(policies={"shared"}, policy_mapping_fn=lambda *_, **__: "shared")
algorithm = config.training(train_batch_size_per_learner=500, minibatch_size=250, num_epochs=2).build_algo()
algorithm.train()
algorithm.save_to_path(str(Path("checkpoint").absolute()))
algorithm.stop()
ray.shutdown()
""",
    ),
    "BenchMARL and TorchRL": (
        ("benchmarl", "torchrl"),
        """
from pettingzoo.mpe import simple_spread_v3
from benchmarl.algorithms import IppoConfig
from benchmarl.environments import PettingZooTask
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
config = ExperimentConfig.get_from_yaml()
config.loggers, config.evaluation, config.render, config.create_json = [], False, False, False
config.max_n_iters, config.max_n_frames, config.on_policy_collected_frames_per_batch = 1, None, 300
config.on_policy_minibatch_size, config.on_policy_n_minibatch_iters = 100, 4
task, algorithm, model = (each.get_from_yaml() for each in (PettingZooTask.SIMPLE_SPREAD, IppoConfig, MlpConfig))
experiment = Experiment(
    task=task, algorithm_config=algorithm, model_config=model, critic_model_config=model, seed=0, config=config
)
experiment.run()
world = lambda: simple_spread_v3.parallel_env(continuous_actions=True)
env = world()
""",
    ),
    "JaxMARL and Flax": (
        ("jaxmarl", "flax"),
        """
Path("training.py").write_text('''
import flax.linen as nn

network = nn.Sequential([nn.Dense(32), nn.tanh, nn.Dense(5)])
''')
import jax, jaxmarl, optax
from jax import numpy as jnp
from jaxmarl.wrappers.baselines import save_params
from training import network

class Stepped:
    # JaxMARL's environment as a loop of PettingZoo's asks for it
    def __init__(self):
        self.env, self.key = jaxmarl.make("MPE_simple_spread_v3"), jax.random.PRNGKey(7)

    def action_space(self, agent):
        return self.env.action_space(agent)

    def reset(self, seed):
        seen, self.state = self.env.reset(jax.random.PRNGKey(seed))
        self.agents = list(self.env.agents)
        return seen, {}

    def step(self, actions):
        seen, self.state, paid, over, _ = self.env.step_env(self.key, self.state, actions)
        self.agents = [] if over["__all__"] else self.agents
        return seen, paid, over, over, {}

env, world = Stepped(), "mpe2.simple_spread_v3:parallel_env"

def returns(parameters, key):
    # REINFORCE: log-probabilities of drawn actions, by the returns that follow
    seen, state = env.env.reset(key)

    def step(now, key):
        seen, state = now
        rows = jnp.stack(list(seen.values()))
        logits = network.apply(parameters, rows)
        acted = jax.random.categorical(key, logits)
        chosen = jax.nn.log_softmax(logits)[jnp.arange(len(rows)), acted].sum()
        seen, state, paid, *_ = env.env.step_env(key, state, dict(zip(seen, acted)))
        return (seen, state), (chosen, paid["agent_0"])

    _, (chosen, paid) = jax.lax.scan(step, (seen, state), jax.random.split(key, 25))
    return chosen, paid[::-1].cumsum()[::-1]

def loss(parameters, keys):
    chosen, gained = jax.vmap(lambda key: returns(parameters, key))(keys)
    return -(chosen * jax.lax.stop_gradient(gained - gained.mean(axis=0))).mean()

parameters = network.init(jax.random.PRNGKey(0), jnp.zeros((1, 18)))
fit = optax.adam(0.01)
held, learn = fit.init(parameters), jax.jit(jax.grad(loss))
for turn in range(20):
    changes, held = fit.update(learn(parameters, jax.random.split(jax.random.PRNGKey(turn), 64)), held)
    parameters = optax.apply_updates(parameters, changes)
save_params(parameters, "actor.safetensors")
""",
    ),
    "EPyMARL": (
        ("torch",),
        SPREAD
        + CLONE
        + """
from torch.nn import Linear

class RNNAgent(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.fc1, self.rnn, self.fc2 = Linear(18 + 3, 64), Linear(64, 64), Linear(64, 5)

    def forward(self, seen):
        return self.fc2(torch.relu(self.rnn(torch.relu(self.fc1(seen)))))

def rule(seen):
    # each agent goes to its own landmark, along the axis on which it is farther
    place = seen[:, 18:].argmax(dim=1)
    dx, dy = (seen.gather(1, (4 + 2 * place + axis)[:, None])[:, 0] for axis in (0, 1))
    return torch.where(dx.abs() > dy.abs(), torch.where(dx > 0, 2, 1), torch.where(dy > 0, 4, 3))

def draw(n):
    return torch.hstack([torch.randn(n, 18), torch.eye(3)[torch.randint(3, (n,))]])

torch.save(clone(RNNAgent(), draw, rule).state_dict(), "agent.th")
""",
    ),
}
ACTING = """
import gymnasium
import maviper
import numpy as np

few = {"iterations": 2, "rollouts": 8, "selection_episodes": 4, "held_out": 4, "refinement_episodes": 0}
team = maviper.extract(act, world=world, max_depth=4, **few)
seen, _ = env.reset(seed=1)
steps, same = 0, []
if isinstance(env, gymnasium.Env):
    over = False
    while not over:
        action = team.act(seen)
        assert env.action_space.contains(action), action
        same.append(action == act("agent", seen[None])[0])
        seen, _, ended, cut, _ = env.step(action)
        over = ended or cut
while getattr(env, "agents", ()):
    actions = team.act(seen, agents=env.agents)
    assert list(actions) == list(env.agents)
    for agent, action in actions.items():
        assert env.action_space(agent).contains(action), (agent, action)
        meant = act(agent, np.asarray(seen[agent])[None])[0]
        same.append(np.abs(meant - action).mean() < 0.2 if np.ndim(action) else meant == action)
    seen, *_ = env.step(actions)
# small trees of few episodes: more often as the expert than by chance
chance = 0.35 if team.agents[0].outputs else 1 / len(team.agents[0].actions)
assert len(same) > 8 and np.mean(same) > 1.4 * chance, (np.mean(same), chance)
print(team, np.mean(same))
"""


def lines_of(heading):
    """The code under a heading of the section."""
    section = manual.page("experts").partition(f"\n{SECTION}\n")[2]
    return re.search(rf"\n### {heading}\n.*?```python\n(.*?)```", section, flags=re.S)[1]


def test_every_library_of_the_section_is_tried():
    section = manual.page("experts").partition(f"\n{SECTION}\n")[2]
    assert re.findall(r"^### (.*)", section, flags=re.M) == list(TRAINING)
    for heading in TRAINING:
        statements = [line for line in lines_of(heading).splitlines() if line and "import " not in line]
        assert len(statements) <= 7, heading


@pytest.mark.nightly
@pytest.mark.train
@pytest.mark.parametrize("heading", TRAINING)
def test_a_team_is_extracted_by_the_lines_of_the_page(heading, tmp_path):
    packages, training = TRAINING[heading]
    for package in packages:
        if find_spec(package) is None:
            pytest.skip(f"{package} is not installed")
    if SPREAD in training:  # which the PettingZoo that TorchRL takes is too old for
        pytest.importorskip("mpe2.simple_spread_v3", exc_type=ImportError)
    program = f"from pathlib import Path\n{training}\n{lines_of(heading)}\n{ACTING}"
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0 and ran.stdout.splitlines()[-1].startswith("Team("), ran.stderr[-3_000:]
