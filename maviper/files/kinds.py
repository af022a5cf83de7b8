"""Which of our documents is this file? The kinds, how each is recognised, and which command takes it.

Does: recognises a document by what it says of itself, whole or damaged, of this version or another.
Assumes: the bytes of the file.
Does not: read documents or judge them; who reads one says what is wrong inside it.
"""

import re
from dataclasses import dataclass

from codegen.errors import InputError

SAFETENSORS = slice(8, 9)  # where such a file's JSON header begins, after its length
HEADER = 1 << 16  # bytes of it that are looked at


@dataclass(frozen=True)
class Kind:
    """A kind of document."""

    called: str  # in words, with an article
    taken: str  # which command takes it, in words


PROFILE = Kind("a policy profile", "`maviper show`, `evaluate`, `compile`, `verify` and `repair` take it")
EXPERT = Kind("an expert's file", "`maviper extract` and `evaluate` take it; only profiles end in .json")
TRAINING = Kind("the state of a training", "`maviper train --resume` takes its folder")
CERTIFICATE = Kind("a certificate", "`maviper check` takes it")
EPISODE_CERTIFICATE = Kind("a certificate about episodes", CERTIFICATE.taken)
COUNTEREXAMPLE = Kind("a counterexample", "`maviper replay` and `maviper extract --counterexamples` take it")
EPISODE_COUNTEREXAMPLE = Kind("a counterexample about episodes", "`maviper replay` takes it")
SYSTEM_CERTIFICATE = Kind("a certificate about a stated system", CERTIFICATE.taken)
SYSTEM_COUNTEREXAMPLE = Kind("a counterexample in a stated system", EPISODE_COUNTEREXAMPLE.taken)
WORLD = Kind("a world file", "`maviper worlds check` and `maviper verify --system` take it")
STATES = Kind("a file of states", "`maviper extract --counterexamples` takes it")
ZONES = Kind("a list of failing cells", "no command takes it; it is for you to read")
REPORT = Kind("a report", "no command takes it; it is for you to read")
DIFFERENCE = Kind("a comparison of two profiles", "no command takes it; it is for you to read")
CONFIG = Kind("the configuration of a run", "`maviper extract --resume` takes its folder")
CELL = Kind("a cell of a comparison", "`maviper compare -o` or `reproduce -o` takes the folder of all cells")
CLAIMS = Kind("a file of claims", "`maviper verify --claims` takes it")
REGION = Kind("a region file", "`--region` takes it")

NAMED = {
    "certificate": CERTIFICATE,
    "episode-certificate": EPISODE_CERTIFICATE,
    "counterexample": COUNTEREXAMPLE,
    "episode-counterexample": EPISODE_COUNTEREXAMPLE,
    "system-certificate": SYSTEM_CERTIFICATE,
    "system-counterexample": SYSTEM_COUNTEREXAMPLE,
    "system-verification": REPORT,
    "states": STATES,
    "zones": ZONES,
    "verification": REPORT,
    "difference": DIFFERENCE,
    "difference-outputs": DIFFERENCE,
    "extraction": CONFIG,
    "cell": CELL,
}
IN_HEADERS = {b'"maviper-expert-': EXPERT, b'"maviper-training-': TRAINING}
_SAYS = re.compile(rb'"(?:certificate|counterexample|states|zones|report|difference|format)"\s*:\s*"maviper-([a-z-]+)-')
_PROFILE = re.compile(rb'"schema_version"\s*:')
_WORLD = re.compile(rb"^\s*\[(?:variables|agents|dynamics)\b", re.MULTILINE)
_CLAIMS = re.compile(rb"^\s*\[\[(?:claim|property)\]\]", re.MULTILINE)
_REGION = re.compile(rb"^\s*(?:\[(?:box|difference|apart)\]|(?:default|goals)\s*=)", re.MULTILINE)


def kind_of(data: bytes) -> Kind | None:
    """The kind that the bytes of a file are of, as far as they say; None: of none of ours."""
    if not data.lstrip().startswith(b"{"):
        if data[SAFETENSORS] == b"{":
            return next((kind for says, kind in IN_HEADERS.items() if says in data[:HEADER]), None)
        if _WORLD.search(data):
            return WORLD
        return CLAIMS if _CLAIMS.search(data) else REGION if _REGION.search(data) else None
    said = _SAYS.search(data)
    if said:
        return NAMED.get(said[1].decode())
    return PROFILE if _PROFILE.search(data) else None


def ensure(data: bytes, where: str, what: str, *wanted: Kind) -> None:
    """InputError where the bytes say that they are a document of ours that is not wanted. `what`: that is, in words."""
    kind = kind_of(data)
    if kind is not None and kind not in wanted:
        raise InputError(f"{kind.called}, not {what}", where, kind.taken)
