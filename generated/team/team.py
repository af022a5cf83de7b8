# # Your own team in ten minutes
#
# From an empty folder: an environment, an expert, trees, a table, a claim, a counterexample, a proof
# and a header. No training is needed.
#
# All Python on this page is one program: type it into a notebook, or into one script. What it prints
# stands below it. A clone has both, made from this page: `generated/team/team.ipynb` and
# `generated/team/team.py`.
#
# ## Environment and expert
#
# Two robots on a line are to meet. The environment is any parallel one of PettingZoo; `teams`,
# `features` and `action_names` are optional. The expert is any function from an agent and its
# observations `[n, n_features]` to actions `[n]`. This one is written by hand, and [policies of other
# libraries](../../maviper/manual/experts.md#policies-of-other-libraries) become one in five lines. Copies of the
# environment may play in processes, which import a script of yours again: put its calls under `if
# __name__ == "__main__":`. For the command line save this block as `mygame.py`:

import numpy as np
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from maviper.profiles import FeatureSpec


class Meet(ParallelEnv):
    """Two robots on a line. Both pay for the distance between them."""

    metadata = {"name": "meet"}

    def __init__(self, max_cycles=20):
        self.possible_agents = ["front", "rear"]
        self.max_cycles = max_cycles
        self.teams = {"robots": self.possible_agents}
        seen = [FeatureSpec("x", "m", -10.0, 10.0, None), FeatureSpec("gap", "m", -20.0, 20.0, None)]
        self.features = {agent: seen for agent in self.possible_agents}
        self.action_names = {agent: ["left", "stay", "right"] for agent in self.possible_agents}

    def observation_space(self, agent):
        return Box(-20, 20, (2,), np.float32)

    def action_space(self, agent):
        return Discrete(3)

    def observe(self, agent):
        other = "rear" if agent == "front" else "front"
        return np.array([self.x[agent], self.x[other] - self.x[agent]], np.float32)

    def reset(self, seed=None, options=None):
        self.agents, self.time = list(self.possible_agents), 0
        self.x = dict(zip(self.agents, np.random.default_rng(seed).uniform(-1, 1, 2)))
        return {agent: self.observe(agent) for agent in self.agents}, {agent: {} for agent in self.agents}

    def step(self, actions):
        for agent, action in actions.items():
            self.x[agent] += 0.1 * (action - 1)
        self.time += 1
        seen = {agent: self.observe(agent) for agent in actions}
        rewards = dict.fromkeys(actions, -abs(self.x["front"] - self.x["rear"]))
        over = dict.fromkeys(actions, self.time >= self.max_cycles)
        self.agents = [agent for agent in self.agents if not over[agent]]
        return seen, rewards, dict.fromkeys(actions, False), over, {agent: {} for agent in actions}


def make(max_cycles=20):
    return Meet(max_cycles)


def act(agent, observations):
    """The expert: each robot goes towards the other, and stays when it is near."""
    gaps = observations[:, 1]
    return np.where(gaps > 0.1, 2, np.where(gaps < -0.1, 0, 1))

# ## Trees

import maviper

team = maviper.extract(act, world=make, max_depth=2, max_episodes=300)
print(team)
print(team.to_text())

# ```
# Team('make': front 3 leaves, rear 3 leaves, depth 2)
# front, team robots
#   if gap <= -0.10095857 -> left  (leaf 1, 9.32 % of 740 decisions)
#   if -0.10095857 < gap <= 0.09458538 -> stay  (leaf 3, 82.4 % of 740 decisions)
#   if gap > 0.09458538 -> right  (leaf 4, 8.24 % of 740 decisions)
# rear, team robots
#   if gap <= -0.1010484 -> left  (leaf 2, 7.97 % of 740 decisions)
#   if -0.1010484 < gap <= 0.10095857 -> stay  (leaf 3, 82.7 % of 740 decisions)
#   if gap > 0.10095857 -> right  (leaf 4, 9.32 % of 740 decisions)
# ```
#
# The team acts as the environment takes it:

env = make()
seen, _ = env.reset(seed=1)
while env.agents:
    seen, rewards, *_ = env.step(team.act(seen, agents=env.agents))
print(f"a gap of {abs(seen['front'][1]):.2f} m is left")

# ```
# a gap of 0.08 m is left
# ```
#
# Measure it beside its expert, in fresh episodes. Returns are costs here; a ratio above 1 is better
# than the expert.

measured = maviper.evaluate(team, episodes=200, expert=act)
print(measured)

# ```
# Evaluation of __main__:make, 200 episodes
# robots return: -2.277 [-2.540, -2.014], ratio 1.026 [1.010, 1.047]
# ```
#
# ## A table
#
# Which algorithm, and how deep? All algorithms get the same number of episodes; intervals are over
# seeds.

table = maviper.compare(act, world=make, depths=[1, 2], seeds=5, max_episodes=150)
for row in table.rows:
    reached = f"{row['value']:.2f} [{row['low']:.2f}, {row['high']:.2f}]"
    print(f"{row['algorithm']:<9} depth {row['depth']}: {reached}, {row['leaves']:.0f} leaves")

# ```
# maviper   depth 1: -6.07 [-9.42, -2.72], 4 leaves
# maviper   depth 2: -2.16 [-2.68, -1.65], 6 leaves
# iviper    depth 1: -7.94 [-10.20, -5.68], 4 leaves
# iviper    depth 2: -2.30 [-2.58, -2.02], 6 leaves
# imitation depth 1: -8.00 [-10.22, -5.78], 4 leaves
# imitation depth 2: -2.28 [-2.66, -1.89], 6 leaves
# ```
#
# `print(table)` has words for differences, `table.to_csv()` and `table.to_latex()` are for papers,
# and `table.best` is a team ([comparing](../../maviper/manual/compare.md)).
#
# ## A claim and its counterexample
#
# Write down what the trees must do:

from pathlib import Path

Path("claims.toml").write_text("""
[[claim]]
label = "who is behind catches up"
formula = "rear.gap > 0.05 implies acts(rear) == right"

[[claim]]
name = "ignores"
agent = "rear"
feature = "x"
""")
behind, ignores = maviper.verify_file(team, "claims.toml")
print("who is behind catches up:", behind.verdict)
print("rear ignores its own place:", ignores.verdict)

# ```
# who is behind catches up: VIOLATED
# rear ignores its own place: PROVED
# ```
#
# The first one fails, since the expert stays where the gap is up to 0.1 m. The counterexample says
# where, and which tests lead there:

rear = behind.counterexample.agents[1]
print(rear.agent, "chooses", rear.action)
for step in rear.path:
    print(f"node {step.node}: {step.feature} is {step.value:.3f}, and the threshold {step.threshold:.3f}")

# ```
# rear chooses stay
# node 0: gap is 0.100, and the threshold 0.101
# node 1: gap is 0.100, and the threshold -0.101
# ```
#
# ## A change by hand, and a proof
#
# Node 0 has to test for 0.05. The file says that this was by hand. A proof is about every state, not
# those of some episodes.

mended = team.with_threshold("rear", node=0, value=0.05)
mended.save("robots.json")
print(*(found.verdict for found in maviper.verify_file(mended, "claims.toml")))

# ```
# PROVED PROVED
# ```
#
# ## The header

code = maviper.compile(mended, "c")
print(code)
print(*sorted(path.name for path in code.write("firmware").iterdir()))

# ```
# Compiled: file make.h, bytes 10672
# file make.agreement.json, bytes 1544
# make.agreement.json make.h
# ```
#
# The header is C99 without heap or libc. It was not replayed in episodes, since only built-in games
# are.
#
# ## On the command line
#
# Each function is a command. With `mygame.py` and `claims.toml` in the current folder:
#
#     maviper worlds check mygame:make
#     maviper extract mygame:act --world mygame:make --max-depth 2 --max-episodes 300 -o extracted.json
#     maviper show extracted.json
#     maviper evaluate extracted.json --world mygame:make --expert mygame:act --episodes 200
#     maviper compare mygame:act --world mygame:make --depths 1,2 --seeds 5 --max-episodes 150 -o compared
#     maviper edit extracted.json rear/0=0.05
#     maviper verify extracted.json --claims claims.toml -o answers
#     maviper check answers/certificate-1-formula.json --profile extracted.json
#     maviper compile extracted.json --target c -o code
#
# Where to go on: [experts](../../maviper/manual/experts.md) for networks, [environments](../../maviper/manual/environments.md) for turns, masks
# and dictionaries, [claims](../../maviper/manual/claims.md) for all that can be asked, [embedding](../../maviper/manual/embedding.md) for how
# to call the header. Claims about where the robots are need a [world file](../../maviper/manual/systems.md), which states
# how they move.
