from math import fabs, inf


def gaze(yaw: float, pitch: float = 0.0) -> str:
    best, answer = inf, "front"
    for name, direction in (("front", 0.0), ("left", 90.0), ("right", -90.0)):
        off = fabs(yaw - direction)
        if off <= 45.0 and off < best:
            answer = name
            best = 45.0
    if pitch > 60:
        return "up"
    return answer
