"""Questions about teams that test sums, in their game, for the hunt, and what is wrong with their answers.

Does: random teams of physical deception in random boxes; claims about decisions with errors of features and without,
  and about short episodes, each bound within 2 % of the extreme that the judge has sampled. Asks them by the door that
  a user takes, and hands proofs in under claims that are false.
Assumes: summing.py judges by the profile's file alone.
Does not: know world files.
"""

import copy
import json
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

from codegen.policy_json import dumps
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from tests.hunting.falsifying import Bounded, ask_claim
from tests.hunting.places import inner
from tests.hunting.reading import fractions
from tests.hunting.summing import GOAL, OWN, TEAM, Team
from tests.support.game_sums import team
from verify.claims.region import Region
from verify.claims.region_files import region_toml, start_region
from verify.decimals import plain

SAMPLES, PLAYED = 2_000, 12
BOXES = 50_000
ERRORS = (1, 2, 3, 6)  # powers of two below 1
SIDES = (8, 10, 12)  # of starts of episodes, likewise
EPISODES = ("stays_in", "keeps_apart", "reaches", "covers")
LEAST_RADIUS = Fraction(1, 1 << 40)


class Case(Bounded):
    """A team in a box, with a claim as the judge reads it."""

    checked = 4

    def __init__(self, seed):
        rng = np.random.default_rng([seed, 35])
        self.levels = int(rng.integers(1, 4))
        self.profile = team(seed + 1, (DOUBLE_SUMS, FLOAT32_STEPS)[int(rng.integers(2))], levels=self.levels)
        self.team = Team(json.loads(dumps(self.profile)))
        self.kind = str(rng.choice(["decides", "decides", "steady", *EPISODES]))
        self.moving = self.kind in EPISODES
        power = int(rng.choice(SIDES)) if self.moving else rng.uniform(3 if self.kind == "steady" else -1, 6)
        self.region = self._box(rng, Fraction(2.0**-power))
        self.steps = int(rng.integers(2, 5))
        self.eps = Fraction(1, 1 << int(rng.choice(ERRORS))) if self.kind == "steady" else Fraction(0)
        self.claim = self._claim(rng)

    def _box(self, rng, half):
        whole = start_region(self.profile.world)
        middles = {name: Fraction(int(rng.integers(-96, 97)), 128) for name in whole.box}
        ends = {
            name: (max(low, middles[name] - half), min(high, middles[name] + half))
            for name, (low, high) in whole.box.items()
        }
        return Region(ends, (GOAL,), name="drawn.toml")

    def _claim(self, rng):
        """A claim with a bound close to the most that the judge has sampled."""
        claim = self.near(rng) | {"kind": self.kind}
        if self.moving:  # a radius is above 0, and that of `keeps_apart` is one below which nobody may come
            ends = (-1 << 20, -LEAST_RADIUS) if self.kind == "keeps_apart" else (LEAST_RADIUS, 1 << 20)
            claim |= {key: min(max(claim[key], ends[0]), ends[1]) for key in ("bound", "false")}
        return claim

    def unbounded(self, rng):
        if self.moving:
            return {"agent": str(rng.choice(TEAM))}
        agent = str(rng.choice(TEAM))
        action = str(rng.choice([each.name for each in self.profile.policy(agent).actions]))
        names = [str(each) for each in rng.permutation(list(self.region.box))[:2]]
        return {"agent": agent, "action": action, "terms": [(int(rng.choice([-2, -1, 1])), name) for name in names]}

    def searched(self, claim, rng):
        """The claim with the most that its form reaches in states of the region, and the state: more than the bound
        breaks it. None where it says nothing of those that were sampled.
        """
        states, count = self._drawn(rng, PLAYED if self.moving else SAMPLES), SAMPLES
        if self.moving:
            starts = [{name: values[row] for name, values in states.items()} for row in range(PLAYED)]
            reached = [self._reach(claim, start, {}) for start in starts]
            row = int(np.argmax([float(each) for each in reached]))
            return claim | {"reached": reached[row], "best": (starts[row], {})}
        off = {}
        if self.eps:
            sides = {each.name: rng.choice([-1, 0, 1], count) for each in self.team.features[claim["agent"]]}
            off = {name: each * float(self.eps) for name, each in sides.items()}
        exact = {name: fractions(each) for name, each in off.items()}
        row = self.team.most(claim["agent"], claim["action"], claim["terms"], states, exact or None)
        if row is None:
            return claim | {"reached": None, "best": None}
        best = ({name: values[row] for name, values in each.items()} for each in (states, off))
        start, errors = best
        return claim | {"reached": self._reach(claim, start, errors), "best": (start, errors)}

    def _reach(self, claim, start, errors):
        """What a claim's form comes to from a start, exactly; None where it says nothing there."""
        if not self.moving:
            return self.team.total(claim, start, errors)
        if self.kind == "stays_in":
            return self.team.farthest(start, self.steps)
        if self.kind == "keeps_apart":
            return -self.team.nearest(start, self.steps)
        if self.kind == "reaches":
            return self.team.closest(claim["agent"], OWN[claim["agent"]], start, self.steps)
        return self.team.matched(start, self.steps)

    def _drawn(self, rng, count):
        ends = np.array([inner(*each) for each in self.region.box.values()])  # a rounded end may lie outside of the box
        drawn = rng.uniform(ends[:, 0], ends[:, 1], (count, len(ends)))
        cornered = rng.random(drawn.shape) < 0.2
        return dict(zip(self.region.box, np.where(cornered, ends[:, rng.integers(2)], drawn).T, strict=True))

    # --- cases beside it

    def widened(self, rng):
        """The same in a wider box."""
        other = copy.copy(self)
        more = Fraction(2.0 ** -int(rng.integers(2, 7)))
        whole = start_region(self.profile.world).box
        wide = {
            name: (max(low - more, whole[name][0]), min(high + more, whole[name][1]))
            for name, (low, high) in self.region.box.items()
        }
        other.region = Region(wide, (GOAL,), name="drawn.toml")
        return other

    def altered(self, profile):
        """The same of another team."""
        other = copy.copy(self)
        other.profile, other.team = profile, Team(json.loads(dumps(profile)))
        return other

    # --- files

    @property
    def asked(self):
        """The place of the claim among the questions of its world: `reaches` is one for each agent."""
        return TEAM.index(self.claim["agent"]) if self.kind == "reaches" else 0

    def world(self, claims):
        """The world of a claim, as a user's files state it."""
        with tempfile.TemporaryDirectory() as place:
            file, region = Path(place) / "claims.toml", Path(place) / "region.toml"
            file.write_text("".join(map(self._property, claims)))
            region.write_text(region_toml(self.region))
            options = VerifyOptions(file=file, region=str(region), max_boxes=BOXES, verdict_only=True)
            return StatedWorld.of_game(self.profile, options)

    def _property(self, claim):
        if self.moving:
            own = f"landmarks = {json.dumps(list(OWN.values()))}\n" if self.kind == "reaches" else ""
            radius = plain(abs(claim["bound"]))
            return f'[[property]]\nname = "{self.kind}"\nradius = {radius}\nsteps = {self.steps}\n{own}'
        sides = " + ".join(f"{weight}*{name}" for weight, name in claim["terms"])
        formula = f"acts({claim['agent']}) == {claim['action']} implies {sides} <= {plain(claim['bound'])}"
        eps = f"eps = {plain(self.eps)}\n" if self.eps else ""
        return f'[[property]]\nteam = "defenders"\nformula = "{formula}"\n{eps}'

    def replays(self, claim, found):
        """Whether a counterexample is a state of floats in the box that breaks the claim."""
        start = found.start
        at = {name: start[name] for name in self.region.box}
        inside = all(low <= at[name] <= high for name, (low, high) in self.region.box.items())
        agent = claim["agent"]
        off = {each.name: start.get(f"{agent}.error_{each.name}", Fraction(0)) for each in self.team.features[agent]}
        small = all(abs(each) <= self.eps for each in off.values())
        if not inside or not small or any(Fraction(float(each)) != each for each in (*at.values(), *off.values())):
            return False
        reached = self._reach(claim, at, off)
        return reached is not None and reached > claim["bound"]


def ask(seed, thorough):
    case = Case(seed)
    return ask_claim(case, case.claim, case.world([case.claim]), case.asked, seed, thorough)
