import gymnasium as gym

ACCELERATE_LEFT = 0
COAST = 1
ACCELERATE_RIGHT = 2


def choose_action(state):
    """Push in the direction in which the car already moves."""
    position, velocity = state
    if velocity > 0:
        return ACCELERATE_RIGHT
    elif velocity < 0:
        return ACCELERATE_LEFT
    return COAST


def main():
    env = gym.make("MountainCar-v0")
    obs, _ = env.reset(seed=1)
    for t in range(200):
        obs, reward, terminated, truncated, _ = env.step(choose_action(obs))
        if terminated:
            print(f"solved in {t + 1} steps")
            break


if __name__ == "__main__":
    main()
