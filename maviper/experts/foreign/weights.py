"""Weights by name out of files of torch or safetensors; nothing in them is run.

Does: reads a state dict by `torch.load(weights_only=True)`, or safetensors; finds the layers under a name in it.
Assumes: the extra `maviper[train]` for files of torch.
Does not: load whole modules, TorchScript or any other pickle.
"""

import io
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from codegen.errors import InputError, MissingToolError
from codegen.ir import Float32
from maviper.experts.foreign.layers import Linear

MAX_BYTES = 256 * 2**20
Tensors = Mapping[str, Float32]


def read(data: bytes, where: str, safetensors: bool = False) -> dict[str, Float32]:
    """The tensors of a state dict in a file's bytes, as float32; InputError where it holds anything else."""
    return _safetensors(data, where) if safetensors else of_torch(_torch(data, where), where)


def _safetensors(data: bytes, where: str) -> dict[str, Float32]:
    from safetensors import SafetensorError
    from safetensors.numpy import load

    try:
        return {name: tensor.astype(np.float32) for name, tensor in load(data).items()}
    except (SafetensorError, ValueError, TypeError, KeyError) as error:
        raise InputError("not a safetensors file", f"{where}: {error}"[:200]) from None


def _torch(data: bytes, where: str) -> Any:
    try:
        import torch
    except ImportError:
        advice = "install the extra: pip install 'maviper[train]'"
        raise MissingToolError("weights of torch need torch", where, advice) from None
    try:
        return torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    except Exception as error:  # whatever a damaged or hostile file makes of it
        said = (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
        advice = "save it as torch.save(module.state_dict(), file)"
        raise InputError("not a file of weights alone; nothing else is loaded", f"{where}: {said}", advice) from None


def of_torch(found: Any, where: str) -> dict[str, Float32]:
    """The tensors of a state dict; InputError for anything else."""
    if not isinstance(found, Mapping) or not found:
        raise InputError("not a state dict", where, "save it as torch.save(module.state_dict(), file)")
    tensors: dict[str, Float32] = {}
    for name, value in found.items():
        if not isinstance(name, str) or not hasattr(value, "detach"):
            raise InputError("not a state dict of tensors", f"{where}: {str(name)[:80]}", "save module.state_dict()")
        tensors[name] = value.detach().cpu().float().numpy()
    return tensors


def layers(tensors: Tensors, name: str, where: str) -> list[Linear]:
    """The fully connected layers `NAME.0`, `NAME.2`, ... with one activation after each; InputError where there is
    anything else under the name.
    """
    mine = {key.removeprefix(f"{name}."): value for key, value in tensors.items() if key.startswith(f"{name}.")}
    places = sorted({int(key.partition(".")[0]) for key in mine if re.fullmatch(r"\d{1,3}\.(weight|bias)", key)})
    expected = {f"{place}.{part}": 2 - (part == "bias") for place in places for part in ("weight", "bias")}
    wrong = [key for key in expected.keys() | mine.keys() if getattr(mine.get(key), "ndim", 0) != expected.get(key)]
    if wrong:
        what = "not a network of fully connected layers alone"
        raise InputError(what, f"{where}: {name}.{min(wrong)}", "bring it by module:function: `maviper guide experts`")
    if places != list(range(0, 2 * len(places), 2)):
        what = "cannot tell where its activations are: one is expected after each layer but the last"
        raise InputError(what, f"{where}: {name}: layers {', '.join(map(str, places))}", "see `maviper guide experts`")
    return [Linear(mine[f"{place}.weight"], mine[f"{place}.bias"]) for place in places]


def single(tensors: Tensors, name: str, where: str) -> Linear:
    """The one layer of that name."""
    found = tensors.get(f"{name}.weight"), tensors.get(f"{name}.bias")
    if found[0] is None or found[1] is None or (found[0].ndim, found[1].ndim) != (2, 1):
        raise InputError("a layer is missing", f"{where}: {name}", "the file is damaged, or of another library")
    return Linear(found[0], found[1])
