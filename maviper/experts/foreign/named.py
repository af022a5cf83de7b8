"""What `sb3:FILE.zip` and `torch:FILE.pt,net=actor,activation=tanh,outputs=logits` mean on the command line.

Does: parts the text; reads a file of normalisation statistics.
Assumes: nothing of the files.
Does not: know how an expert is read from one.
"""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from codegen.errors import InputError, UnknownNameError
from maviper.experts.foreign.layers import LayersExpert, Normalization
from maviper.experts.foreign.sb3 import NONE, from_sb3
from maviper.experts.foreign.state_dicts import from_torch
from maviper.files import runs
from maviper.worlds import World

NORMALIZATION = "normalization"
# kind -> what reads it, options that it must have, options that it may have
KINDS: Mapping[str, tuple[Callable[..., LayersExpert], tuple[str, ...], tuple[str, ...]]] = {
    "sb3": (from_sb3, (), ("activation", NORMALIZATION)),
    "torch": (from_torch, ("net", "activation", "outputs"), (NORMALIZATION,)),
}
MAX_STATISTICS = 2**20


class Statistics(msgspec.Struct, forbid_unknown_fields=True):
    """A JSON file of normalisation statistics; the defaults are VecNormalize's."""

    mean: list[float]
    var: list[float]
    clip: float = 10.0
    epsilon: float = 1e-8


def is_file(text: str) -> bool:
    """Returns True if a text names an expert in another library's file."""
    return text.partition(":")[0] in KINDS


def from_name(text: str, world: World | None) -> LayersExpert:
    """The expert that a text names; InputError where the text or the file is wrong, or the world is not said."""
    kind, _, rest = text.partition(":")
    make, needed, optional = KINDS[kind]
    file, *choices = re.split(rf",(?=(?:{'|'.join((*needed, *optional))}|\w+)=)", rest)
    options: dict[str, Any] = {}
    for choice in choices:
        key, _, value = choice.partition("=")
        if key not in (*needed, *optional):
            raise UnknownNameError(f"option of {kind}:", key, (*needed, *optional), text)
        options[key] = value
    missing = [key for key in needed if key not in options]
    if missing:
        example = f"{kind}:{file},net=actor,activation=tanh,outputs=logits"
        raise InputError(f"the file cannot say its {', '.join(missing)}", text, f"state it: {example}")
    if world is None:
        raise InputError("the file does not say which game it plays", text, "name it: --world gymnasium:CartPole-v1")
    if options.get(NORMALIZATION, NONE) != NONE:
        options[NORMALIZATION] = statistics(Path(options[NORMALIZATION]))
    elif kind != "sb3":
        options.pop(NORMALIZATION, None)
    return make(file, world, **options)


def statistics(path: Path) -> Normalization:
    """The normalisation that a JSON file states: `mean`, `var`, and `clip` and `epsilon` where they are unusual."""
    try:
        parsed = msgspec.json.decode(runs.read(path, MAX_STATISTICS), type=Statistics)
    except msgspec.DecodeError as error:
        advice = 'write {"mean": [...], "var": [...]}, with clip and epsilon where they are not 10 and 1e-8'
        raise InputError("not a file of normalisation statistics", f"{path}: {error}"[:200], advice) from None
    return Normalization(parsed.mean, parsed.var, parsed.clip, parsed.epsilon)  # type: ignore[arg-type]
