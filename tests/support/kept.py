"""Profiles that many tests share, kept on disk by the hash of what makes them.

Does: makes a profile where none is kept, or reads the one that is; what is read is the same either way.
Assumes: making it is seeded, and depends on the sources of MAKING, the expert and the libraries that fit trees.
Does not: keep anything in a clean clone; `.pytest_cache` may be removed at any time.
"""

import hashlib
import os
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path

from codegen import policy_json, profiles
from codegen.ir import PolicyProfile

ROOT = Path(__file__).parents[2]
PLACE = ROOT / ".pytest_cache" / "profiles"
MAKING = ("codegen", "maviper", "verify/claims", "tests/conftest.py")
LIBRARIES = ("numpy", "scikit-learn", "mpe2", "pettingzoo")


@cache
def hash_sources() -> str:
    """Of the names and contents of all modules that a profile is made by, and of the libraries' versions."""
    paths = sorted(path for name in MAKING for path in [*(ROOT / name).rglob("*.py"), ROOT / name] if path.is_file())
    found = hashlib.sha256("".join(version(each) for each in LIBRARIES).encode())
    for path in paths:
        found.update(f"\0{path.relative_to(ROOT)}\0".encode() + path.read_bytes())
    return found.hexdigest()


def keep_profile(of: str, make: Callable[[], PolicyProfile]) -> PolicyProfile:
    """The profile that `make` makes; `of`: what it is made from. Those of other sources are removed."""
    sources = hash_sources()
    place = PLACE / f"{sources[:20]}-{hashlib.sha256(of.encode()).hexdigest()[:20]}.json"
    if not place.is_file():
        text = policy_json.dumps(make())
        PLACE.mkdir(parents=True, exist_ok=True)
        for old in PLACE.iterdir():
            if not old.name.startswith(sources[:20]):
                old.unlink(missing_ok=True)
        part = place.with_suffix(f".{os.getpid()}")
        part.write_text(text, encoding="utf-8")
        part.replace(place)  # another worker may have made the same one
    return profiles.loads(place.read_bytes())
