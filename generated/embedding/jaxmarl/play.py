"""The generated policies in JaxMARL's simple_adversary: every step of every episode in one compiled scan.

Does: lets `physical_deception_jax.py` decide for all agents, counts successes.
Assumes: jaxmarl is installed (`pip install jaxmarl`); nothing of maviper is.
Does not: learn; draw.
"""

import argparse
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import jaxmarl
import physical_deception_jax as policies

STEPS = 25
SQUARED_RADIUS = 0.1  # of success: the radius is its root, 0.316


class Played(NamedTuple):
    """Episodes: successes [episodes], actions [episodes, steps, agents], positions before each step [.., entities, 2],
    the goal's number [episodes].
    """

    adversary: Any
    defenders: Any
    actions: Any
    positions: Any
    goal: Any


def episode(env: Any, key: Any) -> Played:
    """One episode; JaxMARL's own observations, order of agents and numbers of actions are those of the policies."""

    def step(now: Any, _: None) -> Any:
        seen, state = now
        actions = policies.act_all(seen)
        seen, after, *_ = env.step_env(key, state, actions)
        return (seen, after), (jnp.stack(list(actions.values())), state.p_pos, near(after.p_pos))

    seen, state = env.reset(key)
    _, (actions, positions, close) = jax.lax.scan(step, (seen, state), None, length=STEPS)
    covered = (close[:, 1, 0] & close[:, 2, 1]) | (close[:, 1, 1] & close[:, 2, 0])
    return Played(close[:, 0, state.goal].any(), covered.any(), actions, positions, state.goal)


def near(position: Any) -> Any:
    """Whether each agent is within the radius of each landmark, [agents, landmarks]."""
    gaps = position[:3, None] - position[None, 3:]
    return (gaps**2).sum(axis=-1) < SQUARED_RADIUS


def play(episodes: int, seed: int) -> Played:
    """So many episodes, side by side."""
    env = jaxmarl.make("MPE_simple_adversary_v3")
    keys = jax.random.split(jax.random.PRNGKey(seed), episodes)
    return jax.jit(jax.vmap(lambda key: episode(env, key)))(keys)


def main() -> None:
    """Reads the options, plays, prints."""
    parser = argparse.ArgumentParser(description="Plays JaxMARL's simple_adversary with the generated policies.")
    parser.add_argument("--episodes", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    if options.episodes < 1 or options.seed < 0:
        parser.error("--episodes starts at 1, --seed at 0")
    played, n = play(options.episodes, options.seed), options.episodes
    for team, wins in (("adversaries", played.adversary), ("defenders", played.defenders)):
        print(f"{team} success r=0.316: {int(wins.sum())} of {n} episodes, {int(wins.sum()) / n:.3f}")


if __name__ == "__main__":
    main()
