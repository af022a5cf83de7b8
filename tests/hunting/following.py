"""Questions about next values in stated systems for the hunt, and what is wrong with their answers.

Does: random systems and formulas of one or two comparisons that name next values, each bound near the extreme that the
  judge has sampled; asks whether they hold in all states, and has the answer judged state by state.
Assumes: stated.py judges by plain data alone.
Does not: know curved rules, modes or flows.

A next value is whatever a step makes of a state: by each piece that holds it, with each error within its bounds.
"""

from fractions import Fraction
from itertools import product

import numpy as np

from tests.hunting import stated
from tests.hunting.asking import Told
from tests.hunting.systems import BUDGETS, nodes, plain
from tests.verify.reach import random_systems
from verify.claims.formula import Linear, disjunction
from verify.claims.region import UNBOUNDED
from verify.question import Question
from verify.reach.decide import decide
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.curves import name_next_values, without_next

STATES, STEP = 120, Fraction(1, 2)  # that the judge asks; many borders of the random systems are multiples of it
WEIGHTS = [Fraction(1), Fraction(-1), Fraction(1, 2), Fraction(-1, 3)]
NEAR = Fraction(2, 100)  # of the sampled extreme


class Judge:
    """A system and a team as plain data."""

    def __init__(self, system, profile):
        self.system = plain(documents.document(system))
        self.agents = [{"agent": one.agent, "numbers": one.numbers, "nodes": nodes(one)} for one in profile.agents]
        self.ranges = {one.name: one.range for one in system.variables}

    def drawn(self, rng):
        """A state in the ranges, often on borders."""
        found = {}
        for name, (low, high) in self.ranges.items():
            share = Fraction(int(rng.integers(0, 1025)), 1024)
            value = low + share * (high - low)
            found[name] = round(value / STEP) * STEP if rng.random() < 0.4 else value
        return found

    def after(self, state):
        """What a state becomes, by each piece that holds it, at the ends of all errors; without names of next ones."""
        for number in stated.holding(self.system, state):
            error = self.system["pieces"][number]["error"]
            for ends in product(*([(name, Fraction(end)) for end in bounds] for name, bounds in error.items())):
                yield stated.moved(self.system, self.agents, state, number, dict(ends))


def summed(terms, state, after):
    """The value of a sum of values and next values."""
    return sum(weight * (after[name[:-1]] if name.endswith("'") else state[name]) for weight, name in terms)


def breaks(comparisons, state, after):
    """Whether none of some comparisons holds."""
    sums = [(summed(terms, state, after), bound, strict) for terms, bound, strict in comparisons]
    return not any(value < bound or (value == bound and not strict) for value, bound, strict in sums)


def drawn(rng, system, judge):
    """Comparisons of which one is to hold: terms, bound, and whether the bound is left out."""
    names, found = list(judge.ranges), []
    for number in range(int(rng.integers(1, 3))):
        terms = {str(rng.choice(names)) + "'": random_systems.some(rng, WEIGHTS)}
        if rng.random() < 0.6:
            terms[str(rng.choice([*names, *(name + "'" for name in names)]))] = random_systems.some(rng, WEIGHTS)
        terms = tuple((weight, name) for name, weight in terms.items())
        states = [judge.drawn(rng) for _ in range(40)]
        sums = [summed(terms, state, after) for state in states for after in judge.after(state)]
        most = max(sums) if sums else Fraction(1)
        bound = most + abs(most) * NEAR * (1 if rng.random() < 0.6 else -1) - (number and Fraction(1, 2))
        found.append((terms, bound, bool(rng.random() < 0.3)))
    return found


def ask(seed, thorough):
    rng = np.random.default_rng([seed, 34])
    system, profile, _ = random_systems.case(rng)
    judge = Judge(system, profile)
    comparisons = drawn(rng, system, judge)
    verdict, found = answered(system, profile, comparisons)
    states = [judge.drawn(rng) for _ in range(STATES * (5 if thorough else 1))]
    violated = any(breaks(comparisons, state, after) for state in states for after in judge.after(state))
    answer = Told(seed, verdict, "following", 2, conflict=True, judged="violated" if violated else "")
    answer.close = len(comparisons) == 1
    if verdict == "PROVED" and violated:
        answer.wrong.append("PROVED, and the judge has a state that breaks it")
    if found is not None and not any(breaks(comparisons, found, after) for after in judge.after(found)):
        answer.wrong.append("VIOLATED by a state that breaks nothing")
    return answer


def answered(system, profile, comparisons):
    """The verdict, and the state of a counterexample: proved where the stronger formula is, violated where the weaker
    is.
    """
    stated_as = disjunction(*(Linear(terms, bound, strict) for terms, bound, strict in comparisons))
    acting = {policy.agent: policy for policy in profile.agents}
    following = name_next_values(system.variables)
    stronger, weaker = without_next(stated_as, system.pieces, following, acting, True, "hunt")
    first = asked(system, profile, stronger)
    if first.verdict.value != "VIOLATED":
        return first.verdict.value, None
    last = first if weaker == stronger else asked(system, profile, weaker)
    return (last.verdict.value, dict(last.counterexample.start)) if last.counterexample else ("UNKNOWN", None)


def asked(system, profile, formula):
    """What is decided of a formula without next values."""
    claim = SystemClaim(Pattern.DECIDES, (), 0, formula=formula)
    return decide(Question(ClosedLoop(profile, system), claim, UNBOUNDED, budgets=BUDGETS))
