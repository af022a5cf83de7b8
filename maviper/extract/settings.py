"""What an extraction is asked for.

Does: the settings of every algorithm, their presets and the limits they must keep.
Assumes: presets change defaults; whatever a user says goes on top.
Does not: know how an algorithm works.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from codegen import ir
from codegen.errors import InputError, UnknownNameError

MAVIPER, IVIPER, VIPER, IMITATION, FITTED_Q = "maviper", "iviper", "viper", "imitation", "fitted-q"
NO_PREDICTION, IVIPER_RESAMPLING = "maviper-no-prediction", "maviper-iviper-resampling"
ALGORITHMS = (MAVIPER, IVIPER, VIPER, IMITATION, FITTED_Q, NO_PREDICTION, IVIPER_RESAMPLING)
EXACT, HISTOGRAM = "exact", "histogram"
SPLITS = (EXACT, HISTOGRAM)
PAPER, DEFAULT = "paper", "default"
PRESETS: dict[str, dict[str, Any]] = {PAPER: {"splits": EXACT}, DEFAULT: {"splits": HISTOGRAM}}
MOST = 1_000_000  # of anything that is counted
EPISODES_PER_SEED = 100_000  # the episode seeds of two extraction seeds do not meet
# What the paper's protocol changes for an algorithm, in both presets; imitation adds 5,000 samples an iteration.
PROTOCOL: dict[str, dict[str, Any]] = {
    IVIPER: {"iterations": 50},
    VIPER: {"iterations": 50},
    IMITATION: {"iterations": 20, "rollouts": 200, "patience": 20},
    FITTED_Q: {"iterations": 10, "rollouts": 1_200, "patience": 10},
}


@dataclass(frozen=True)
class Settings:
    """Settings of an extraction; the defaults are the paper's for physical deception."""

    algorithm: str = MAVIPER
    preset: str = PAPER
    splits: str = EXACT  # how a split is searched: every threshold, or the bins of a histogram
    max_depth: int = 4
    iterations: int = 100
    rollouts: int = 50  # episodes an iteration
    max_samples: int = 300_000
    selection_episodes: int = 100  # per candidate and team
    patience: int = 10  # stop after so many iterations without a gain above the interval
    agent: str = ""  # VIPER's: the one agent that becomes a tree
    seed: int = 0

    @staticmethod
    def of(given: Mapping[str, Any]) -> "Settings":
        """Settings from what a user said; the rest is the algorithm's and the preset's."""
        algorithm, preset = given.get("algorithm", MAVIPER), given.get("preset", DEFAULT)
        if algorithm not in ALGORITHMS:
            raise UnknownNameError("algorithm", algorithm, ALGORITHMS, "--algorithm")
        if preset not in PRESETS:
            raise UnknownNameError("preset", preset, PRESETS, "--preset")
        said = {name: value for name, value in given.items() if value is not None}
        return Settings(**{"preset": preset, **PRESETS[preset], **PROTOCOL.get(algorithm, {}), **said}).checked()

    def checked(self) -> "Settings":
        """The settings themselves; InputError or UnknownNameError when one cannot be used."""
        for kind, value, known in (
            ("algorithm", self.algorithm, ALGORITHMS),
            ("preset", self.preset, PRESETS),
            ("splits", self.splits, SPLITS),
        ):
            if value not in known:
                raise UnknownNameError(kind, value, known, f"--{kind}")
        for name in ("max_depth", "iterations", "rollouts", "max_samples", "selection_episodes", "patience"):
            if not 1 <= getattr(self, name) <= MOST:
                where = f"--{name.replace('_', '-')}"
                raise InputError(f"{name} must be at least 1 and at most {MOST}, not {getattr(self, name)}", where)
        if self.max_depth > ir.MAX_DEPTH:
            raise InputError(f"max_depth must be at most {ir.MAX_DEPTH}", "--max-depth")
        if not 0 <= self.seed < 2**32:
            raise InputError("the seed must be from 0 to 4294967295", "--seed")
        if max(self.iterations * self.rollouts, self.selection_episodes) > EPISODES_PER_SEED:
            where = "--iterations times --rollouts, --selection-episodes"
            raise InputError(f"more than {EPISODES_PER_SEED} episodes in all", where)
        return self
