"""What a run-time monitor costs, how often it refuses noisy states, and whether its words hold.

    python -m tests.benchmarks.monitor [--json] [--states N]

Of the committed proof that two defenders have distinct targets. Cost: a step of the monitor beside the decision of all
agents from the same world state, in C, in turn, over states of episodes. Words: episodes in which every velocity is
pushed at random after each step; the claim is judged by numpy alone, from its definition. Noise: the monitor is given
positions of agents that are off by a normal error of 1/1000 of the region's side, and a false alarm is a word other
than OK where the true state has OK. Warning: the share of departures that LEAVING comes one
step before. Control: a team that breaks the claim, so that the judge is seen to say so.
"""

import argparse
import ctypes
import json
import subprocess
import tempfile
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.agreement.compiled import STRICT, find_compiler
from codegen.lowering.lower import lower
from codegen.lowering.watching import Watch, watch
from codegen.observe import observe
from codegen.region import RegionSpec
from codegen.targets import emit, monitor
from maviper import load
from maviper.compilation.monitors import proved_by

FOLDER = Path(__file__).parents[2] / "generated" / "verdicts" / "physical_deception"
CERTIFICATE = FOLDER / "certificate-1-distinct_targets.json"
STATES = 1_000_000
STEPS = 25
NOISE = 2e-3  # of a position: 1/1000 of the side of the region
PUSH = 0.3  # standard deviation of what is added to a velocity after each step
ROUNDS = 7
PROGRAM = """#include "{p}_monitor.h"
#include <time.h>
static double now(void)
{{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}}
void cost(const double *w, long n, int *kept, double *seconds);
void cost(const double *w, long n, int *kept, double *seconds)
{{
    int actions[{agents}];
    {p}_monitor m;
    double start = now();
    long i;
    int k;
    for (i = 0; i < n; i++) {{
        {p}_act_team(w + i * {N}, actions);
        for (k = 0; k < {agents}; k++) {{
            *kept += actions[k];
        }}
    }}
    seconds[0] = now() - start;
    {p}_monitor_start(&m);
    start = now();
    for (i = 0; i < n; i++) {{
        {p}_monitor_renew_all(&m);
        *kept += {p}_monitor_step(&m, w + i * {N}, {P}_DT);
        m.latched = 0;
    }}
    seconds[1] = now() - start;
}}
void words(const double *w, long n, int *found);
void words(const double *w, long n, int *found)
{{
    {p}_monitor m;
    long i;
    for (i = 0; i < n; i++) {{
        {p}_monitor_start(&m);
        {p}_monitor_renew_all(&m);
        found[i] = {p}_monitor_step(&m, w + i * {N}, {P}_DT);
    }}
}}
"""


def library(texts: dict[str, Any], watched: Watch, folder: Path) -> ctypes.CDLL:
    """The monitor and the decisions, compiled."""
    p = watched.model.prefix
    for name, text in texts.items():
        (folder / name).write_text(text)
    names = {"p": p, "P": p.upper(), "N": len(watched.model.places), "agents": len(watched.model.agents)}
    (folder / "bench.c").write_text("#define _POSIX_C_SOURCE 199309L\n" + PROGRAM.format(**names))
    flags = [*(each for each in STRICT if "pedantic" not in each), "-O3", "-shared", "-fPIC"]
    subprocess.run([*(find_compiler() or ["cc"]), *flags, "bench.c", "-o", "bench.so"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "bench.so"))


def pointer(array: Any) -> ctypes.c_void_p:
    """Of a contiguous array."""
    return array.ctypes.data_as(ctypes.c_void_p)


def episodes(profile: ir.PolicyProfile, count: int, seed: int) -> Any:
    """World states [count, STEPS, n_coordinates] of episodes from the start box, every step of which is perturbed."""
    rng, world = np.random.default_rng(seed), profile.world
    at = {name: place for place, name in enumerate(world.coordinates())}
    w = np.zeros((count, len(at)))
    for entity in world.agents + world.landmarks:
        for axis in "xy":
            w[:, at[f"{entity.name}.{axis}"]] = rng.uniform(world.start_low, world.start_high, count)
    goal = rng.integers(len(world.goals), size=count)
    for axis in "xy":
        w[:, at[f"goal.{axis}"]] = np.choose(goal, [w[:, at[f"{name}.{axis}"]] for name in world.goals])
    found = np.empty((count, STEPS, len(at)))
    for step in range(STEPS):
        found[:, step] = w
        pushes = {
            policy.agent: np.array([each.effect or (0.0, 0.0) for each in policy.actions])[acted(profile, policy, w)]
            for policy in profile.agents
        }
        for entity in world.agents:
            for k, axis in enumerate("xy"):
                place, speed = at[f"{entity.name}.{axis}"], at[f"{entity.name}.v{axis}"]
                w[:, place] += world.dt * w[:, speed]
                w[:, speed] *= 1.0 - world.damping
                w[:, speed] += world.dt * entity.force * pushes[entity.name][:, k] + PUSH * rng.normal(size=count)
    return found


def acted(profile: ir.PolicyProfile, policy: ir.AgentPolicy, w: Any) -> Any:
    """The action of an agent in each state."""
    return ir.act(policy, observe(policy.features, w, profile.world, policy.numbers))


def fails(profile: ir.PolicyProfile, w: Any) -> Any:
    """Where no matching of defenders and landmarks has each defender close in on its own, or be at it: the claim."""
    at = {name: place for place, name in enumerate(profile.world.coordinates())}
    team, landmarks = profile.team("defenders"), [each.name for each in profile.world.landmarks]
    engaged = {}
    for policy in team:
        effect = np.array([each.effect or (0.0, 0.0) for each in policy.actions])[acted(profile, policy, w)]
        for name in landmarks:
            offset = np.stack([w[:, at[f"{name}.{axis}"]] - w[:, at[f"{policy.agent}.{axis}"]] for axis in "xy"], 1)
            engaged[policy.agent, name] = ((effect * offset).sum(1) > 0.0) | (np.abs(offset).max(1) <= 0.1)
    holds = np.zeros(len(w), dtype=bool)
    for order in permutations(landmarks, len(team)):
        holds |= np.logical_and.reduce([engaged[each.agent, name] for each, name in zip(team, order, strict=True)])
    return ~holds


def measured(states: int) -> dict[str, float]:
    """The figures."""
    profile, proved = load(FOLDER / "profile.json"), proved_by(CERTIFICATE, load(FOLDER / "profile.json"))
    model = lower(profile)
    watched = watch(profile, model, proved.region, proved.certificate, proved.claim)
    texts = {**emit(profile, ["c"]), **monitor.emit(watched, ["c"])}
    with tempfile.TemporaryDirectory(prefix="maviper-") as scratch:
        made = library(texts, watched, Path(scratch))
        played = episodes(profile, -(-states // STEPS), 0)
        w = np.ascontiguousarray(played.reshape(-1, played.shape[-1])[:states])
        found = words_of(made, w)
        return (
            costs(made, w[:20_000])
            | said(profile, proved.region, w, found)
            | noisy(profile, made, w, found)
            | warned(found[: len(found) // STEPS * STEPS].reshape(-1, STEPS))
        )


def words_of(made: ctypes.CDLL, w: Any) -> Any:
    """The word of each state, by a monitor that has just been started."""
    found = np.zeros(len(w), np.int32)
    made.words(pointer(w), ctypes.c_long(len(w)), pointer(found))
    return found


def costs(made: ctypes.CDLL, w: Any) -> dict[str, float]:
    """Processor time of a step beside that of the decisions: the median of rounds in turn."""
    kept, seconds, ratios = np.zeros(1, np.int32), np.zeros(2), []
    for _ in range(ROUNDS):
        made.cost(pointer(w), ctypes.c_long(len(w)), pointer(kept), pointer(seconds))
        ratios.append((seconds[1] / seconds[0], seconds[1] / len(w)))
    return {"ratio": float(np.median([each for each, _ in ratios])), "step_ns": 1e9 * min(each for _, each in ratios)}


def said(profile: ir.PolicyProfile, region: RegionSpec, w: Any, found: Any) -> dict[str, float]:
    """How often the monitor vouches, and how often the claim fails where it does and where it does not."""
    failing, vouched = fails(profile, w), found <= 1
    within = region.holds(w, profile.world.coordinates())
    return {
        "states": len(w),
        "vouched": float(vouched.mean()),
        "fails_while_vouched": int((failing & vouched).sum()),
        "fails_elsewhere": int((failing & ~vouched).sum()),
        "control_fails": int((fails(_alike(profile), w) & vouched).sum()),
        "inside_but_refused": int((within & ~vouched).sum()),
    }


def _alike(profile: ir.PolicyProfile) -> ir.PolicyProfile:
    """A control that must fail: both defenders act by the first one's tree."""
    first, _ = team = profile.team("defenders")
    changed = tuple(replace(each, tree=first.tree) if each in team else each for each in profile.agents)
    return replace(profile, agents=changed)


def noisy(profile: ir.PolicyProfile, made: ctypes.CDLL, w: Any, found: Any) -> dict[str, float]:
    """The share of states with OK that the monitor does not call so from noisy positions of the agents."""
    rng, seen, names = np.random.default_rng(1), w.copy(), profile.world.coordinates()
    positions = [names.index(f"{agent.name}.{axis}") for agent in profile.world.agents for axis in "xy"]
    seen[:, positions] += rng.normal(scale=NOISE, size=(len(w), len(positions)))
    again = words_of(made, np.ascontiguousarray(seen))
    calm = found == 0
    return {"false_alarms": float((again[calm] != 0).mean())}


def warned(found: Any) -> dict[str, float]:
    """The share of departures that LEAVING comes before, and the steps between."""
    out = (found[:, 1:] == 2) & (found[:, :-1] <= 1)
    before = found[:, :-1] == 1
    return {"departures": int(out.sum()), "warned_one_step_before": float(before[out].mean()) if out.any() else 1.0}


def main() -> None:
    """Prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--states", type=int, default=STATES)
    given = parser.parse_args()
    found = measured(given.states)
    if given.json:
        targets = {"ratio": 2.0, "fails_while_vouched": 0, "false_alarms": 0.05}
        figures = [
            {"name": name, "value": found[name], "reach": reach, "stretch": reach, "better": "lower"}
            for name, reach in targets.items()
        ]
        print(json.dumps({"figures": figures}))
        return
    for name, value in found.items():
        print(f"{name:24} {value:,.4g}")


if __name__ == "__main__":
    main()
