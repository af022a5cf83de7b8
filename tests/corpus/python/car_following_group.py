# Expert rules of the group project, obs order: gap, own speed, lead speed
import math as m

g = 9.81
MU = .7
V_MAX = m.sqrt(2 * MU * g * 25.0)      # stopping within 25 m


def follow(obs):
    gap, own, lead = obs[0], obs[1], obs[2]
    too_fast = own > V_MAX
    close, very_close = gap < 15.0, gap < 6.0
    if very_close:
        return 'BRAKE_HARD'
    if close and not lead > 1.0 or too_fast:
        return 'BRAKE'
    if not close and own < 0.9 * V_MAX:
        return 'ACCELERATE'
    return 'HOLD'
