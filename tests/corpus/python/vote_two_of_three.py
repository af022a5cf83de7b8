"""2-out-of-3 voting of redundant pressure transmitters, SIL 2."""

TRIP_BAR = 16.0


def trip(pt_101a, pt_101b, pt_101c):
    votes = sum([pt_101a > TRIP_BAR, pt_101b > TRIP_BAR, pt_101c > TRIP_BAR])
    return votes >= 2
