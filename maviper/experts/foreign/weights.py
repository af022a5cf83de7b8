"""Weights by name out of files of torch or safetensors; nothing in them is run.

Does: reads a state dict, or safetensors; finds the layers under a name in it.
Assumes: the extra `maviper[train]` where archives.py does not read a file: torch before 1.6, rare types of numbers.
Does not: load whole modules, TorchScript or any other pickle.
"""

import io
import re
import zipfile
from collections.abc import Callable, Mapping
from typing import Protocol, TypeGuard, cast, runtime_checkable

import numpy as np

from codegen.errors import InputError, MissingToolError
from codegen.ir import Float32
from maviper.experts.foreign.archives import NotPlainError, state_dict
from maviper.experts.foreign.layers import Linear
from maviper.worlds.outside.sources import is_mapping

MAX_BYTES = 256 * 2**20
REFUSED = re.compile(r"(?:GLOBAL|class) ([A-Za-z_][\w.]{0,100}) (?:was|is) not")  # in torch's words
ADVISED = re.compile(r"weights.only|safe_globals|trust", re.IGNORECASE)  # where torch says how to load more
Tensors = Mapping[str, Float32]


@runtime_checkable
class Tensor(Protocol):
    """The part of torch's tensor that is used here."""

    @property
    def layout(self) -> object:
        """The layout of its numbers."""
        ...

    @property
    def is_quantized(self) -> bool:
        """True if its numbers are codes."""
        ...

    @property
    def is_meta(self) -> bool:
        """True if it has a shape alone."""
        ...

    def is_complex(self) -> bool:
        """Returns True if its numbers are complex."""
        ...

    def numel(self) -> int:
        """Counts its numbers."""
        ...

    def detach(self) -> "Tensor":
        """Itself, without what led to it."""
        ...

    def cpu(self) -> "Tensor":
        """Itself, in the machine's own memory."""
        ...

    def float(self) -> "Tensor":
        """Itself, as float32."""
        ...

    def numpy(self) -> Float32:
        """Its numbers, of its shape."""
        ...


def read(data: bytes, where: str, safetensors: bool = False) -> dict[str, Float32]:
    """The tensors of a state dict in a file's bytes, as float32; InputError where it holds anything else."""
    if safetensors:
        return _safetensors(data, where)
    try:
        return state_dict(data, MAX_BYTES)
    except NotPlainError as reason:  # torch reads more, or says why it does not
        return of_torch(_torch(data, where, str(reason)), where)


def _safetensors(data: bytes, where: str) -> dict[str, Float32]:
    from safetensors import SafetensorError
    from safetensors.numpy import load

    try:
        return {name: tensor.astype(np.float32) for name, tensor in load(data).items()}
    except (SafetensorError, ValueError, TypeError, KeyError) as error:
        raise InputError("not a safetensors file", f"{where}: {error}"[:200]) from None


def _torch(data: bytes, where: str, reason: str) -> object:
    """Loads the data with torch; `reason`: why it is asked."""
    try:
        import torch  # pyright: ignore[reportMissingImports]
    except ImportError:
        advice = "save it as torch.save(module.state_dict(), file), or install torch: pip install 'maviper[train]'"
        raise MissingToolError("only torch can read these weights, if at all", f"{where}: {reason}", advice) from None
    try:
        _ensure_small(data)
        load = cast("Callable[..., object]", torch.load)  # pyright: ignore[reportUnknownMemberType]
        return load(io.BytesIO(data), map_location="cpu", weights_only=True)
    except Exception as error:  # whatever a damaged or hostile file makes of it
        said = _reason(error)
        advice = "save it as torch.save(module.state_dict(), file)"
        raise InputError("not a file of weights alone; nothing else is loaded", f"{where}: {said}", advice) from None


def _reason(error: Exception) -> str:
    """Why torch does not load a file, without its advice to load it all the same, which would run what it holds."""
    text = str(error).strip()
    named = REFUSED.search(text)
    if named:
        return f"it holds {named[1]}"
    if ADVISED.search(text):
        return "it is a TorchScript archive" if "TorchScript" in text else "it holds more than tensors, or is damaged"
    return (text.splitlines() or [type(error).__name__])[0][:200]


def _ensure_small(data: bytes) -> None:
    """ValueError where torch would unpack more than MAX_BYTES. It reads compressed parts too."""
    size, packed = len(data), io.BytesIO(data)
    if zipfile.is_zipfile(packed):  # not before torch 1.6
        with zipfile.ZipFile(packed) as archive:
            size = sum(part.file_size for part in archive.infolist())
    if size > MAX_BYTES:
        raise ValueError(f"it unpacks to more than {MAX_BYTES} bytes")


def of_torch(loaded: object, where: str) -> dict[str, Float32]:
    """The tensors of a state dict; InputError for anything else, and for more numbers than MAX_BYTES hold.

    A small file may state a large shape, all of whose places are one number in memory.
    """
    given: Mapping[object, object] = loaded if is_mapping(loaded) else {}
    if not given:
        raise InputError("not a state dict", where, "save it as torch.save(module.state_dict(), file)")
    tensors: dict[str, Float32] = {}
    room = MAX_BYTES
    for name, value in given.items():
        if not isinstance(name, str) or not _plain(value):
            raise InputError("not a state dict of tensors", f"{where}: {str(name)[:80]}", "save module.state_dict()")
        room -= 4 * value.numel()
        if room < 0:
            raise InputError(f"the weights are more than {MAX_BYTES} bytes", f"{where}: {name[:80]}")
        tensors[name] = value.detach().cpu().float().numpy()
    return tensors


def _plain(value: object) -> TypeGuard[Tensor]:
    """Returns True if it is a tensor of real numbers that lie one beside the other: not sparse, complex, quantized or
    without data.
    """
    if not isinstance(value, Tensor) or str(value.layout) != "torch.strided":
        return False
    return not (value.is_complex() or value.is_quantized or value.is_meta)


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
    layer = tensors.get(f"{name}.weight"), tensors.get(f"{name}.bias")
    if layer[0] is None or layer[1] is None or (layer[0].ndim, layer[1].ndim) != (2, 1):
        raise InputError("a layer is missing", f"{where}: {name}", "the file is damaged, or of another library")
    return Linear(layer[0], layer[1])
