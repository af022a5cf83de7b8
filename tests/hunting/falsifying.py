"""Answers to claims that a sum stays below a bound, and false claims close to proved ones, as a forger hands them in.

Does: asks a claim of a case and says what is wrong with the answer; takes a claim that is proved; finds a claim, a
  region or a team beside it with which the judge knows the claim to be false; puts a proof of the one under the other,
  hashes and all, sometimes with edits.
Assumes: cases with `claim`s that have a `false` bound, and with `widened`, `altered`, `searched`, `violated`, `world`,
  `replays`, `levels` and `checked`: of so many certificates one is given to the checker again.
Does not: judge.
"""

import base64
import copy
import json
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen.errors import InputError
from codegen.ir import CONSTANT, NO_FEATURE, PolicyProfile
from codegen.policy_json import content_hash
from codegen.sums import Sum
from tests.hunting.asking import Told
from tests.support.altered import altered, sealed
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import from_json
from verify.systems import documents

NEAR = Fraction(2, 100)  # of the sampled extreme
BEYOND, BRINK = 0.55, 0.15  # the shares of claims that lie beyond it, and short of it by less than a rounding
LEAST = Fraction(1, 1 << 10)  # of an extreme whose hundredth part says something
DIGITS = 40  # of bounds, in binary, behind the point
PLACES = 25  # of a decimal: what is less than one in its last place is less than any rounding of an extreme


def place_bound(rng, reached, brink=BRINK):
    """The claim's `bound`, one that is `false`, and whether it is `close`. `reached`: None where nothing was, and any
    bound will do; `brink`: the share of bounds that are short by less than a rounding.
    """
    extreme = Fraction(-1) if reached is None else reached
    near, way = max(abs(extreme), LEAST) * NEAR, rng.random()
    bound = below(extreme) if way < brink else inwards(extreme, near if way < brink + BEYOND else -near)
    close = reached is not None and abs(bound - reached) <= abs(reached) * NEAR
    return {"bound": bound, "false": inwards(extreme, -near), "close": close}


def says_much(reached):
    """Whether an extreme is one whose hundredth part says something."""
    return reached is not None and abs(reached) >= LEAST


def below(extreme):
    """A decimal below an extreme, but not by as much as a rounding."""
    return Fraction(math.ceil(extreme * 10**PLACES) - 1, 10**PLACES)


def inwards(extreme, off):
    """A number of few digits, off an extreme by as much or a little less."""
    bound = (extreme + off) * 2**DIGITS
    return Fraction(math.floor(bound) if off > 0 else math.ceil(bound), 2**DIGITS)


class Bounded:
    """A case whose claims bound a sum. `searched` finds the most that a judge knows; `drawn`: claims at most, until
    that says something.
    """

    drawn, brink, asked = 20, BRINK, 0

    def near(self, rng, *given):
        """A claim with a bound close to the most that was searched."""
        for _ in range(self.drawn):
            claim = self.searched(self.unbounded(rng, *given), rng)
            if says_much(claim["reached"]):
                break
        return claim | place_bound(rng, claim["reached"], self.brink)

    def violated(self, claim):
        """Whether what reaches most breaks it, in exact numbers."""
        return claim["reached"] is not None and claim["reached"] > claim["bound"]


TRIED = 8  # ways to make a claim false


# --- claims that are false


def falsify(case, claim, rng):
    """A case and a claim of it that the judge knows to be false, close to others; None where none is known."""
    for _ in range(TRIED):
        way = rng.integers(3)
        if way == 0:
            other, false = case, claim | {"bound": claim["false"]}
        else:
            other = case.widened(rng) if way == 1 else case.altered(alter(case.profile, rng))
            false = other.searched(claim, rng)
        if other.violated(false):
            return other, false
    return None


def alter(profile: PolicyProfile, rng: np.random.Generator) -> PolicyProfile:
    """The profile with one number of one agent changed: an action, what a leaf gives, or a threshold."""
    place = int(rng.integers(len(profile.agents)))
    agents = list(profile.agents)
    policy, tree = agents[place], agents[place].tree
    splits = np.flatnonzero(tree.feature != NO_FEATURE)
    if len(splits) and rng.random() < 0.4:
        threshold = tree.threshold.copy()
        threshold[rng.choice(splits)] += float(rng.choice([-0.5, 0.25, 1.0]))
        tree = replace(tree, threshold=threshold)
    elif policy.outputs:
        vectors = list(tree.vectors)
        number = int(rng.integers(len(vectors)))
        vectors[number] = tuple(_add(each, float(rng.choice([-0.5, 0.25, 1.0]))) for each in vectors[number])
        tree = replace(tree, vectors=tuple(vectors))
    else:
        action = tree.action.copy()
        leaf = rng.choice(np.flatnonzero(tree.feature == NO_FEATURE))
        action[leaf] = (action[leaf] + 1) % len(policy.actions)
        tree = replace(tree, action=action)
    agents[place] = replace(policy, tree=tree)
    return replace(profile, agents=tuple(agents))


def _add(each: Sum, more: float) -> Sum:
    """A sum with a larger constant."""
    if not any(place == CONSTANT for _, place in each.terms):
        return Sum((*each.terms, (more, CONSTANT)))
    return Sum(tuple((weight + more if place == CONSTANT else weight, place) for weight, place in each.terms))


# --- edits of a certificate's document


def _keep(document, rng):
    """Nothing."""


def _bytes(document, rng):
    """Bytes of a proof are others, fewer or more."""
    for holder, key in _proofs(document):
        proof = bytearray(base64.b64decode("".join(holder[key])))
        place = int(rng.integers(len(proof) + 1))
        way = rng.integers(4)
        if way == 0 and proof:
            proof[min(place, len(proof) - 1)] = int(rng.integers(12))
        elif way == 1:
            proof = proof[:place]
        elif way == 2:
            proof = proof[:place] + proof[place + 1 :]
        else:
            proof = bytearray(int(rng.integers(4)))
        holder[key] = [base64.b64encode(bytes(proof)).decode()]


def _proofs(document):
    return [(part, "proof") for part in document.get("parts", [])] + [(document, "cuts")] * ("cuts" in document)


def _shows(document, rng):
    """One part says that it shows everything, and stands alone."""
    if parts := document.get("parts"):
        part = parts[int(rng.integers(len(parts)))]
        part["shows"] = sorted({way for each in parts for way in each["shows"]} | {0})
        document["parts"] = [part]


def _follows(document, rng):
    """A part follows fewer variables, or forgets what its hulls bound."""
    for part in document.get("parts", []):
        if part["followed"] and rng.random() < 0.5:
            part["followed"].pop(int(rng.integers(len(part["followed"]))))
        for hull in part["hulls"]:
            if hull["region"]:
                hull["region"].pop(int(rng.integers(len(hull["region"]))))


def _cells(document, rng):
    """Cells of a cover are wider, narrower or gone."""
    cells = document.get("cells", {})
    for name in list(cells):
        way = rng.integers(3)
        if way == 2:
            del cells[name]
        else:
            cells[name] = str(Fraction(cells[name].strip('"')) * (Fraction(1, 4) if way else 4))


def _inhabits(document, rng):
    """The state that shows that there is one is another."""
    inhabitant = document["inhabitant"]
    name = str(rng.choice(sorted(inhabitant)))
    inhabitant[name] = str(Fraction(inhabitant[name].strip('"')) + Fraction(int(rng.integers(-2, 3)), 4))


EDITS = (_keep, _keep, _bytes, _shows, _follows, _cells, _inhabits)


def is_refused(certificate, claim, profile, system, rng):
    """Whether the checker refuses a proof as one of a false claim about a profile and a system, edited or as it is."""
    certificate = altered(
        certificate, claim=claim, profile=content_hash(profile), system=documents.content_hash(system)
    )
    document = copy.deepcopy(json.loads(to_json(certificate)))
    EDITS[int(rng.integers(len(EDITS)))](document, rng)
    try:
        accept(from_json(sealed(document)), profile, system)
    except (RejectedError, InputError):
        return True
    return False


FORGING = 3  # of so many certificates one is forged


def ask_claim(case, claim, world, place, seed, thorough):
    """What is wrong with the answer to a claim. `place`: of it among the questions of its world."""
    result = world.answer(world.asked[place].question, beside=thorough)
    violated, verdict = case.violated(claim), result.verdict.value
    told = Told(seed, verdict, claim["kind"], case.levels, conflict=True, judged="violated" if violated else "")
    told.close = claim["close"]
    if verdict == "PROVED" and violated:
        told.wrong.append("PROVED, and the judge has a state or an episode that breaks it")
    if verdict == "PROVED":
        certificate = result.evidence.certificate
        again = from_json(to_json(certificate))
        if again != certificate:
            told.wrong.append("PROVED by a certificate that is another one once it is read")
        if thorough or seed % case.checked == 0:
            told.front = accept(again, world.profile, world.statement.system) >= 0
        if not violated and (thorough or seed % FORGING == 0):
            _judge_forgery(case, claim, certificate, told, np.random.default_rng([seed, 37]))
    if verdict == "VIOLATED" and not case.replays(claim, result.evidence.counterexample):
        told.wrong.append("VIOLATED by a state or an episode that is none, or breaks nothing")
    return told


def _judge_forgery(case, claim, certificate, told, rng):
    """Hands a proof in under a false claim and notes in `told` what became of it."""
    falsified = falsify(case, claim, rng)
    if falsified is None:
        return
    other, false = falsified
    world = other.world([false])
    told.forged += 1
    if is_refused(certificate, world.claims[case.asked], world.profile, world.statement.system, rng):
        told.refused += 1
    else:
        told.wrong.append("a proof of another claim is accepted as one of a claim that is false")
