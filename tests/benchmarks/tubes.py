"""The tubes of the proofs in generated/arch, as one drawing: a state against time, the claim's region, episodes.

    python tests/benchmarks/tubes.py --plot FILE.svg [--thin] [NAME ...]

A tube is what the checker makes of a certificate: for each step of a period, the bounds of all of its sets, all times
of the step among them. Episodes start at random and are integrated by scipy. `--thin` joins neighbouring steps, so that
a file stays small: generated/arch/tubes.svg is `--thin pendulum tora_reach unicycle`.
"""

import argparse
import re
import sys
from fractions import Fraction
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for maviper, also when run by this path

import numpy as np

from codegen.numbers import nearest_double
from maviper.files.profiles import load
from maviper.worlds.stated.certified import read_certificate
from maviper.worlds.stated.systems import FlowRule, start
from verify.checker.envelope import numbers
from verify.checker.flows.sweep import FlowSweep, Plan
from verify.systems.observing import choose_actions

PLACE = Path(__file__).parents[2] / "generated" / "arch"
PANELS = {  # the number of a claim, and what is drawn: a variable, or a sum of some
    "pendulum": (1, "angle", {"angle": 1}),
    "nav": (1, "x1", {"x1": 1}),
    "acc": (1, "distance - 1.4 v", {"lead.p": 1, "ego.p": -1, "ego.v": -1.4}),
    "tora_remain": (1, "x1", {"x1": 1}),
    "tora_reach": (1, "x1", {"x1": 1}),
    "unicycle": (1, "x1", {"x1": 1}),
    "docking": (1, "x3 - n (x1 + x2)", {"x3": 1, "x1": -0.001027, "x2": -0.001027}),
    "attitude": (1, "x4", {"x4": 1}),
    "double_pendulum_less": (1, "th1", {"th1": 1}),
    "double_pendulum_more": (1, "th1", {"th1": 1}),
    "airplane": (1, "x2", {"x2": 1}),
    "quad": (1, "x3", {"x3": 1}),
    "cart_pole": (1, "x1", {"x1": 1}),
}
EPISODES, SEED, FINE = 8, 0, 100  # periods, up to which episodes are drawn between samples
THIN_EPISODES, THIN_STEPS, THIN_FINE = 4, 40, 10


def tube(statement, profile, certificate, weights):
    """The ends of each step in seconds, bounds of a sum over its sets, and bounds at the end of the last one."""
    sweep, steps, ends = FlowSweep(profile, statement.system, certificate.claim), {}, {}
    names = [each.name for each in statement.system.variables]
    terms = [(names.index(name), weight) for name, weight in weights.items()]

    def around(known, box):
        low = sum(weight * (box.low if weight > 0 else box.high)[:, column] for column, weight in terms)
        high = sum(weight * (box.high if weight > 0 else box.low)[:, column] for column, weight in terms)
        return min([known[0], *low]), max([known[1], *high])

    def see(told):
        key = told.period, told.step
        steps[key] = around(steps.get(key, (np.inf, -np.inf)), told.tube)
        ends[key] = around(ends.get(key, (np.inf, -np.inf)), told.after)

    sweep.watch = see
    widths = {sweep.columns[name]: nearest_double(width) for name, width in certificate.proof.cells.items()}
    sweep.run(Plan(list(numbers(certificate.proof.cuts)), certificate.proof.order, certificate.proof.steps, widths))
    part = float(statement.system.flow.period) / certificate.proof.steps
    begins = np.array([(period * certificate.proof.steps + step) * part for period, step in steps])
    low, high = np.array(list(steps.values())).T
    return begins, begins + part, low, high, ends[max(ends)]


def thinned(begins, ends, low, high):
    """The same with neighbouring steps joined, so that there are few."""
    count = -(-len(begins) // THIN_STEPS)
    places = np.arange(0, len(begins), count)
    last = np.minimum(places + count, len(begins)) - 1
    return begins[places], ends[last], np.minimum.reduceat(low, places), np.maximum.reduceat(high, places)


def episode(statement, profile, weights, rng, fine):
    """Times and values of one episode."""
    rule, state = FlowRule(statement.system.flow), start(statement, rng)
    names, steps = [each.name for each in statement.system.variables], statement.system.steps
    shares = np.array([0.25, 0.5, 0.75, 1.0]) if steps <= fine else np.array([1.0])
    times, values = [0.0], [sum(weight * state[name] for name, weight in weights.items())]
    for period in range(steps):
        exact = {name: Fraction(value) for name, value in state.items()}
        taken = choose_actions(statement.system, profile, exact)
        actions = {policy.agent: policy.actions[taken[policy.agent]].name for policy in profile.agents}
        found = rule.integrate_states(state, actions, shares * rule.period)
        times += ((period + shares) * rule.period).tolist()
        values += sum(weight * found[:, names.index(name)] for name, weight in weights.items()).tolist()
        state = dict(zip(names, found[-1].tolist(), strict=True))
    return times, values


def bounds(claim, weights):
    """What the first region of a claim says of a sum: the least and the largest number, where it says so."""
    low, high = None, None
    for half in claim.regions[0]:
        factors = {name: float(factor) for name, factor in half.form.terms}
        if factors.keys() != weights.keys():
            continue
        scale = next(factors[name] / weights[name] for name in factors)
        if all(abs(factors[name] - scale * weights[name]) < 1e-9 for name in factors):
            end = -float(half.form.constant) / scale
            low, high = (low, end) if scale > 0 else (end, high)
    return low, high


def panel(axes, name, thin):
    """Draws one question."""
    number, words, weights = PANELS[name]
    (path,) = (PLACE / name).glob(f"certificate-{number}-*.json")
    certificate, statement = read_certificate(path)
    profile, rng = load(PLACE / name / "profile.json"), np.random.default_rng(SEED)
    begins, ends, low, high, last = tube(statement, profile, certificate, weights)
    if thin:
        begins, ends, low, high = thinned(begins, ends, low, high)
    times = np.stack([begins, ends], axis=1).ravel()
    axes.fill_between(times, np.repeat(low, 2), np.repeat(high, 2), color="tab:blue", alpha=0.3, linewidth=0)
    axes.plot([ends[-1]] * 2, last, color="tab:blue", linewidth=2.5)
    for _ in range(THIN_EPISODES if thin else EPISODES):
        drawn = episode(statement, profile, weights, rng, THIN_FINE if thin else FINE)
        axes.plot(*drawn, color="black", linewidth=0.4)
    claim = certificate.claim
    period = float(statement.system.flow.period)
    since, until = claim.by * period, claim.steps * period
    wrong = "tab:red" if claim.says.avoided else "tab:green"
    for end in bounds(claim, weights):
        if end is not None:
            axes.plot([since, max(until, since + 0.02 * ends[-1])], [end, end], color=wrong, linewidth=1.5)
    axes.set_title(f"{name}: {words}", fontsize=8)
    axes.tick_params(labelsize=7)


def shortened(drawing):
    """An SVG with points of lines to a tenth."""
    return re.sub(r"(?m)^(L|M|<path d=\"M) .*$", lambda line: re.sub(r"(\d\.\d)\d+", r"\1", line[0]), drawing)


def main():
    """Draws the questions that are asked for, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=list(PANELS))
    parser.add_argument("--plot", type=Path, required=True, help="an SVG file to write")
    parser.add_argument("--thin", action="store_true", help="fewer episodes, and steps joined: a small file")
    options = parser.parse_args()
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "tubes"
    matplotlib.rcParams["svg.fonttype"] = "none" if options.thin else "path"
    matplotlib.rcParams["path.simplify_threshold"] = 0.5
    from matplotlib import pyplot

    rows = -(-len(options.names) // 3)
    figure, axes = pyplot.subplots(rows, 3, figsize=(10, 2.2 * rows), squeeze=False)
    for place, name in zip(axes.flat, options.names, strict=False):
        panel(place, name, options.thin)
    for place in axes.flat[len(options.names) :]:
        place.axis("off")
    figure.supxlabel(
        "seconds; blue: holds all states, a line at the end; green: bounds of the claim; red: of what it avoids",
        fontsize=8,
    )
    figure.tight_layout()
    figure.savefig(options.plot, metadata={"Date": None})
    options.plot.write_text(shortened(options.plot.read_text()))


if __name__ == "__main__":
    main()
