def two_hand_press(left_button, right_button, guard_closed, pressure):
    """Two-hand control of a hydraulic press."""
    both = bool(left_button) and bool(right_button)
    one_only = bool(left_button) != bool(right_button)
    safe = guard_closed and 3.0 <= pressure <= 6.5
    if one_only:
        return "retract"
    return "press" if both and safe else "hold"
