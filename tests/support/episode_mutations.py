"""Certificates about episodes changed at random, with hashes made to fit: none of a false claim may be accepted."""

from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import InputError
from tests.support.altered import altered
from tests.support.episode_certificates import failures, stands
from tests.support.strategies import with_trees
from verify.claims.region import Region


class Judged(NamedTuple):
    """A mutation: whether it is accepted, and whether some sampled start fails its claim."""

    profile: ir.PolicyProfile
    certificate: object
    stood: bool
    false: bool


def judge_mutations(cases, seed, count, starts):
    """So many mutations of (profile, certificate), with what became of them; AssertionError where one that is false, or
    is about what the profile does not have, is accepted.
    """
    rng = np.random.default_rng(seed)
    for _ in range(count):
        profile, certificate = mutated(rng, *cases[rng.integers(len(cases))])
        stood, claim, region = stands(certificate, profile), certificate.claim, certificate.header.region
        try:
            false = failures(profile, claim, region, starts, seed=3) > 0
        except (InputError, LookupError, ValueError):  # about what the profile does not have
            assert not stood
            false = False
        assert not (stood and false), (claim, region)
        yield Judged(profile, certificate, stood, false)


def other_world(rng, profile):
    """Other contacts, sizes, forces, damping or time."""
    world = profile.world
    kind = int(rng.integers(4))
    if kind == 0:
        factor = float(rng.choice([0.0, 0.25, 0.5, 3.0]))
        return replace(profile, world=replace(world, contact_force=world.contact_force * factor))
    if kind == 1:
        changes = [{"contact_margin": 0.02}, {"contact_margin": 1e-4}, {"damping": 0.1}, {"damping": 0.4}, {"dt": 0.12}]
        return replace(profile, world=replace(world, **changes[int(rng.integers(len(changes)))]))
    size = {"size": float(rng.choice([0.02, 0.3]))} if kind == 2 else {"force": float(rng.choice([1.0, 8.0]))}
    return replace(profile, world=replace(world, agents=tuple(replace(one, **size) for one in world.agents)))


def other_tree(rng, profile):
    agents = [policy.agent for policy in profile.agents]
    agent = agents[int(rng.integers(len(agents)))]
    grown = profile.policy(agent).tree
    place = int(rng.integers(len(grown.feature)))
    if grown.feature[place] == ir.NO_FEATURE:
        action = grown.action.copy()
        action[place] = rng.integers(5)
        return with_trees({agent: replace(grown, action=action)}, profile)
    threshold = grown.threshold.copy()
    threshold[place] += np.float32(rng.choice([-0.4, -0.05, 0.05, 0.4]))
    return with_trees({agent: replace(grown, threshold=threshold)}, profile)


def other_claim(rng, certificate):
    claim = certificate.claim
    if rng.random() < 0.5:
        return altered(certificate, claim=replace(claim, steps=max(0, claim.steps + int(rng.choice([-2, -1, 1, 2])))))
    factor = Fraction(int(rng.integers(21, 60)), 20) if claim.apart else Fraction(int(rng.integers(5, 20)), 20)
    return altered(certificate, claim=replace(claim, radius=claim.radius * factor))


def wider(rng, certificate):
    region = certificate.header.region
    name = str(rng.choice([name for name in region.box if not name.endswith(("vx", "vy"))]))
    low, high = region.box[name]
    ends = low - Fraction(int(rng.integers(4)), 10), high + Fraction(int(rng.integers(4)), 10)
    return altered(certificate, region=Region({**region.box, name: ends}, region.goals))


def other_names(rng, certificate):
    """A part about another pair, other followed agents, or none of them; or another claim of the same proof."""
    parts, claim = list(certificate.proof.parts), certificate.claim
    place, kind = int(rng.integers(len(parts))), int(rng.integers(5))
    part = parts[place]
    if kind == 0:
        parts[place] = altered(part, followed=part.followed[:-1] or ("agent_1",))
    elif kind == 1:
        parts[place] = altered(part, followed=(*part.followed, "agent_0", "agent_1"))
    elif kind == 2:
        parts.remove(part)
    elif kind == 3:
        parts[place] = altered(part, agent="", landmark="")
    elif claim.apart:
        claim = replace(claim, others=("obstacle_0", "landmark_0", "agent_0")[int(rng.integers(3)) :][:1])
    else:
        claim = replace(claim, landmarks=claim.landmarks[::-1])
    return altered(certificate, parts=tuple(parts), claim=claim)


def other_proof(rng, certificate):
    """Bytes of a proof that are others, more or fewer; the proof of another part; or none."""
    parts = list(certificate.proof.parts)
    place, kind = int(rng.integers(len(parts))), int(rng.integers(5))
    proof = bytearray(parts[place].proof)
    at = int(rng.integers(len(proof)))
    if kind == 0:
        proof = bytearray(int(rng.integers(4)))
    elif kind == 1:
        proof = bytearray(parts[int(rng.integers(len(parts)))].proof)
    else:
        proof[at : at + int(rng.integers(1, 3))] = bytes(rng.integers(0, 12, rng.integers(3)).tolist())
    parts[place] = altered(parts[place], proof=bytes(proof))
    return altered(certificate, parts=tuple(parts))


def mutated(rng, profile, certificate):
    """(profile, certificate), one of them changed at random."""
    kind = int(rng.integers(7))
    if kind in (0, 1):
        return (other_world if kind else other_tree)(rng, profile), certificate
    change = (other_claim, wider, other_names, other_proof, other_proof)[kind - 2]
    return profile, change(rng, certificate)
