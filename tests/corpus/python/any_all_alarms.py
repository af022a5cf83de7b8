LOW, HIGH = 4.0, 20.0


def loop_status(i1, i2, i3):
    currents = [i1, i2, i3]
    if any(i < LOW for i in currents):
        return "broken_wire"
    if all(i >= HIGH for i in currents):
        return "saturated"
    return "ok"
