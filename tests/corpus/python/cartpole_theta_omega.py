"""Classic two-regime CartPole heuristic (angle when far, angular velocity when close)."""
import gymnasium as gym
import numpy as np

LEFT, RIGHT = 0, 1


def theta_omega_policy(obs):
    theta, w = obs[2:4]
    if abs(theta) < 0.03:
        return LEFT if w < 0 else RIGHT
    else:
        return LEFT if theta < 0 else RIGHT


def rollout(env, policy, seed):
    obs, _ = env.reset(seed=seed)
    score = 0.0
    done = False
    while not done:
        obs, r, term, trunc, _ = env.step(policy(obs))
        score += r
        done = term or trunc
    return score


if __name__ == "__main__":
    env = gym.make("CartPole-v1")
    scores = [rollout(env, theta_omega_policy, s) for s in range(100)]
    print(np.mean(scores), "+/-", np.std(scores))
