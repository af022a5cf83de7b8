import sys
try:
    import numpy as np
except ImportError:
    np = None

class Controller(object):
    """State machine without state."""
    ACTIONS = ("hold", "buy", "sell")
    @staticmethod
    def _over(x): return x > 70
    @classmethod
    def _under(cls, x): return x < 30
    def __call__(self, rsi, trend):
        if self._over(rsi) and trend < 0: return self.ACTIONS[2]
        if self._under(rsi) and trend >= 0: return self.ACTIONS[1]
        return self.ACTIONS[0]
if __name__ == "__main__":
    print(Controller()(float(sys.argv[1]), 1))
