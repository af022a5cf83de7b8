"""States of episodes that are pushed after every step, for monitors under measurement, and what of claims breaks there.

Does: plays games and stated systems in numpy, many episodes at once; compares a monitor's words with a claim's formula
  or regions, and with what the file makes of a state one step on.
Assumes: a compiled monitor (monitored.py). A state is a row; every draw has a seed.
Does not: time anything, or share code with proofs.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from codegen.ir import act
from maviper import load
from maviper.compilation.monitors import load_proof
from maviper.worlds.stated.certified import read_certificate
from tests.support.monitored import acting, compiled, meets
from tests.support.stated_play import Played

STEPS, LONG = 25, 60  # of episodes of games, and of claims for ever
NOISE = 1e-3  # of a number: of the side of the region
PUSH = 0.3  # of games: standard deviation of what is added to a velocity after each step
SHIFT = 0.02  # of systems: the same of a variable, for the side of the hull of the proof's boxes


def episodes(profile: Any, count: int, seed: int, box: Any = None, push: float = PUSH) -> Any:
    """World states [count, STEPS, n_coordinates] of episodes from the start box, every step of which is perturbed.
    `box`: bounds of coordinates that start elsewhere; `push`: how much is added to velocities.
    """
    rng, world = np.random.default_rng(seed), profile.world
    at = {name: place for place, name in enumerate(world.coordinates())}
    w = np.zeros((count, len(at)))
    for entity in world.agents + world.landmarks:
        for axis in "xy":
            low, high = map(float, (box or {}).get(f"{entity.name}.{axis}", (world.start_low, world.start_high)))
            w[:, at[f"{entity.name}.{axis}"]] = rng.uniform(low, high, count)
    if world.goals:
        goal = rng.integers(len(world.goals), size=count)
        for axis in "xy":
            w[:, at[f"goal.{axis}"]] = np.choose(goal, [w[:, at[f"{name}.{axis}"]] for name in world.goals])
    found = np.empty((count, STEPS, len(at)))
    for step in range(STEPS):
        found[:, step] = w
        w = move_game(profile, w, acting(profile, w), push * rng.normal(size=(len(world.agents), 2, count)))
    return found


def move_game(profile: Any, w: Any, acted: Any, pushed: Any = None) -> Any:
    """States of a game one step on; `pushed`: what is added to velocities, [agents, 2, states]."""
    w, world = w.copy(), profile.world
    at = {name: place for place, name in enumerate(world.coordinates())}
    for number, entity in enumerate(world.agents):
        effects = np.array([each.effect or (0.0, 0.0) for each in profile.policy(entity.name).actions])
        speeds = [at[f"{entity.name}.v{axis}"] for axis in "xy"]
        for k, axis in enumerate("xy"):
            w[:, at[f"{entity.name}.{axis}"]] += world.dt * w[:, speeds[k]]
            force = world.dt * entity.force * effects[acted[entity.name]][:, k]
            w[:, speeds[k]] = (1.0 - world.damping) * w[:, speeds[k]] + force
            w[:, speeds[k]] += 0.0 if pushed is None else pushed[number, k]
        if entity.max_speed is not None:
            speed = np.hypot(*(w[:, place] for place in speeds))
            w[:, speeds] *= np.minimum(1.0, entity.max_speed / np.maximum(speed, 1e-9))[:, None]
    return w


class Watching:
    """A certificate about a stated system, with its monitor and a judge."""

    def __init__(self, certificate: Path, made: Any, proved: Any, profile: Any) -> None:
        found, statement = read_certificate(certificate)
        self.claim, self.cover, self.made, self.profile = found.claim, proved.region, made, profile
        self.played = Played(statement, profile)
        self.last = LONG if self.cover.ever else len(self.cover.steps) - 1
        self.ranges = np.array([[float(end) for end in one.range] for one in statement.system.variables]).T
        self.columns = [self.played.names.index(one.name) for one in self.cover.variables]

    def measured(self, w: Any) -> Any:
        """What of states the monitor is given: all but what agents round by."""
        return w[:, self.columns]

    def sides(self, step: int) -> Any:
        """Of the hull of the proof's boxes at a step, by variable; of what no box bounds, of its range; of what is not
        measured 0.
        """
        parts, sides = self.cover.steps[0 if self.cover.ever else step], np.zeros(self.ranges.shape[1])
        low = np.max([part.low.min(axis=0) for part in parts], axis=0)
        high = np.min([part.high.max(axis=0) for part in parts], axis=0)
        ends = self.measured(self.ranges)
        count = len(self.columns)  # then come sums
        sides[self.columns] = np.minimum(high[:count], ends[1]) - np.maximum(low[:count], ends[0])
        return sides

    def vouched(self, w: Any, step: int) -> Any:
        """For which states of a step the monitor vouches."""
        return self.made.words(self.measured(w), np.full(len(w), 0 if self.cover.ever else step)) <= 1

    def broken(self, w: Any, step: int) -> Any:
        """Which states of a step break the claim."""
        if self.claim.about_decisions:
            acted = {policy.agent: act(policy, self.played.observed(w, policy)) for policy in self.profile.agents}
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

    def moved(self, w: Any, step: int, rng: Any) -> Any:
        """The states one step on; None where nothing follows."""
        return None if self.claim.about_decisions or step == self.last else self.played.moved(w, rng)

    def ahead(self, after: Any, step: int, which: Any) -> Any:
        """Of which of some states the next one breaks the claim, and of which it is not vouched for."""
        if after is None:
            return np.zeros((2, int(which.sum())), dtype=bool)
        return np.stack([self.broken(after[which], step + 1), ~self.vouched(after[which], step + 1)])


def shuffled(profile: Any) -> Any:
    """A control that must fail: every leaf has the next action."""

    def turn(policy: Any) -> Any:
        action = policy.tree.action
        turned = np.where(action >= 0, (action + 1) % len(policy.actions), action)
        return replace(policy, tree=replace(policy.tree, action=turned))

    return replace(profile, agents=tuple(map(turn, profile.agents)))


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


def perturbed(watching: Watching, states: int, share: float = 1.0) -> dict[str, Any]:
    """What episodes show in which every state is pushed, or in each step a share of them."""
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
        after = watching.moved(w, step, rng)
        failing, (breaks, lost) = broken.copy(), watching.ahead(after, step, vouched)
        failing[vouched] |= breaks | lost
        seen["lost"] += int((lost & ~breaks).sum())
        wrong = control.broken(w, step) if watching.claim.about_decisions else broken
        ahead = control.ahead(control.moved(w[vouched], step, rng), step, np.ones(int(vouched.sum()), dtype=bool))
        seen["control"] += int(wrong[vouched].sum() + ahead.any(axis=0).sum())
        noisy = w[vouched] + NOISE * watching.sides(step) * rng.normal(size=w[vouched].shape)
        alarms += int((~watching.vouched(noisy, step)).sum())
        for key, found in (("states", np.ones_like(vouched)), ("vouched", vouched), ("fails", failing & vouched),
                           ("elsewhere", broken & ~vouched)):  # fmt: skip
            seen[key] += int(found.sum())
        left[(left < 0) & ~vouched] = step
        broke[(broke < 0) & broken] = step
        if step < watching.last:
            w = watching.starts(rng, count) if after is None else after  # of claims about decisions
            pushed = rng.random((len(w), 1)) < share
            w = w + SHIFT * watching.sides(step + 1) * pushed * rng.normal(size=w.shape)
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


# --- costs

COSTED = 140_000  # states whose decisions are timed, each once


def cost_watched(watching: Watching, calm: Sequence[Any]) -> dict[str, float]:
    """The costs of a monitor over states by step, mixed: so no branch is foreseen."""
    whole = np.concatenate(calm)
    at = np.concatenate([np.full(len(w), 0 if watching.cover.ever else step) for step, w in enumerate(calm)])
    order = np.random.default_rng(3).permutation(len(at))[:COSTED]
    return watching.made.costs(whole[order], at[order])


# --- claims for ever about games: whoever is vouched for is played some steps on

AHEAD = 20  # steps that are played from a state
SOME = 10  # one of so many states, from which that is done; from all others one step


def lasting(certificate: Path, profile_file: Path, states: int, costed: int) -> dict[str, Any]:
    """The figures of a claim that a team stays within a radius for ever."""
    profile = load(profile_file)
    proved, stated = load_proof(certificate, profile), json.loads(certificate.read_text())
    names, side = profile.world.coordinates(), profile.world.start_high - profile.world.start_low
    places = [names.index(f"{each.agent}.{axis}") for each in profile.team(stated["team"]) for axis in "xy"]

    radius = float(Fraction(stated["radius"]))

    def is_out(w: Any) -> Any:
        return (np.abs(w[:, places]) > radius).any(axis=1)

    def leaves(w: Any, shift: int) -> Any:
        """From which states a team leaves in some steps whose trees take other actions, by so many places."""
        out = is_out(w)
        for _ in range(AHEAD):
            acted = {
                name: (each + shift) % len(profile.policy(name).actions) for name, each in acting(profile, w).items()
            }
            w = move_game(profile, w, acted)
            out |= is_out(w)
        return out

    with compiled(profile, proved) as made:

        def vouched(w: Any) -> Any:
            return made.words(w, np.zeros(len(w), np.int32)) <= 1

        w = episodes(profile, -(-states // STEPS), 0).reshape(-1, len(names))[:states]
        held = vouched(w)
        kept = w[held]
        after = move_game(profile, kept, acting(profile, kept))
        fails = is_out(kept) | is_out(after)
        fails[::SOME] |= leaves(kept[::SOME], 0)
        calm = episodes(profile, -(-states // STEPS // 10), 2, push=0.0).reshape(-1, len(names))
        noisy = kept.copy()
        noisy[:, places] += np.random.default_rng(1).normal(scale=NOISE * side, size=(len(kept), len(places)))
        return made.costs(w[:costed], np.zeros(costed, np.int32)) | {
            "states": len(w),
            "vouched": float(held.mean()),
            "fails_while_vouched": int(fails.sum()),
            "lost": int((~vouched(after)).sum()),
            "fails_elsewhere": int(is_out(w[~held]).sum()),
            "control_fails": max(int(leaves(kept[::SOME], shift).sum()) for shift in range(1, 5)),
            "calm": len(calm),
            "refused": int((~vouched(calm)).sum()),
            "false_alarms": float((~vouched(noisy)).mean()),
            "warning": np.nan,
        }
