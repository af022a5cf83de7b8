"""What zones say beside Z3, the checker, and errors tried one by one at rational points."""

from fractions import Fraction
from itertools import product

import numpy as np

from tests.support.zone_cases import actions_at, actions_with_errors, exactly_inside, grid_points, stated
from verify.checker import decisions
from verify.checker.certificate import numbers
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.formula import for_goal, holds
from verify.kinds import MACHINE, Semantics
from verify.question import Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.zones import engine as zones

EPS = Fraction(1, 10)
CLAIM = DistinctTargets("defenders", eps=EPS)


def stands(profile, claim, state, goal, machine=True):
    """Whether no errors make the team violate the claim at a rational point."""
    asked = for_goal(formula(profile, claim), goal)
    if claim.eps:
        ways = actions_with_errors(profile, state, goal, claim.eps, machine)
    else:
        ways = {agent: [action] for agent, action in actions_at(profile, state, goal, machine).items()}
    return all(
        holds(asked, state, dict(zip(ways, joint, strict=True)))
        for joint in product(*(sorted(actions) for actions in ways.values()))
    )


def agree(profile, claim, region, semantics=MACHINE, seed=0):
    """Zones, Z3, checker and points of a grid say the same; returns the verdict."""
    asked, machine = formula(profile, claim), semantics == MACHINE
    found = zones.decide(stated(profile, asked, region, semantics, eps=claim.eps))
    assert found.verdict is decide(Question(Game(profile), claim, region, semantics)).verdict
    if found.verdict is Verdict.VIOLATED:
        assert exactly_inside(region, found.state)
        assert not stands(profile, claim, found.state, found.goal, machine)
    if found.verdict is Verdict.PROVED:
        assert exactly_inside(region, found.inhabitant)
        for goal, proof in found.proofs.items():
            arithmetic = Semantics(semantics, claim.eps)
            assert decisions.check(profile, (asked,), region, goal, arithmetic, numbers(proof)) >= 0
        for state in grid_points(np.random.default_rng(seed), region, 12):
            assert all(stands(profile, claim, state, goal, machine) for goal in region.goal_cases)
    return found.verdict
