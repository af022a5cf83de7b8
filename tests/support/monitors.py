"""Monitors in four languages as functions, and their twin: what each must say, from the region itself."""

import ctypes
import json
import subprocess
from fractions import Fraction

import numpy as np

from codegen.agreement.compiled import STRICT, find_compiler
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
        return bool(self.spec.holds(np.array([w]), self.names)[0])


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
        w = np.array([rng.uniform(one.low, one.high) for one in cover.variables])
        for boxes in cover.steps[0 if cover.ever else min(twin.at, len(cover.steps) - 1)]:
            row = rng.integers(len(boxes.low))
            bounded = np.flatnonzero(np.isfinite(boxes.low[row]))
            low, high = boxes.low[row][bounded], boxes.high[row][bounded]
            w[bounded] = np.clip(low + rng.random(len(low)) * (high - low), low, high)
            if rng.random() < 0.15:
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


PROGRAM = """#include "{p}_monitor.h"
void run(const double *w, const int *fresh, const double *dt, const int *start, long n, int *words, int *acted);
void run(const double *w, const int *fresh, const double *dt, const int *start, long n, int *words, int *acted)
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
        acted[i] = {p}_monitor_{a}(&m, (int)(i % {A}));
    }}
}}
"""


def run_c(texts, watched, folder, asked):
    """Words and actions of the first agent, by the C."""
    p, agent = watched.model.prefix, watched.model.agents[0]
    names = {"p": p, "a": agent.lower, "N": watched.size, "A": agent.names.n_actions}
    (folder / "run.c").write_text(PROGRAM.format(**names))
    for name, text in texts.items():
        if name.endswith(".h"):
            (folder / name).write_text(text)
    command = [*find_compiler(), *STRICT, "-O1", "-ffp-contract=off", "-shared", "-fPIC", "run.c", "-o", "run.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    library = ctypes.CDLL(str(folder / "run.so"))
    w, fresh, dt, start = (np.ascontiguousarray(each) for each in asked)
    words, acted = np.zeros(len(w), np.int32), np.zeros(len(w), np.int32)
    pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (w, fresh, dt, start)]
    library.run(*pointers, ctypes.c_long(len(w)), *(each.ctypes.data_as(ctypes.c_void_p) for each in (words, acted)))
    return words.tolist(), acted.tolist()


def run_python(texts, watched, asked):
    """The same by the Python."""
    space = {}
    exec(compile(texts[f"{watched.model.prefix}_monitor.py"], "monitor", "exec"), space)
    found, agent = space["Monitor"](), watched.model.agents[0]
    words, acted = [], []
    for i, (w, fresh, dt, start) in enumerate(zip(*asked, strict=True)):
        if start:
            found.start()
        for place in np.flatnonzero(fresh):
            found.renew(int(place))
        words.append(int(found.step(w.tolist(), float(dt))))
        acted.append(found.act(agent.name, i % len(agent.actions)))
    return words, acted


SCRIPT = """import { Monitor } from "./MODULE";
import { readFileSync } from "node:fs";
const number = (each) => ({ NaN: NaN, inf: Infinity, "-inf": -Infinity })[each] ?? each;
const m = new Monitor();
const words = [], acted = [];
for (const [i, [w, fresh, dt, start]] of JSON.parse(readFileSync("asked.json")).entries()) {
  if (start) m.start();
  fresh.forEach((each, place) => each && m.renew(place));
  words.push(m.step(w.map(number), number(dt)));
  acted.push(m.act("AGENT", i % N_ACTIONS));
}
console.log(JSON.stringify([words, acted]));
"""


def run_javascript(texts, watched, folder, asked):
    """The same by the JavaScript, under node."""
    name, agent = f"{watched.model.prefix}_monitor.mjs", watched.model.agents[0]
    (folder / name).write_text(texts[name])
    script = SCRIPT.replace("MODULE", name).replace("AGENT", agent.name).replace("N_ACTIONS", str(len(agent.actions)))
    (folder / "run.mjs").write_text(script)
    rows = [[_told(each) for each in row] for row in zip(*asked, strict=True)]
    (folder / "asked.json").write_text(json.dumps(rows))
    done = subprocess.run(["node", "run.mjs"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return tuple(json.loads(done.stdout))


def _told(value):
    if np.ndim(value):
        return [_told(each) for each in value]
    value = value.item()
    return value if isinstance(value, int) or np.isfinite(value) else {"nan": "NaN"}.get(str(value), str(value))


RUST = """mod monitor;
use std::io::Read;
fn main() {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text).unwrap();
    let mut m = monitor::Monitor::default();
    for (i, line) in text.lines().enumerate() {
        let n: Vec<f64> = line.split(' ').map(|each| f64::from_bits(each.parse().unwrap())).collect();
        let mut w = [0.0; monitor::SIZE];
        w.copy_from_slice(&n[2..2 + monitor::SIZE]);
        if n[1] > 0.0 {
            m.start();
        }
        for place in 0..monitor::SIZE {
            if n[2 + monitor::SIZE + place] > 0.0 {
                m.renew(place);
            }
        }
        println!("{} {}", m.step(&w, n[0]) as usize, m.AGENT(i % N_ACTIONS));
    }
}
"""


def run_rust(texts, watched, folder, asked):
    """The same by the Rust."""
    agent = watched.model.agents[0]
    (folder / "monitor.rs").write_text(texts[f"{watched.model.prefix}_monitor.rs"])
    size = "N_VARIABLES" if watched.lookup else "N_COORDINATES"
    main = RUST.replace("AGENT", agent.names.module).replace("SIZE", size).replace("N_ACTIONS", str(len(agent.actions)))
    (folder / "main.rs").write_text(main)
    done = subprocess.run(
        ["rustc", "--edition", "2021", "-A", "dead_code", "main.rs"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    w, fresh, dt, start = asked
    rows = np.column_stack([dt, start, w, fresh]).astype(np.float64)
    text = "\n".join(" ".join(map(str, row)) for row in rows.view(np.uint64).tolist())
    done = subprocess.run([str(folder / "main")], input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pairs = [line.split() for line in done.stdout.splitlines()]
    return [int(word) for word, _ in pairs], [int(action) for _, action in pairs]
