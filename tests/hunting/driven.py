"""Questions about stated systems whose agents give numbers or test sums, for the hunt, and what is wrong with answers.

Does: random systems of affine rules, with errors and without, and one or two random agents, whose features are affine
  forms; claims about single states and about short episodes. Each bound lies within 2 % of the extreme that the judge
  has searched. Asks them by a world file, as a user does.
Assumes: driving.py judges by plain data and the profile's file.
Does not: know games, or observations as variables (outputs.py).
"""

import copy
import json
import tempfile
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from pathlib import Path

import numpy as np

from codegen.policy_json import dumps
from codegen.profiles import ensure
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from tests.hunting.driving import Plant, Searched
from tests.hunting.falsifying import Bounded, ask_claim
from tests.support import summed
from tests.support.giving import tamed
from verify.decimals import plain

TOGETHER = 4  # claims about one system
SAMPLES = 600
BOXES = 20_000
WIDE = Fraction(16)  # of the ranges: far from where episodes get
NAMES = ("x", "v", "w")
FACTORS = [Fraction(each) for each in ("1", "1", "-1", "0.5", "2", "0.1", "-0.3")]
KINDS = ("decides", "decides", "stays_in", "avoids", "reaches_and_stays", "reaches")


class Case(Bounded):
    """A system with claims as the judge reads them."""

    brink = 0.06  # of claims: of most the answer is UNKNOWN, and takes as many boxes as it may
    checked = 8

    def __init__(self, number):
        rng = np.random.default_rng([number, 36])
        self.names = NAMES[: int(rng.integers(2, 4))]
        self.levels = int(rng.integers(0, 4))
        self.steps = int(rng.integers(1, 5))
        made = [self._agent(rng, place) for place in range(int(rng.integers(1, 3)))]
        self.profile = ensure(summed.profile(*made))
        self.plain = self._plain(rng)
        self.plant = Plant(json.loads(dumps(self.profile)), self.plain)
        self.claims = [self.near(rng) for _ in range(TOGETHER)]

    def _agent(self, rng, place):
        arithmetic = (DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS)[int(rng.integers(3))]
        gives = "float32" if arithmetic == DOUBLE_SUMS and rng.random() < 0.4 else None
        given = {"outputs": int(rng.choice([0, 1, 2])), "levels": self.levels, "n_features": int(rng.integers(3, 6))}
        given |= {"gives": gives if given["outputs"] else None, "bounded": True}
        made = tamed(summed.policy(int(rng.integers(1 << 30)), arithmetic, **given, agent=f"agent_{place}"))
        return replace(made, outputs=tuple(replace(each, unit="1") for each in made.outputs))

    def _plain(self, rng):
        """Features, pushes, rules, errors and starts."""

        def some(count):
            return {str(each): self._factor(rng) for each in rng.permutation(list(self.names))[:count]}

        features = {
            each.agent: {
                one.name: some(int(rng.integers(1, 3))) | {"": Fraction(int(rng.integers(-4, 5)), 8)}
                for one in each.features
            }
            for each in self.profile.agents
        }
        pushes = {
            each.agent: {
                one.name: {"u0": {"": Fraction(int(rng.integers(-4, 5)), 4)} | some(int(rng.random() < 0.3))}
                for one in each.actions
            }
            for each in self.profile.agents
            if not each.outputs
        }
        rules = {}
        for name in self.names:
            rules[name] = {name: Fraction(str(rng.choice(["1", "0.875", "0.5", "-0.5", "0.9"])))}
            other = str(rng.choice([each for each in self.names if each != name]))
            rules[name][other] = Fraction(str(rng.choice(["0", "0.125", "0.25", "-0.1"])))
            for each in self.profile.agents:
                for output in _inputs_of(each):
                    if rng.random() < 0.6:
                        rules[name][f"{each.agent}.{output}"] = Fraction(str(rng.choice(["0.5", "-0.25", "0.1", "1"])))
        errors = {name: Fraction(1, 1 << int(rng.integers(3, 8))) for name in self.names if rng.random() < 0.3}
        start = {}
        for name in self.names:
            low, width = Fraction(int(rng.integers(-16, 12)), 8), Fraction(1, 1 << int(rng.integers(0, 6)))
            start[name] = (low, low + width)
        return {"features": features, "pushes": pushes, "rules": rules, "errors": errors, "start": start}

    @staticmethod
    def _factor(rng):
        return FACTORS[int(rng.integers(len(FACTORS)))]

    def unbounded(self, rng):
        kind = str(rng.choice(KINDS))
        claim = {"kind": kind, "when": None, "steps": self.steps, "by": 0}
        names = [str(each) for each in rng.permutation(list(self.names))[: int(rng.integers(1, 3))]]
        claim["terms"] = {name: self._factor(rng) for name in names}
        if kind == "reaches_and_stays":
            claim["by"] = int(rng.integers(1, self.steps + 1))
        if kind != "decides":
            return claim
        claim["steps"] = 0
        one = self.profile.agents[int(rng.integers(len(self.profile.agents)))]
        if one.outputs:
            claim["terms"] = {f"{one.agent}.u0": Fraction(int(rng.choice([1, -1])))}
            others = [f"{each.agent}.{own}" for each in self.profile.agents for own in _inputs_of(each)]
            other = str(rng.choice([*others, *self.names]))
            if other not in claim["terms"]:
                claim["terms"][other] = self._factor(rng)
        else:
            claim["when"] = one.agent, str(rng.choice([each.name for each in one.actions]))
        return claim

    def searched(self, claim, rng):
        """The claim with the states or starts in which its sum reaches most."""
        return claim | {"reached": Searched(self.plant, claim, self.plain["start"], rng, SAMPLES).reached}

    def widened(self, rng):
        """The same from a wider box."""
        other, more = copy.copy(self), Fraction(1, 1 << int(rng.integers(0, 5)))
        start = {name: (low - more, high + more) for name, (low, high) in self.plain["start"].items()}
        other.plain = self.plain | {"start": start}
        return other

    def altered(self, profile):
        """The same of other agents."""
        other = copy.copy(self)
        other.profile, other.plant = profile, Plant(json.loads(dumps(profile)), self.plain)
        return other

    def replays(self, claim, found):
        """Whether a counterexample starts in the box, moves by the rules with allowed errors, and breaks the claim."""
        start = {name: found.start[name] for name in self.names}
        inside = all(low <= start[name] <= high for name, (low, high) in self.plain["start"].items())
        steps = len(found.states) - 1
        sizes = self.plain["errors"]
        errors = [{name: each.get(name, Fraction(0)) for name in sizes} for each in found.errors[:steps]]
        if not inside or any(abs(each[name]) > sizes[name] for each in errors for name in sizes):
            return False
        at = {name: np.array([value], object) for name, value in start.items()}
        states = self.plant.episodes(at, errors, steps)
        moved = [{name: column[0] for name, column in each.items()} for each in states]
        if moved != [{name: each[name] for name in self.names} for each in found.states]:
            return False
        errors += [dict.fromkeys(sizes, Fraction(0))] * (claim["steps"] - steps)
        return self.plant.exactly(claim, start, errors) > claim["bound"]

    # --- files

    def world(self, claims):
        """The world of claims, as a user's files state them."""
        with tempfile.TemporaryDirectory() as place:
            file = Path(place) / "world.toml"
            file.write_text(self.source(claims))
            options = VerifyOptions(world=str(file), max_boxes=BOXES, verdict_only=True)
            return StatedWorld.of(self.profile, options)

    def source(self, claims):
        variables = "".join(f"{name} = {{ range = [{plain(-WIDE)}, {plain(WIDE)}] }}\n" for name in self.names)
        rules = "".join(f'{name} = "{_text(form)}"\n' for name, form in self.plain["rules"].items())
        errors = "".join(f"{name} = {plain(size)}\n" for name, size in self.plain["errors"].items())
        errors = f"[dynamics.error]\n{errors}" if errors else ""
        agents = "".join(map(self._agent_tables, self.profile.agents))
        head = (
            f'name = "driven"\nsteps = {self.steps}\n[variables]\n{variables}{agents}[start]\nbox = {{ {self._box} }}\n'
        )
        return f"{head}[dynamics.next]\n{rules}{errors}{''.join(map(self._property, claims))}"

    @property
    def _box(self):
        return ", ".join(f"{name} = [{plain(low)}, {plain(high)}]" for name, (low, high) in self.plain["start"].items())

    def _agent_tables(self, policy):
        features = "".join(f'{name} = "{_text(form)}"\n' for name, form in self.plain["features"][policy.agent].items())
        given = "".join(f'{each.name} = "1"\n' for each in policy.outputs)
        acts = "".join(
            f'{name} = {{ u0 = "{_text(sets["u0"])}" }}\n'
            for name, sets in self.plain["pushes"].get(policy.agent, {}).items()
        )
        table = f"outputs]\n{given}" if given else f"actions]\n{acts}"
        return f"[agents.{policy.agent}.features]\n{features}[agents.{policy.agent}.{table}"

    def _property(self, claim):
        bound, kind = plain(claim["bound"]), claim["kind"]
        if kind == "decides":
            terms = {_given(name): weight for name, weight in claim["terms"].items()}
            when = "" if claim["when"] is None else "acts({}) == {} implies ".format(*claim["when"])
            region = f"region = {{ box = {{ {self._box} }} }}\n"
            return f'[[property]]\nformula = "{when}{_text(terms)} <= {bound}"\n{region}'
        sign = ">" if kind == "avoids" else "<="
        by = f"by = {claim['by']}\n" if claim["by"] else ""
        region = f'region = {{ where = ["{_text(claim["terms"])} {sign} {bound}"] }}\n'
        return f'[[property]]\nname = "{kind}"\nsteps = {self.steps}\n{by}{region}'


def _inputs_of(policy):
    """The names of what an agent gives, or of what its actions set."""
    return [each.name for each in policy.outputs] or ["u0"]


def _given(name):
    agent, _, output = name.partition(".")
    return f"out({agent}).{output}" if output else name


def _text(form):
    terms = [f"{plain(weight)}*{name}" for name, weight in form.items() if name and weight]
    terms += [plain(form[""])] if "" in form else []
    return " + ".join(terms).replace("+ -", "- ")


@lru_cache(maxsize=1)
def one_case(number):
    return Case(number)


def ask(seed, thorough):
    case = one_case(seed // TOGETHER)
    claim = case.claims[seed % TOGETHER]
    return ask_claim(case, claim, case.world([claim]), 0, seed, thorough)  # alone: no other claim takes its boxes
