"""The kinds of files that trees of others come in, how each is recognised, and who reads it.

Does: names the kinds, and reads the trees of a file of any of them.
Assumes: the bytes of a file, and its name.
Does not: touch files, or open a pickle.
"""

import gc
import re
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from codegen.errors import InputError
from codegen.importers.reading import AGENT, NOTHING, Origin, Said

PICKLES = (".pkl", ".pickle", ".joblib", ".sav", ".skops")
BINARY = re.compile(rb"\{L.{8}learner|binf", re.DOTALL)  # how XGBoost's UBJSON begins, and its form before that
SAVE = 'save what is read instead: booster.save_model("model.json")'
FITTED = "give the fitted model itself: maviper.from_sklearn, or to_onnx of skl2onnx"
PICTURES = (  # forms that round numbers or leave the objective out: how each begins, what it is, what to save instead
    (re.compile(rb"\s*booster\[0\]|\s*\[\s*\{\s*\"nodeid\""), "a dump of XGBoost, without its objective", SAVE),
    (re.compile(rb"\s*\|--- "), "scikit-learn's export_text, whose numbers are rounded", FITTED),
    (re.compile(rb"\s*(strict )?(di)?graph\b"), "a drawing in dot, whose numbers are rounded", f"{FITTED}; {SAVE}"),
    (re.compile(rb"\s*<\?xml(?s:.{,4096})<PMML|\s*<PMML"), "PMML", f"{FITTED}; {SAVE}"),
)
MAX_BYTES = 256 * 2**20


class Kind(NamedTuple):
    """A kind of file."""

    called: str
    endings: tuple[str, ...]  # of file names
    says: re.Pattern[bytes] | None  # what tells it apart from others of these endings; None: nothing needs to
    module: str  # of this package, which is imported where such a file comes
    function: str  # of the module
    takes: int = 2  # how many it is given of content, name, and what the user says


KINDS = (
    Kind("if/else Python", (".py",), None, "python.source", "from_python", 3),
    Kind("ONNX", (".onnx",), None, "onnx.model", "origin_of", 1),
    Kind("our own C header", (".h",), re.compile(rb"^#define \w+_PROFILE \"", re.MULTILINE), "c.header", "from_header"),
    Kind("if/else C", (".c", ".ino", ".cpp", ".hpp", ".cc", ".h"), None, "c.source", "from_c", 3),
    Kind("XGBoost", (".json",), re.compile(rb'"gradient_booster"\s*:'), "boosted", "from_xgboost"),
    Kind("treelite", (".json",), re.compile(rb'"leaf_vector_shape"\s*:'), "boosted", "from_treelite"),
    Kind("dtControl", (".json",), re.compile(rb'"actual_label"\s*:'), "nodes", "from_dtcontrol", 3),
    Kind("LightGBM", (".txt",), re.compile(rb"\Atree\r?\nversion="), "boosted", "from_lightgbm"),
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
    for says, what, advice in PICTURES:
        if says.match(content) and not where.lower().endswith(".py"):
            raise InputError(f"the file is {what}", where, advice)
    for kind in KINDS:
        if where.lower().endswith(kind.endings) and (kind.says is None or kind.says.search(content)):
            reader = getattr(import_module(f"codegen.importers.{kind.module}"), kind.function)
            origins = _call(reader, *(content, where, said)[: kind.takes])
            return {AGENT: origins} if isinstance(origins, Origin) else origins
    known = ", ".join(f"{kind.called} ({' '.join(kind.endings)})" for kind in KINDS)
    raise InputError("not a file that trees can be read from", where, f"known: {known}")


def _call(reader: Callable[..., Any], *given: Any) -> Any:
    """What a reader returns. Syntax trees are large, and nothing of them is garbage before the reader returns."""
    collects = gc.isenabled()
    gc.disable()
    try:
        return reader(*given)
    finally:
        if collects:
            gc.enable()


# CPython has calls in chunks of 16 kB, and gets the next one from the system each time that a call needs it: readers go
# up and down at such a place thousands of times. The chunk of one large call has room for all within it.
_call.__code__ = _call.__code__.replace(co_stacksize=(1 << 16) + 1)
