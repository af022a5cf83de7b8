import gymnasium as gym

NOTHING, LEFT_ENGINE, MAIN_ENGINE, RIGHT_ENGINE = 0, 1, 2, 3


def lander_policy(obs):
    x, y, vx, vy, angle, ang_vel, left_leg, right_leg = obs

    # on the ground: engines off
    if left_leg and right_leg:
        return NOTHING

    # falling too fast
    if vy < -0.3 and y < 0.8 or vy < -0.6:
        return MAIN_ENGINE

    # keep it upright
    if angle > 0.1:
        return RIGHT_ENGINE
    elif angle < -0.1:
        return LEFT_ENGINE

    if ang_vel > 0.25:
        return RIGHT_ENGINE
    if ang_vel < -0.25:
        return LEFT_ENGINE

    return NOTHING


if __name__ == '__main__':
    env = gym.make("LunarLander-v3")
    for episode in range(5):
        obs, _ = env.reset()
        done, ret = False, 0
        while not done:
            obs, r, term, trunc, _ = env.step(lander_policy(obs))
            ret += r
            done = term or trunc
        print(f'Episode {episode}: {ret:.1f}')
