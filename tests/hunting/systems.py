"""Questions about stated systems for the hunt, and what is wrong with their answers.

Does: random systems with pieces, errors, modes, cases, choices; half of the claims lie within 2 % of the extreme that
  the judge has sampled; asks them, and has every answer judged.
Assumes: stated.py judges by plain data alone.
Does not: draw curved rules or claims for ever.
"""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen.floats import rational_literal
from tests.hunting import stated
from tests.hunting.asking import Told
from tests.verify.reach import random_modes, random_systems
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.solver.unrolled import opinion
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.claims import Pattern
from verify.systems.system import Affine, HalfSpace

BUDGETS = Budgets(max_boxes=200_000, max_states=400, max_programs=4_000, samples=1_024)
EPISODES = 200
NEAR = (Fraction(98, 100), Fraction(102, 100))


def nodes(policy):
    """A tree as the judge reads it."""
    tree, names = policy.tree, [feature.name for feature in policy.features]
    rows = zip(
        tree.feature.tolist(),
        tree.threshold.tolist(),
        tree.left.tolist(),
        tree.right.tolist(),
        tree.action,
        strict=True,
    )
    return [
        [policy.actions[int(action)].name] if feature < 0 else [names[feature], threshold, left, right]
        for feature, threshold, left, right, action in rows
    ]


def bounds(system):
    """Bounds of the starts, by the half spaces of one variable."""
    found = {one.name: list(one.range) for one in system.variables}
    for half in system.start:
        if len(half.form.terms) == 1:
            ((name, factor),) = half.form.terms
            end, side = -half.form.constant / factor, int(factor > 0)
            found[name][side] = (min if side else max)(found[name][side], end)
    return {name: ends for name, ends in found.items() if ends[0] <= ends[1]}


def plain(value):
    """Data as JSON gives it back."""
    return json.loads(json.dumps(value, default=rational_literal))


def claimed(claim):
    """A claim as the judge reads it."""
    regions = [
        [{"below" if half.strict else "most": documents._affine(half.form)} for half in region]
        for region in claim.regions
    ]
    return {"name": claim.name, "by": claim.by, "regions": regions}


def near(rng, system, claim, episodes):
    """The claim that a sum stays below a bound close to what was sampled; the claim itself where nothing was."""
    form = random_systems.affine(rng, [one.name for one in system.variables if not one.modes], [Fraction(0)])
    values = [form.at(state) for states in episodes for state in states]
    if not values or max(values) <= 0:
        return claim
    end = max(values) * NEAR[int(rng.integers(2))]
    return replace(claim, pattern=Pattern.STAYS_IN, regions=((HalfSpace(Affine.of(dict(form.terms), -end)),),), by=0)


def ask(seed, thorough):
    """The answer to the question of a seed."""
    rng = np.random.default_rng([seed, 33])
    system, profile, claim = (random_modes if rng.random() < 0.6 else random_systems).case(rng)
    told, judged = (
        plain(documents.document(system)),
        [{"agent": one.agent, "nodes": nodes(one)} for one in profile.agents],
    )
    count = EPISODES * (5 if thorough else 1)
    starts = plain(bounds(system))
    episodes = (
        list(stated.sampled(told, judged, starts, claim.steps, count, seed))
        if len(starts) == len(system.variables)
        else []
    )
    if rng.random() < 0.75:
        claim = near(rng, system, claim, episodes)
    question = Question(ClosedLoop(profile, system), claim, UNBOUNDED, budgets=BUDGETS)
    found, asked = decide(question), claimed(claim)
    answer = Told(seed, found.verdict.value, claim.name, 2, conflict=bool(episodes))
    violated = any(stated.broken(asked, states) for states in episodes)
    answer.judged = "violated" if violated else ""
    if found.verdict.value == "PROVED" and violated:
        answer.wrong.append("PROVED, and the judge has an episode that breaks it")
    if found.counterexample is not None and not _replays(told, judged, starts, claim, asked, found.counterexample):
        answer.wrong.append("VIOLATED by an episode that is none, or breaks nothing")
    if thorough or seed % 8 == 0:
        answer.second, second = True, opinion(question).verdict.value
        if {second, found.verdict.value} == {"PROVED", "VIOLATED"}:
            answer.wrong.append(f"{found.verdict.value}, and the solver says {second}")
    return answer


def _replays(told, judged, starts, claim, asked, found):
    """Whether the judge finds a counterexample to be one: it ends where the claim is broken, whatever comes later."""
    start = dict(found.start)
    inside = all(Fraction(low) <= start[name] <= Fraction(high) for name, (low, high) in starts.items())
    if not inside or not all(stated.meets(half, start) for half in told["start"]):
        return False

    def error(step, name, low, high):
        return min(max(found.errors[step].get(name, Fraction(0)), low), high)

    states = stated.played(told, judged, start, found.step, lambda step, _: found.pieces[step], error)
    return states is not None and states == [dict(each) for each in found.states] and stated.broken(asked, states)
