"""Monitors of claims for ever about games under measurement: pushed states, and what follows from each.

Does: plays games in numpy from every state that a monitor vouches for, some steps on, and looks where agents are.
Assumes: a certificate that a team stays within a radius for ever, by edges.
Does not: share code with the proof, or with the monitor.
"""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from maviper import load
from maviper.compilation.monitors import load_proof
from tests.support.monitored import acting, compiled
from tests.support.pushed import NOISE, STEPS, episodes, move_game

AHEAD = 20  # steps that are played from a state
SOME = 10  # one of so many states, from which that is done; from all others one step


def lasting(certificate: Path, profile_file: Path, states: int, costed: int) -> dict[str, Any]:
    """The figures of a claim that a team stays within a radius for ever."""
    profile = load(profile_file)
    proved, stated = load_proof(certificate, profile), json.loads(certificate.read_text())
    names, side = profile.world.coordinates(), profile.world.start_high - profile.world.start_low
    places = [names.index(f"{each.agent}.{axis}") for each in profile.team(stated["team"]) for axis in "xy"]

    radius = float(Fraction(stated["radius"]))

    def is_out(w: Any) -> Any:
        return (np.abs(w[:, places]) > radius).any(axis=1)

    def leaves(w: Any, shift: int) -> Any:
        """From which states a team leaves in some steps whose trees take other actions, by so many places."""
        out = is_out(w)
        for _ in range(AHEAD):
            acted = {
                name: (each + shift) % len(profile.policy(name).actions) for name, each in acting(profile, w).items()
            }
            w = move_game(profile, w, acted)
            out |= is_out(w)
        return out

    with compiled(profile, proved) as made:

        def vouched(w: Any) -> Any:
            return made.words(w, np.zeros(len(w), np.int32)) <= 1

        w = episodes(profile, -(-states // STEPS), 0).reshape(-1, len(names))[:states]
        held = vouched(w)
        kept = w[held]
        after = move_game(profile, kept, acting(profile, kept))
        fails = is_out(kept) | is_out(after)
        fails[::SOME] |= leaves(kept[::SOME], 0)
        calm = episodes(profile, -(-states // STEPS // 10), 2, push=0.0).reshape(-1, len(names))
        noisy = kept.copy()
        noisy[:, places] += np.random.default_rng(1).normal(scale=NOISE * side, size=(len(kept), len(places)))
        return made.costs(w[:costed], np.zeros(costed, np.int32)) | {
            "states": len(w),
            "vouched": float(held.mean()),
            "fails_while_vouched": int(fails.sum()),
            "lost": int((~vouched(after)).sum()),
            "fails_elsewhere": int(is_out(w[~held]).sum()),
            "control_fails": max(int(leaves(kept[::SOME], shift).sum()) for shift in range(1, 5)),
            "calm": len(calm),
            "refused": int((~vouched(calm)).sum()),
            "false_alarms": float((~vouched(noisy)).mean()),
            "warning": np.nan,
        }
