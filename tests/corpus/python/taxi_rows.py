"""Taxi heuristic on the decoded state (row, column, passenger, destination).

Only the leg from the depot R (0, 0) to the depot Y (4, 0); the walls force a detour over column 0.
"""

SOUTH, NORTH, EAST, WEST, PICKUP, DROPOFF = 0, 1, 2, 3, 4, 5
IN_TAXI = 4


def taxi(row, col, passenger, destination):
    carrying = passenger == IN_TAXI
    if not carrying:
        if passenger != 0:
            return EAST
        if row == 0 and col == 0:
            return PICKUP
        if col > 0:
            return WEST
        return NORTH
    if destination == 2:
        if row == 4 and col == 0:
            return DROPOFF
        return SOUTH if row < 4 else WEST
    return EAST if col < 4 else NORTH
