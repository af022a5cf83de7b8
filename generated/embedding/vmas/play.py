"""The generated policies in VMAS's simple_adversary: batches of torch tensors, successes counted.

Does: lets `physical_deception_torch.py` decide for all agents; maps actions, force and goals to those of the policies.
Assumes: vmas is installed (`pip install vmas`); nothing of maviper is.
Does not: learn; draw.
"""

import argparse
from typing import Any, NamedTuple

import physical_deception_torch as policies
import torch
from vmas import make_env
from vmas.scenarios.mpe.simple_adversary import Scenario

STEPS = 25
SQUARED_RADIUS = 0.1  # of success: the radius is its root, 0.316
FORCE = 5.0  # what an action adds to a velocity per unit of time in mpe2; 1 in VMAS
ACTIONS = torch.tensor([0, 3, 6, 1, 2])  # stay, left, right, down, up among VMAS's nine: 3 times x's choice plus y's


class Strong(Scenario):
    """The scenario with mpe2's force, or another."""

    def __init__(self, force: float) -> None:
        super().__init__()
        self.force = force

    def process_action(self, agent: Any) -> None:
        """What VMAS lets a scenario do to an action before it moves the agent."""
        agent.action.u = agent.action.u * self.force


class Played(NamedTuple):
    """Episodes: successes [episodes], actions [episodes, steps, agents], positions before each step [.., entities, 2],
    the goal's number [episodes].
    """

    adversary: torch.Tensor
    defenders: torch.Tensor
    actions: torch.Tensor
    positions: torch.Tensor
    goal: torch.Tensor


def seen_with(goal: torch.Tensor, observations: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """Observations with a goal of each episode's own: VMAS has one for a whole batch. A defender observes the goal's
    offset, then those of both landmarks; the goal is one of them.
    """
    found = dict(observations)
    for agent in ("agent_0", "agent_1"):
        seen = found[agent]
        found[agent] = torch.cat([torch.where(goal[:, None] == 0, seen[:, 2:4], seen[:, 4:6]), seen[:, 2:]], dim=1)
    return found


def near(world: Any) -> torch.Tensor:
    """Whether each agent is within the radius of each landmark, [episodes, agents, landmarks]."""
    agents, landmarks = (torch.stack([each.state.pos for each in some], 1) for some in (world.agents, world.landmarks))
    return ((agents[:, :, None] - landmarks[:, None]) ** 2).sum(dim=-1) < SQUARED_RADIUS


def play(episodes: int, seed: int, force: float = FORCE) -> Played:
    """So many episodes, side by side."""
    env = make_env(
        Strong(force), num_envs=episodes, device="cpu", continuous_actions=False, seed=seed, dict_spaces=True
    )
    goal = torch.randint(2, (episodes,), generator=torch.Generator().manual_seed(seed))
    seen, rows, actions, positions = env.reset(seed=seed), torch.arange(episodes), [], []
    adversary = defenders = torch.zeros(episodes, dtype=torch.bool)
    for _ in range(STEPS):
        positions.append(torch.stack([each.state.pos for each in (*env.world.agents, *env.world.landmarks)], dim=1))
        chosen = policies.act_all(seen_with(goal, seen))
        actions.append(torch.stack(list(chosen.values()), dim=1))
        seen, *_ = env.step({agent: ACTIONS[action][:, None] for agent, action in chosen.items()})
        close = near(env.world)
        adversary = adversary | close[rows, 0, goal]
        defenders = defenders | (close[:, 1, 0] & close[:, 2, 1]) | (close[:, 1, 1] & close[:, 2, 0])
    return Played(adversary, defenders, torch.stack(actions, dim=1), torch.stack(positions, dim=1), goal)


def main() -> None:
    """Reads the options, plays, prints."""
    parser = argparse.ArgumentParser(description="Plays VMAS's simple_adversary with the generated policies.")
    parser.add_argument("--episodes", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--force", type=float, default=FORCE, help="of an action; VMAS itself has 1")
    options = parser.parse_args()
    if options.episodes < 1 or options.seed < 0:
        parser.error("--episodes starts at 1, --seed at 0")
    played, n = play(options.episodes, options.seed, options.force), options.episodes
    for team, wins in (("adversaries", played.adversary), ("defenders", played.defenders)):
        print(f"{team} success r=0.316: {int(wins.sum())} of {n} episodes, {int(wins.sum()) / n:.3f}")


if __name__ == "__main__":
    main()
