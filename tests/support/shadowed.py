"""Monitors for noisy numbers under measurement: whole episodes in a closed loop with them, pushed or not.

The agents that a proof follows decide from the state that the monitor follows, as a user's program does.
"""

import ctypes
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

from maviper.compilation.monitors import noisy
from tests.support.followed import Followed
from tests.support.monitored import acting

PUSHES = (0.3, 0.03, 0.003)  # standard deviations of what is added to a velocity: seen at once, or perhaps never
PROGRAM = """
long size(void);
long size(void)
{{
    return (long)sizeof({p}_monitor);
}}
void look({p}_monitor *m, const double *w, long n, int begin, int *words, double *last);
void look({p}_monitor *m, const double *w, long n, int begin, int *words, double *last)
{{
    long i;
    int k;
    for (i = 0; i < n; i++) {{
        if (begin == 1) {{
            {p}_monitor_start(&m[i]);
        }}
        {p}_monitor_renew_all(&m[i]);
        words[i] = {p}_monitor_step(&m[i], w + i * {N}, {P}_DT);
        for (k = 0; k < {N}; k++) {{
            last[i * {N} + k] = m[i].last[k];
        }}
    }}
}}
void tell({p}_monitor *m, int *acts, long n);
void tell({p}_monitor *m, int *acts, long n)
{{
    long i;
    for (i = 0; i < n; i++) {{
        {told}
    }}
}}
"""


class Shadowed(Followed):
    """A certificate that agents arrive, and its monitor in C for numbers that are off by `noise`."""

    def __init__(self, certificate, folder, profile, noise):
        self.noise = noise
        super().__init__(certificate, folder, profile)

    def _proved(self, proved):
        return noisy(proved, self.noise)

    def _program(self, names, agents):
        told = " ".join(
            f"acts[i * {len(agents)} + {k}] = {names['p']}_monitor_{agent.lower}(&m[i], acts[i * {len(agents)} + {k}]);"
            for k, agent in enumerate(agents)
        )
        return super()._program(names, agents) + PROGRAM.format(told=told, **names)

    def flown(self, count, seed, sigma, share):
        """Episodes from random starts; all numbers are off by a normal error, and in each step this share is pushed.
        The words [episodes, steps + 1] and the true states.
        """
        rng, names = np.random.default_rng(seed), self.profile.world.coordinates()
        w = self.starts(rng, count)
        monitors = np.zeros(count * int(self._library.size()), np.uint8)
        n, words, last = ctypes.c_long(count), np.zeros(count, np.int32), np.zeros_like(w)
        scale = rng.choice(PUSHES, count)
        said, states = [], []
        for step in range(self.steps):
            seen = np.ascontiguousarray(w + sigma * rng.normal(size=w.shape))
            self._library.look(_at(monitors), _at(seen), n, int(step == 0), _at(words), _at(last))
            said.append(words.copy())
            states.append(w.copy())
            ours, theirs = acting(self.profile, last), acting(self.profile, seen)
            acts = np.column_stack(
                [
                    (ours if policy.agent in self.start.followed else theirs)[policy.agent]
                    for policy in self.profile.agents
                ]
            ).astype(np.int32)
            acts = np.ascontiguousarray(acts)
            self._library.tell(_at(monitors), _at(acts), n)
            pushed = np.where(rng.random(count) < share, scale, 0.0)
            w = self.moved(w, dict(zip(self._names, acts.T, strict=True)), pushed, rng)
        assert len(names) == w.shape[1]
        return np.stack(said, axis=1), np.stack(states, axis=1)


def _at(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def flying(certificate: Path, profile: Path, states: int, noise: float, sigma: float):
    """The figures of a claim that a team arrives, flown with noisy numbers; the claim's radius is the certificate's and
    what the noise adds to a distance.
    """
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        flown = Shadowed(certificate, Path(folder), profile, noise)
        count = -(-states // flown.steps)
        calm, w = flown.flown(count, 0, 0.0, 0.0)
        costs = flown.costs(w[:700], flown.acting(w[:700]))
        noisy_words, _ = flown.flown(count, 1, sigma, 0.0)
        words, w = flown.flown(count, 2, sigma, 1.0 / flown.steps)
        radius = flown.radius + Fraction(6) * Fraction(str(noise))
        return costs | flown.judged(words, w, float(radius)) | {
            "calm": calm.size,
            "refused": int((calm > 1).sum()),
            "false_alarms": float((noisy_words > 1).mean()),
        }  # fmt: skip
