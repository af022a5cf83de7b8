RULES = [
    (lambda o: o[0] > 0.7, "left"),
    (lambda o: o[1] > 0.7, "right"),
    (lambda o: o[0] < -0.2 and o[1] < -0.2, "back"),
]
def choose(o):
    for test, what in RULES:
        if test(o):
            return what
    return "forward"
