def damper(x):
    position, speed = x
    if position ** 3 > 0.2 and speed ** 4 < 7.5:
        return "brake"
    if speed // 0.5 == -3:
        return "release"
    return "hold"
