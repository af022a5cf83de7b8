from typing import Literal, TypedDict

Manoeuvre = Literal["keep", "left", "right"]


class Observation(TypedDict):
    left_gap: float
    right_gap: float
    ahead: float


SAFE_GAP = 1.5e1


def plan(o: Observation) -> Manoeuvre:
    if o["ahead"] > 2 * SAFE_GAP:
        return "keep"
    left_free, right_free = o["left_gap"] > SAFE_GAP, o["right_gap"] > SAFE_GAP
    if left_free and not right_free:
        return "left"
    if right_free and not left_free:
        return "right"
    return "left" if left_free and right_free else "keep"
