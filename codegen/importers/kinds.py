"""The kinds of files that trees of others come in, how each is recognised, and who reads it.

Does: names the kinds, and reads the trees of a file of any of them.
Assumes: the bytes of a file, and its name.
Does not: touch files, or open a pickle.
"""

import re
from collections.abc import Callable
from typing import NamedTuple

from codegen.errors import InputError
from codegen.importers import boosted, documents
from codegen.importers.c import header
from codegen.importers.c import source as c
from codegen.importers.c.plain import ENDINGS
from codegen.importers.onnx import model as onnx
from codegen.importers.origin import AGENT, NOTHING, Origin, Said
from codegen.importers.python import source as python

PICKLES = (".pkl", ".pickle", ".joblib", ".sav", ".skops")
BINARY = re.compile(rb"\{L.{8}learner|binf", re.DOTALL)  # how XGBoost's UBJSON begins, and its form before that
MAX_BYTES = 256 * 2**20


class Kind(NamedTuple):
    """A kind of file."""

    called: str
    endings: tuple[str, ...]  # of file names
    says: re.Pattern[bytes] | None  # what tells it apart from others of these endings; None: nothing needs to
    read: Callable[[bytes, str, Said], dict[str, Origin]]  # content and name -> tree by name


def _onnx(content: bytes, where: str, said: Said) -> dict[str, Origin]:
    return {AGENT: onnx.origin_of(content)}


def _alone(read: Callable[[bytes, str], dict[str, Origin]]) -> Callable[[bytes, str, Said], dict[str, Origin]]:
    """A reader of files that say everything themselves."""
    return lambda content, where, said: read(content, where)


KINDS = (
    Kind(python.KIND, (".py",), None, python.from_python),
    Kind(onnx.KIND, (".onnx",), None, _onnx),
    Kind(header.KIND, (".h",), re.compile(rb"^#define \w+_PROFILE \"", re.MULTILINE), _alone(header.from_header)),
    Kind(c.KIND, (".c", *ENDINGS), None, c.from_c),
    Kind(boosted.XGBOOST, (".json",), re.compile(rb'"gradient_booster"\s*:'), _alone(boosted.from_xgboost)),
    Kind(documents.TREELITE, (".json",), re.compile(rb'"leaf_vector_shape"\s*:'), _alone(documents.from_treelite)),
    Kind(documents.DTCONTROL, (".json",), re.compile(rb'"actual_label"\s*:'), documents.from_dtcontrol),
    Kind(boosted.LIGHTGBM, (".txt",), re.compile(rb"\Atree\r?\nversion="), _alone(boosted.from_lightgbm)),
)


def read(content: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The trees in a file, by the names of its functions; one without a name is agent_0. InputError for every other
    file.
    """
    if content[:1] == b"\x80" or where.lower().endswith(PICKLES):
        advice = "load it yourself, then call maviper.from_sklearn; or convert it to ONNX"
        raise InputError("the file is a pickle, which runs code when it is opened", where, advice)
    if BINARY.match(content):
        advice = 'write it as JSON: booster.save_model("model.json"), for classifiers and regressors as well'
        raise InputError("the file is a booster of XGBoost in binary form", where, advice)
    for kind in KINDS:
        if where.lower().endswith(kind.endings) and (kind.says is None or kind.says.search(content)):
            return kind.read(content, where, said)
    known = ", ".join(f"{kind.called} ({' '.join(kind.endings)})" for kind in KINDS)
    raise InputError("not a file that trees can be read from", where, f"known: {known}")
