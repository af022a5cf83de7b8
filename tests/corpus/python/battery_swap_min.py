"""Battery pack balancing: act on the weakest of three cells against a fixed limit."""

UNDER_V = 2.9
OVER_V = 4.2


def balance_cmd(cells):
    lowest = min(cells[0], cells[1], cells[2])
    highest = max(cells)
    if lowest < UNDER_V:
        return "disconnect"
    if highest > OVER_V:
        return "bleed"
    return "charge"
