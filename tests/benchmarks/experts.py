"""How good the shipped experts are, beside the targets: 1,000 episodes that nothing else uses, worse ends of intervals.

    python tests/benchmarks/experts.py [--all] [--json]
    python -m tests.benchmarks.experts --curve [WORLD ...] [--seed 0] [--set NAME=VALUE ...] [--json] [--keep]
    python -m tests.benchmarks.experts --draw

--all: every shipped seed, not only the default ones. Training times are those of the cards; they belong to the machine
that the card names.

--curve: trains with the default recipe, or what it is cut to here, for two minutes at most. Against the fixed panel
(panel.py) it measures the actors as they are after so many seconds of the processor, measurements not counted: training
runs on one core, so these are the seconds on a machine that does nothing else. It says when the expert is usable: when
it first reaches, for all teams, what is called so here. --set changes a setting of the training, such as scaled=1.
--keep writes the points of the curves into curves.json, beside this file, over those of the same call.

--draw: draws the curves of predators and prey in that file into the manual.
"""

import argparse
import json
import sys
import time
from importlib import resources
from pathlib import Path

import numpy as np

from maviper.episodes import measures
from maviper.experts import network
from maviper.experts.scripted import build_script
from maviper.files import runs
from maviper.reproduction import figures as drawing
from maviper.worlds import find
from maviper.worlds.games.predator_prey import PREDATORS

SEEDS = range(9_100_000, 9_101_000)
# (world, label of the measure) -> (reach, stretch)
TARGETS = {
    ("physical-deception", "defenders success r=0.316"): (0.98, 0.99),
    ("physical-deception", "defenders success r=0.1"): (0.60, 0.90),
    ("physical-deception", "adversaries success r=0.316"): (0.55, 0.64),
    ("physical-deception,velocity=1", "defenders success r=0.316"): (0.98, 0.99),
    ("physical-deception,velocity=1", "defenders success r=0.1"): (0.60, 0.90),
    ("physical-deception,velocity=1", "adversaries success r=0.316"): (0.55, 0.64),
    ("cooperative-navigation", "agents D + collisions"): (0.70, 0.60),
}
RATIO_TARGETS = {"predators": (1.25, 1.5), "prey": (0.80, 0.60)}
TIME_TARGETS = (15 * 60, 3 * 60)
# world -> what is not as in the default recipe, and what is usable: team -> its measure on the panel
QUICK = {
    "physical-deception": ({"steps": 1_024_000}, {"defenders": 0.98, "adversaries": 0.55}),
    "cooperative-navigation": ({}, {"agents": 0.85}),
    "predator-prey": ({"steps": 3_072_000, "shaping": 10}, {"predators": 0.6, "prey": 2.0}),
    "predator-prey,observation=mpe2": ({"steps": 3_072_000, "shaping": 10}, {"predators": 1.5, "prey": 3.0}),
}
MAX_KEPT_BYTES = 2**20
MARKS = (5, 10, 20, 30, 45, 60, 80, 100, 120)  # seconds of the processor
CURVE_EPISODES = 500
KEPT = Path(__file__).with_name("curves.json")
PICTURE = Path(__file__).parents[2] / "maviper" / "manual" / "learning.svg"
DRAWN = {"predators": drawing.MARKS["iviper"], "prey": drawing.MARKS["maviper"]}
USABLE_TARGETS = (120, 20)


def card_of(name):
    stem = network.SHIPPED[name].removesuffix(".safetensors")
    return json.loads((resources.files("maviper.experts.shipped") / f"{stem}.json").read_text())


def figure(name, value, reach, stretch, better):
    return {"name": name, "value": value, "reach": reach, "stretch": stretch, "better": better}


def of_expert(name):
    expert, world = network.load(name)
    among = measures.evaluate(world, [expert] * len(world.agents), SEEDS)
    for measure in world.measures:
        found = among[measure]
        worse = found.interval[1 if measure.lower_is_better else 0]
        reach, stretch = TARGETS.get((world.name, measure.label), (None, None))
        better = "lower" if measure.lower_is_better else "higher"
        yield figure(f"{name}: {measure.label} {measures.format_estimate(found)}", worse, reach, stretch, better)
    if PREDATORS in world.teams:
        yield from touches(name, world, expert)
    yield figure(f"{name}: training seconds", card_of(name)["seconds"], *TIME_TARGETS, "lower")


def touches(name, world, expert):
    """Against fixed scripts, in the scripts' touches; the worse end of a bootstrap over common episodes."""
    script, rng = build_script(world), np.random.default_rng(0)
    episodes = world.start_from_seeds(SEEDS)
    draws = rng.integers(len(SEEDS), size=(2_000, len(SEEDS)))
    from maviper.episodes.play import play

    base = play(world, [script] * len(world.agents), episodes).values[0]
    for team in world.teams:
        mixed = [expert if agent in world.members(team) else script for agent in range(len(world.agents))]
        ours = play(world, mixed, episodes).values[0]
        ratios = ours[draws].mean(axis=1) / base[draws].mean(axis=1)
        low, high = np.quantile(ratios, (0.025, 0.975))
        lower = world.primary(team).lower_is_better
        text = f"{name}: {team} against the script, ratio {ours.mean() / base.mean():.3f} [{low:.3f}, {high:.3f}]"
        yield figure(text, high if lower else low, *RATIO_TARGETS[team], "lower" if lower else "higher")


def curve(name, seed, changed):
    """[(seconds, steps, team -> value on the panel)] of a short training. `changed`: settings, by name."""
    from maviper.experts.cards import Request
    from maviper.experts.training import mappo, train
    from tests.benchmarks import panel

    world, members = panel.panel(name)
    chosen = train.settings_of(world, Request("mappo", overrides={**QUICK[name][0], "seed": seed, **changed}))
    trainer, spent, found = mappo.Mappo(world, chosen, "cpu"), 0.0, []
    for mark in MARKS:
        while spent < mark and trainer.steps < chosen.steps:
            begun = time.process_time()
            trainer.advance()
            spent += time.process_time() - begun
        subject = {"learner": network.build_expert(world, trainer.tensors(), {"world": name})}
        reached = panel.judged(world, subject, members, CURVE_EPISODES)
        values = {team: float(np.mean(list(reached[team, "learner"].values()))) for team in world.teams}
        found.append((spent, trainer.steps, values))
        if trainer.steps >= chosen.steps:
            break
    return found


def usable_after(name, found):
    """Seconds until all teams first are at their usable values; infinite where that does not happen."""
    from tests.benchmarks import panel

    world, wanted = find(name), QUICK[name][1]
    for seconds, _, values in found:
        lower = {team: (panel.navigation(world) or world.primary(team)).lower_is_better for team in world.teams}
        if all(values[team] <= wanted[team] if lower[team] else values[team] >= wanted[team] for team in world.teams):
            return seconds
    return float("inf")


def curves(names, seed, changed, keep):
    for name in names or QUICK:
        found = curve(name, seed, changed)
        if keep:
            kept = json.loads(runs.read(KEPT, MAX_KEPT_BYTES)) if KEPT.exists() else {}
            points = [[round(seconds, 1), steps, values] for seconds, steps, values in found]
            called = " ".join([name, f"seed={seed}", *(f"{key}={value}" for key, value in sorted(changed.items()))])
            runs.write(KEPT, runs.as_json({**kept, called: points}))
        for seconds, steps, values in found:
            shown = ", ".join(f"{team} {value:.3f}" for team, value in values.items())
            print(f"{name}: after {seconds:.0f} s, {steps:,} steps: {shown}", file=sys.stderr)
        wanted = ", ".join(f"{team} {value:g}" for team, value in QUICK[name][1].items())
        text = f"{name}: seconds until usable on the panel ({wanted})"
        yield figure(text, usable_after(name, found), *USABLE_TARGETS, "lower")


def drawn(kept):
    """The curves of predators and prey, in touches over the panel, as SVG; means over the kept seeds at each mark."""
    plain = [called for called in kept if len(called.split()) == 2]  # of settings that nobody changed
    told = [kept[called] for called in plain if called.startswith("predator-prey ")]
    series = {team: [] for team in DRAWN}
    for at in range(min(map(len, told))):
        millions = float(np.mean([points[at][1] for points in told])) / 1e6
        for team, points in series.items():
            values = [each[at][2][team] for each in told]
            points.append(drawing.Point(float(np.mean(values)), np.nan, np.nan, millions))
    return drawing.lines("Touches an episode over the panel", "millions of joint steps", series, None, DRAWN)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("worlds", nargs="*")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--curve", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--draw", action="store_true")
    options = parser.parse_args()
    changed = dict(each.split("=", 1) for each in options.set)
    if options.draw:
        runs.write(PICTURE, drawn(json.loads(runs.read(KEPT, MAX_KEPT_BYTES))))
        return
    names = [name for name in network.SHIPPED if options.all or "@" not in name]
    own = (found for name in names for found in of_expert(name))
    figures = list(curves(options.worlds, options.seed, changed, options.keep) if options.curve else own)
    if options.json:
        print(json.dumps({"figures": figures}))
        return
    for item in figures:
        goal = "" if item["reach"] is None else f"  (reach {item['reach']:g}, stretch {item['stretch']:g})"
        print(f"{item['name']}: {item['value']:.3f}{goal}")


if __name__ == "__main__":
    main()
