"""Profiles and regions on disk, and the version of this package that writes them.

Does: reads and checks a policy profile; reads a region by name: the start region, or one in a file; names the version.
Assumes: paths from the caller.
Does not: write profiles, or decide what holds in a region.
"""

from collections.abc import Sequence
from pathlib import Path

from codegen import ir, profiles
from codegen.deciding import ensure_plain
from codegen.errors import InputError, escape_text
from codegen.ir import PolicyProfile
from maviper.files import kinds, runs
from verify.claims.region import Region
from verify.claims.region_files import everywhere, find_observed_velocities, read_region

READER = "this command"
VERSION = "0.3.0"  # pyproject.toml and CITATION.cff say the same


def version() -> str:
    """The version of the package, of the files that run; what was installed beside them may be older."""
    return VERSION


def load(path: str | Path, *, sums: bool = False) -> PolicyProfile:
    """The policy profile in a JSON file, checked. ProfileError (an InputError) with the path of the fault otherwise, or
    an InputError that says which other document of ours the file is. `sums`: whether the caller takes agents that test
    sums or give numbers; else InputError for them.
    """
    inside = Path(path) / runs.PROFILE_FILE
    if Path(path).is_dir() and inside.is_file():
        raise InputError("a folder, not a profile", str(path), f"did you mean {inside}?")
    data = runs.read(Path(path), profiles.MAX_BYTES)
    kinds.ensure(data, str(path), kinds.PROFILE.called, kinds.PROFILE)
    profile = profiles.loads(data, Path(path).name)
    return profile if sums else ensure_plain(profile, READER)


def find_profile(profile: object, beside: Path, *, sums: bool = False) -> PolicyProfile:
    """A profile that is given, or lies in a file; None: profile.json beside another file. `sums`: as for `load`."""
    if profile is None:
        place = beside.parent / runs.PROFILE_FILE
        if not place.exists():
            raise InputError(f"no {runs.PROFILE_FILE} lies beside the file", str(beside), "name it with --profile FILE")
        return load(place, sums=sums)
    if isinstance(profile, str | Path):
        return load(profile, sums=sums)
    if not isinstance(profile, PolicyProfile):
        raise InputError(f"{type(profile).__name__} is no team", "", "give a team, or the path of its file")
    return profile if sums else ensure_plain(profile, READER)


MAX_REGION_BYTES = 2**20


def find_region(name: str, profile: ir.PolicyProfile, others: Sequence[str] = ()) -> Region:
    """`start` for the start region, else the region in the file `name`. `others`: names that the caller knows."""
    if name == "start":
        return everywhere(profile)
    path = Path(name)
    if not path.suffix and len(path.parts) == 1 and not path.exists():
        what = f"'{escape_text(name)}' is {'none of' if others else 'neither'} "
        what += f"{', '.join(f'`{each}`' for each in ('start', *others))} {'and no' if others else 'nor a'} file"
        raise InputError(what, "--region", f"write {', '.join(('start', *others))}, or the file's name")
    try:
        data = runs.read(path, MAX_REGION_BYTES)
        kinds.ensure(data, name, kinds.REGION.called, kinds.REGION)
        source = data.decode()
    except UnicodeDecodeError:
        raise InputError("not a readable region file", f"{name}: not UTF-8 text", "is this the right file?") from None
    # a file called start must not be taken for the start region when the report names it
    where = f"./{path.name}" if path.name == "start" else path.name
    return read_region(source, profile.world, where, find_observed_velocities(profile))
