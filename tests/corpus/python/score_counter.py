def policy(observation):
    x, v, theta, omega = observation
    score = 0
    if theta > 0.02: score += 1
    if omega > 0.1: score += 1
    if x < -1: score -= 1
    if v > 2.0: score -= 1
    if score > 0:
        return 1
    elif score < 0:
        return 0
    else:
        return int(omega > 0)
