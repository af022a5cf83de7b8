"""Weights by name out of files of torch or safetensors; nothing in them is run.

Does: reads a state dict, or safetensors; finds the layers under a name in it. The zip archives that `torch.save`
  writes are read without torch: their index, a pickle, as a list of instructions, and the numbers of the tensors that
  it names.
Assumes: nothing of the file; torch's layout since 1.6: a folder with `data.pkl`, and each storage as `data/NUMBER`.
Does not: unpickle, or have torch do so. Instructions that a state dict does not need are refused, and a name calls
  nothing: three names stand for a dictionary, a tensor and a type of numbers. Nor load whole modules or TorchScript.
"""

import io
import math
import pickletools
import re
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32
from maviper.experts.foreign.layers import Linear
from maviper.worlds.outside.sources import is_mapping

INDEX, ORDER = "data.pkl", "byteorder"
MAX_INDEX = 2**22  # bytes: the largest index is about a hundred for each tensor
PROTOCOL = 2  # torch's
DICTIONARY, TENSOR = "collections OrderedDict", "torch._utils _rebuild_tensor_v2"
TYPES: Mapping[str, str] = {  # what a storage holds, in numpy's words
    "torch DoubleStorage": "<f8",
    "torch FloatStorage": "<f4",
    "torch HalfStorage": "<f2",
    "torch LongStorage": "<i8",
    "torch IntStorage": "<i4",
    "torch ShortStorage": "<i2",
    "torch CharStorage": "|i1",
    "torch ByteStorage": "|u1",
}
CONSTANTS: Mapping[str, object] = {"NEWTRUE": True, "NEWFALSE": False, "NONE": None, "EMPTY_TUPLE": ()}
UNREADABLE = (zipfile.BadZipFile, zlib.error, EOFError, LookupError, OverflowError, RuntimeError)


class NotPlainError(ValueError):
    """Why an archive is not read here: it holds more than a state dict of plain tensors, or it is damaged."""


class _Name(NamedTuple):
    """A module and a name in it, as text."""

    text: str


class _Storage(NamedTuple):
    """Numbers in a row: their type and the file that holds them."""

    numbers: str
    file: str
    size: int


class _Tensor(NamedTuple):
    """A view of a storage, as torch has it: all in numbers, not in bytes."""

    storage: _Storage
    offset: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]


def part(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    """One file of a zip; ValueError where it holds more than it may.

    Only what zips usually hold is unpacked. Python reads other compressions without a limit.
    """
    if archive.getinfo(name).compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} is compressed in an unknown way")
    with archive.open(name) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{name} is larger than {most} bytes")
    return content


def state_dict(data: bytes, most: int) -> dict[str, Float32]:
    """The tensors of a state dict as float32, rounded as torch rounds; NotPlainError for anything else, and for more
    than `most` bytes, packed or as float32.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _tensors(archive, most)
    except UNREADABLE as error:
        raise NotPlainError(str(error) or type(error).__name__) from None
    except NotPlainError:
        raise
    except ValueError as error:
        raise NotPlainError(str(error)) from None


def _tensors(archive: zipfile.ZipFile, most: int) -> dict[str, Float32]:
    files = archive.namelist()
    folder = files[0].partition("/")[0]
    if len(set(files)) < len(files) or not all(file.startswith(f"{folder}/") for file in files):
        raise NotPlainError("files lie twice in it, or beside its one folder")
    order = f"{folder}/{ORDER}"
    if order in files and part(archive, order, 16) != b"little":
        raise NotPlainError("its bytes are in another order")
    room, storages = most, dict[str, bytes]()
    tensors: dict[str, Float32] = {}
    machine = _Machine()
    for opcode, argument, _ in pickletools.genops(part(archive, f"{folder}/{INDEX}", MAX_INDEX)):
        machine.obey(opcode.name, argument)
    if len(machine.stack) != 1 or not _dictionary(machine.stack[0]):
        raise NotPlainError("it holds no tensors")
    for name, tensor in _dictionary(machine.stack[0]).items():
        if not isinstance(name, str) or not isinstance(tensor, _Tensor):
            raise NotPlainError(f"{str(name)[:80]} is no tensor")
        room -= 4 * math.prod(tensor.shape)
        if room < 0:
            raise NotPlainError(f"the weights are more than {most} bytes")
        file = tensor.storage.file
        if file not in storages:
            storages[file] = part(archive, f"{folder}/data/{file}", most - sum(map(len, storages.values())))
        tensors[name] = _numbers(tensor, storages[file])
    return tensors


def _numbers(tensor: _Tensor, data: bytes) -> Float32:
    """The numbers of a view; NotPlainError where it reaches out of its storage."""
    storage, offset, shape, strides = tensor
    kind = np.dtype(storage.numbers)
    if len(data) != storage.size * kind.itemsize:
        raise NotPlainError(f"storage {storage.file} holds {len(data)} bytes, not {storage.size} numbers")
    if 0 in shape:
        return np.zeros(shape, np.float32)
    last = offset + sum((size - 1) * stride for size, stride in zip(shape, strides, strict=True))
    if last >= storage.size:
        raise NotPlainError(f"a tensor reaches out of storage {storage.file}")
    steps = [stride * kind.itemsize if size > 1 else 0 for size, stride in zip(shape, strides, strict=True)]
    view = np.ndarray(shape, kind, data, offset * kind.itemsize, steps)
    with np.errstate(over="ignore"):  # a double beyond float32 becomes infinity, as in torch
        return view.astype(np.float32, "C")


# --- the index


class _Machine:
    """The stack on which a pickle builds its value."""

    def __init__(self) -> None:
        self.stack: list[object] = []
        self._marks: list[int] = []  # heights of the stack
        self._memo: dict[object, object] = {}

    def obey(self, name: str, argument: object) -> None:
        """One instruction."""
        stack = self.stack
        match name:
            case "BININT" | "BININT1" | "BININT2" | "LONG1" | "BINUNICODE":
                stack.append(argument)
            case "GLOBAL":
                stack.append(_Name(str(argument)))
            case "BINPUT" | "LONG_BINPUT":
                self._memo[argument] = stack[-1]
            case "BINGET" | "LONG_BINGET":
                stack.append(self._memo[argument])
            case "MARK":
                self._marks.append(len(stack))
            case "TUPLE":
                stack.append(tuple(self._since_mark()))
            case "TUPLE1" | "TUPLE2" | "TUPLE3":
                stack.append(tuple(self._pop_above(len(stack) - int(name[-1]))))
            case "EMPTY_DICT":
                stack.append({})
            case "SETITEM":
                self._fill(self._pop_above(len(stack) - 2))
            case "SETITEMS":
                self._fill(self._since_mark())
            case "BINPERSID":
                stack.append(_storage(stack.pop()))
            case "REDUCE":
                what, given = self._pop_above(len(stack) - 2)
                stack.append(_make_object(what, given))
            case "BUILD":  # attributes of a dictionary, in which torch notes versions of modules
                stack.pop()
                _dictionary(stack[-1])
            case "PROTO" if argument != PROTOCOL:
                raise NotPlainError(f"it is of protocol {argument}")
            case "PROTO" | "STOP":
                pass
            case _ if name in CONSTANTS:
                stack.append(CONSTANTS[name])
            case _:
                raise NotPlainError(f"it holds {name}, which no state dict needs")

    def _pop_above(self, height: int) -> list[object]:
        """Takes off the items above a height and returns them."""
        if height < 0:
            raise NotPlainError("its index is damaged")
        items = self.stack[height:]
        del self.stack[height:]
        return items

    def _since_mark(self) -> list[object]:
        return self._pop_above(self._marks.pop())

    def _fill(self, items: Sequence[object]) -> None:
        """Puts names and what they mean into the dictionary on top."""
        known = _dictionary(self.stack[-1])
        for key, entry in zip(items[::2], items[1::2], strict=True):
            if not isinstance(key, str):
                raise NotPlainError("a name in it is no text")
            known[key] = entry


def _dictionary(value: object) -> dict[object, object]:
    if not isinstance(value, dict):
        raise NotPlainError("it is no state dict")
    return cast("dict[object, object]", value)


def _storage(given: object) -> _Storage:
    """Reads torch's description of a storage: ("storage", type, name of its file, device, count of numbers)."""
    match given:
        case ("storage", _Name(kind), str(file), str(), int(count)) if kind in TYPES and file.isdecimal():
            return _Storage(TYPES[kind], file, count)
        case _:
            raise NotPlainError("it holds numbers of a type that only torch reads")


def _make_object(what: object, given: object) -> object:
    """Returns the stand-in for a call: an empty dictionary, or a tensor of (storage, offset, shape, strides, ...)."""
    parts = cast("tuple[object, ...]", given) if isinstance(given, tuple) else None
    match what, parts:
        case _Name(text), () if text == DICTIONARY:
            return {}
        case _Name(text), (_Storage() as storage, offset, shape, strides, bool(), hooks) if text == TENSOR:
            if hooks == {} and all(map(_counts, ((offset,), shape, strides))):
                lengths, steps = cast("tuple[int, ...]", shape), cast("tuple[int, ...]", strides)
                if len(lengths) == len(steps):
                    return _Tensor(storage, cast("int", offset), lengths, steps)
        case _:
            pass
    said = what.text if isinstance(what, _Name) else "a call"
    raise NotPlainError(f"it holds {said}")


def _counts(given: object) -> bool:
    """Returns True if it is a tuple of whole numbers from 0."""
    return isinstance(given, tuple) and all(
        type(each) is int and each >= 0 for each in cast("tuple[object, ...]", given)
    )


MAX_BYTES = 256 * 2**20
Tensors = Mapping[str, Float32]


def read(data: bytes, where: str, safetensors: bool = False) -> dict[str, Float32]:
    """The tensors of a state dict in a file's bytes, as float32; InputError where it holds anything else."""
    if safetensors:
        from safetensors import SafetensorError
        from safetensors.numpy import load

        try:
            return {name: tensor.astype(np.float32) for name, tensor in load(data).items()}
        except (SafetensorError, ValueError, TypeError, KeyError) as error:
            raise InputError("not a safetensors file", f"{where}: {error}"[:200]) from None
    try:
        return state_dict(data, MAX_BYTES)
    except NotPlainError as reason:
        advice = "save it as torch.save(module.state_dict(), file), or load it yourself: `maviper guide experts`"
        raise InputError("not a file of weights alone; nothing else is loaded", f"{where}: {reason}", advice) from None


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
        torch_tensor: Any = value
        # real numbers that lie one beside the other: not sparse, complex, quantized or without data
        plain = str(getattr(value, "layout", "")) == "torch.strided"
        plain = plain and not (torch_tensor.is_complex() or torch_tensor.is_quantized or torch_tensor.is_meta)
        if not isinstance(name, str) or not plain:
            raise InputError("not a state dict of tensors", f"{where}: {str(name)[:80]}", "save module.state_dict()")
        room -= 4 * torch_tensor.numel()
        if room < 0:
            raise InputError(f"the weights are more than {MAX_BYTES} bytes", f"{where}: {name[:80]}")
        tensors[name] = torch_tensor.detach().cpu().float().numpy()
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
    layer = tensors.get(f"{name}.weight"), tensors.get(f"{name}.bias")
    if layer[0] is None or layer[1] is None or (layer[0].ndim, layer[1].ndim) != (2, 1):
        raise InputError("a layer is missing", f"{where}: {name}", "the file is damaged, or of another library")
    return Linear(layer[0], layer[1])
