"""Monitors in three languages as functions, and their twin: what each must say, from the region itself."""

import ctypes
import json
import shutil
import subprocess
from fractions import Fraction
from itertools import product

import numpy as np

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.boxes.bounding import is_inside
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch
from codegen.targets import emit, monitor

OK, LEAVING, OUTSIDE, INVALID = range(4)
HASH = "0" * 64
LANGUAGES = tuple(monitor.LANGUAGES)


def files(profile, spec, targets=LANGUAGES):
    """The texts of code and monitors, and the lowered monitor."""
    model = lower(profile)
    watched = watch(profile, model, spec, HASH, "nothing, but in a test")
    return {**emit(profile, targets), **monitor.emit(watched, targets)}, watched


class Twin:
    """What a monitor must say: exact membership by fractions where it vouches, a machine of its own beside it."""

    def __init__(self, profile, spec, watched):
        self.names, self.spec, self.dt = profile.world.coordinates(), spec, profile.world.dt
        self.limits = {
            each.place.index: (float(each.low.decimal), float(each.high.decimal)) for each in watched.watched
        }
        self.moves = [(each.place.index, each.velocity.index) for each in watched.moved]
        self.start()

    def start(self):
        self.age, self.word, self.stays = dict.fromkeys(self.limits, np.inf), INVALID, False

    def step(self, w, fresh, dt):
        for place in self.age:
            self.age[place] = 0.0 if fresh[place] else self.age[place] + dt
        if self.stays:
            return self.word
        late = not 0.0 <= dt <= 1.5 * self.dt
        if late or any(
            not (self.age[place] <= 1.5 * self.dt and low <= w[place] <= high)
            for place, (low, high) in self.limits.items()
        ):
            self.word = INVALID
        elif not self.holds(w):
            self.word = OUTSIDE
        else:
            after = np.array(w)
            for place, velocity in self.moves:
                after[place] = w[place] + self.dt * w[velocity]
            self.word = OK if self.holds(after) else LEAVING
        self.stays = self.word in (OUTSIDE, INVALID)
        return self.word

    def holds(self, w):
        return bool(is_inside(self.spec, np.array([w]), self.names)[0])


class CoverTwin:
    """What the monitor of a cover must say: the boxes of the proof one by one, a machine of its own beside them."""

    def __init__(self, cover):
        self.cover = cover
        self.start()

    def start(self):
        self.age, self.word, self.stays, self.at = [np.inf] * len(self.cover.variables), INVALID, False, 0

    def step(self, w, fresh, dt):
        cover = self.cover
        self.age = [0.0 if new else age + dt for age, new in zip(self.age, fresh, strict=True)]
        if self.stays:
            return self.word
        timely = (0.5 * cover.dt if cover.paced else 0.0) <= dt <= 1.5 * cover.dt
        ranges = zip(self.age, w, cover.variables, strict=True)
        if not timely or any(not (age <= 1.5 * cover.dt and one.low <= x <= one.high) for age, x, one in ranges):
            self.word = INVALID
        elif not cover.holds(np.array([w]), self.at)[0]:
            self.word = OUTSIDE
        else:
            self.word = OK if cover.ever or self.at + 1 < len(cover.steps) else LEAVING
            self.at += 1
        self.stays = self.word in (OUTSIDE, INVALID)
        return self.word


def said_of_cover(cover, rows):
    """What the twin says of what `asked_of_cover` gives."""
    twin, words = CoverTwin(cover), []
    for w, fresh, dt, start in zip(*rows, strict=True):
        if start:
            twin.start()
        words.append(twin.step(w, fresh, dt))
    return words


def asked_of_cover(cover, count, seed):
    """States in boxes, at their ends and beside these, far away; sensors that fail, steps that are late or early: w,
    fresh, dt, start. Most are of the step that a monitor is at which says OK.
    """
    rng, rows, twin = np.random.default_rng(seed), [], CoverTwin(cover)
    size = len(cover.variables)
    for _ in range(count):
        start = int(twin.stays or rng.random() < 0.02)
        if start:
            twin.start()
        w = np.array([rng.uniform(max(one.low, -1e6), min(one.high, 1e6)) for one in cover.variables])
        for boxes in cover.steps[0 if cover.ever else min(twin.at, len(cover.steps) - 1)]:
            row = rng.integers(len(boxes.low))
            bounded = np.flatnonzero(np.isfinite(boxes.low[row][:size]))  # of sums the twin knows
            low, high = boxes.low[row][bounded], boxes.high[row][bounded]
            w[bounded] = np.clip(low + rng.random(len(low)) * (high - low), low, high)
            if len(bounded) and rng.random() < 0.15:
                column = rng.choice(bounded)
                end = (boxes.low, boxes.high)[rng.integers(2)][row, column]
                w[column] = end if rng.random() < 0.5 else np.nextafter(end, rng.choice([-np.inf, np.inf]))
        if rng.random() < 0.01:
            w[rng.integers(size)] = rng.choice([np.nan, np.inf, -np.inf, 1e12])
        fresh = (rng.random(size) > 0.005).astype(np.int32)
        dt = rng.choice([cover.dt, 0.0, 1.4 * cover.dt, np.nan, 9.0 * cover.dt], p=[0.98, *[0.005] * 4])
        rows.append((w, fresh, dt, start))
        twin.step(w, fresh, dt)
    w, fresh, dt, starts = map(np.array, zip(*rows, strict=True))
    return w, fresh, dt, starts.astype(np.int32)


class TrackTwin:
    """What the monitor of episodes must say: the motion of the game by a few lines of its own."""

    def __init__(self, profile, start):
        self.profile, self.proved, self.world = profile, start, profile.world
        self.names = list(self.world.coordinates())
        self.start()

    def start(self):
        self.age, self.word, self.stays, self.at = np.full(len(self.names), np.inf), INVALID, False, 0
        self.last, self.acts = None, None

    def moved(self, w, acts):
        """The state one step on."""
        after, world = w.copy(), self.world
        for policy, act in zip(self.profile.agents, acts, strict=True):
            (entity,) = (one for one in world.agents if one.name == policy.agent)
            for axis, push in zip("xy", policy.actions[act].effect or (0.0, 0.0), strict=True):
                place, speed = self.names.index(f"{policy.agent}.{axis}"), self.names.index(f"{policy.agent}.v{axis}")
                after[place] = w[place] + world.dt * w[speed]
                after[speed] = w[speed] * (1.0 - world.damping) + push * entity.force * world.dt
        return after

    def step(self, w, fresh, dt):
        self.age = np.where(fresh, 0.0, self.age + dt)
        if self.stays:
            return self.word
        step = self.world.dt
        if not 0.5 * step <= dt <= 1.5 * step or not ((self.age <= 1.5 * step) & (np.abs(w) <= 1e9)).all():
            self.word = INVALID
        elif (at := None if self.at > self.proved.steps else self.reached(w)) is None:
            self.word = OUTSIDE
        else:
            self.word = OK if self.at < self.proved.steps else LEAVING
            self.at, self.last = self.at + 1, at
        self.stays = self.word in (OUTSIDE, INVALID)
        return self.word

    def reached(self, w):
        """The state of the proof's episode in which a state is; None where it is in none."""
        return w if (self.follows(w) if self.at else self.starts(w)) else None

    def starts(self, w):
        resting = all(w[at] == 0.0 for at, name in enumerate(self.names) if ".v" in name)
        return resting and is_inside(self.proved.region, np.array([w]), tuple(self.names))[0]

    def follows(self, w):
        ways = [
            [act] if policy.agent in self.proved.followed else range(len(policy.actions))
            for policy, act in zip(self.profile.agents, self.acts, strict=True)
        ]
        still = [at for at, name in enumerate(self.names) if name.startswith(("landmark", "goal"))]
        if (w[still] != self.last[still]).any():
            return False
        return any(self._is_led(self.moved(self.last, way), w) for way in product(*ways))

    def _is_led(self, after, w):
        """By rounding; of what was at rest exactly, and of speeds that nothing pushes from rest."""
        close = np.abs(after - w) <= 2.0**-40
        for at, name in enumerate(self.names):
            if ".v" in name and self.last[at] == 0.0:
                place = self.names.index(name.replace(".v", "."))
                close[place] = after[place] == w[place]
                close[at] &= after[at] != 0.0 or w[at] == 0.0
        return close.all()


def asked_of_episodes(profile, start, count, seed):
    """Starts, what follows from them by random actions, and what does not quite: w, fresh, dt, start, actions."""

    def disturbed(rng, w, begins):
        if begins and rng.random() < 0.1:
            w[rng.integers(len(w))] = rng.choice([1.5, 1e-300, np.nan])
        if not begins and rng.random() < 0.03:
            w[rng.integers(len(w))] += rng.choice([2.0**-39, -(2.0**-39), 2.0**-42, 1e-3, np.inf])
        return w

    return asked_of(TrackTwin(profile, start), profile, start, count, seed, disturbed)


def asked_of(twin, profile, start, count, seed, disturbed):
    """Starts and what follows from them by random actions, as `disturbed(rng, state, whether it is a start)` has it."""
    rng, rows = np.random.default_rng(seed), []
    size, names = len(twin.names), twin.names
    for _ in range(count):
        begun = int(twin.stays or rng.random() < 0.01)
        if begun:
            twin.start()
        begins = twin.at == 0
        w = _started(start.region, names, rng) if begins else twin.moved(twin.last, twin.acts)
        w = disturbed(rng, w, begins)
        fresh = (rng.random(size) > 0.0005).astype(np.int32)
        dt = rng.choice([profile.world.dt, 0.0, np.nan, 9.0], p=[0.991, 0.003, 0.003, 0.003])
        twin.step(w, fresh, dt)
        twin.acts = [int(rng.integers(len(policy.actions))) for policy in profile.agents]
        rows.append((w, fresh, dt, begun, twin.acts))
    w, fresh, dt, starts, acts = map(np.array, zip(*rows, strict=True))
    return w, fresh, dt, starts.astype(np.int32), acts.astype(np.int32)


def _started(region, names, rng):
    w = np.zeros(len(names))
    for name, (low, high) in region.box.items():
        w[names.index(name)] = rng.uniform(float(Fraction(low)), float(Fraction(high)))
    goal = rng.choice(region.goals)
    for axis in "xy":
        w[names.index(f"goal.{axis}")] = w[names.index(f"{goal}.{axis}")]
    return w


def inside(spec, names, w):
    """Whether a state is in a region, in exact arithmetic."""
    at = {name: Fraction(value) for name, value in zip(names, map(float, w), strict=True)}
    boxes = all(Fraction(low) <= at[name] <= Fraction(high) for name, (low, high) in spec.box.items())
    for pair, (low, high) in spec.difference.items():
        first, second = pair.split(" - ")
        boxes = boxes and Fraction(low) <= at[first] - at[second] <= Fraction(high)
    for pair, least in spec.apart.items():
        first, second = pair.split(" - ")
        boxes = boxes and any(abs(at[f"{first}.{axis}"] - at[f"{second}.{axis}"]) >= Fraction(least) for axis in "xy")
    goal = not spec.goals or any(
        all(at[f"goal.{axis}"] == at[f"{name}.{axis}"] for axis in "xy") for name in spec.goals
    )
    return boxes and goal


def actions(watched, asked):
    """What every agent does after each state, [n, agents]: the fifth of what is asked, or the first agent's turn."""
    if len(asked) > 4:
        return np.ascontiguousarray(asked[4], np.int32)
    found = np.zeros((len(asked[0]), len(watched.model.agents)), np.int32)
    found[:, 0] = np.arange(len(found)) % len(watched.model.agents[0].actions)
    return found


PROGRAM = """#include "{p}_monitor.h"
#define GIVEN const double *w, const int *fresh, const double *dt, const int *start, const int *acts, long n
void run(GIVEN, int *words, int *acted);
void run(GIVEN, int *words, int *acted)
{{
    {p}_monitor m;
    long i;
    int k;
    {p}_monitor_start(&m);
    for (i = 0; i < n; i++) {{
        if (start[i] == 1) {{
            {p}_monitor_start(&m);
        }}
        for (k = 0; k < {N}; k++) {{
            if (fresh[i * {N} + k] == 1) {{
                {p}_monitor_renew(&m, k);
            }}
        }}
        words[i] = {p}_monitor_step(&m, w + i * {N}, dt[i]);
        {calls}
    }}
}}
"""


def ensure_said_by_all(texts, watched, folder, asked, said, languages=("javascript",)):
    """Python, C and those of `languages` that can be run here give the same words and actions."""
    assert run_python(texts, watched, asked) == said
    if find_compiler() is not None:
        assert run_c(texts, watched, folder, asked) == said
    if "javascript" in languages and shutil.which("node"):
        assert run_javascript(texts, watched, folder, asked) == said


def run_c(texts, watched, folder, asked, flags=("-O1", "-ffp-contract=off")):
    """Words and actions of the first agent, by the C."""
    p, agents = watched.model.prefix, watched.model.agents
    calls = [f"{p}_monitor_{agent.lower}(&m, acts[i * {len(agents)} + {k}])" for k, agent in enumerate(agents)]
    text = " ".join([f"acted[i] = {calls[0]};", *(f"(void){call};" for call in calls[1:])])
    names = {"p": p, "N": watched.size, "calls": text}
    (folder / "run.c").write_text(PROGRAM.format(**names))
    for name, text in texts.items():
        if name.endswith(".h"):
            (folder / name).write_text(text)
    command = [*find_compiler(), *STRICT, *flags, "-shared", "-fPIC", "run.c", "-o", "run.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    library = ctypes.CDLL(str(folder / "run.so"))
    w, fresh, dt, start = (np.ascontiguousarray(each) for each in asked[:4])
    words, acted = np.zeros(len(w), np.int32), np.zeros(len(w), np.int32)
    pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (w, fresh, dt, start, actions(watched, asked))]
    library.run(*pointers, ctypes.c_long(len(w)), *(each.ctypes.data_as(ctypes.c_void_p) for each in (words, acted)))
    return words.tolist(), acted.tolist()


def run_python(texts, watched, asked):
    """The same by the Python."""
    space = {}
    exec(compile(texts[f"{watched.model.prefix}_monitor.py"], "monitor", "exec"), space)
    found, agents = space["Monitor"](), watched.model.agents
    words, acted = [], []
    for w, fresh, dt, start, acts in zip(*asked[:4], actions(watched, asked), strict=True):
        if start:
            found.start()
        for place in np.flatnonzero(fresh):
            found.renew(int(place))
        words.append(int(found.step(w.tolist(), float(dt))))
        told = [found.act(agent.name, act) for agent, act in zip(agents, acts.tolist(), strict=True)]
        acted.append(told[0])
    return words, acted


SCRIPT = """import { Monitor } from "./MODULE";
import { readFileSync } from "node:fs";
const number = (each) => ({ NaN: NaN, inf: Infinity, "-inf": -Infinity })[each] ?? each;
const m = new Monitor();
const words = [], acted = [];
for (const [w, fresh, dt, start, acts] of JSON.parse(readFileSync("asked.json"))) {
  if (start) m.start();
  fresh.forEach((each, place) => each && m.renew(place));
  words.push(m.step(w.map(number), number(dt)));
  acted.push(NAMES.map((agent, k) => m.act(agent, acts[k]))[0]);
}
console.log(JSON.stringify([words, acted]));
"""


def run_javascript(texts, watched, folder, asked):
    """The same by the JavaScript, under node."""
    name, agents = f"{watched.model.prefix}_monitor.mjs", [agent.name for agent in watched.model.agents]
    (folder / name).write_text(texts[name])
    script = SCRIPT.replace("MODULE", name).replace("NAMES", json.dumps(agents))
    (folder / "run.mjs").write_text(script)
    rows = [[_told(each) for each in row] for row in zip(*asked[:4], actions(watched, asked), strict=True)]
    (folder / "asked.json").write_text(json.dumps(rows))
    done = subprocess.run(["node", "run.mjs"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return tuple(json.loads(done.stdout))


def _told(value):
    if np.ndim(value):
        return [_told(each) for each in value]
    value = value.item()
    return value if isinstance(value, int) or np.isfinite(value) else {"nan": "NaN"}.get(str(value), str(value))
