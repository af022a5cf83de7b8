def f(o):
    left, *rest, right = o[0], o[1], o[2]
    if left < right: return 1
    if rest[0] > 0.5: return 2
    return 0
