"""How fast claims about stated systems are decided and their certificates checked, beside two other ways.

    python tests/benchmarks/reach.py [--timeout 60] [--only NAME ...] [--json]

Yardsticks, in the same run: the whole episode as one query to z3's API (verify/solver/unrolled.py), given
--timeout seconds; and a box around all states of a step, propagated action by action, which proves or does not.
All times are of the processor. A query that ends with its time counts as that time, so the ratio is then a lower bound.

Cases: a quadrotor as a double integrator on three axes (one line of switching an axis, and a tree of depth 4 fitted to
that expert on positions and velocities, which joins the axes), a linearised pendulum with and without errors, two
agents in a corridor, two queues at a crossing.
"""

import argparse
import json
import math
import sys
import time
from fractions import Fraction as F
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from codegen.numbers import round_down
from tests.support import system_cases as cases
from tests.support.system_cases import decided, possible
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.systems.reading import goes_left
from verify.claims.formula import Linear, holds
from verify.result import Verdict
from verify.solver import unrolled
from verify.systems.claims import Pattern, SystemClaim

TARGETS = {
    "quadrotor, s": (60.0, 10.0, "lower"),
    "quadrotor, certificate, MB": (5.0, 1.0, "lower"),
    "quadrotor, check, s": (10.0, 3.0, "lower"),
    "direct Z3 over ours with certificate and check, geometric mean": (10.0, 100.0, "higher"),
}
AXES = "xyz"


def fitted(depth=4):
    """A tree of that depth on positions and velocities, fitted to the switching expert: it joins the axes."""
    random, names = np.random.default_rng(0), [*AXES, *(f"v{axis}" for axis in AXES)]
    seen = random.uniform(-1, 1, (20_000, 6)) * np.array([0.5] * 3 + [0.3] * 3)
    wanted = ((seen[:, :3] + 2 * seen[:, 3:] <= 0) * np.array([1, 2, 4])).sum(axis=1)
    found = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(seen.astype(np.float32), wanted)
    grown = found.tree_

    def nested(node):
        if grown.children_left[node] < 0:
            return int(found.classes_[np.argmax(grown.value[node])])
        test = int(grown.feature[node]), float(round_down(grown.threshold[node]))
        return test, nested(grown.children_left[node]), nested(grown.children_right[node])

    return cases.team(cases.policy("drone", names, [f"push{number}" for number in range(8)], nested(0)))


def asked():
    """Name -> system, profile, claim."""
    integrator = cases.double_integrator(axes=3)
    noisy = cases.double_integrator(axes=3, error=F(1, 1000))
    within = dict.fromkeys(AXES, (F(-1), F(1)))
    pendulum, shaken, crossing = cases.pendulum(), cases.pendulum(error=F(1, 2000)), cases.queue()
    avoids = SystemClaim(Pattern.AVOIDS, (cases.collision(F(1, 5)),), 15)
    return {
        "quadrotor": (integrator, fitted(), cases.stays(integrator, 30, **within)),
        "quadrotor, one line per axis": (integrator, cases.switching(3), cases.stays(integrator, 30, **within)),
        "the same with errors": (noisy, cases.switching(3), cases.stays(noisy, 30, **within)),
        "pendulum": (pendulum, cases.balancing(), cases.stays(pendulum, 20, angle=(F(-1, 10), F(1, 10)))),
        "pendulum with errors": (shaken, cases.balancing(), cases.stays(shaken, 20, angle=(F(-1, 8), F(1, 8)))),
        "corridor": (cases.corridor(), cases.passing(), avoids),
        "crossing": (crossing, cases.serving(), cases.stays(crossing, 20, north=(0, 12), east=(0, 12))),
    }


# --- boxes


def spread(form, box):
    low = high = form.constant
    for name, factor in form.terms:
        ends = sorted((factor * box[name][0], factor * box[name][1]))
        low, high = low + ends[0], high + ends[1]
    return low, high


def reached(system, policy, box):
    """The actions that an agent may take in a box."""
    tree, found, pending = policy.tree, set(), [0]
    while pending:
        node = pending.pop()
        if tree.feature[node] < 0:
            found.add(policy.actions[int(tree.action[node])].name)
            continue
        feature = system.features[policy.agent][policy.features[int(tree.feature[node])].name]
        side = goes_left(feature, float(tree.threshold[node]), tree.numbers)
        if isinstance(side, Linear):
            ends = spread(feature.form, box)
            shift = side.bound + feature.form.constant
            pending += [int(tree.left[node])] * (ends[0] <= shift) + [int(tree.right[node])] * (ends[1] >= shift)
        else:
            pending.append(int(tree.left[node] if side.parts == () else tree.right[node]))
    return sorted(found)


def boxes_prove(system, profile, claim):
    """Whether the box around all states of each step stays away from what breaks the claim."""
    box = {one.name: one.range for one in system.variables}
    for half in system.start:
        if len(half.form.terms) == 1:
            (name, factor), end = half.form.terms[0], -half.form.constant / half.form.terms[0][1]
            low, high = box[name]
            box[name] = (low, min(high, end)) if factor > 0 else (max(low, end), high)
    for step in range(claim.steps + 1):
        corners = [dict(zip(box, ends, strict=True)) for ends in zip(*box.values(), strict=True)]
        apart = claim.kind is Pattern.AVOIDS and any(
            spread(half.form, box)[0] > 0 for region in claim.regions for half in region
        )
        broken = claim.violation_at(step)
        inside = claim.kind is Pattern.STAYS_IN and not any(holds(broken, each, {}) for each in corners)
        if not apart and not inside:
            return False
        after = {}
        for piece in system.pieces:
            cut = {n: (max(box[n][0], low), min(box[n][1], high)) for n, (low, high) in piece.where.items()}
            if any(low > high for low, high in cut.values()):
                continue
            here = {**box, **cut}
            acts = {policy.agent: reached(system, policy, here) for policy in profile.agents}
            for name, form in piece.move.items():
                low, high = spread(form, here)
                for agent, actions in acts.items():
                    ends = [
                        spread(piece.effect[agent, one][name], here) if name in piece.effect[agent, one] else (0, 0)
                        for one in actions
                    ]
                    low, high = low + min(e[0] for e in ends), high + max(e[1] for e in ends)
                error = piece.error.get(name, (F(0), F(0)))
                before = after.get(name, (low + error[0], high + error[1]))
                after[name] = min(before[0], low + error[0]), max(before[1], high + error[1])
        box = after
    return True


# --- the run


def timed(call):
    began = time.process_time()  # other work on the machine does not count
    return call(), time.process_time() - began


def measured(system, profile, claim, timeout):
    (result,), took = timed(lambda: decided(profile, system, [claim]))
    row = {"verdict": result.verdict.value, "s": took, "states": result.states, "programs": result.programs}
    if result.verdict is Verdict.PROVED:
        row["bytes"] = len(to_json(result.certificate))
        _, row["check"] = timed(lambda: accept(result.certificate, profile, system))
    row["boxes"], row["boxes_s"] = timed(lambda: boxes_prove(system, profile, claim))
    row["z3"], row["z3_s"] = timed(lambda: possible(unrolled.encode_claim(profile, system, claim)[0], timeout * 1_000))
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--timeout", type=int, default=60, help="seconds for a query to Z3")
    parser.add_argument("--only", nargs="*", help="names of cases")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = {}
    for name, question in asked().items():
        if options.only and name not in options.only:
            continue
        rows[name] = row = measured(*question, options.timeout)
        z3 = {None: "no answer", True: "broken", False: "holds"}[row["z3"]]
        said = (
            f"{name:<26} {row['verdict']:<9} {row['s']:7.1f} s {row['states']:8,} states {row['programs']:7,} programs "
            f"{row.get('bytes', 0) / 1e6:7.3f} MB  check {row.get('check', 0):5.1f} s   "
            f"Z3: {z3} in {row['z3_s']:6.1f} s   boxes: {'prove' if row['boxes'] else 'fail'} ({row['boxes_s']:.2f} s)"
        )
        print(said, file=sys.stderr if options.json else sys.stdout, flush=True)
    ratios = [row["z3_s"] / (row["s"] + row.get("check", 0)) for row in rows.values()]
    values = {"direct Z3 over ours with certificate and check, geometric mean": math.exp(np.mean(np.log(ratios)))}
    if "quadrotor" in rows:
        row = rows["quadrotor"]
        values |= {"quadrotor, s": row["s"], "quadrotor, certificate, MB": row.get("bytes", math.inf) / 1e6}
        values["quadrotor, check, s"] = row.get("check", math.inf)
    if options.json:
        keys = ("reach", "stretch", "better")
        figures = [
            {"name": n, "value": float(v), **dict(zip(keys, TARGETS[n], strict=True))} for n, v in values.items()
        ]
        print(json.dumps({"figures": figures}))
    else:
        for name, value in values.items():
            print(f"{name}: {value:.3g} (reach {TARGETS[name][0]:g})")


if __name__ == "__main__":
    main()
