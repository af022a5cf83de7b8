"""State dicts in torch's archives, read without torch: the same numbers as torch's, and nothing in them is run."""

import io
import sys
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.experts.foreign import weights
from maviper.experts.foreign.weights import NotPlainError, state_dict

MOST = 2**20
NUMBERS = np.arange(12, dtype="<f4")


def text(value):
    return b"X" + len(value).to_bytes(4, "little") + value.encode()


def number(value):
    return b"\x8a\x09" + value.to_bytes(9, "little", signed=True)


def tuple_of(*parts):
    return b"(" + b"".join(parts) + b"t"


def name(value):
    return b"c" + value.replace(" ", "\n").encode() + b"\n"


EMPTY = name("collections OrderedDict") + b")R"


def tensor(shape=(3, 4), strides=(4, 1), offset=0, kind="torch FloatStorage", file="0", count=12, device="cpu"):
    """The instructions that make a tensor."""
    storage = tuple_of(text("storage"), name(kind), text(file), text(device), number(count)) + b"Q"
    places = [tuple_of(*map(number, each)) for each in (shape, strides)]
    return name("torch._utils _rebuild_tensor_v2") + tuple_of(storage, number(offset), *places, b"\x89", EMPTY) + b"R"


def index(**tensors):
    entries = b"".join(text(key.replace("__", ".")) + value for key, value in tensors.items())
    return b"\x80\x02" + EMPTY + b"(" + entries + b"u."


def archive(program, numbers=NUMBERS, how=zipfile.ZIP_STORED, **more):
    """A file as torch.save writes it."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", how) as file:
        file.writestr("archive/data.pkl", program)
        file.writestr("archive/data/0", numbers.tobytes())
        for place, held in {"version": b"3\n", "byteorder": b"little", **more}.items():
            file.writestr(f"archive/{place}", held)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, NUMBERS.reshape(3, 4)),
        ({"shape": (4, 3), "strides": (1, 4)}, NUMBERS.reshape(3, 4).T),
        ({"shape": (2,), "strides": (5,), "offset": 6}, NUMBERS[[6, 11]]),
        ({"shape": (), "strides": (), "offset": 11}, NUMBERS[11]),
        ({"shape": (2, 2), "strides": (0, 0), "offset": 3}, np.full((2, 2), 3)),
        ({"shape": (0, 7), "strides": (7, 1)}, np.zeros((0, 7))),
        ({"shape": (1, 2), "strides": (2**60, 1)}, NUMBERS[None, :2]),
    ],
)
def test_views_of_storages_are_read_as_torch_has_them(given, expected):
    found = state_dict(archive(index(net__0__weight=tensor(**given))), MOST)
    assert list(found) == ["net.0.weight"] and found["net.0.weight"].dtype == np.float32
    assert np.array_equal(found["net.0.weight"], expected) and found["net.0.weight"].shape == expected.shape


def test_doubles_and_whole_numbers_become_float32():
    for kind, numbers in (("Double", NUMBERS / 3), ("Half", NUMBERS / 7), ("Long", NUMBERS), ("Byte", NUMBERS)):
        given = numbers.astype({"Double": "<f8", "Half": "<f2", "Long": "<i8", "Byte": "|u1"}[kind])
        found = state_dict(archive(index(a=tensor(kind=f"torch {kind}Storage")), given), MOST)["a"]
        assert np.array_equal(found, given.astype(np.float32).reshape(3, 4))


@pytest.mark.parametrize(
    ("program", "said"),
    [
        (index(a=tensor(offset=1)), "reaches out"),
        (index(a=tensor(strides=(5, 1))), "reaches out"),
        (index(a=tensor(offset=-1)), "_rebuild_tensor_v2"),
        (index(a=tensor(strides=(-4, 1))), "_rebuild_tensor_v2"),
        (index(a=tensor(strides=(1,))), "_rebuild_tensor_v2"),
        (index(a=tensor(shape=(2**40, 2**30), strides=(0, 0))), "more than"),
        (index(a=tensor(shape=(0, 2**70), strides=(1, 1))), "."),
        (index(a=tensor(shape=(1,) * 70, strides=(1,) * 70)), "."),
        (index(a=tensor(count=2**62)), "holds 48 bytes"),
        (index(a=tensor(count=-3)), "holds 48 bytes"),
        (index(a=tensor(file="1")), "archive/data/1"),
        (index(a=tensor(file="../0")), "only torch reads"),
        (index(a=tensor(kind="torch ComplexFloatStorage")), "only torch reads"),
        (index(a=tensor(kind="os system")), "only torch reads"),
        (index(a=name("posix system") + b"(" + text("true") + b"tR"), "it holds posix system"),
        (index(a=name("posix system")), "a is no tensor"),
        (index(a=text("numbers")), "a is no tensor"),
        (index(a=b"}"), "a is no tensor"),
        (b"\x80\x02" + EMPTY + b"(" + number(1) + tensor() + b"u.", "no text"),
        (b"\x80\x02" + EMPTY + b"(" + text("a") + b"u.", "."),
        (b"\x80\x02" + tensor() + b".", "no state dict"),
        (b"\x80\x02" + EMPTY + b".", "no tensors"),
        (b"\x80\x02" + EMPTY + EMPTY + b".", "no tensors"),
        (b"\x80\x02(ios\nsystem\n.", "INST"),
        (b"\x80\x02h\x07.", "."),
        (b"\x80\x02b.", "."),
        (b"\x80\x04\x8c\x02os\x8c\x06system\x93.", "protocol 4"),
        (b"cos\nsystem\n(S'true'\ntR.", "STRING"),
        (b"", "."),
    ],
)
def test_forged_indexes_are_refused(program, said):
    with pytest.raises(NotPlainError, match=said):
        state_dict(archive(program), MOST)


def test_forged_archives_are_refused():
    whole = index(a=tensor())
    twice = io.BytesIO(archive(whole))
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(twice, "a") as file:
        file.writestr("archive/data/0", bytes(48))
    forged = [
        (archive(whole, byteorder=b"big"), "another order"),
        (twice.getvalue(), "twice"),
        (archive(whole, how=zipfile.ZIP_LZMA), "unknown way"),
        (archive(whole, np.zeros(MOST, "<f4"), zipfile.ZIP_DEFLATED), "larger than"),
        (archive(whole)[:-30], "zip"),
        (b"no zip", "zip"),
        (archive(whole).replace(NUMBERS.tobytes(), bytes(48)), "CRC"),
    ]
    for data, said in forged:
        with pytest.raises(NotPlainError, match=said):
            state_dict(data, MOST)


def changes(program):
    """An index with each byte changed in three ways, and cut off at each byte."""
    for place, byte in enumerate(program):
        yield program[:place]
        yield from (program[:place] + bytes([other]) + program[place + 1 :] for other in (byte ^ 1, byte ^ 128, 0x52))


def test_any_byte_may_be_wrong():
    accepted = 0
    for program in changes(index(a=tensor())):
        try:
            found = state_dict(archive(program), MOST)
        except NotPlainError:
            continue
        accepted += 1
        assert all(isinstance(key, str) and value.dtype == np.float32 for key, value in found.items())
    assert accepted  # a letter of a name, say


@pytest.mark.train
def test_what_is_accepted_with_a_wrong_byte_is_what_torch_reads():
    pytest.importorskip("torch")
    for program in changes(index(a=tensor())):
        data = archive(program)
        try:
            found = state_dict(data, MOST)
        except NotPlainError:
            continue
        assert_as_torch(found, data)


def assert_as_torch(found, data):
    import torch

    theirs = torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    assert list(found) == list(theirs)
    for key, value in theirs.items():
        assert np.array_equal(found[key], value.detach().float().numpy()) and found[key].shape == tuple(value.shape)


@pytest.mark.train
def test_state_dicts_of_torch_are_read_as_torch_reads_them():
    torch = pytest.importorskip("torch")
    torch.manual_seed(4)
    parts = torch.nn.Linear(5, 3), torch.nn.BatchNorm1d(3), torch.nn.LSTM(3, 2)
    whole = torch.randn(6, 4)
    extra = {"row": whole[2], "column": whole[:, 1], "turned": whole.T, "one": torch.tensor(3), "none": whole[:0]}
    odd = {"double": whole.double() * 1e300, "half": whole.half(), "whole": whole.long(), "same": whole}
    for given in (torch.nn.Sequential(*parts).state_dict(), extra | odd, dict(torch.nn.Linear(1, 1).state_dict())):
        buffer = io.BytesIO()
        torch.save(given, buffer)
        assert_as_torch(state_dict(buffer.getvalue(), MOST), buffer.getvalue())


def test_torch_is_never_asked(monkeypatch):
    asked = SimpleNamespace(load=lambda *_, **__: pytest.fail("a file is handed to torch"))
    monkeypatch.setitem(sys.modules, "torch", asked)
    assert np.array_equal(weights.read(archive(index(a=tensor())), "a.pt")["a"], NUMBERS.reshape(3, 4))
    for data, said in ((archive(index(a=text("numbers"))), "a is no tensor"), (b"torch 1.5", "File is not a zip file")):
        with pytest.raises(InputError) as caught:
            weights.read(data, "a.pt")
        what, where, _ = str(caught.value).splitlines()
        assert "weights alone" in what and where.strip() == f"a.pt: {said}"
