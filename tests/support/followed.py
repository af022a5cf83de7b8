"""Monitors of claims that agents arrive, under measurement: whole episodes, pushed or not, and a judge of its own.

Episodes are arrays [episodes, steps + 1, coordinates]; what the agents do in them is [episodes, steps + 1, agents].
"""

import ctypes
import json
import subprocess
import tempfile
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.lowering.lower import lower
from codegen.targets import emit, monitor
from maviper import load
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.files import runs
from tests.support.monitored import WITH_CLOCK, acting
from verify.checker.certificate import MAX_BYTES

NOISE = 1e-3  # of the side of the region
PUSH = 0.3  # standard deviation of what is added to a velocity
ROUNDS = 7
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


class Followed:
    """A certificate that agents arrive, and its monitor in C."""

    def __init__(self, certificate, folder, profile=None):
        self.profile = load(profile or certificate.parent / "profile.json")
        proved: Any = self._proved(load_proof(certificate, self.profile))
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
        texts = {**emit(self.profile, ["c"]), **monitor.emit(watched, ["c"])}
        texts["bench.c"] = WITH_CLOCK.format(**names) + self._program(names, agents)
        for name, text in texts.items():
            (folder / name).write_text(text)
        flags = [*(each for each in STRICT if "pedantic" not in each), "-O3", "-shared", "-fPIC"]
        command = [*(find_compiler() or ["cc"]), *flags, "bench.c", "-o", "bench.so"]
        subprocess.run(command, cwd=folder, check=True)
        self._library = ctypes.CDLL(str(folder / "bench.so"))
        self._names = [policy.agent for policy in self.profile.agents]
        self._at = {name: place for place, name in enumerate(self.profile.world.coordinates())}

    def _proved(self, proved):
        return proved

    def _program(self, names, agents):
        return PROGRAM.format(**names)

    def words(self, w, acts):
        """The words of whole episodes, and the seconds of their decisions and of the monitor."""
        w, acts = np.ascontiguousarray(w), np.ascontiguousarray(acts, np.int32)
        found, seconds = np.zeros(w.shape[:2], np.int32), np.zeros(2)
        pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (w, acts, found, seconds)]
        sizes = [ctypes.c_long(size) for size in w.shape[:2]]
        self._library.follow(*pointers[:2], *sizes, *pointers[2:])
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
        """Random starts of the proof."""
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
        w, at, world = w.copy(), self._at, self.profile.world
        for policy in self.profile.agents:
            (entity,) = (one for one in world.agents if one.name == policy.agent)
            effects = np.array([each.effect or (0.0, 0.0) for each in policy.actions])[acted[policy.agent]]
            for k, axis in enumerate("xy"):
                place, speed = at[f"{policy.agent}.{axis}"], at[f"{policy.agent}.v{axis}"]
                w[:, place] = w[:, place] + world.dt * w[:, speed]
                w[:, speed] = w[:, speed] * (1.0 - world.damping) + effects[:, k] * entity.force * world.dt
                w[:, speed] += pushed * rng.normal(size=len(w))
        return w

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
