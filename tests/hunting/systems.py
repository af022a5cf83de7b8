"""Questions about stated systems for the hunt, and what is wrong with their answers.

Does: random systems with pieces, errors, modes, cases, choices and curved rules; claims about some steps and for ever,
  with what is assumed and invariants that are proposed; half of the claims lie within 2 % of the extreme that the judge
  has sampled; asks them, and has every answer judged.
Assumes: stated.py and sampling.py judge by plain data alone.
Does not: know flows.
"""

import json
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from codegen.floats import rational_literal
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from tests.hunting import stated
from tests.hunting.asking import Told
from tests.hunting.sampling import Episodes
from tests.support.system_cases import ends_of, form, policy, team
from tests.verify.reach import random_modes, random_systems
from tests.verify.reach.random_systems import affine, nested, some
from verify.certificates.systems import to_json
from verify.checker.systems.proofs import from_json
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.solver.unrolled import opinion
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.files import statement_of
from verify.systems.statement import Statement
from verify.systems.system import Affine, HalfSpace
from verify.verdicts.systems import verify_system

BUDGETS = Budgets(max_boxes=150_000, samples=512)
EPISODES = 1_000
NEAR, BEYOND = Fraction(2, 100), 0.6  # of the sampled extreme; the share of close claims that lie beyond it
LONG, BENT = 30, 6  # steps of a claim for ever in which the judge looks; where squares double the digits each time
SECOND = 32  # of so many questions one is asked of the solver too


@dataclass(frozen=True)
class Case:
    """A question as it is drawn, and the system as the judge reads it. `statement`: where rules are curved."""

    system: Any
    profile: Any
    claim: SystemClaim
    plain: dict[str, Any]
    statement: Statement | None = None


def nodes(policy):
    """A tree as the judge reads it."""
    tree, names = policy.tree, [feature.name for feature in policy.features]
    columns = (each.tolist() for each in (tree.feature, tree.threshold, tree.left, tree.right, tree.action))
    return [
        [policy.actions[action].name] if feature < 0 else [names[feature], threshold, left, right]
        for feature, threshold, left, right, action in zip(*columns, strict=True)
    ]


def plain(value):
    """Data as JSON gives it back."""
    return json.loads(json.dumps(value, default=rational_literal))


def claimed(claim):
    """A claim as the judge reads it."""
    return documents.plain({"name": claim.name, "by": claim.by, "regions": claim.regions, "assuming": claim.assuming})


def drawn(rng):
    way = rng.random()
    if way < 0.2:
        statement, profile, told = draw_curved(rng)
        claim = SystemClaim(Pattern.STAYS_IN, (random_systems.polytope(rng, NAMES),), int(rng.integers(1, 6)))
        return Case(statement.system, profile, claim, told, statement)
    system, profile, claim = (random_modes if way < 0.6 else random_systems).case(rng)
    return Case(system, profile, claim, plain(documents.document(system)))


def numbers(system):
    """The names of the variables that are no modes."""
    return [one.name for one in system.variables if not one.modes]


def for_ever(rng, case):
    """The claim as one about all steps, sometimes late, with assumed regions, or with a proposed invariant."""
    names, by = numbers(case.system), int(rng.integers(1, 6)) if rng.random() < 0.4 else 0
    assuming = (random_systems.polytope(rng, names),) if rng.random() < 0.3 else ()
    steps = LONG if case.statement is None else BENT
    found = replace(case.claim, pattern=Pattern.ALWAYS, by=by, steps=steps, assuming=assuming)
    if rng.random() < 0.4:
        sizes = {name: random_systems.some(rng, [Fraction(1), Fraction(2), Fraction(4)]) for name in names}
        box = [HalfSpace(form(-size, **{name: sign})) for name, size in sizes.items() for sign in (1, -1)]
        sloped = [HalfSpace(random_systems.affine(rng, names, [Fraction(-1), Fraction(-2)]))]
        found = replace(found, invariant=(tuple(box + sloped * (rng.random() < 0.4)),))
    if rng.random() < 0.4:
        size = random_systems.some(rng, [Fraction(1), Fraction(2), Fraction(4)])
        found = replace(found, regions=(tuple(HalfSpace(form(-size, **{n: s})) for n in names for s in (1, -1)),))
    return found


def near(rng, case, claim, episodes):
    """The claim that a sum stays below a bound close to what was sampled; None where nothing was."""
    total = random_systems.affine(rng, numbers(case.system), [Fraction(0)])
    sampled = episodes.most(documents.plain(total), claim.by)
    if sampled is None or not 2.0**-10 < abs(sampled) < 2.0**40:
        return None
    extreme = Fraction(sampled).limit_denominator(1 << 20)
    end = extreme + abs(extreme) * (NEAR if rng.random() < BEYOND else -NEAR)
    region = (HalfSpace(Affine.of(dict(total.terms), -end)),)
    pattern = claim.pattern if claim.says.ever else Pattern.STAYS_IN
    return replace(claim, pattern=pattern, regions=(region,), by=claim.by if claim.says.ever else 0, assuming=())


def ask(seed, thorough):
    rng = np.random.default_rng([seed, 33])
    case = drawn(rng)
    claim = for_ever(rng, case) if rng.random() < 0.4 else case.claim
    agents, starts = (
        [{"agent": one.agent, "nodes": nodes(one)} for one in case.profile.agents],
        plain({name: ends for name, ends in ends_of(case.system).items() if ends[0] <= ends[1]}),
    )
    episodes = None
    if len(starts) == len(case.system.variables):
        count = EPISODES * (5 if thorough else 1)
        episodes = Episodes(case.plain, agents, starts, claim.steps, count, seed)
    close = near(rng, case, claim, episodes) if episodes and rng.random() < 0.75 else None
    claim = close or claim
    asked, found = claimed(claim), answered(case, claim)
    alive = episodes is not None and bool(episodes.alive[-1].any())
    violated = episodes is not None and episodes.broken(asked)
    answer = Told(seed, found.verdict.value, claim.name, 2, conflict=alive, judged="violated" if violated else "")
    answer.close = close is not None
    evidence = found.evidence
    if found.verdict.value == "PROVED" and violated:
        answer.wrong.append("PROVED, and the judge has an episode that breaks it")
    if found.verdict.value == "PROVED" and from_json(to_json(evidence.certificate)) != evidence.certificate:
        answer.wrong.append("PROVED by a certificate that is another one once it is read")
    if evidence.counterexample is not None and not replays(case, agents, starts, claim, evidence.counterexample):
        answer.wrong.append("VIOLATED by an episode that is none, or breaks nothing")
    if case.statement is None and (thorough or seed % SECOND == 0):
        answer.second, second = True, opinion(question(case, claim)).verdict.value
        if {second, found.verdict.value} == {"PROVED", "VIOLATED"}:
            answer.wrong.append(f"{found.verdict.value}, and the solver says {second}")
    return answer


def question(case, claim):
    return Question(ClosedLoop(case.profile, case.system), claim, UNBOUNDED, budgets=BUDGETS)


def answered(case, claim):
    """The result, by the door that a user takes where rules are curved."""
    if case.statement is None:
        return verify_system(question(case, claim), beside=False)
    world = StatedWorld(case.profile, case.profile, case.statement, (claim,), {}, {}, VerifyOptions(verdict_only=True))
    return world.answer(question(case, claim), beside=False)


def replays(case, agents, starts, claim, found):
    """Whether the judge finds a counterexample to be one: it ends where the claim is broken, whatever comes later."""
    start, asked = dict(found.start), claimed(claim)
    inside = all(Fraction(low) <= start[name] <= Fraction(high) for name, (low, high) in starts.items())
    if not inside or not all(stated.meets(half, start) for half in case.plain["start"]):
        return False
    if case.statement is not None:
        return broken_by_rules(case.plain, agents, found.states, asked)

    def error(step, name, low, high):
        return min(max(found.errors[step].get(name, Fraction(0)), low), high)

    states = stated.played(case.plain, agents, start, found.step, lambda step, _: found.pieces[step], error)
    return states is not None and states == [dict(each) for each in found.states] and stated.broken(asked, states)


NARROW = Fraction(1, 1 << 80)  # what the states that are told may be off


def broken_by_rules(system, agents, states, asked):
    """Whether the exact episode with the errors of given states, cut to their bounds, breaks a claim beside them."""
    implied = [
        {name: after[name] - value for name, value in stated.moved(system, agents, state, 0, {}).items()}
        for state, after in pairwise(states)
    ]

    def error(step, name, low, high):
        return min(max(implied[step][name], low), high)

    exact = stated.played(system, agents, dict(states[0]), len(states) - 1, lambda _, pieces: pieces[0], error)
    if exact is None or not stated.broken(asked, exact):
        return False
    return all(
        abs(told[name] - value) <= NARROW
        for told, known in zip(states, exact, strict=True)
        for name, value in known.items()
    )


# --- systems whose rules are curved

RANGE = Fraction(4)
NAMES = ("x", "y")
ACTIONS = ("go", "rest", "back")
FACTORS = (Fraction(-1, 2), Fraction(1, 2), Fraction(3, 4), Fraction(1, 4))
SQUARED = (Fraction(1, 8), Fraction(-1, 8), Fraction(1, 4))
PUSHES = (Fraction(1, 8), Fraction(-1, 8), Fraction(1, 2), Fraction(-1, 2), Fraction(0))
ERROR = Fraction(1, 64)
CUTS = 4


def _rule(random):
    """A rule: multiples of variables and of products."""
    terms = {name: some(random, FACTORS) for name in NAMES if random.random() < 0.7} or {"x": Fraction(1, 2)}
    products = [(some(random, SQUARED), [some(random, NAMES), some(random, NAMES)])] if random.random() < 0.8 else []
    return {"constant": "0", "terms": {name: str(weight) for name, weight in terms.items()}, "products": products}


def _written(form):
    """A sum as a world file has it."""
    found = [f"({weight})*{name}" for name, weight in form["terms"].items()]
    found += [f"({weight})*{'*'.join(names)}" for weight, names in form.get("products", ())]
    return " + ".join([f"({form['constant']})", *found])


def _plain(form):
    return {"constant": str(form.constant), "terms": {name: str(weight) for name, weight in form.terms}}


def draw_curved(random):
    """(statement, team, the plain data of the system): squares and products of two variables, within ranges."""
    features = {f"f{number}": _plain(affine(random, NAMES)) for number in range(2)}
    pushed, rules = some(random, NAMES), {name: _rule(random) for name in NAMES}
    pushes = {action: some(random, PUSHES) for action in ACTIONS}
    errors = {name: ERROR for name in NAMES if random.random() < 0.4}
    middles = {name: Fraction(int(random.integers(-4, 5)), 4) for name in NAMES}
    half = some(random, [Fraction(1, 16), Fraction(1, 4), Fraction(1, 2)])
    lines = ['name = "curved"', "steps = 6", "[variables]"]
    lines += [f'{name} = {{ range = ["{-RANGE}", "{RANGE}"] }}' for name in NAMES]
    lines += ["[agents.a.features]", *(f'{name} = "{_written(form)}"' for name, form in features.items())]
    lines += ["[agents.a.actions]", *(f'{name} = {{ push = "{push}" }}' for name, push in pushes.items())]
    starts = [f'{name} = ["{middles[name] - half}", "{middles[name] + half}"]' for name in NAMES]
    lines += [f"[start]\nbox = {{ {', '.join(starts)} }}", "[dynamics.cuts]", *(f"{name} = {CUTS}" for name in NAMES)]
    lines += ["[dynamics.error]", *(f'{name} = "{error}"' for name, error in errors.items())]
    lines += ["[dynamics.next]"]
    lines += [f'{name} = "{_written(rule)}{" + a.push" * (name == pushed)}"' for name, rule in rules.items()]
    tree = nested(random, 3, 2, len(ACTIONS))
    return (
        statement_of("\n".join(lines), "curved"),
        team(policy("a", list(features), ACTIONS, tree)),
        {
            "variables": [[name, "1", str(-RANGE), str(RANGE)] for name in NAMES],
            "features": {
                "a": {name: {"form": form, "measure": "value", "bounds": None} for name, form in features.items()}
            },
            "start": [
                {"most": {"constant": str(sign * -middles[name] - half), "terms": {name: str(sign)}}}
                for name in NAMES
                for sign in (1, -1)
            ],
            "pieces": [
                {
                    "where": {name: [str(-RANGE), str(RANGE)] for name in NAMES},
                    "move": rules,
                    "effect": [
                        ["a", action, {pushed: {"constant": str(push), "terms": {}}}] for action, push in pushes.items()
                    ],
                    "error": {name: [str(-error), str(error)] for name, error in errors.items()},
                }
            ],
        },
    )
