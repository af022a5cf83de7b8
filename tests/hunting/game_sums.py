"""Questions about teams that test sums, in their game, for the hunt, and what is wrong with their answers.

Does: random teams of physical deception in random boxes; claims about decisions with errors of features and without,
  each bound within 2 % of the extreme that the judge has sampled; claims about short episodes, likewise. Asks them by
  the door that a user takes.
Assumes: summing.py judges by the profile's file alone.
Does not: know world files.
"""

import json
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

from codegen.policy_json import dumps
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from tests.hunting.asking import Told
from tests.hunting.outputs import BEYOND, NEAR
from tests.hunting.reading import fractions
from tests.hunting.summing import GOAL, Team
from tests.support.game_sums import team
from verify.certificates.systems import to_json
from verify.checker.covers.certificates import from_json
from verify.claims.region import Region
from verify.claims.region_files import region_toml
from verify.claims.uncertified.starts import start_region
from verify.decimals import plain

SAMPLES, PLAYED = 2_000, 12
LEAST = 2.0**-7  # of an extreme whose hundredth part says something
BOXES = 50_000
CHECKED = 4  # of so many certificates one is given to the checker again
ERRORS = (1, 2, 3, 6)  # powers of two below 1
SIDES = (8, 10, 12)  # of starts of episodes, likewise


class Case:
    """A team in a box, with a claim as the judge reads it."""

    def __init__(self, seed):
        rng = np.random.default_rng([seed, 35])
        self.levels = int(rng.integers(1, 4))
        self.profile = team(seed + 1, (DOUBLE_SUMS, FLOAT32_STEPS)[int(rng.integers(2))], levels=self.levels)
        self.team = Team(json.loads(dumps(self.profile)))
        self.kind = str(rng.choice(["decides", "decides", "steady", "stays_in", "keeps_apart"]))
        self.moving = self.kind in ("stays_in", "keeps_apart")
        whole = start_region(self.profile.world)
        power = int(rng.choice(SIDES)) if self.moving else rng.uniform(3 if self.kind == "steady" else -1, 6)
        half = Fraction(2.0**-power)
        middles = {name: Fraction(int(rng.integers(-96, 97)), 128) for name in whole.box}
        ends = {
            name: (max(low, middles[name] - half), min(high, middles[name] + half))
            for name, (low, high) in whole.box.items()
        }
        self.region = Region(ends, (GOAL,), name="drawn.toml")
        self.steps = int(rng.integers(2, 5))
        self.eps = Fraction(1, 1 << int(rng.choice(ERRORS))) if self.kind == "steady" else Fraction(0)
        self.close = self.violated = False
        self.claim = self._moving(rng) if self.moving else self._deciding(rng)

    def _drawn(self, rng, count):
        ends = np.array([[float(end) for end in each] for each in self.region.box.values()])
        drawn = rng.uniform(ends[:, 0], ends[:, 1], (count, len(ends)))
        cornered = rng.random(drawn.shape) < 0.2
        return dict(zip(self.region.box, np.where(cornered, ends[:, rng.integers(2)], drawn).T, strict=True))

    def _deciding(self, rng):
        agent = str(rng.choice(["agent_0", "agent_1"]))
        action = str(rng.choice([each.name for each in self.profile.policy(agent).actions]))
        names = [str(each) for each in rng.permutation(list(self.region.box))[:2]]
        terms = [(int(rng.choice([-2, -1, 1])), name) for name in names]
        states, off = self._drawn(rng, SAMPLES), None
        if self.eps:
            sides = {each.name: rng.choice([-1, 0, 1], SAMPLES) for each in self.team.features[agent]}
            off = {name: fractions(each * float(self.eps)) for name, each in sides.items()}
        most = self.team.most(agent, action, terms, states, off)
        reached = Fraction(-1) if most is None else most[0]
        self.close = most is not None and abs(reached) >= LEAST
        near = max(abs(reached), Fraction(LEAST)) * NEAR
        beyond = rng.random() < BEYOND
        self.violated = most is not None and not beyond
        return {
            "agent": agent,
            "action": action,
            "terms": terms,
            "bound": _short(reached + (near if beyond else -near)),
        }

    def _moving(self, rng):
        drawn = self._drawn(rng, PLAYED)
        starts = [{name: values[row] for name, values in drawn.items()} for row in range(PLAYED)]
        far = self.kind == "stays_in"
        reached = [(self.team.farthest if far else self.team.nearest)(each, self.steps) for each in starts]
        extreme = max(reached) if far else min(reached)
        self.close = abs(extreme) >= LEAST
        near = max(abs(extreme), Fraction(LEAST)) * NEAR
        beyond = rng.random() < BEYOND
        self.violated = not beyond
        return {"radius": max(_short(extreme + (near if beyond is far else -near)), Fraction(1, 1 << 40))}

    def world(self):
        """The world of the claim, as a user's files state it."""
        with tempfile.TemporaryDirectory() as place:
            file, region = Path(place) / "claims.toml", Path(place) / "region.toml"
            file.write_text(self._property())
            region.write_text(region_toml(self.region))
            options = VerifyOptions(file=file, region=str(region), max_boxes=BOXES, verdict_only=True)
            return StatedWorld.of_game(self.profile, options)

    def _property(self):
        if self.moving:
            return f'[[property]]\nname = "{self.kind}"\nradius = {plain(self.claim["radius"])}\nsteps = {self.steps}\n'
        claim = self.claim
        sides = " + ".join(f"{weight}*{name}" for weight, name in claim["terms"])
        formula = f"acts({claim['agent']}) == {claim['action']} implies {sides} <= {plain(claim['bound'])}"
        eps = f"eps = {plain(self.eps)}\n" if self.eps else ""
        return f'[[property]]\nteam = "defenders"\nformula = "{formula}"\n{eps}'

    def replays(self, start):
        """Whether a counterexample is a state of floats in the box that breaks the claim."""
        at = {name: start[name] for name in self.region.box}
        inside = all(low <= at[name] <= high for name, (low, high) in self.region.box.items())
        if not inside or any(Fraction(float(each)) != each for each in at.values()):
            return False
        if self.kind == "stays_in":
            return self.team.farthest(at, self.steps) > self.claim["radius"]
        if self.kind == "keeps_apart":
            return self.team.nearest(at, self.steps) < self.claim["radius"]
        agent = self.claim["agent"]
        off = {each.name: start.get(f"{agent}.error_{each.name}", Fraction(0)) for each in self.team.features[agent]}
        small = all(abs(each) <= self.eps and Fraction(float(each)) == each for each in off.values())
        return small and self.team.exceeds(self.claim, at, off)


def _short(bound):
    """A decimal of few digits close to a number."""
    return Fraction(round(bound * 2**40), 2**40)


def ask(seed, thorough):
    """The answer to the question of a seed."""
    case = Case(seed)
    world = case.world()
    found = world.answer(world.asked[0].question, beside=thorough)
    verdict = found.verdict.value
    judged = "violated" if case.violated else ""
    told = Told(seed, verdict, case.kind, case.levels, conflict=True, judged=judged, close=case.close)
    if verdict == "PROVED" and case.violated:
        told.wrong.append("PROVED, and the judge has a state or an episode that breaks it")
    if verdict == "PROVED" and (thorough or seed % CHECKED == 0):
        certificate = found.evidence.certificate
        again = from_json(to_json(certificate))
        told.front = again == certificate and again.check(world.profile, world.statement.system) >= 0
        if not told.front:
            told.wrong.append("PROVED by a certificate that is another one once it is read")
    if verdict == "VIOLATED" and not case.replays(found.evidence.counterexample.start):
        told.wrong.append("VIOLATED by a state that is none, or breaks nothing")
    return told
