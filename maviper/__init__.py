"""MAVIPER: neural multi-agent policies as small decision trees, compiled exactly and proved.

Does: `load` a policy profile, `compile` it to code, `verify` claims about it; everything else is a command.
Assumes: heavy libraries are imported by the functions that need them.
Does not: import anything heavy itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from codegen.ir import PolicyProfile
    from maviper.agreement import Compiled
    from maviper.replaying import Replayed
    from verify.closed_loop import LoopResult
    from verify.engine import Result

__all__ = ["compile", "from_onnx", "from_sklearn", "load", "replay", "verify", "version"]


def version() -> str:
    """The installed version of the package."""
    from importlib import metadata

    return metadata.version("maviper")


def load(path: str | Path) -> PolicyProfile:
    """The policy profile in a JSON file, checked. ProfileError (an InputError) with the path of the fault otherwise."""
    from pathlib import Path

    from codegen import policy_json
    from maviper import runs

    return policy_json.loads(runs.read(Path(path), policy_json.MAX_BYTES), Path(path).name)


def from_sklearn(classifier: object, **names: object) -> PolicyProfile:
    """A profile from a fitted scikit-learn DecisionTreeClassifier; arguments as `codegen.importers.from_sklearn`."""
    from codegen.importers import from_sklearn as imported

    return imported(classifier, **names)  # pyright: ignore[reportArgumentType]


def from_onnx(model: Path | bytes, **names: object) -> PolicyProfile:
    """A profile from an ONNX ensemble of one tree; arguments as `codegen.importers.from_onnx`."""
    from codegen.importers import from_onnx as imported

    return imported(model, **names)  # pyright: ignore[reportArgumentType]


def compile(
    profile: PolicyProfile,
    targets: Iterable[str] = ("c", "python", "json"),
    prefix: str | None = None,
    style: str = "auto",
) -> Compiled:
    """Code for a profile, replayed against it with tolerance zero before it is returned. `style`: of the C.

    DisagreementError when any decision differs. `Compiled.files` maps file names to texts (of ONNX: bytes).
    """
    from maviper.agreement import compile_profile

    return compile_profile(profile, targets, prefix, style)


def verify(
    profile: PolicyProfile, property_name: str = "distinct_targets", region: str = "start", where: bool = False
) -> Result | LoopResult:
    """The verdict on a built-in property in a region: `start` for the start box, or the path of a region file.

    `where`: also where a claim about single decisions holds and fails (`Result.where`, `Result.within`).
    """
    from maviper.claims import find_region, verify_claims
    from verify.claim import find_claim
    from verify.violations import DEFAULT_ZONES

    claim = find_claim(property_name, profile)
    zones = DEFAULT_ZONES if where else None
    return verify_claims(profile, [(claim, find_region(region, profile))], where=zones)[0]


def replay(counterexample: Path, profile: Path) -> Replayed:
    """The counterexample of a file that `maviper verify -o` wrote, replayed with the profile in a file."""
    from maviper.replaying import replay as replayed

    return replayed(counterexample, load(profile))
