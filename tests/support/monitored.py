"""Monitors under measurement: C that tells words and times for many states, and judges that share no code with proofs.

A *case* is a certificate with its monitor. States are rows; each has the step of the proof that it is at.
"""

import ctypes
import json
import shutil
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.agreement.compiled import STRICT
from codegen.lowering.lower import lower
from codegen.observe import observe
from codegen.targets import emit, rendered
from maviper.compilation.monitors import lower_monitor
from maviper.worlds.stated.certified import read_certificate
from tests.support.monitors import built, pointer
from verify.claims.formula import Acts, And, Goal, Linear, Not, Or, read_formula
from verify.systems.system import Measure

ROUNDS = 7
ALIGNED = ("-falign-functions=64", "-falign-loops=64")  # where code lies makes a third of what a call takes
OPTIMISED = [*(each for each in STRICT if "pedantic" not in each), "-O3"]
WITH_CLOCK = """#define _POSIX_C_SOURCE 199309L
#include "{p}_monitor.h"
#include <time.h>
static double now(void)
{{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}}
"""  # what a program begins with, before it is filled in
PROGRAM = """/* functions of which their callers know nothing */
#if defined(__clang__)
#define CALLED static __attribute__((noinline))
#else
#define CALLED static __attribute__((noipa))
#endif
{decide}
CALLED int decide_called(const double *w)
{{
    return decide(w);
}}
CALLED int step_called({p}_monitor *m, const double *w)
{{
    return {p}_monitor_step(m, w, {dt});
}}
CALLED int decide_all(const double *w, long n)
{{
    int sum = 0;
    long i;
    for (i = 0; i < n; i++) {{
        sum += decide_called(w + i * {N});
    }}
    return sum;
}}
CALLED int step_all({p}_monitor *m, const double *w, const int *at, long n)
{{
    int sum = 0;
    long i;
    (void)at;
    for (i = 0; i < n; i++) {{
        {p}_monitor_renew_all(m);
        {step}
        sum += step_called(m, w + i * {N});
        m->active = 1;
    }}
    return sum;
}}
void cost(const double *w, const int *at, long n, int *kept, double *seconds);
void cost(const double *w, const int *at, long n, int *kept, double *seconds)
{{
    {p}_monitor m;
    double start;
    long i;
    {p}_monitor_start(&m);
    for (i = 0; i < n * {N}; i++) {{
        *kept += w[i] > 0.0 ? 1 : 0; /* so that the first of the loops does not fetch the states for the other */
    }}
    start = now();
    *kept += decide_all(w, n);
    seconds[0] = now() - start;
    start = now();
    *kept += step_all(&m, w, at, n);
    seconds[1] = now() - start;
}}
void words(const double *w, const int *at, long n, int *found);
void words(const double *w, const int *at, long n, int *found)
{{
    {p}_monitor one;
    {p}_monitor *const m = &one;
    long i;
    (void)at;
    for (i = 0; i < n; i++) {{
        {p}_monitor_start(m);
        {p}_monitor_renew_all(m);
        {step}
        found[i] = {p}_monitor_step(m, w + i * {N}, {dt});
    }}
}}
"""


@dataclass
class Made:
    """A compiled monitor."""

    library: ctypes.CDLL
    path: Path
    asked: int = 0  # how often for costs

    def words(self, w, at):
        """The word of each state, by a monitor that has just been started, at these steps of the proof."""
        w, at, found = np.ascontiguousarray(w), np.ascontiguousarray(at, np.int32), np.zeros(len(w), np.int32)
        self.library.words(pointer(w), pointer(at), ctypes.c_long(len(w)), pointer(found))
        return found

    def costs(self, w, at):
        """Processor time of a step beside that of the decisions of all agents, both called once per state: the least of
        rounds in turn. Each round has states of its own: of a row that comes again, processors learn which way its
        branches go, and then a tree takes a fifth of what it takes in flight. Each time a copy is loaded, so that code
        and tables lie elsewhere: that may be a fifth of the time.
        """
        self.asked += 1
        library = ctypes.CDLL(shutil.copy(self.path, self.path.with_name(f"bench{self.asked}.so")))
        w, at = np.ascontiguousarray(w), np.ascontiguousarray(at, np.int32)
        kept, seconds, times = np.zeros(1, np.int32), np.zeros(2), []
        for part in np.array_split(np.arange(len(w)), ROUNDS):
            block = pointer(w[part[0] :]), pointer(at[part[0] :]), ctypes.c_long(len(part))
            library.cost(*block, pointer(kept), pointer(seconds))
            times.append(1e9 * seconds / len(part))
        decision, step = np.min(times, axis=0).tolist()
        return {"ratio": step / decision, "decision_ns": decision, "step_ns": step}


@contextmanager
def compiled(profile, proved, system=None):
    """The monitor of what is proved, and the decisions from the same states, compiled with -O3."""
    model = lower(profile)
    watched = lower_monitor(profile, model, proved)
    p, upper = model.prefix, model.prefix.upper()
    names = {
        "p": p,
        "N": watched.size,
        "dt": f"{upper}_DT" if watched.check.kind != "cover" else f"{upper}_M_DT",
        "step": "m->step = at[i];" if watched.check.kind == "cover" else "",
        "decide": _game(model) if system is None else _system(model, profile, system, proved.region.variables),
    }
    texts = {**emit(profile, ["c"]), **rendered.emit_monitors(watched, ["c"])}
    texts["run.c"] = (WITH_CLOCK + PROGRAM).format(**names)
    with tempfile.TemporaryDirectory(prefix="maviper-") as scratch:
        yield Made(built(Path(scratch), texts, (*OPTIMISED, *ALIGNED)), Path(scratch) / "run.so")


DECIDE = """static int decide(const double *w)
{{
    int actions[{count}];
{lines}
    return {total};
}}"""  # all agents' decisions from a state: the sum of their actions


def _filled(lines, count):
    total = " + ".join(f"actions[{k}]" for k in range(count))
    return DECIDE.format(lines="\n".join(lines), total=total, count=count)


def _game(model):
    """All agents' decisions from a world state."""
    return _filled([f"    {model.prefix}_act_team(w, actions);"], len(model.agents))


def _system(model, profile, system, measured):
    """All agents' decisions from a state: features in double as the file has them, rounded to what is compared; what is
    not measured, as roundings are not, is left out.
    """
    names = [one.name for one in measured]
    lines = []
    for k, (agent, policy) in enumerate(zip(model.agents, profile.agents, strict=True)):
        rows = [_feature(system.features[policy.agent][spec.name], names) for spec in policy.features]
        kind = agent.tables.threshold_type
        lines.append(f"    const {kind} x_{agent.lower}[{len(rows)}] = {{")
        lines += [f"        ({kind})({row})," for row in rows]
        lines += ["    };", f"    actions[{k}] = {agent.names.act}(x_{agent.lower});"]
    return _filled(lines, len(model.agents))


def _feature(feature, names):
    terms = [
        f"w[{names.index(name)}]" if factor == 1 else f"{float(factor)!r} * w[{names.index(name)}]"
        for name, factor in feature.form.terms
        if name in names
    ]
    form = " + ".join([*terms, *([repr(float(feature.form.constant))] if feature.form.constant or not terms else [])])
    if feature.measure is Measure.VALUE:
        return form
    return f"({form}) > 0.0 ? 1.0 : (({form}) < 0.0 ? -1.0 : 0.0)"  # as dear as any other measure


# --- judges


def meets(formula, at, acted, goal):
    """Where a formula holds. `at`: coordinates by name, `acted`: actions by agent, `goal`: the goal's place by axis."""
    match formula:
        case Linear(terms, bound, strict):
            total = sum(float(weight) * at[name] for weight, name in terms)
            return total < float(bound) if strict else total <= float(bound)
        case Acts(agent, action):
            return acted[agent] == action
        case Goal(landmark):
            return np.logical_and.reduce([goal[axis] == at[f"{landmark}.{axis}"] for axis in "xy"])
        case And():
            whole = np.ones(len(next(iter(at.values()))), dtype=bool)
            return np.logical_and.reduce([whole, *(meets(part, at, acted, goal) for part in formula.parts)])
        case Or():
            none = np.zeros(len(next(iter(at.values()))), dtype=bool)
            return np.logical_or.reduce([none, *(meets(part, at, acted, goal) for part in formula.parts)])
        case Not(part):
            return ~meets(part, at, acted, goal)


def acting(profile, w):
    """The action of every agent in each state of a game."""
    return {
        policy.agent: ir.act(policy, observe(policy.features, w, profile.world, policy.numbers))
        for policy in profile.agents
    }


def formula_of(certificate: Path, stated: bool = False):
    """The formula of a certificate about decisions; `stated`: whether it is about a world file."""
    if stated:
        return read_certificate(certificate)[0].claim.formula
    return read_formula(json.loads(certificate.read_text())["formula"])
