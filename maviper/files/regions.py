"""Regions by name: the start region, or one in a file.

Does: reads a region file for a profile.
Assumes: paths from the caller.
Does not: decide what holds in a region.
"""

from pathlib import Path

from codegen import ir
from codegen.errors import InputError
from maviper.files import kinds, runs
from verify.claims.region import Region
from verify.claims.region_files import read_region
from verify.claims.uncertified.starts import everywhere, find_observed_velocities

MAX_REGION_BYTES = 2**20


def find_region(name: str, profile: ir.PolicyProfile) -> Region:
    """`start` for the start region, else the region in the file `name`."""
    if name == "start":
        return everywhere(profile)
    path = Path(name)
    try:
        data = runs.read(path, MAX_REGION_BYTES)
        kinds.ensure(data, name, kinds.REGION.called, kinds.REGION)
        source = data.decode()
    except UnicodeDecodeError:
        raise InputError("not a readable region file", f"{name}: not UTF-8 text", "is this the right file?") from None
    # a file called start must not be taken for the start region when the report names it
    where = f"./{path.name}" if path.name == "start" else path.name
    return read_region(source, profile.world, where, find_observed_velocities(profile))
