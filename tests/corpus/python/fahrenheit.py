def c_to_f(c):
    return c * 9 / 5 + 32


def advice(celsius):
    f = c_to_f(celsius)
    if f >= 103:
        return "danger"
    elif f >= 91:
        return "caution"
    elif f <= 32:
        return "frost"
    return "fine"
