"""Student's t, as far as we use it."""

class _Continuous:
    def ppf(self, q: float, df: float) -> float: ...
    def sf(self, x: float, df: float) -> float: ...

t: _Continuous
