from typing import Callable, Sequence

policy: Callable[[Sequence[float]], int] = lambda obs: 1 if 3 * obs[2] > 0.05 else 0
