import numpy as np


class WallFollower:
    """Follows the wall on the right at a set distance."""

    STRAIGHT = 0
    LEFT = 1
    RIGHT = 2

    def __init__(self, distance=0.5, tolerance=0.1):
        self.distance = distance
        self.tolerance = tolerance
        self.front_limit = 2 * distance

    def act(self, scan):
        scan = np.asarray(scan)
        front, right = scan[0], scan[-1]
        if front < self.front_limit:
            return self.LEFT
        error = right - self.distance
        if error > self.tolerance:
            return self.RIGHT
        if error < -self.tolerance:
            return self.LEFT
        return self.STRAIGHT


if __name__ == "__main__":
    robot = WallFollower()
    print(robot.act([2.0, 1.0, 0.45]))
