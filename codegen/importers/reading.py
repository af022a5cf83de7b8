"""What readers of trees are told of a source, and what they hand over; the kinds of files, and who reads each.

Does: names the parts of a tree as it was read, and what a user may say of a file; recognises a file by its name and
  content, and has its reader read it.
Assumes: readers that understood all of their source.
Does not: touch files, open a pickle, or make a profile (origin.py).
"""

import gc
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, NamedTuple

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.ir import Bool, Floats, GrownTree, PolicyProfile, Sum, Update

AGENT = "agent_0"
NOT_COMPARED = "nobody: the source was not compared"  # who replayed an import, where nobody did
SUMS = 1 << 24  # from this place on, features of a grown tree are sums
MEMORY = 1 << 23  # from this place on, those that are remembered
MAX_FEATURES = 1 << 20  # of an observation
MAX_VALUES = 64  # of a regressor, beyond which they are no actions
FLOATS = "floats"  # Python's own, beside the types of arrays
SINGLES, DOUBLES = (f"any numbers, which it makes {numbers}" for numbers in (FLOAT32, FLOAT64))


def find_uncompared(profile: PolicyProfile) -> list[str]:
    """The agents whose source was compared with nothing: what read it must be right."""
    facts = profile.provenance.training
    return [policy.agent for policy in profile.agents if facts.get(f"{policy.agent} replayed by") == NOT_COMPARED]


class Kept(NamedTuple):
    """What a source gives that remembers: a label, and what becomes of its memory."""

    label: Any
    updates: tuple[Update, ...]


class Remembered(NamedTuple):
    """A whole number that a source remembers: its range, and what it begins with."""

    name: str
    low: int
    high: int
    initial: int


@dataclass(frozen=True)
class Answers:
    """The answers of a source itself to observations."""

    told: Any  # places of its own labels [n], or numbers [n, n_outputs]; with memory after each [n, 1 + n_memories]
    asked: Bool  # [n]: whether its assertions take the observation
    known: Bool  # [n]: whether the answer is a label, or as many numbers as its leaves give
    word: Callable[[int], str]  # the answer to one of them, as a person reads it
    given: str = ""  # what the source takes, in words, where that is less than its reader says


class Running(NamedTuple):
    """A source that runs: all numbers in it, and what asks it."""

    numbers: Sequence[int | float]
    ask: Callable[[Floats], Answers]  # rows [n, n_features]
    types: Sequence[str] = ()  # NumPy's, of its features one after the other; of others, what the profile compares


@dataclass(frozen=True, kw_only=True)
class Facts:
    """The facts known of a source, beside its tree."""

    kind: str  # in words, such as "if/else Python"
    replayed_by: str = "a second reading of the file"  # who decides where the tree is replayed, in words
    features: Sequence[str] = ()  # names; (): the source gives none
    n_features: int = 0  # 0: the source does not say; then as many as are tested or named
    n_read: int = 0  # features up to the last one that the source looks at, also in a test that decides nothing
    nan: bool = False  # whether a NaN is decided as in the source
    finite: bool = False  # whether the source takes finite numbers only
    numbers: str = FLOAT32  # that it compares; what is given to it becomes one of these first
    whole: tuple[tuple[int, int], ...] = ()  # the range of each feature, where all are whole; (): some are floats
    given: str = "any numbers"  # what the source is given where it decides so, in words
    keyed: bool = False  # whether it looks features up by these names, wherever they are
    notes: tuple[str, ...] = ()  # what of the source was skipped or assumed, in words
    called: Mapping[Any, str] = field(default_factory=dict[Any, str])  # what it calls some of the labels
    placed: tuple[str, ...] = ()  # the names of a profile's actions, where labels are their places
    memory: tuple[Remembered, ...] = ()  # what it remembers: the features from MEMORY on


@dataclass(frozen=True, kw_only=True)
class Origin(Facts):
    """The source of an agent's tree: its tests, its labels, and how it decides by itself."""

    grown: GrownTree  # a leaf's action is the place of its label
    labels: tuple[Any, ...]  # that its leaves return; numbers ascending
    # of a model: rows [n, n_features] -> the places of its own labels [n], or numbers [n, n_outputs]
    act: Callable[[Floats], Any] | None = None
    second: Callable[[], AbstractContextManager[Running]] | None = None  # of source code: what runs it
    takes: Callable[[Floats], Bool] | None = None  # which observations it takes, where not all finite ones
    arithmetic: str = ""  # of sums; "": there is none
    sums: tuple[Sum, ...] = ()  # the feature SUMS + k of `grown` is sums[k]
    vectors: tuple[tuple[Sum, ...], ...] = ()  # what leaves give, in place of labels
    bounds: tuple[tuple[float | None, float | None], ...] = ()  # of each output; (): there are none
    pairs: tuple[tuple[int, tuple[Update, ...]], ...] = ()  # with memory: what actions of the tree are, by label
    permits: tuple[tuple[str, ...], ...] = ()  # of each leaf, left to right: the labels that it permits; (): its own

    @property
    def n_named(self) -> int:
        """Features up to the last one that a test or a sum names."""
        single = self.grown.feature[self.grown.feature < MEMORY]
        sums = (*self.sums, *(each for vector in self.vectors for each in vector))
        return 1 + max([int(single.max(initial=-1)), *(place for each in sums for place in each.places)])


@dataclass(frozen=True)
class Said:
    """The facts that the user says of a source that does not say them itself."""

    scores: bool = False  # whether a list of numbers holds a score for each action
    wanted: str = ""  # the function that is asked for, where a file has several
    features: tuple[str, ...] = ()  # names of all features, in their order; (): not said
    arrays: str = ""  # what Python is given: floats, or arrays of float32 or float64; "": not said
    outputs: tuple[str, ...] = ()  # names of the numbers that are returned to be given; (): labels are returned
    run: bool = True  # whether source code may be run, in a process of its own, to be compared
    prefer: tuple[str, ...] = ()  # labels, the most wanted first, where a leaf permits several
    reads: tuple[str, ...] = ()  # functions whose calls are features: firmware that reads sensors
    acts: tuple[str, ...] = ()  # functions whose calls are actions, one a decision
    beside: Callable[[str], bytes | None] = lambda _: None  # the content of a file that lies beside the source


NOTHING = Said()


# --- kinds of files

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
            if (said.reads or said.acts) and kind.function != "from_c":
                what = f"calls are named, as {(*said.reads, *said.acts)[0]}(), and the file is {kind.called}"
                raise InputError(what, where, "name calls of if/else C; of other files, features and actions")
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
