"""Ordered rules as data: the first rule that fires decides."""

RULES = [
    (lambda t, h: t > 30.0, "cool"),
    (lambda t, h: t < 16.0, "heat"),
    (lambda t, h: h > 70, "dry"),
]


def climate(temp, humidity):
    for condition, action in RULES:
        if condition(temp, humidity):
            return action
    return "off"
