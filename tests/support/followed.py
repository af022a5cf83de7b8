"""Monitors of claims that agents arrive, under measurement: whole episodes, pushed or not, and a judge of its own.

Episodes are arrays [episodes, steps + 1, coordinates]; what the agents do in them is [episodes, steps + 1, agents].
"""

import ctypes
import json
import tempfile
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from codegen.lowering.lower import lower
from codegen.targets import emit, rendered
from maviper import load
from maviper.compilation.monitors import load_proof, lower_monitor, noisy
from maviper.files import runs
from tests.support.monitored import OPTIMISED, WITH_CLOCK, acting
from tests.support.monitors import built, pointer
from tests.support.pushed import NOISE, PUSH, move_game
from verify.checker.certificate import MAX_BYTES

ROUNDS = 7
PUSHES = (0.3, 0.03, 0.003)  # standard deviations of what is added to a velocity: seen at once, or perhaps never
PROGRAM = """void follow(const double *w, const int *acts, long episodes, long steps, int *found, double *seconds);
void follow(const double *w, const int *acts, long episodes, long steps, int *found, double *seconds)
{{
    {p}_monitor m;
    int actions[{K}];
    int kept = 0;
    int k;
    long i;
    long t;
    double start = now();
    for (i = 0; i < episodes * steps; i++) {{
        {p}_act_team(w + i * {N}, actions);
        for (k = 0; k < {K}; k++) {{
            kept += actions[k];
        }}
    }}
    seconds[0] = now() - start;
    found[0] = kept; /* so that nothing is left out */
    start = now();
    for (i = 0; i < episodes; i++) {{
        {p}_monitor_start(&m);
        for (t = 0; t < steps; t++) {{
            const long at = i * steps + t;
            {p}_monitor_renew_all(&m);
            found[at] = {p}_monitor_step(&m, w + at * {N}, {P}_DT);
            {calls}
        }}
    }}
    seconds[1] = now() - start;
}}
"""
# with noisy numbers, in a closed loop: agents that a proof follows decide from the state that the monitor follows
FLYING = """
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


class Followed:
    """A certificate that agents arrive, and its monitor in C, for numbers that are off by `noise`."""

    def __init__(self, certificate, folder, profile=None, noise=None):
        self.profile = load(profile or certificate.parent / "profile.json")
        proved: Any = load_proof(certificate, self.profile)
        proved = noisy(proved, noise) if noise else proved
        stated = json.loads(runs.read_unpacked(certificate, MAX_BYTES))
        self.team, self.radius = stated["team"], Fraction(stated["radius"])
        self.start, self.steps = proved.region, proved.region.steps + 1
        model = lower(self.profile)
        watched = lower_monitor(self.profile, model, proved)
        p, agents = model.prefix, model.agents
        calls = " ".join(
            f"(void){p}_monitor_{agent.lower}(&m, acts[at * {len(agents)} + {k}]);" for k, agent in enumerate(agents)
        )
        names = {"p": p, "P": p.upper(), "N": watched.size, "K": len(agents), "calls": calls}
        texts = {**emit(self.profile, ["c"]), **rendered.emit_monitors(watched, ["c"])}
        told = " ".join(
            f"acts[i * {len(agents)} + {k}] = {p}_monitor_{agent.lower}(&m[i], acts[i * {len(agents)} + {k}]);"
            for k, agent in enumerate(agents)
        )
        texts["run.c"] = (WITH_CLOCK + PROGRAM + FLYING).format(told=told, **names)
        self._library = built(folder, texts, OPTIMISED)
        self._names = [policy.agent for policy in self.profile.agents]
        self._at = {name: place for place, name in enumerate(self.profile.world.coordinates())}

    def words(self, w, acts):
        """The words of whole episodes, and the seconds of their decisions and of the monitor."""
        w, acts = np.ascontiguousarray(w), np.ascontiguousarray(acts, np.int32)
        found, seconds = np.zeros(w.shape[:2], np.int32), np.zeros(2)
        sizes = [ctypes.c_long(size) for size in w.shape[:2]]
        self._library.follow(pointer(w), pointer(acts), *sizes, pointer(found), pointer(seconds))
        return found, seconds

    def costs(self, w, acts):
        """Processor time of a step of the monitor beside that of the decisions, the least of rounds in turn."""
        seconds = np.min([self.words(w, acts)[1] for _ in range(ROUNDS)], axis=0)
        decision, step = (1e9 * seconds / (w.shape[0] * w.shape[1])).tolist()
        return {"ratio": step / decision, "decision_ns": decision, "step_ns": step}

    def acting(self, w):
        """What agents do in states [episodes, steps, coordinates]."""
        acted = [acting(self.profile, np.ascontiguousarray(w[:, step])) for step in range(w.shape[1])]
        return np.stack([np.column_stack([each[name] for name in self._names]) for each in acted], axis=1)

    def starts(self, rng, count):
        w = np.zeros((count, len(self._at)))
        for name, (low, high) in self.start.region.box.items():
            w[:, self._at[name]] = rng.uniform(float(Fraction(low)), float(Fraction(high)), count)
        goals = self.profile.world.goals
        goal = rng.integers(len(goals), size=count)
        for axis in "xy":
            w[:, self._at[f"goal.{axis}"]] = np.choose(goal, [w[:, self._at[f"{name}.{axis}"]] for name in goals])
        return w

    def moved(self, w, acted, pushed, rng):
        """The states one step on; `pushed`: the standard deviation of what is added to velocities, by episode."""
        return move_game(self.profile, w, acted, pushed * rng.normal(size=(len(acted), 2, len(w))))

    def played(self, count, seed, share):
        """Episodes from random starts of the proof; in each step after the first, this share of them is pushed."""
        rng = np.random.default_rng(seed)
        w = self.starts(rng, count)
        states, acts = np.empty((count, self.steps, w.shape[1])), []
        for step in range(self.steps):
            states[:, step] = w
            acted = acting(self.profile, w)
            acts.append(np.column_stack([acted[name] for name in self._names]))
            w = self.moved(w, acted, np.where(rng.random(count) < share, PUSH, 0.0), rng)
        return states, np.stack(acts, axis=1)

    def flown(self, count, seed, sigma, share):
        """Episodes in a closed loop from random starts; all numbers are off by a normal error, and in each step this
        share is pushed. The words [episodes, steps + 1] and the true states.
        """
        rng = np.random.default_rng(seed)
        w = self.starts(rng, count)
        monitors = np.zeros(count * int(self._library.size()), np.uint8)
        n, words, last = ctypes.c_long(count), np.zeros(count, np.int32), np.zeros_like(w)
        scale = rng.choice(PUSHES, count)
        said, states = [], []
        for step in range(self.steps):
            seen = np.ascontiguousarray(w + sigma * rng.normal(size=w.shape))
            self._library.look(pointer(monitors), pointer(seen), n, int(step == 0), pointer(words), pointer(last))
            said.append(words.copy())
            states.append(w.copy())
            ours, theirs = acting(self.profile, last), acting(self.profile, seen)
            chosen = [(ours if name in self.start.followed else theirs)[name] for name in self._names]
            acts = np.ascontiguousarray(np.column_stack(chosen), np.int32)
            self._library.tell(pointer(monitors), pointer(acts), n)
            pushed = np.where(rng.random(count) < share, scale, 0.0)
            w = self.moved(w, dict(zip(self._names, acts.T, strict=True)), pushed, rng)
        return np.stack(said, axis=1), np.stack(states, axis=1)

    def fails(self, states, radius):
        """In which episodes no matching has each agent of the team come to a landmark of its own."""
        at, marks = self._at, self.profile.world.landmarks
        names = [policy.agent for policy in self.profile.team(self.team)]

        def gap(one, other):
            return np.abs(states[:, :, at[one]] - states[:, :, at[other]])

        arrived = {
            (agent, mark.name): np.logical_and(
                *(gap(f"{agent}.{axis}", f"{mark.name}.{axis}") <= radius for axis in "xy")
            )
            for agent in names
            for mark in marks
        }
        arrived = {pair: there.any(axis=1) for pair, there in arrived.items()}
        ways = permutations([mark.name for mark in marks], len(names))
        return ~np.logical_or.reduce(
            [np.logical_and.reduce([arrived[pair] for pair in zip(names, way, strict=True)]) for way in ways]
        )

    def judged(self, words, w, radius):
        """What perturbed episodes show. A claim that a team arrives breaks at the last step: the warning is how many
        steps before it the monitor stops to vouch, of episodes that break it.
        """
        failing, vouched = self.fails(w, radius), (words <= 1).all(axis=1)
        lost = failing & ~vouched
        marks = [place for name, place in self._at.items() if name.startswith("landmark")]
        others = w.copy()
        others[:, :, marks] = np.roll(w, 1, axis=0)[:, :, marks]  # the landmarks of another episode
        return {
            "states": words.size,
            "vouched": float((words <= 1).mean()),
            "fails_while_vouched": int((failing & vouched).sum()),
            "fails_elsewhere": int(lost.sum()),
            "control_fails": int((self.fails(others, radius) & vouched).sum()),
            "warning": float((self.steps - 1 - (words[lost] > 1).argmax(axis=1)).mean()) if lost.any() else np.nan,
        }


def arriving(certificate: Path, states: int):
    """The figures of a claim that a team arrives."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        followed = Followed(certificate, Path(folder))
        count = -(-states // followed.steps)
        w, acts = followed.played(count, 0, 0.0)
        calm, _ = followed.words(w, acts)
        found = followed.costs(w[:700], acts[:700])
        seen, rng = w.copy(), np.random.default_rng(1)
        side = followed.profile.world.start_high - followed.profile.world.start_low
        seen[:, :, 0] += rng.normal(scale=NOISE * side, size=seen.shape[:2])
        noisy, _ = followed.words(seen, acts)
        w, acts = followed.played(count, 2, 1.0 / followed.steps)
        words, _ = followed.words(w, acts)
        return found | followed.judged(words, w, float(followed.radius)) | {
            "calm": calm.size,
            "refused": int((calm > 1).sum()),
            "false_alarms": float((noisy[:, 1:] > 1).mean()),
        }  # fmt: skip


def flying(certificate: Path, profile: Path, states: int, noise: float, sigma: float):
    """The figures of a claim that a team arrives, flown with noisy numbers; the claim's radius is the certificate's and
    what the noise adds to a distance.
    """
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        flown = Followed(certificate, Path(folder), profile, noise)
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
