"""JSON: the profile itself, which any program can read.

Does: emits PREFIX.json.
Assumes: a reader walks `tree` from node 0: left iff x[feature] <= threshold.
Does not: differ from the profile.
"""

from codegen import ir
from codegen.lower import Model
from codegen.policy_json import dumps


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The profile."""
    return {f"{model.prefix}.json": dumps(profile)}
