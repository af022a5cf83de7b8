"""JSON: the profile itself, which any program can read, and a reference reader to start from.

Does: emits PREFIX.json and PREFIX_reader.py.
Assumes: a reader walks `tree` from node 0: left iff x[feature] <= threshold.
Does not: differ from the profile; the reader is the same for every profile of float32 agents, another one reads float64
  agents too. It needs Python 3.8 or newer alone.
"""

from codegen import ir
from codegen.lowering.model import Model
from codegen.lowering.render import render
from codegen.policy_json import dumps


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The profile and the reader."""
    return {
        f"{model.prefix}.json": dumps(profile),
        f"{model.prefix}_reader.py": render("json/reader.py.j2", model=model),
    }
