"""The languages that a profile compiles to; a new one is a module here, a folder of templates and a line below.

Does: names the targets and emits any of them.
Assumes: a target is a function from the lowered model and the profile to files.
Does not: write files or check them (agreement/selfcheck.py).
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial

from codegen import ir
from codegen.deciding import REMEMBERING, SUMMING, ensure_forgets, ensure_plain
from codegen.errors import InputError, UnknownNameError
from codegen.lowering.lower import AUTO, lower
from codegen.lowering.model import Model
from codegen.targets import onnx, rendered, st, svg

Emitter = Callable[[Model, ir.PolicyProfile], Mapping[str, str | bytes]]
TARGETS: dict[str, Emitter] = {
    "c": rendered.emit_c,
    "shared": rendered.emit_shared,
    "python": rendered.one_text("python/module.py.j2", ".py"),  # standard library; numpy in batch functions alone
    "json": rendered.emit_json,
    "javascript": rendered.one_text("javascript/module.js.j2", ".mjs"),  # for pages and Node.js
    "rust": rendered.one_text("rust/module.rs.j2", ".rs"),  # `mod PREFIX;` takes the file in
    "smt": rendered.one_text("smt/trees.smt2.j2", ".smt2"),  # trees as functions over Float32
    "svg": svg.emit,
    "st": st.emit,
    onnx.NEW_TARGET: onnx.emit,
    onnx.OLD_TARGET: partial(onnx.emit, old=True),
    "jax": rendered.one_text("arrays/module.py.j2", "_jax.py", library="jax", where="jnp"),
    "torch": rendered.one_text("arrays/module.py.j2", "_torch.py", library="torch", where="torch"),
}
USUAL = ("c", "python", "json")
RECIPROCAL = ("jax", "torch", onnx.NEW_TARGET, onnx.OLD_TARGET)  # which may multiply with one in place of dividing
SINGLE = ("smt", "st", "jax", "torch")  # which take float32 agents only


def emit(
    profile: ir.PolicyProfile, targets: Iterable[str] = USUAL, prefix: str | None = None, style: str = AUTO
) -> dict[str, str | bytes]:
    """File name -> text, or bytes where a target is no text, for the chosen targets; equal profiles give equal bytes.

    `style`: of the C. UnknownNameError for another target, InputError for one that does not take the numbers that an
    agent compares, MissingToolError for one whose package is not installed.
    """
    return emit_model(lower(profile, prefix, style), profile, targets)


def emit_model(model: Model, profile: ir.PolicyProfile, targets: Iterable[str]) -> dict[str, str | bytes]:
    """The same from a profile that is lowered already."""
    files: dict[str, str | bytes] = {}
    for target in targets:
        if target in ("cpp", "c++", "cc"):
            raise InputError(f"unknown target '{target}'", "--target", "choose c, whose header is C++17 too")
        if target not in TARGETS:
            raise UnknownNameError("target", target, TARGETS, "--target")
        for agent in model.agents if target in SINGLE else ():
            if not agent.single and not (agent.whole and target == "st"):
                what = f"the target {target} has no float64 agents, and {agent.name} compares {agent.compared}"
                otherwise = "" if agent.whole else ", or import the tree with --numbers float32"
                raise InputError(what, "--target", f"leave {target} out{otherwise}")
        if target not in SUMMING:
            ensure_plain(profile, f"the target {target}", memory=True)
        if target in RECIPROCAL and model.divides:
            what = f"the target {target} may round a quotient in a sum otherwise than the profile"
            raise InputError(what, "--target", f"leave {target} out")
        if target not in REMEMBERING:
            ensure_forgets(profile, f"the target {target}")
        files |= TARGETS[target](model, profile)
    return files
