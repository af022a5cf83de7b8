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

import numpy as np

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.lowering.lower import lower
from codegen.targets import emit, monitor
from maviper import load
from maviper.compilation.monitors import proved_by, watched_by
from tests.support.monitored import WITH_CLOCK, acting

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

    def __init__(self, certificate, folder):
        self.profile = load(certificate.parent / "profile.json")
        proved = proved_by(certificate, self.profile)
        self.start, self.steps = proved.region, proved.region.steps + 1
        model = lower(self.profile)
        watched = watched_by(self.profile, model, proved)
        p, agents = model.prefix, model.agents
        calls = " ".join(
            f"(void){p}_monitor_{agent.lower}(&m, acts[at * {len(agents)} + {k}]);" for k, agent in enumerate(agents)
        )
        names = {"p": p, "P": p.upper(), "N": watched.size, "K": len(agents), "calls": calls}
        texts = {**emit(self.profile, ["c"]), **monitor.emit(watched, ["c"])}
        texts["bench.c"] = (WITH_CLOCK + PROGRAM).format(**names)
        for name, text in texts.items():
            (folder / name).write_text(text)
        flags = [*(each for each in STRICT if "pedantic" not in each), "-O3", "-shared", "-fPIC"]
        command = [*(find_compiler() or ["cc"]), *flags, "bench.c", "-o", "bench.so"]
        subprocess.run(command, cwd=folder, check=True)
        self._library = ctypes.CDLL(str(folder / "bench.so"))

    def words(self, w, acts):
        """The words of whole episodes, and the seconds of their decisions and of the monitor."""
        w, acts = np.ascontiguousarray(w), np.ascontiguousarray(acts, np.int32)
        found, seconds = np.zeros(w.shape[:2], np.int32), np.zeros(2)
        pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (w, acts, found, seconds)]
        sizes = [ctypes.c_long(size) for size in w.shape[:2]]
        self._library.follow(*pointers[:2], *sizes, *pointers[2:])
        return found, seconds

    def played(self, count, seed, share):
        """Episodes from random starts of the proof; in each step after the first, this share of them is pushed."""
        rng, world = np.random.default_rng(seed), self.profile.world
        at = {name: place for place, name in enumerate(world.coordinates())}
        w = np.zeros((count, len(at)))
        for name, (low, high) in self.start.region.box.items():
            w[:, at[name]] = rng.uniform(float(Fraction(low)), float(Fraction(high)), count)
        goal = rng.integers(len(world.goals), size=count)
        for axis in "xy":
            w[:, at[f"goal.{axis}"]] = np.choose(goal, [w[:, at[f"{name}.{axis}"]] for name in world.goals])
        states, acts = np.empty((count, self.steps, len(at))), []
        for step in range(self.steps):
            states[:, step] = w
            acted = acting(self.profile, w)
            acts.append(np.column_stack([acted[policy.agent] for policy in self.profile.agents]))
            pushed = rng.random(count) < share
            for policy in self.profile.agents:
                (entity,) = (one for one in world.agents if one.name == policy.agent)
                effects = np.array([each.effect or (0.0, 0.0) for each in policy.actions])[acted[policy.agent]]
                for k, axis in enumerate("xy"):
                    place, speed = at[f"{policy.agent}.{axis}"], at[f"{policy.agent}.v{axis}"]
                    w[:, place] = w[:, place] + world.dt * w[:, speed]
                    w[:, speed] = w[:, speed] * (1.0 - world.damping) + effects[:, k] * entity.force * world.dt
                    w[:, speed] += np.where(pushed, PUSH * rng.normal(size=count), 0.0)
        return states, np.stack(acts, axis=1)

    def fails(self, states, team, radius):
        """In which episodes no matching has each agent of a team come to a landmark of its own."""
        at = {name: place for place, name in enumerate(self.profile.world.coordinates())}
        names, marks = [policy.agent for policy in self.profile.team(team)], self.profile.world.landmarks

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


def arriving(certificate: Path, states: int):
    """The figures of a claim that a team arrives."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        followed = Followed(certificate, Path(folder))
        count = -(-states // followed.steps)
        w, acts = followed.played(count, 0, 0.0)
        calm, _ = followed.words(w, acts)
        seconds = np.min([followed.words(w[:700], acts[:700])[1] for _ in range(ROUNDS)], axis=0)
        per_state = 1e9 * seconds / (min(count, 700) * followed.steps)
        seen, rng = w.copy(), np.random.default_rng(1)
        side = followed.profile.world.start_high - followed.profile.world.start_low
        seen[:, :, 0] += rng.normal(scale=NOISE * side, size=seen.shape[:2])
        noisy, _ = followed.words(seen, acts)
        w, acts = followed.played(count, 2, 1.0 / followed.steps)
        words, _ = followed.words(w, acts)
        stated = json.loads(certificate.read_text())
        team, radius = stated["team"], float(Fraction(stated["radius"]))
        failing = followed.fails(w, team, radius)
        vouched = (words <= 1).all(axis=1)
        others = np.roll(w, 1, axis=0)  # the landmarks of another episode
        w[:, :, _marks(followed)] = others[:, :, _marks(followed)]
        control = followed.fails(w, team, radius)
    return {
        "ratio": float(per_state[1] / per_state[0]),
        "decision_ns": float(per_state[0]),
        "step_ns": float(per_state[1]),
        "states": words.size,
        "vouched": float((words <= 1).mean()),
        "fails_while_vouched": int((failing & vouched).sum()),
        "fails_elsewhere": int((failing & ~vouched).sum()),
        "control_fails": int((control & vouched).sum()),
        "refused": int((calm > 1).sum()),
        "false_alarms": float((noisy[:, 1:] > 1).mean()),
        "warning": 0.0,
    }


def _marks(followed):
    names = followed.profile.world.coordinates()
    return [place for place, name in enumerate(names) if name.startswith("landmark")]
