"""The function `maviper.robust`.

Does: what the command does, with its options as parameters.
Assumes: heavy libraries are imported when it is called.
Does not: print.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from maviper.verification.robust import Radii


def robust(
    profile: PolicyProfile | str | Path, observations: str | Path, agent: str | None = None, *, certify: bool = False
) -> Radii:
    """For each observation of a CSV or JSON file the largest radius within which an agent acts the same, exactly.

    `agent`: default, the only one; `certify`: each radius is proved, and its certificate checked. InputError for a file
    that is no table of finite observations of that agent.
    """
    from maviper.files.profiles import loaded
    from maviper.verification.robust import robust as radii

    return radii(loaded(profile, beside=Path(observations)), Path(observations), agent, certify)
