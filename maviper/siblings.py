"""That `codegen` and `verify` are the packages that came with this one.

Does: raises ImportError where another package of one of these names would be imported in its stead.
Assumes: the three lie side by side, in a checkout as in a wheel.
Does not: import them.

Both names are nouns that others may use too. They stay at the top level, since folders of a checkout are importable
as they lie only so; whoever installs another package of that name is told at once, instead of by an odd error later.
"""

from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
SIBLINGS = ("codegen", "verify")


def ensure_found() -> None:
    """ImportError names the package that is in the way, and where it lies."""
    for name in SIBLINGS:
        spec = find_spec(name)
        origin = None if spec is None else spec.origin or next(iter(spec.submodule_search_locations or ()), None)
        if origin is None:
            raise ImportError(f"maviper is not installed in full: its package {name} is missing; install it again")
        if HERE not in (Path(origin).resolve().parent.parent, Path(origin).resolve().parent):
            where = f"another package or module of the name {name} is found first: {origin}"
            raise ImportError(f"{where}; maviper has one of that name, so install it in an environment of its own")


ensure_found()
