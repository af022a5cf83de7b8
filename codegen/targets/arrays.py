"""Array libraries: JAX and PyTorch modules of one template, which decide for whole batches on any device.

Does: emits PREFIX_jax.py or PREFIX_torch.py: nested `where` over the bits of float32 numbers, in their order.
Assumes: JAX 0.4 or PyTorch 2.2, or newer, with whoever runs the module.
Does not: import either of them; observe world states, for which JAX has no doubles unless it is told to.

Numbers are compared as integers since XLA on a CPU takes subnormal numbers for zero, and a GPU may.
"""

from codegen import ir
from codegen.lowering.model import Model
from codegen.lowering.render import render


def jax(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The module for JAX."""
    return {f"{model.prefix}_jax.py": render("arrays/module.py.j2", model=model, library="jax", where="jnp")}


def torch(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The module for PyTorch."""
    return {f"{model.prefix}_torch.py": render("arrays/module.py.j2", model=model, library="torch", where="torch")}
