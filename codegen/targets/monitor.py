"""Monitors: beside the code of a profile, whether a world state is one for which a claim is proved.

Does: emits PREFIX_monitor.h, .py and .mjs, one for each language that is asked for.
Assumes: a lowered monitor; for C, PREFIX.h beside it.
Does not: use heap, recursion or mutable globals; read a certificate.
"""

from collections.abc import Iterable

from codegen.lowering.render import render
from codegen.lowering.watching import WORDS, Watch

LANGUAGES = {"c": "h", "python": "py", "javascript": "mjs"}  # target -> the ending of its file


def emit(watch: Watch, targets: Iterable[str]) -> dict[str, str]:
    """The files, name -> text; targets that have no monitor get none."""
    return {
        f"{watch.model.prefix}_monitor.{ending}": render(
            f"monitor/monitor.{ending}.j2", watch=watch, check=watch.check, model=watch.model, words=WORDS
        )
        for target, ending in LANGUAGES.items()
        if target in targets
    }
