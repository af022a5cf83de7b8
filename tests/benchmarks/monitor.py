"""What a run-time monitor costs, how often it refuses noisy states, and whether its words hold.

    python -m tests.benchmarks.monitor [--json] [--states N] [--only WORD]

Of all committed proofs that have a monitor, and of proofs for ever of three committed worlds, which are made first.

Cost: a step of the monitor beside the decision of all agents from the same state, in C, in turn, over states of
episodes; the decision makes its observations from the state, too. Both are built into one loop over all states
(ratio), both are functions that are called for each (ratio_called), and a control step that decides is a function that
is called with a monitor and without (ratio_added: what it adds, as a multiple of the decision). No state comes twice,
and steps of all episodes are mixed, so that no branch is foreseen. In ratio_flown they come as in flight, episode by
episode. ratio_by_hand: the least that a monitor can be, called: one box for all states.
Refused: states of unperturbed episodes for which the monitor does not vouch (of games: states within the
region). Words: episodes in which every state is pushed at random after each step. A word of a game is judged by numpy
from the claim's formula; one of a stated system also by what the file makes of the state one step on: that must be
vouched for again, and keep the claim. Of turned boxes monitors may refuse a state near an edge: `lost` counts those
that came from one that was vouched for, and keep the claim. Noise: the monitor is given numbers that are off by a
normal error of 1/1000 of the side of the region, or of the hull of the proof's boxes; a false alarm is a word that does
not vouch for a state that is vouched for. Warning: of a game, the share of departures that LEAVING comes before; of
episodes, how many steps before the claim breaks the monitor stops to vouch, on average; nan where no pushed episode
breaks the claim.
Control: the same states with other trees, which must be seen to fail. Of claims about episodes of games whole episodes
are played: they fail while vouched for if no word was another; the control has the landmarks of other episodes.
"""

import argparse
import json
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen.ir import act
from codegen.lowering.turning import Turned
from maviper import load, verify_system
from maviper.compilation.monitors import load_proof
from maviper.worlds.stated.certified import read_certificate
from tests.support.followed import arriving
from tests.support.monitored import acting, compiled, formula_of, meets
from tests.support.shadowed import flying
from tests.support.stated_play import Played

GENERATED = Path(__file__).parents[2] / "generated"
GAMES = (
    "verdicts/physical_deception/certificate-1-distinct_targets",
    "verdicts/physical_deception/certificate-2-own_target",
    "verdicts/cooperative_navigation/certificate-1-distinct_targets",
    "verdicts/predator_prey/certificate-1-formula",
    "verdicts/predator_prey/certificate-2-formula",
    "physical_deception/certificate-1-distinct_targets",  # what the demo writes
    "proved_defenders/certificate-1-distinct_targets",
    "proved_navigation/certificate-1-distinct_targets",
)
EPISODES = (
    "verdicts/physical_deception/certificate-7-reaches",
    "verdicts/physical_deception/certificate-8-reaches",
)
FLOWN = "flight/certificate-1-reaches"  # with numbers that are off, in a closed loop
OFF = 0.007  # by how much its monitor lets numbers be off: 3.5 standard deviations of the noise
SYSTEMS = (
    "worlds/cart_pole/certificate-1-stays_in",
    "worlds/cart_pole/certificate-2-stays_in",
    "worlds/corridor/certificate-1-avoids",
    "worlds/crossing/certificate-1-stays_in",
    "worlds/mountain_car/certificate-1-stays_in",
    "worlds/pendulum/certificate-1-stays_in",
    "worlds/pendulum/certificate-2-decides",
    "worlds/quadrotor/certificate-1-stays_in",
    "worlds/quadrotor/certificate-2-reaches_and_stays",
    "worlds/tanks/certificate-1-stays_in",
    "worlds/tanks/certificate-2-always",
    "worlds/tanks/certificate-3-decides",
    "worlds/pendulum_v1/certificate-1-stays_in",
    "worlds/pendulum_v1/certificate-2-decides",
    "arch/acc/certificate-1-stays_in",
    "arch/airplane/certificate-1-stays_in",
    "arch/attitude/certificate-1-avoids",
    "arch/double_pendulum_less/certificate-1-stays_in",
    "arch/double_pendulum_more/certificate-1-stays_in",
    "arch/quad/certificate-1-reaches_and_stays",
    "arch/docking/certificate-1-stays_in",
    "arch/pendulum/certificate-1-reaches_and_stays",
    "arch/tora_reach/certificate-1-reaches_and_stays",
    "arch/tora_remain/certificate-1-stays_in",
    "arch/unicycle/certificate-1-reaches_and_stays",
)
FOR_EVER = {
    "quadrotor": "x = [-0.6, 0.6], y = [-0.6, 0.6], z = [-0.6, 0.6]",
    "pendulum": "angle = [-0.15, 0.15]",
    "crossing": "north = [0, 6], east = [0, 6]",
}
STATES = 1_000_000
STEPS, LONG = 25, 60  # of episodes of games, and of claims for ever
NOISE = 1e-3  # of a number: of the side of the region
SIDE = 2.0  # of the start region of games
PUSH = 0.3  # of games: standard deviation of what is added to a velocity after each step
SHIFT = 0.02  # of systems: the same of a variable, for the side of the hull of the proof's boxes
COSTED = 140_000  # states whose decisions are timed, each once
FIGURES = (
    *(
        "ratio",
        "ratio_called",
        "ratio_flown",
        "ratio_added",
        "ratio_by_hand",
        "decision_ns",
        "step_ns",
        "decision_called",
        "step_called",
        "control_ns",
    ),
    *("vouched", "fails_while_vouched", "lost", "fails_elsewhere", "control_fails"),
    *("refused", "false_alarms", "warning"),
)


# --- games


def episodes(profile: Any, count: int, seed: int) -> Any:
    """World states [count, STEPS, n_coordinates] of episodes from the start box, every step of which is perturbed."""
    rng, world = np.random.default_rng(seed), profile.world
    at = {name: place for place, name in enumerate(world.coordinates())}
    w = np.zeros((count, len(at)))
    for entity in world.agents + world.landmarks:
        for axis in "xy":
            w[:, at[f"{entity.name}.{axis}"]] = rng.uniform(world.start_low, world.start_high, count)
    if world.goals:
        goal = rng.integers(len(world.goals), size=count)
        for axis in "xy":
            w[:, at[f"goal.{axis}"]] = np.choose(goal, [w[:, at[f"{name}.{axis}"]] for name in world.goals])
    found = np.empty((count, STEPS, len(at)))
    effects = {
        policy.agent: np.array([each.effect or (0.0, 0.0) for each in policy.actions]) for policy in profile.agents
    }
    for step in range(STEPS):
        found[:, step] = w
        acted = acting(profile, w)
        for entity in world.agents:
            speeds = [at[f"{entity.name}.v{axis}"] for axis in "xy"]
            for k, axis in enumerate("xy"):
                w[:, at[f"{entity.name}.{axis}"]] += world.dt * w[:, speeds[k]]
                pushed = world.dt * entity.force * effects[entity.name][acted[entity.name]][:, k]
                w[:, speeds[k]] = (1.0 - world.damping) * w[:, speeds[k]] + pushed + PUSH * rng.normal(size=count)
            if entity.max_speed is not None:
                speed = np.hypot(*(w[:, place] for place in speeds))
                w[:, speeds] *= np.minimum(1.0, entity.max_speed / np.maximum(speed, 1e-9))[:, None]
    return found


def game(name: str, states: int) -> dict[str, Any]:
    """The figures of a claim about decisions of a game."""
    certificate = GENERATED / f"{name}.json"
    profile = load(certificate.parent / "profile.json")
    proved, formula = load_proof(certificate, profile), formula_of(certificate)
    names = profile.world.coordinates()
    played = episodes(profile, -(-states // STEPS), 0)
    w = np.ascontiguousarray(played.reshape(-1, len(names))[:states])
    at = dict(zip(names, w.T, strict=True))
    goal = {axis: at[f"goal.{axis}"] for axis in "xy"} if profile.world.goals else {}
    acted = acting(profile, w)
    failing = ~meets(formula, at, acted, goal)
    wrong = {policy.agent: (acted[policy.agent] + 1) % len(policy.actions) for policy in profile.agents}
    within = proved.region.holds(w, names)
    with compiled(profile, proved) as made:
        step = np.zeros(len(w), np.int32)
        found = made.words(w, step)
        vouched = found <= 1
        seen, rng = w.copy(), np.random.default_rng(1)
        moving = [names.index(f"{agent.name}.{axis}") for agent in profile.world.agents for axis in "xy"]
        side = profile.world.start_high - profile.world.start_low
        seen[:, moving] += rng.normal(scale=NOISE * side, size=(len(w), len(moving)))
        noisy = made.words(seen, step)
        figures = made.costs(w[:COSTED], step[:COSTED])
    whole = found[: len(found) // STEPS * STEPS].reshape(-1, STEPS)
    out = (whole[:, 1:] == 2) & (whole[:, :-1] <= 1)
    return figures | {
        "states": len(w),
        "vouched": float(vouched.mean()),
        "fails_while_vouched": int((failing & vouched).sum()),
        "fails_elsewhere": int((failing & ~vouched).sum()),
        "control_fails": int((~meets(formula, at, wrong, goal) & vouched).sum()),
        "refused": int((within & ~vouched).sum()),
        "false_alarms": float((noisy[found == 0] != 0).mean()),
        "warning": float((whole[:, :-1] == 1)[out].mean()) if out.any() else np.nan,
    }


# --- stated systems


def for_ever(name: str, folder: Path) -> Path:
    """The proof that a committed world keeps a claim for ever, made anew."""
    for file in ("profile.json", "world.toml"):
        shutil.copy(GENERATED / "worlds" / name / file, folder)
    (folder / "ever.toml").write_text(f'[[property]]\nname = "always"\nregion = {{ box = {{ {FOR_EVER[name]} }} }}\n')
    found = verify_system(load(folder / "profile.json"), folder / "world.toml", folder / "ever.toml")
    ((_, text),) = found.certificates.items()
    (folder / "certificate.json").write_text(text)
    return folder / "certificate.json"


class Watching:
    """A certificate about a stated system, with its monitor and a judge."""

    def __init__(self, certificate: Path, made: Any, proved: Any, profile: Any) -> None:
        found, statement = read_certificate(certificate)
        self.claim, self.cover, self.made, self.profile = found.claim, proved.region, made, profile
        self.played = Played(statement, profile)
        self.turned = isinstance(self.cover.steps[0][0], Turned)
        self.last = LONG if self.cover.ever else len(self.cover.steps) - 1
        self.ranges = np.array([[float(end) for end in one.range] for one in statement.system.variables]).T

    def sides(self, step: int) -> Any:
        """Of the hull of the proof's boxes at a step, by variable; of what no box bounds, of its range."""
        parts = self.cover.steps[0 if self.cover.ever else step]
        low = np.max([part.low.min(axis=0) for part in parts], axis=0)
        high = np.min([part.high.max(axis=0) for part in parts], axis=0)
        return np.minimum(high, self.ranges[1]) - np.maximum(low, self.ranges[0])

    def vouched(self, w: Any, step: int) -> Any:
        """For which states of a step the monitor vouches."""
        return self.made.words(w, np.full(len(w), 0 if self.cover.ever else step)) <= 1

    def broken(self, w: Any, step: int) -> Any:
        """Which states of a step break the claim."""
        if self.claim.about_decisions:
            acted = {policy.agent: acting_of(self.played, w, policy) for policy in self.profile.agents}
            return ~meets(self.claim.formula, self.played.at(w), acted, {})
        inside = self.played.inside(w, self.claim.regions)
        if self.claim.says.avoided:
            return inside
        return ~inside if not self.claim.says.first or step >= self.claim.by else np.zeros(len(w), dtype=bool)

    def starts(self, rng: Any, count: int) -> Any:
        """Where episodes start; of claims about decisions, anywhere."""
        if not self.claim.about_decisions:
            return self.played.starts(rng, count)
        return self.ranges[0] + rng.random((count, self.ranges.shape[1])) * (self.ranges[1] - self.ranges[0])

    def ahead(self, w: Any, step: int, rng: Any) -> Any:
        """Of which states the next one breaks the claim, and of which it is not vouched for."""
        if self.claim.about_decisions or step == self.last:
            return np.zeros((2, len(w)), dtype=bool)
        after = self.played.moved(w, rng)
        return np.stack([self.broken(after, step + 1), ~self.vouched(after, step + 1)])


def acting_of(played: Played, w: Any, policy: Any) -> Any:
    """The action of an agent in each state."""
    return act(policy, played.observed(w, policy))


def shuffled(profile: Any) -> Any:
    """A control that must fail: every leaf has the next action."""
    return replace(
        profile,
        agents=tuple(
            replace(
                each,
                tree=replace(
                    each.tree,
                    action=np.where(
                        each.tree.action >= 0, (each.tree.action + 1) % len(each.actions), each.tree.action
                    ),
                ),
            )
            for each in profile.agents
        ),
    )


def system(certificate: Path, states: int) -> dict[str, Any]:
    """The figures of a claim about a stated system."""
    profile = load(certificate.parent / "profile.json")
    proved = load_proof(certificate, profile)
    _, statement = read_certificate(certificate)
    with compiled(profile, proved, statement.system) as made:
        watching = Watching(certificate, made, proved, profile)
        calm, refused = unperturbed(watching, max(100, states // 200))
        at = np.concatenate([np.full(len(w), 0 if watching.cover.ever else step) for step, w in enumerate(calm)])
        order = np.random.default_rng(3).permutation(len(at))[:COSTED]
        costs = made.costs(np.concatenate(calm)[order], at[order])
        flown = np.arange(len(at)).reshape(len(calm), -1).T.ravel()[:COSTED]  # episode by episode
        costs |= {"ratio_flown": made.costs(np.concatenate(calm)[flown], at[flown])["ratio_called"], "refused": refused}
        return costs | perturbed(watching, states)


def unperturbed(watching: Watching, count: int) -> tuple[list[Any], int]:
    """The states of episodes that nobody pushes, by step, and how many of them the monitor does not vouch for."""
    rng, refused, found = np.random.default_rng(2), 0, []
    w = watching.starts(rng, count)
    for step in range(watching.last + 1):
        found.append(w)
        if watching.claim.about_decisions:
            return found, 0
        refused += int((~watching.vouched(w, step)).sum())
        if step < watching.last:
            w = watching.played.moved(w, rng)
    return found, refused


def perturbed(watching: Watching, states: int) -> dict[str, Any]:
    """What episodes show in which every state is pushed."""
    rng, count = np.random.default_rng(0), -(-states // (watching.last + 1))
    control = Watching.__new__(Watching)
    control.__dict__.update(watching.__dict__)
    control.played = Played(watching.played.statement, shuffled(watching.profile))
    control.profile = control.played.profile
    w, seen = (
        watching.starts(rng, count),
        dict.fromkeys(("states", "vouched", "fails", "elsewhere", "control", "lost"), 0),
    )
    alarms, left, broke = 0, np.full(count, -1), np.full(count, -1)
    for step in range(watching.last + 1):
        w = w[np.isfinite(w).all(axis=1)] if watching.claim.about_decisions else np.nan_to_num(w, nan=0.0)
        vouched, broken = watching.vouched(w, step), watching.broken(w, step)
        failing, (breaks, lost) = broken.copy(), watching.ahead(w[vouched], step, rng)
        failing[vouched] |= breaks if watching.turned else breaks | lost
        seen["lost"] += int((lost & ~breaks).sum())
        wrong = control.broken(w, step) if watching.claim.about_decisions else broken
        seen["control"] += int(wrong[vouched].sum() + control.ahead(w[vouched], step, rng).any(axis=0).sum())
        noisy = w[vouched] + NOISE * watching.sides(step) * rng.normal(size=w[vouched].shape)
        alarms += int((~watching.vouched(noisy, step)).sum())
        for key, found in (("states", np.ones_like(vouched)), ("vouched", vouched), ("fails", failing & vouched),
                           ("elsewhere", broken & ~vouched)):  # fmt: skip
            seen[key] += int(found.sum())
        left[(left < 0) & ~vouched] = step
        broke[(broke < 0) & broken] = step
        if step < watching.last:
            w = watching.starts(rng, count) if watching.claim.about_decisions else watching.played.moved(w, rng)
            w = w + SHIFT * watching.sides(step + 1) * rng.normal(size=w.shape)
    both = broke >= 0
    return {
        "states": seen["states"],
        "vouched": seen["vouched"] / seen["states"],
        "fails_while_vouched": seen["fails"],
        "lost": seen["lost"],
        "fails_elsewhere": seen["elsewhere"],
        "control_fails": seen["control"],
        "false_alarms": alarms / max(1, seen["vouched"]),
        "warning": float((broke - left)[both].mean()) if both.any() and not watching.claim.about_decisions else np.nan,
    }


def measured(states: int, only: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """The figures of each proof, by its name."""
    for name in GAMES:
        if only in name:
            yield name, game(name, states)
    for name in EPISODES:
        if only in name:
            yield name, arriving(GENERATED / f"{name}.json", states)
    if only in FLOWN:
        profile = GENERATED / "verdicts" / "physical_deception" / "profile.json"
        yield FLOWN, flying(GENERATED / f"{FLOWN}.json", profile, states, OFF, NOISE * SIDE)
    for name in SYSTEMS:
        if only in name:
            yield name, system(GENERATED / f"{name}.json", states)
    for name in FOR_EVER:
        if only in f"worlds/{name}/always":
            with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
                yield f"worlds/{name}/always", system(for_ever(name, Path(folder)), states)


def main() -> None:
    """Prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--states", type=int, default=STATES)
    parser.add_argument("--only", default="", metavar="WORD", help="proofs whose name holds it")
    given = parser.parse_args()
    if given.json:
        found = dict(measured(given.states, given.only))
        targets = dict.fromkeys(("ratio", "ratio_called", "ratio_flown", "ratio_added"), 2.0)
        targets |= {"fails_while_vouched": 0, "refused": 0, "false_alarms": 0.05}
        figures = [
            {"name": f"{proof}: {name}", "value": row[name], "reach": reach, "stretch": reach, "better": "lower"}
            for proof, row in found.items()
            for name, reach in targets.items()
            if name in row
        ]
        print(json.dumps({"figures": figures}))
        return
    print(f"{'':50}" + "".join(f"{name:>20}" for name in FIGURES), flush=True)
    for proof, row in measured(given.states, given.only):
        print(f"{proof:50}" + "".join(f"{row.get(name, np.nan):20,.4g}" for name in FIGURES), flush=True)


if __name__ == "__main__":
    main()
