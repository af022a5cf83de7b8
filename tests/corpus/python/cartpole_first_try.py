import gymnasium as gym


def policy(obs):
    # obs = [cart position, cart velocity, pole angle, pole angular velocity]
    angle = obs[2]
    return 0 if angle < 0 else 1


if __name__ == "__main__":
    env = gym.make("CartPole-v1", render_mode="human")
    obs, info = env.reset()
    total = 0
    while True:
        obs, reward, terminated, truncated, info = env.step(policy(obs))
        total += reward
        if terminated or truncated:
            break
    print("return:", total)
    env.close()
