"""What several tests use of `verify.checker.decisions.test_certificates`."""

from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.policy_json import content_hash
from tests.support.altered import altered, read_game
from tests.support.zone_cases import stated
from verify.certificates.games import to_json
from verify.checker import decisions
from verify.checker.certificate import numbers
from verify.checker.reading import RejectedError
from verify.claims.decisions import formula
from verify.claims.wording import BUILT_IN
from verify.kinds import Semantics
from verify.question import Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.zones import engine as zones


def changed_tree(rng, pair):
    policies = list(pair.agents)
    place = next(k for k in rng.permutation(len(policies)) if policies[k].team == "defenders")
    old = policies[place].tree
    node = int(rng.integers(len(old.feature)))
    action, threshold = old.action.copy(), old.threshold.copy()
    if old.feature[node] == ir.NO_FEATURE:
        action[node] = rng.integers(5)
    elif rng.random() < 0.5:
        threshold[node] = np.nextafter(threshold[node], np.float32(rng.choice([-9, 9]))) or 0.5
        threshold[node] = threshold[node] if abs(threshold[node]) > 1e-30 else 0.001
    else:
        threshold[node] += np.float32(rng.normal() / 4)
    policies[place] = replace(policies[place], tree=replace(old, action=action, threshold=threshold), grown=None)
    return replace(pair, agents=tuple(policies))


def changed_region(rng, region):
    box = dict(region.box)
    name = str(rng.choice(list(box)))
    low, high = box[name]
    kind = rng.integers(4)
    if kind == 0:
        box[name] = (low - Fraction(int(rng.integers(1, 9)), 8), high)
    elif kind == 1:
        box[name] = (low + (high - low) / 4, high)
    elif kind == 2:
        return replace(region, differences=())
    else:
        return replace(region, apart=())
    return replace(region, box=box)


def changed_proof(rng, proofs):
    goal = str(rng.choice(sorted(proofs)))
    data = bytearray(proofs[goal])
    for _ in range(int(rng.integers(1, 4))):
        place = int(rng.integers(len(data)))
        kind = rng.integers(4)
        if kind == 0:
            data[place] = rng.integers(0, 60)
        elif kind == 1:
            del data[place : place + int(rng.integers(1, 4))]
        elif kind == 2:
            data[place:place] = bytes(rng.integers(0, 60, int(rng.integers(1, 4))).tolist())
        else:
            data[place] = min(127, data[place] + 1)
    return {**proofs, goal: bytes(data)}


def changed(rng, pair, made, kinds):
    """One change of a kind (tree, region, property, errors or proof), with hashes and formula made again."""
    kind, claim = kinds[rng.integers(len(kinds))], made.claim.property
    if kind == "tree":
        pair = changed_tree(rng, pair)
    if kind == "region":
        made = altered(made, region=changed_region(rng, made.header.region))
    if kind == "property":
        name = str(rng.choice(["own_target", "no_double", "distinct_targets"]))
        margin, radius = Fraction(int(rng.integers(0, 4)), 40), Fraction(int(rng.integers(0, 30)), 100)
        made = altered(made, property=BUILT_IN[name](claim.team, margin, radius, eps=claim.eps))
    if kind == "errors":
        eps = Fraction(int(rng.integers(1, 100)), 1000)
        made = altered(made, property=replace(claim, eps=eps), eps=eps)
    if kind == "proof":
        made = altered(made, proofs=changed_proof(rng, made.proof.proofs))
    made = altered(made, profile=content_hash(pair), formula=formula(pair, made.claim.property))
    return kind, pair, read_game(to_json(made))


def judge_changes(rng, certified, count, kinds):
    """How many changes of each kind pass and are refused; of what passes both engines say that it holds. `certified`:
    teams with their certificates, by turns.
    """
    passed, refused = Counter(), Counter()
    for place in range(count):
        kind, other, forged = changed(rng, *certified[place % len(certified)], kinds)
        try:
            decisions.check_certificate(forged, other)
        except RejectedError:
            refused[kind] += 1
            continue
        passed[kind] += 1
        found = zones.decide(stated(other, forged.claim.formula, forged.header.region, eps=forged.header.eps))
        assert found.verdict is Verdict.PROVED
        if kind not in ("region", "proof"):
            assert decide(Question(Game(other), forged.claim.property, forged.header.region)).verdict is Verdict.PROVED
    return passed, refused


def ensure_caught(bug, patch, questions):
    """With a bug of the engine some proof of (team, claim, region) is refused, and every one of a false claim."""
    asked = [(pair, formula(pair, claim), region, claim.eps) for pair, claim, region in questions]
    truths = [zones.decide(stated(pair, wanted, region, eps=eps)).verdict for pair, wanted, region, eps in asked]
    bug(patch)
    caught = 0
    for (pair, wanted, region, eps), truth in zip(asked, truths, strict=True):
        found, refused = zones.decide(stated(pair, wanted, region, eps=eps)), 0
        for goal, proof in found.proofs.items():
            try:
                decisions.check(pair, (wanted,), region, goal, Semantics(eps=eps), numbers(proof))
            except RejectedError:
                refused += 1
        caught += refused
        assert refused or found.verdict is not Verdict.PROVED or truth is Verdict.PROVED
    assert caught > 0
