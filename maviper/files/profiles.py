"""Profiles on disk, and the version of this package that writes them.

Does: reads and checks a policy profile; names the installed version.
Assumes: paths from the caller.
Does not: write profiles.
"""

from pathlib import Path

from codegen import profiles
from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.sum_rules import ensure_plain
from maviper.files import kinds, runs

READER = "this command"
VERSION = "0.2.0"  # pyproject.toml and CITATION.cff say the same


def version() -> str:
    """The version of the package, of the files that run; what was installed beside them may be older."""
    return VERSION


def load(path: str | Path, *, sums: bool = False) -> PolicyProfile:
    """The policy profile in a JSON file, checked. ProfileError (an InputError) with the path of the fault otherwise, or
    an InputError that says which other document of ours the file is. `sums`: whether the caller takes agents that test
    sums or give numbers; else InputError for them.
    """
    data = runs.read(Path(path), profiles.MAX_BYTES)
    kinds.ensure(data, str(path), kinds.PROFILE.called, kinds.PROFILE)
    profile = profiles.loads(data, Path(path).name)
    return profile if sums else ensure_plain(profile, READER)


def find_profile(profile: PolicyProfile | str | Path | None, beside: Path, *, sums: bool = False) -> PolicyProfile:
    """A profile that is given, or lies in a file; None: profile.json beside another file. `sums`: as for `load`."""
    if profile is None:
        place = beside.parent / runs.PROFILE_FILE
        if not place.exists():
            raise InputError(f"no {runs.PROFILE_FILE} lies beside the file", str(beside), "name it with --profile FILE")
        return load(place, sums=sums)
    if isinstance(profile, str | Path):
        return load(profile, sums=sums)
    return profile if sums else ensure_plain(profile, READER)
