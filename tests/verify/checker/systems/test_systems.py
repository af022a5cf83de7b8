"""Certificates about stated systems: damaged proofs are refused, and no proof is taken for one of a false claim."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered
from tests.support.system_cases import decided, double_integrator, form, policy, stays, switching, team
from tests.verify.reach import random_systems
from verify.certificates.proofs import count_bytes
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Hull
from verify.reach.play import Starts, courses
from verify.reach.replay import replay_course
from verify.result import Verdict
from verify.systems import documents
from verify.systems.system import HalfSpace, Piece

MUTATIONS = 1_000


def coupled():
    """A rotation whose proof adds several rows: start and errors are not told apart by axes."""
    system = double_integrator(axes=1, error=F(1, 500), steps=12)
    piece = system.pieces[0]
    move = {"x": form(x=F(99, 100), vx=F(1, 5)), "vx": form(x=F(-1, 10), vx=F(98, 100))}
    start = (*system.start, HalfSpace(form(F(-3, 5), x=1, vx=1)))
    spread = tuple(replace(half, form=form(F(-1, 5), **dict(half.form.terms))) for half in start[2:4])
    return replace(system, start=(*start[:2], *spread, start[4]), pieces=(Piece({}, move, piece.effect, piece.error),))


@pytest.fixture(scope="module")
def proved():
    """Certificates with their profiles and systems: with bounds alone, with rows, with hulls, of many small systems."""
    found = []
    cases = [
        (double_integrator(axes=2, steps=20), switching(axes=2), dict.fromkeys("xy", (F(-3, 5), F(3, 5)))),
        (coupled(), switching(axes=1), {"x": (F(-7, 10), F(7, 10))}),
        (double_integrator(axes=1, error=F(1, 1000), steps=25), switching(axes=1), {"x": (F(-7, 10), F(7, 10))}),
    ]
    for system, profile, bounds in cases:
        (result,) = decided(profile, system, [stays(system, system.steps, **bounds)])
        assert result.verdict is Verdict.PROVED, (result, system.name)
        found.append((result.certificate, profile, system))
    for seed in range(120):
        system, profile, claim = random_systems.case(np.random.default_rng(seed))
        (result,) = decided(profile, system, [claim])
        if result.verdict is Verdict.PROVED and count_bytes(result.certificate.proof):
            found.append((result.certificate, profile, system))
    assert (
        len(found) >= 8 and count_bytes(found[1][0].proof) > 500 and any(part.hulls for part in found[2][0].proof.parts)
    )
    return found


def damaged(certificate, random):
    """The certificate with a proof in which a number is another one, is missing, or is there twice."""
    place = int(random.integers(len(certificate.proof.parts)))
    part = certificate.proof.parts[place]
    proof = bytearray(part.proof)
    at = int(random.integers(len(proof)))
    match int(random.integers(4)):
        case 0:
            proof[at] ^= 1 << int(random.integers(8))
        case 1:
            del proof[at]
        case 2:
            proof.insert(at, int(random.integers(256)))
        case _:
            del proof[at:]
    parts = (*certificate.proof.parts[:place], altered(part, proof=bytes(proof)), *certificate.proof.parts[place + 1 :])
    return altered(certificate, parts=parts)


def refused(certificate, profile, system):
    try:
        accept(certificate, profile, system)
    except (RejectedError, InputError):
        return True
    return False


@pytest.mark.slow
def test_damaged_proofs_are_refused(proved):
    """What is still accepted is another proof of the same: a multiplier that may be larger, a row that may be kept."""
    random, tried, counted = np.random.default_rng(0), 0, 0
    while counted < MUTATIONS:
        certificate, profile, system = proved[tried % len(proved)]
        counted += refused(damaged(certificate, random), profile, system)
        tried += 1
    assert counted / tried > 0.75, (counted, tried)


def changed(profile, system, claim, random):
    """The question with one number changed: of A, B, e, the start, the region, a test or a measure."""
    piece = system.pieces[int(random.integers(len(system.pieces)))]
    names = [one.name for one in system.variables]
    name, other = random_systems.some(random, names), random_systems.some(random, names)
    amount = random_systems.some(random, [F(1, 50), F(-1, 50), F(1, 10), F(-1, 10), F(1), F(-1)])
    match int(random.integers(7)):
        case 0:
            move = {**piece.move, name: piece.move[name].plus(form(**{other: amount}))}
            after = replace(piece, move=move)
        case 1:
            choice = random_systems.some(random, list(piece.effect))
            effect = piece.effect[choice]
            more = {**effect, name: effect.get(name, form()).plus(form(amount))}
            after = replace(piece, effect={**piece.effect, choice: more})
        case 2:
            low, high = piece.error.get(name, (F(0), F(0)))
            after = replace(piece, error={**piece.error, name: (low - abs(amount), high + abs(amount))})
        case 3:
            start = tuple(replace(half, form=half.form.plus(form(-abs(amount)))) for half in system.start)
            return profile, replace(system, start=start), claim
        case 4:
            regions = tuple(
                tuple(replace(half, form=half.form.plus(form(amount))) for half in region) for region in claim.regions
            )
            return profile, system, replace(claim, regions=regions)
        case 5:
            agent = random_systems.some(random, profile.agents)
            threshold = agent.tree.threshold + np.where(agent.tree.feature >= 0, float(amount), 0).astype(np.float32)
            trees = [
                replace(one, tree=replace(one.tree, threshold=threshold)) if one is agent else one
                for one in profile.agents
            ]
            return team(*trees), system, claim
        case _:
            agent = random_systems.some(random, list(system.features))
            known = system.features[agent]
            feature = random_systems.some(random, list(known))
            measured = replace(known[feature], form=known[feature].form.plus(form(amount, **{other: amount})))
            return profile, replace(system, features={**system.features, agent: {**known, feature: measured}}), claim
    pieces = tuple(after if one is piece else one for one in system.pieces)
    return profile, replace(system, pieces=pieces), claim


def is_false(profile, system, claim):
    played = courses(profile, system, claim, Starts(256))
    return any(replay_course(profile, system, claim, course) is not None for course in played)


@pytest.mark.slow
def test_no_certificate_shows_a_false_claim(proved):
    """A certificate is put to a question that differs in one number, and whose claim a replayed episode breaks."""
    random, counted, tried = np.random.default_rng(1), 0, 0
    while counted < MUTATIONS:
        certificate, *about = proved[tried % len(proved)]
        profile, system, claim = changed(*about, certificate.claim, random)
        tried += 1
        if is_false(profile, system, claim):
            hashes = {"profile": content_hash(profile), "system": documents.content_hash(system)}
            assert refused(altered(certificate, claim=claim, **hashes), profile, system), (tried, claim)
            counted += 1


def test_another_profile_or_system_is_told_by_its_hash(proved):
    certificate, profile, system = proved[0]
    with pytest.raises(InputError, match="another system"):
        accept(certificate, profile, replace(system, name="another"))
    with pytest.raises(InputError, match="another profile"):
        accept(certificate, switching(axes=1), system)


def test_every_way_must_be_shown_by_variables_that_depend_on_no_other(proved):
    certificate, profile, system = proved[0]
    first, second = certificate.proof.parts
    with pytest.raises(RejectedError, match="no part shows"):
        accept(altered(certificate, parts=(first,)), profile, system)
    with pytest.raises(RejectedError, match="depends"):
        accept(altered(certificate, parts=(altered(first, followed=("x",)), second)), profile, system)
    with pytest.raises(RejectedError, match="part 0"):  # what the first one follows says nothing of y
        swapped = (altered(first, shows=second.shows), altered(second, shows=first.shows))
        accept(altered(certificate, parts=swapped), profile, system)


def test_hulls_hold_what_goes_on_in_them(proved):
    certificate, profile, system = proved[2]
    part = next(part for part in certificate.proof.parts if part.hulls)
    place = certificate.proof.parts.index(part)

    def with_hulls(hulls):
        parts = (*certificate.proof.parts[:place], altered(part, hulls=hulls), *certificate.proof.parts[place + 1 :])
        return altered(certificate, parts=parts)

    first, *others = part.hulls
    narrow = tuple(replace(half, form=half.form.plus(form(F(1, 10)))) for half in first.region)
    for hulls in (
        (Hull(first.step, narrow), *others),
        (Hull(first.step + 1, first.region), *others),
        (Hull(first.step, first.region[1:]), *others),  # its first variable has no lower bound
        tuple(others),
        (),
    ):
        with pytest.raises(RejectedError):
            accept(with_hulls(hulls), profile, system)


def test_an_inhabitant_must_be_a_start(proved):
    certificate, profile, system = proved[0]
    far = {**certificate.header.inhabitant, "x": F(9)}
    with pytest.raises(RejectedError, match="vacuous"):
        accept(altered(certificate, inhabitant=far), profile, system)


def test_a_policy_with_one_action_needs_no_tests():
    system = double_integrator(axes=1, steps=3)
    profile = team(policy("drone", ["sx"], ["push0", "push1"], 1))
    (result,) = decided(profile, system, [stays(system, 3, x=(-1, 1))])
    assert result.verdict is Verdict.PROVED and count_bytes(result.certificate.proof) == 0
