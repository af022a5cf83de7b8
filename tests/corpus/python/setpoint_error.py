class BangBang:
    """on/off control with dead band, setpoint given once"""

    def __init__(self, setpoint: float = 65.0, deadband: float = 2.0, *, inverted: bool = False):
        self._sp = setpoint
        self._db = deadband / 2
        self._sign = -1 if inverted else 1

    def __call__(self, pv: float) -> int:
        error = self._sign * (self._sp - pv)
        if error > self._db:
            return 1
        if error < -self._db:
            return -1
        return 0


controller = BangBang(setpoint=72.5)
