"""MAVIPER: neural multi-agent policies as small decision trees, compiled exactly and proved.

Does: `load` a policy profile, `compile` it to code, `verify` claims about it; everything else is a command.
Assumes: heavy libraries are imported by the functions that need them.
Does not: import anything heavy itself.
"""

from importlib import metadata


def version() -> str:
    """The installed version of the package."""
    return metadata.version("maviper")
