"""The functions `maviper.robust`, `maviper.diff` and `maviper.verify_system`.

Does: what the commands do, with their options as parameters.
Assumes: heavy libraries are imported when they are called.
Does not: print.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from codegen.process import flags
from maviper.options import DiffOptions, SystemOptions, completed, spelled_out

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from maviper.verification.diff import Compared
    from maviper.verification.robust import Radii
    from maviper.verification.run import Verified


@flags.defaults
def robust(
    profile: PolicyProfile | str | Path, observations: str | Path, agent: str | None = None, *, certify: bool = False
) -> Radii:
    """For each observation of a CSV or JSON file the largest radius within which an agent acts the same, exactly.

    `agent`: default, the only one; `certify`: each radius is proved, and its certificate checked. InputError for a file
    that is no table of finite observations of that agent.
    """
    from maviper.files.profiles import find_profile
    from maviper.verification.robust import robust as radii

    return radii(find_profile(profile, beside=Path(observations)), Path(observations), agent, certify)


@flags.defaults
@spelled_out(DiffOptions)
def diff(
    first: PolicyProfile, second: PolicyProfile, region: str | Path = "start", **asked: Unpack[DiffOptions]
) -> Compared:
    """Every state of a region in which two profiles act differently, or the proof that there is none.

    `Compared.facts` has shares, zones and examples, `Compared.found` the certificate. InputError for profiles whose
    worlds, agents, features or actions differ.
    """
    from maviper.verification.diff import compare_profiles, request

    return compare_profiles(first, second, str(region), request(**asked))


@flags.defaults
@spelled_out(SystemOptions)
def verify_system(
    profile: PolicyProfile,
    world: str | Path,
    properties: str | Path | None = None,
    **asked: Unpack[SystemOptions],
) -> Verified:
    """The verdicts on the claims of a world file, or of a property file, about the system that the file states.

    `Verified.results` has verdicts and evidence, `document` the report. InputError for files that cannot be used, a
    profile of another world, and a statement that is further from its reference than it says.
    """
    from codegen.check import ensure
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import verified_system

    file = None if properties is None else Path(properties)
    options = VerifyOptions(world=Path(world), file=file, **completed(SystemOptions, asked))
    return verified_system(ensure(profile), options)
