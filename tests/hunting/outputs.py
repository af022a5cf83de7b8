"""Questions about outputs and tests of sums for the hunt, over observations, and what is wrong with their answers.

Does: random trees that test sums and give numbers, in three arithmetics, in random boxes; claims about an output, two
  outputs, two agents, an agent that observes with errors, an action; each bound lies within 2 % of the extreme that
  the judge has sampled. Asks them by the door that a user takes.
Assumes: giving.py judges by the profile's file alone.
Does not: know world files.
"""

import copy
import json
import tempfile
from fractions import Fraction
from functools import lru_cache
from itertools import count
from pathlib import Path

import numpy as np

from codegen.policy_json import dumps
from codegen.profiles import ensure
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from tests.hunting import giving
from tests.hunting.falsifying import Bounded, ask_claim
from tests.support import summed
from tests.support.giving import tamed
from verify.decimals import plain

TOGETHER = 4  # claims about one team, which one search decides
SAMPLES = 2_000
EXACTLY = 8  # of the states that reach most, which are looked at in exact numbers
FAR = 100_000_000  # beyond all numbers
KINDS = ("output", "outputs", "agents", "robust")


class Case(Bounded):
    """Agents of one kind in a box, with claims as the judge reads them and the answers to them."""

    drawn = 100  # an action may never be taken, an output may never change
    checked = 16

    def __init__(self, number):
        rng = np.random.default_rng([number, 34])
        arithmetic = (DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS)[int(rng.integers(3))]
        acting, levels = rng.random() < 0.3, int(rng.integers(0, 5))
        self.levels = max(levels, int(acting))  # a leaf alone that takes an action has nothing to sum
        gives = "float32" if arithmetic == DOUBLE_SUMS and rng.random() < 0.4 else None
        given = {"outputs": 0 if acting else 2, "levels": self.levels, "n_features": int(rng.integers(3, 6))}
        given |= {"gives": None if acting else gives, "bounded": rng.random() < 0.4}
        seeds = [int(each) for each in rng.integers(1 << 30, size=2)]
        made = [_draw_agent(seed, arithmetic, {**given, "agent": f"agent_{n}"}) for n, seed in enumerate(seeds)]
        self.profile = ensure(summed.profile(*made))
        self.box = {each.name: _ends(rng) for each in self.profile.agents[0].features}
        self.eps = float(rng.choice([1, 8, 64])) * 2.0**-8
        self.states = giving.States(json.loads(dumps(self.profile)), self.box, self.eps)
        self.claims = [self.near(rng, acting) for _ in range(TOGETHER)]

    def unbounded(self, rng, acting):
        one, other = (each.agent for each in self.profile.agents)
        kind = "action" if acting else str(rng.choice(KINDS))
        claim = {"kind": kind, "when": None, "both": rng.random() < 0.3}
        sign = int(rng.choice([1, -1]))
        if kind == "action":
            names = [str(each) for each in rng.permutation(list(self.box))[:2]]
            weights = rng.choice([-2, -1, 1], len(names)).tolist()
            claim["terms"] = [(w, "variable", one, name) for w, name in zip(weights, names, strict=True)]
            claim["when"] = one, str(rng.choice(self.states.agents[one].actions))
        elif kind == "robust":
            claim |= {"terms": [(1, "off", one, "u0"), (-1, "given", one, "u0")], "size": True}
        else:
            second = {"output": (0, one, "u1"), "outputs": (-sign, one, "u1"), "agents": (-sign, other, "u0")}[kind]
            claim["terms"] = [(sign, "given", one, "u0")]
            claim["terms"] += [(second[0], "given", *second[1:])] if second[0] else []
        return claim

    def searched(self, claim, rng):
        """The claim with the most that its terms reach in states of the box, and the states that reach most."""
        best = self.states.most(claim, rng, SAMPLES)
        claim = claim | {"best": best}
        return claim | {"reached": self.reach(claim, *(each[0].tolist() for each in best))}

    def widened(self, rng):
        """The same in a wider box."""
        other, more = copy.copy(self), float(rng.choice([0.125, 0.5, 1.0]))
        other.box = {name: (max(low - more, -3.0), min(high + more, 3.0)) for name, (low, high) in self.box.items()}
        other.states = giving.States(json.loads(dumps(self.profile)), other.box, self.eps)
        return other

    def altered(self, profile):
        """The same of other agents."""
        other = copy.copy(self)
        other.profile, other.states = profile, giving.States(json.loads(dumps(profile)), self.box, self.eps)
        return other

    def violated(self, claim):
        """Whether one of the states that reach most breaks it, in exact numbers."""
        numbers, errors = (each[:EXACTLY] for each in claim["best"])
        return any(self.exceeds(claim, *pair) for pair in zip(numbers.tolist(), errors.tolist(), strict=True))

    def exceeds(self, claim, numbers, errors):
        reached = self.reach(claim, numbers, errors)
        return reached is not None and reached > claim["bound"]

    def reach(self, claim, numbers, errors):
        """What its terms come to in a state, exactly; None where it says nothing there."""
        exact = [dict(zip(self.box, map(Fraction, each), strict=True)) for each in (numbers, errors)]
        return giving.exactly(self.states, claim, *exact)

    def replays(self, claim, found):
        """Whether a counterexample is a state of floats in the box that breaks it."""
        start = found.start
        numbers = [start[name] for name in self.box]
        errors = [start.get(f"{self.profile.agents[0].agent}_off.{name}", Fraction(0)) for name in self.box]
        inside = all(low <= each <= high for each, (low, high) in zip(numbers, self.box.values(), strict=True))
        small = claim["kind"] != "robust" or all(abs(each) <= Fraction(self.eps) for each in errors)
        floats = all(Fraction(float(each)) == each for each in numbers + errors)
        return inside and small and floats and self.exceeds(claim, numbers, errors)

    def world(self, claims):
        """The world of claims, as a user's files state them."""
        with tempfile.TemporaryDirectory() as place:
            file, region = Path(place) / "claims.toml", Path(place) / "region.toml"
            file.write_text("".join(map(self._property, claims)))
            region.write_text(
                "[box]\n" + "".join(f"{name} = [{low}, {high}]\n" for name, (low, high) in self.box.items())
            )
            shared = ("all",)
            return StatedWorld.of_observations(
                self.profile, VerifyOptions(file=file, region=str(region), shared=shared, verdict_only=True)
            )

    def _property(self, claim):
        bound = plain(claim["bound"])
        if claim["kind"] == "robust":
            agent = self.profile.agents[0].agent
            head = f'name = "robust"\nagent = "{agent}"\noutput = "u0"\neps = {plain(Fraction(self.eps))}\n'
            return f"[[property]]\n{head}most = {bound}\n"
        sides = [f"{weight}*{_word(kind, agent, name)}" for weight, kind, agent, name in claim["terms"]]
        sides = " + ".join(sides)
        lower = f"{sides} >= -{FAR} and " if claim["both"] else ""
        when = "" if claim["when"] is None else "acts({}) == {} implies ".format(*claim["when"])
        return f'[[property]]\nformula = "{when}({lower}{sides} <= {bound})"\n'


def _draw_agent(seed, arithmetic, given):
    """The first random agent from a seed on that tests sums or gives numbers."""
    drawn = (tamed(summed.policy(each, arithmetic, **given)) for each in count(seed))
    return next(each for each in drawn if each.tree.arithmetic)


def _word(kind, agent, name):
    return name if kind == "variable" else f"out({agent}).{name}"


def _ends(rng):
    """A range whose ends are numbers of few digits."""
    low, width = int(rng.integers(-24, 20)), int(rng.integers(1, 25))
    return low / 8, min(low + width, 24) / 8


@lru_cache(maxsize=1)
def one_case(number):
    case = Case(number)
    return case, case.world(case.claims)


def ask(seed, thorough):
    case, world = one_case(seed // TOGETHER)
    place = seed % TOGETHER
    return ask_claim(case, case.claims[place], world, place, seed, thorough)
