"""Monitors in three languages as functions, and their twin: what each must say, from the region itself."""

import ctypes
import json
import shutil
import subprocess
from fractions import Fraction
from itertools import product

import numpy as np

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.boxes import is_inside
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch
from codegen.targets import emit, rendered
from maviper import load, verify_system
from tests.support.generated import FOLDER

OK, LEAVING, OUTSIDE, INVALID = range(4)
HASH = "0" * 64
LANGUAGES = tuple(rendered.LANGUAGES)
FLAGS = (*STRICT, "-O1", "-ffp-contract=off")


def pointer(array):
    """Where the numbers of an array begin, for a function of C."""
    return array.ctypes.data_as(ctypes.c_void_p)


def files(profile, spec, targets=LANGUAGES):
    """The texts of code and monitors, and the lowered monitor."""
    model = lower(profile)
    watched = watch(profile, model, spec, HASH, "nothing, but in a test")
    return {**emit(profile, targets), **rendered.emit_monitors(watched, targets)}, watched


def certify(folder, world, text):
    """The certificate of a claim about a committed world, in a folder of its own beside profile and world file."""
    for name in ("profile.json", "world.toml"):
        shutil.copy(FOLDER.parent / "worlds" / world / name, folder)
    (folder / "properties.toml").write_text(f"[[property]]\n{text}\n")
    found = verify_system(load(folder / "profile.json"), folder / "world.toml", folder / "properties.toml")
    ((_, certificate),) = found.certificates.items()
    (folder / "certificate.json").write_text(certificate)
    return folder / "certificate.json"


def module_of(watched):
    """The names of a monitor in Python."""
    (text,) = rendered.emit_monitors(watched, ["python"]).values()
    space = {}
    exec(compile(text, "monitor", "exec"), space)
    return space


class Machine:
    """What every monitor must say, by a few lines of its own: which numbers are valid, and that a word stays. `limits`:
    by place the least and most of what is watched.
    """

    def __init__(self, dt, limits, paced=False):
        self.dt, self.early, self.places = dt, 0.5 * dt if paced else 0.0, list(limits)
        self.low, self.high = np.array(list(limits.values())).T
        self.start()

    def start(self):
        self.age, self.word, self.stays, self.at = np.full(len(self.places), np.inf), INVALID, False, 0

    def step(self, w, fresh, dt):
        self.age = np.where(np.asarray(fresh)[self.places], 0.0, self.age + dt)
        if self.stays:
            return self.word
        now = np.asarray(w)[self.places]
        valid = (self.age <= 1.5 * self.dt) & (self.low <= now) & (now <= self.high)
        self.word = self.judge(w) if self.early <= dt <= 1.5 * self.dt and valid.all() else INVALID
        self.stays = self.word in (OUTSIDE, INVALID)
        return self.word

    def judge(self, w):
        """The word of a valid state."""
        return OK

    def said(self, rows):
        """The words of rows of w, fresh, dt, start, and what agents do then."""
        words = []
        for w, fresh, dt, start, *acts in zip(*rows, strict=True):
            if start:
                self.start()
            words.append(self.step(w, fresh, dt))
            self.acts = acts[0].tolist() if acts else None
        return words


def limits_of(watched):
    """By place the least and most of what a monitor watches."""
    return {each.place.index: (float(each.low.decimal), float(each.high.decimal)) for each in watched.watched}


class Twin(Machine):
    """What the monitor of a region must say: exact membership by fractions where it vouches."""

    def __init__(self, profile, spec, watched):
        self.names, self.spec = profile.world.coordinates(), spec
        self.moves = [(each.place.index, each.velocity.index) for each in watched.check.moved]
        super().__init__(profile.world.dt, limits_of(watched))

    def judge(self, w):
        after = np.array(w)
        for place, velocity in self.moves:
            after[place] = w[place] + self.dt * w[velocity]
        return OUTSIDE if not self.holds(w) else OK if self.holds(after) else LEAVING

    def holds(self, w):
        return bool(is_inside(self.spec, np.array([w]), self.names)[0])


class CoverTwin(Machine):
    """What the monitor of a cover must say: the boxes of the proof one by one."""

    def __init__(self, cover):
        self.cover = cover
        super().__init__(cover.dt, {at: one[1:] for at, one in enumerate(cover.variables)}, cover.paced)

    def judge(self, w):
        if not self.cover.holds(np.array([w]), self.at)[0]:
            return OUTSIDE
        self.at += 1
        return OK if self.cover.ever or self.at < len(self.cover.steps) else LEAVING


def drawn(profile, spec, count, rng):
    """States in the box of a region, at its ends and beside, with the goal at a landmark; and which that is."""
    names = list(profile.world.coordinates())
    w = rng.uniform(-1.0, 1.0, (count, len(names)))
    w[:, [at for at, name in enumerate(names) if ".v" in name]] *= 0.3
    for name, bounds in spec.box.items():
        ends = np.array([float(Fraction(end)) for end in bounds])
        column = rng.uniform(*ends, count)
        at_end = rng.random(count) < 0.05
        pool = [*ends, *np.nextafter(ends, -np.inf), *np.nextafter(ends, np.inf), *(1.4 * ends)]
        column[at_end] = rng.choice(pool, at_end.sum())
        w[:, names.index(name)] = column
    goals = rng.choice(profile.world.goals or [""], count)
    for axis in "xy" if profile.world.goals else "":
        w[:, names.index(f"goal.{axis}")] = w[np.arange(count), [names.index(f"{goal}.{axis}") for goal in goals]]
    return w, goals


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


class TrackTwin(Machine):
    """What the monitor of episodes must say: the motion of the game by a few lines of its own."""

    def __init__(self, profile, start):
        self.profile, self.proved, self.world = profile, start, profile.world
        self.names = list(self.world.coordinates())
        super().__init__(self.world.dt, dict.fromkeys(range(len(self.names)), (-1e9, 1e9)), paced=True)

    def start(self):
        super().start()
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

    def judge(self, w):
        reached = None if self.at > self.proved.steps else self.reached(w)
        if reached is None:
            return OUTSIDE
        self.at, self.last = self.at + 1, reached
        return OK if self.at <= self.proved.steps else LEAVING

    def reached(self, w):
        """The state of the proof's episode in which a state is; None where it is in none."""
        return w if (self.follows(w) if self.at else self.starts(w)) else None

    def starts(self, w):
        resting = all(w[at] == 0.0 for at, name in enumerate(self.names) if ".v" in name)
        return resting and is_inside(self.proved.region, np.array([w]), tuple(self.names))[0]

    def ways(self):
        """The states one step on: of those whom the proof does not follow, any action counts."""
        acts = [
            [act] if policy.agent in self.proved.followed else range(len(policy.actions))
            for policy, act in zip(self.profile.agents, self.acts, strict=True)
        ]
        return (self.moved(self.last, way) for way in product(*acts))

    def follows(self, w):
        still = [at for at, name in enumerate(self.names) if name.startswith(("landmark", "goal"))]
        if (w[still] != self.last[still]).any():
            return False
        return any(self._is_led(after, w) for after in self.ways())

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
    found[:, 0] = np.arange(len(found)) % (watched.fallbacks[0].count or 1)
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


def ensure_alike(profile, watched, asked, wanted, folder, languages=LANGUAGES):
    """Python, and of these languages those that can be run here, say the words that are wanted, and the first agent
    acts by them.
    """
    given, rest = actions(watched, asked)[:, 0].tolist(), watched.fallbacks[0].action
    said = wanted, [act if word in (OK, LEAVING) else rest for act, word in zip(given, wanted, strict=True)]
    texts = {**emit(profile, languages), **rendered.emit_monitors(watched, languages)}
    assert run_python(watched, asked) == said
    if "c" in languages and find_compiler() is not None:
        assert run_c(texts, watched, folder, asked) == said
    if "javascript" in languages and shutil.which("node"):
        assert run_javascript(texts, watched, folder, asked) == said
    return texts, said


def built(folder, texts, flags=FLAGS):
    """The library of the program run.c among texts, which includes the others."""
    for name, text in texts.items():
        (folder / name).write_text(text)
    command = [*(find_compiler() or ["cc"]), *flags, "-shared", "-fPIC", "run.c", "-o", "run.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "run.so"))


def run_c(texts, watched, folder, asked, flags=FLAGS):
    """Words and actions of the first agent, by the C."""
    p, agents = watched.model.prefix, watched.model.agents
    calls = [f"{p}_monitor_{agent.lower}(&m, acts[i * {len(agents)} + {k}])" for k, agent in enumerate(agents)]
    text = " ".join([f"acted[i] = {calls[0]};", *(f"(void){call};" for call in calls[1:])])
    names = {"p": p, "N": watched.size, "calls": text}
    library = built(folder, {**texts, "run.c": PROGRAM.format(**names)}, flags)
    w, fresh, dt, start = (np.ascontiguousarray(each) for each in asked[:4])
    words, acted = np.zeros(len(w), np.int32), np.zeros(len(w), np.int32)
    given = (w, fresh, dt, start, actions(watched, asked))
    library.run(*map(pointer, given), ctypes.c_long(len(w)), pointer(words), pointer(acted))
    return words.tolist(), acted.tolist()


def run_python(watched, asked):
    """The same by the Python."""
    found, agents = module_of(watched)["Monitor"](), watched.model.agents
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
    rows = [[_told(each) for each in row] for row in zip(*asked[:4], actions(watched, asked), strict=True)]
    (folder / "asked.json").write_text(json.dumps(rows))
    return tuple(_run_node(script, folder))


def _run_node(script, folder):
    (folder / "run.mjs").write_text(script)
    done = subprocess.run(["node", "run.mjs"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def _told(value):
    if np.ndim(value):
        return [_told(each) for each in value]
    value = value.item()
    return value if isinstance(value, int) or np.isfinite(value) else {"nan": "NaN"}.get(str(value), str(value))


# --- agents that give numbers: what each language makes of outputs, after a step that is OK

GIVING = """#include "{p}_monitor.h"
void run(const double *given, long n, double *found);
void run(const double *given, long n, double *found)
{{
    static const double x[{size}] = {{0.0}};
    long i;
    int k;
    for (i = 0; i < n; i++) {{
        {p}_monitor m;
        {kind} y[{K}];
        int word;
        {p}_monitor_start(&m);
        for (k = 0; k < 2; k++) {{
            {p}_monitor_renew_all(&m);
            (void){p}_monitor_step(&m, x, {p_upper}_M_DT);
        }}
        for (k = 0; k < {K}; k++) {{
            y[k] = ({kind})given[i * {K} + k];
        }}
        word = {p}_monitor_{agent}(&m, y);
        {p}_monitor_renew_all(&m);
        found[i * ({K} + 1)] = ({p}_monitor_step(&m, x, {p_upper}_M_DT) == word) ? word : -1; /* it stays */
        for (k = 0; k < {K}; k++) {{
            found[i * ({K} + 1) + k + 1] = y[k];
        }}
    }}
}}
"""
GIVING_SCRIPT = """import { Monitor, DT } from "./MODULE";
const number = (each) => ({ nan: NaN, inf: Infinity, "-inf": -Infinity })[each] ?? each;
console.log(JSON.stringify(GIVEN.map((given) => {
  const m = new Monitor();
  m.renew_all();
  m.step(new Array(SIZE).fill(0), DT);
  const outputs = m.give("AGENT", given.map(number));
  return [m.word, ...outputs];
})));
"""


def given_by(texts, watched, folder, given):
    """By language the rows of word and outputs, for the outputs `given` [n, outputs] of the first agent."""
    found = {"python": _given_in_python(watched, given)}
    if find_compiler() is not None:
        found["c"] = _given_in_c(texts, watched, folder, given)
    if shutil.which("node"):
        name = f"{watched.model.prefix}_monitor.mjs"
        (folder / name).write_text(texts[name])
        told = json.dumps([[each if np.isfinite(each) else str(each) for each in row] for row in given])
        script, agent = GIVING_SCRIPT, watched.fallbacks[0].agent.name
        for word, text in {"MODULE": name, "GIVEN": told, "SIZE": len(watched.places), "AGENT": agent}.items():
            script = script.replace(word, str(text))
        found["javascript"] = _run_node(script, folder)
    return found


def _given_in_python(watched, given):
    space, name = module_of(watched), watched.fallbacks[0].agent.name
    rows = []
    for each in given:
        found = space["Monitor"]()
        found.renew_all()
        assert found.step([0.0] * len(watched.places), space["DT"]) == 0
        outputs = found.give(name, each)
        rows.append([int(found.word), *outputs])
    return rows


def _given_in_c(texts, watched, folder, given):
    p, agent = watched.model.prefix, watched.fallbacks[0].agent
    names = {"p": p, "p_upper": p.upper(), "size": watched.size, "K": len(given[0])}
    program = GIVING.format(**names, kind=agent.summed.kind, agent=agent.lower)
    library = built(folder, {**texts, "run.c": program})
    asked, found = np.array(given), np.zeros((len(given), len(given[0]) + 1))
    library.run(pointer(asked), ctypes.c_long(len(given)), pointer(found))
    return [[int(row[0]), *row[1:].tolist()] for row in found]


# --- monitors for noisy numbers: a twin that follows episodes by a few lines of its own


class ShadowTwin(TrackTwin):
    """What a monitor for numbers that are off by `noise` must say. `last` is the state of the proof's episode."""

    def __init__(self, profile, start):
        self.near = 2.0 * start.noise
        super().__init__(profile, start)

    def reached(self, w):
        """As in the other twin: the first state that is near."""
        known = self.ways() if self.at else [self.begun(w)]
        return next((at for at in known if at is not None and (np.abs(w - at) <= self.near).all()), None)

    def begun(self, w):
        """The start of the region that is next to a state, at rest, with its goal at a landmark."""
        found = w.copy()
        for name, ends in self.proved.region.box.items():
            found[self.names.index(name)] = np.clip(found[self.names.index(name)], *map(float, map(Fraction, ends)))
        found[[at for at, name in enumerate(self.names) if ".v" in name]] = 0.0
        goal, marks = ([self.names.index(f"{name}.{axis}") for axis in "xy"] for name in ("goal", "landmark_0"))
        for name in self.proved.region.goals:
            marks = [self.names.index(f"{name}.{axis}") for axis in "xy"]
            if (np.abs(w[goal] - found[marks]) <= self.near).all():
                found[goal] = found[marks]
                return found if self.starts(found) else None
        return None


def asked_of_shadows(profile, start, count, seed):
    """Noisy starts and what follows from them, pushes, sensors that fail: w, fresh, dt, start, actions."""

    def disturbed(rng, w, begins):
        size = len(w)
        w = w + rng.uniform(-1.0, 1.0, size) * start.noise * rng.choice([0.0, 1.0, 1.9, 2.3], p=[0.2, 0.6, 0.18, 0.02])
        if rng.random() < 0.02:
            w[rng.integers(size)] += rng.choice([3.0 * start.noise, 1.5, np.nan, np.inf])
        return w

    return asked_of(ShadowTwin(profile, start), profile, start, count, seed, disturbed)
