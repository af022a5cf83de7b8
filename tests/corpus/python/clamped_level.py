def clamp(v, lo, hi):
    return max(lo, min(hi, v))
def speed_cmd(dist):
    """returns the level 0..3"""
    d = clamp(dist, 0.0, 10.0)
    level = 3
    while level > 0 and d < level * 2.5:
        level -= 1
    return level
