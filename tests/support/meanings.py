"""Agents that observe every kind of meaning, states in which tests tie, and whether the solver says they fail there."""

from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.ir import Meaning
from maviper.worlds import find
from tests.support.teams import STAY, tree
from verify.claims.region import Region
from verify.claims.region_files import positions, start_region
from verify.question import Question
from verify.solver.encode import query
from verify.solver.terms import number
from verify.states.state import State
from verify.subjects import Game

WORLD = find("physical-deception")


def meanings(agent):
    """One of each kind: nothing, coordinates and differences as numbers, as signs, as 0 or 1, as being equal."""
    across = ((1, "landmark_0.x"), (-1, f"{agent}.x"))
    up = ((-1, f"{agent}.y"), (1, "landmark_1.y"))
    goal = ((1, "goal.x"), (-1, f"{agent}.x"))
    mine, backwards = ((1, f"{agent}.x"),), ((-1, f"{agent}.y"),)
    numbers = [Meaning(()), Meaning(across), Meaning(mine), Meaning(backwards)]
    signs = [Meaning(terms, "sign") for terms in (across, up, mine, goal)]
    same = [Meaning(((1, "goal.x"), (-1, "landmark_0.x")), "zero"), Meaning(across, "zero")]
    return [*numbers, *signs, *(Meaning(terms, "positive") for terms in (across, up, backwards, goal)), *same]


def with_meanings(trees):
    """A deception profile whose defenders observe `meanings`, with these trees."""
    agents = []
    for name, features, actions in zip(WORLD.agents, WORLD.features, WORLD.actions, strict=True):
        if name in trees:
            kinds = enumerate(meanings(name))
            features = tuple(ir.FeatureSpec(f"f{k}", "none", -2.0, 2.0, meaning) for k, meaning in kinds)
        agents.append(ir.AgentPolicy(name, WORLD.team_of(name), features, actions, trees.get(name, tree(STAY))))
    return ir.PolicyProfile(WORLD.spec, tuple(agents), ir.Provenance("", "", 0, "", ""))


def tied_points(count, seed):
    """World states on a coarse grid, where differences are often exactly 0, and beside it by one float64."""
    rng = np.random.default_rng(seed)
    names = positions(WORLD.spec)
    grid = rng.integers(-2, 3, size=(count, len(names))) / 4
    beside = np.nextafter(grid, rng.choice([-9.0, 9.0], size=grid.shape))
    values = np.where(rng.random(grid.shape) < 0.2, beside, grid)
    return [State(dict(zip(names, map(float, row), strict=True)), f"landmark_{rng.integers(2)}") for row in values]


def asking(profile, claim, slack=Fraction(0)):
    """Whether the solver's constraints hold in a world state with its errors, an error that is not named being 0: all
    variables are replaced, then worked out. Constraints are written down once for each goal.
    """
    import z3

    region, queries = start_region(profile.world), {}
    wide = Region(dict.fromkeys(region.box, (Fraction(-9), Fraction(9))), region.goals)

    def asked(state):
        if state.goal not in queries:
            queries[state.goal] = query(Question(Game(profile), claim, wide), state.goal, slack)
        asked, known = queries[state.goal], dict(state.position) | dict(state.errors)
        values = [(variable, number(Fraction(known.get(name, 0.0)))) for name, variable in asked.variables.items()]
        answer = z3.simplify(z3.substitute(z3.And(*asked.constraints), *values))
        assert z3.is_true(answer) or z3.is_false(answer), answer
        return z3.is_true(answer)

    return asked
