"""Pong paddle, RAM observation decoded to floats by the wrapper."""
NOOP, UP, DOWN = 0, 2, 3  # ALE action numbers
SCREEN_H = 210
PADDLE_X = 140


def paddle(obs):
    ball_x, ball_offset, ball_vx = obs

    if ball_vx <= 0 and ball_x < PADDLE_X // 2:
        return NOOP
    margin = SCREEN_H * 0.02
    if ball_offset > +margin:
        return DOWN
    if ball_offset < -margin:
        return UP
    return NOOP
