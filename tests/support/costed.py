"""What monitors cost: for each kind of claim the states that are timed, and a function that times them.

Does: compiles a monitor once, and keeps its states, so that many monitors can be timed in turn.
Assumes: a C compiler; `kept` closes what was compiled.
Does not: judge words.
"""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from maviper import load
from maviper.compilation.monitors import load_proof
from maviper.worlds.stated.certified import read_certificate
from tests.support.monitored import compiled
from tests.support.pushed import STEPS, Watching, episodes, unperturbed

COSTED = 140_000  # states whose decisions are timed, each once
CALM = 5_000  # episodes of a stated system, of whose states these are some


def cost_following(followed: Any) -> Callable[[], dict[str, float]]:
    """Asks what the monitor of a claim that a team arrives costs."""
    w, _ = followed.played(700, 0, 0.0)
    acts = followed.acting(w)
    return lambda: followed.costs(w, acts)


def cost_game(kept: ExitStack, certificate: Path, profile_file: Path) -> Callable[[], dict[str, float]]:
    """Asks what the monitor of a claim about states of a game costs."""
    profile = load(profile_file)
    proved: Any = load_proof(certificate, profile)
    made = kept.enter_context(compiled(profile, proved))
    box = proved.region.box if proved.stated else None
    w = episodes(profile, -(-COSTED // STEPS), 0, box).reshape(-1, len(profile.world.coordinates()))[:COSTED]
    return lambda: made.costs(w, np.zeros(len(w), np.int32))


def cost_system(kept: ExitStack, certificate: Path, beside: str) -> Callable[[], dict[str, float]]:
    """Asks what the monitor of a claim about a stated system costs."""
    profile = load(certificate.parent / beside)
    proved = load_proof(certificate, profile)
    made = kept.enter_context(compiled(profile, proved, read_certificate(certificate)[1].system))
    watching = Watching(certificate, made, proved, profile)
    return cost_watched(watching, [watching.measured(w) for w in unperturbed(watching, CALM)[0]])


def cost_watched(watching: Watching, calm: Sequence[Any]) -> Callable[[], dict[str, float]]:
    """Asks what a monitor costs over states by step: these mixed, and as they come in flight."""
    whole = np.concatenate(calm)
    at = np.concatenate([np.full(len(w), 0 if watching.cover.ever else step) for step, w in enumerate(calm)])
    order = np.random.default_rng(3).permutation(len(at))[:COSTED]
    flown = np.arange(len(at)).reshape(len(calm), -1).T.ravel()[:COSTED]  # episode by episode

    def ask() -> dict[str, float]:
        in_flight = watching.made.costs(whole[flown], at[flown])["ratio_called"]
        return watching.made.costs(whole[order], at[order]) | {"ratio_flown": in_flight}

    return ask
