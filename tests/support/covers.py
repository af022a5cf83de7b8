"""Questions about stated systems, some of which hang on a single number or are for ever; recipes of covers for them;
what the checker of covers says, and faults to plant in it.
"""

from collections import Counter
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction as F

import numpy as np

from codegen.floats import FLOAT64
from codegen.policy_json import content_hash
from tests.support.altered import of_hashes
from tests.support.exact_play import refuted, start
from tests.support.system_cases import box, decided, form, policy, team
from tests.verify.reach import random_modes, random_systems
from verify.checker.accept import accept
from verify.checker.covers.sweep import BoxSweep, FormSweep
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Invariant
from verify.question import Budgets
from verify.reach.unbounded import InvariantSearch
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, Measure, Piece, System, Variable


def recipe(random, system):
    """How a start may be cut, and cells: none, or of some variables."""
    columns, cuts = len(system.variables), []
    pending, left = 1, int(random.integers(1, 40))
    while pending:
        cut = left > 0 and random.random() < 0.6
        cuts.append(int(random.integers(1, columns + 1)) if cut else 0)
        pending += 1 if cut else -1
        left -= 1
    widths = {
        column: float(random.choice([2.0, 0.5, 0.3, 0.125, 1 / 64]))
        for column in range(columns)
        if random.random() < 0.4
    }
    return cuts, widths


def question(random):
    """A random system with its team and claim; some agents compare float64, some numbers are no floats."""
    system, profile, claim = random_systems.case(random)
    if random.random() < 0.3:
        policies = [
            replace(one, tree=replace(one.tree, threshold=np.array(one.tree.threshold, np.float64), numbers=FLOAT64))
            for one in profile.agents
        ]
        profile = replace(profile, agents=tuple(policies))
    return system, profile, claim


def attacked(salt, seeds, episodes, tries, asking, forms=False):
    """How many claims were shown by some recipe, refuted, or neither. AssertionError for one that is both."""
    met = Counter()
    for seed in seeds:
        random = np.random.default_rng([salt, seed])
        asked = asking(random, seed)
        proved = any(shown(asked, recipe(random, asked[0]), forms) for _ in range(tries))
        broken = refuted(random, asked, episodes if proved else 12)
        assert not (proved and broken), (seed, asked[2])
        met[asked[2].pattern, proved, broken] += 1
    return met


def shown(question, cells, forms=False):
    """Whether the checker takes a cover for a proof, of boxes in cells or of forms."""
    system, profile, claim = question
    try:
        if forms:
            FormSweep(profile, system, claim).run(cells[0])
        else:
            BoxSweep(profile, system, claim).run(*cells)
    except RejectedError:
        return False
    return True


PLAIN = ((0,), {})


def line(start, threshold, measure=Measure.VALUE, bounds=None, numbers="float32", **piece):
    """A number that an agent pushes up by 1 where a feature of it is at most a threshold."""
    feature = Feature(piece.pop("of", form(x=1)), measure, bounds)
    stated = {"where": {}, "move": {"x": form(x=1)}, "effect": {("a", "go"): {"x": form(1)}}, "error": {}} | piece
    variable = Variable("x", "1", (F(-9), F(9)))
    system = System("line", (variable,), {"a": {"f": feature}}, box(x=start), (Piece(**stated),), 3)
    one = policy("a", ["f"], ["go", "rest"], ((0, threshold), 0, 1))
    if numbers == "float64":
        one = replace(one, tree=replace(one.tree, threshold=np.array(one.tree.threshold, np.float64), numbers=numbers))
    return system, team(one)


def claimed(kind, steps, by=0, **bounds):
    return SystemClaim(Pattern(kind), (box(**bounds),), steps, by)


def tie(threshold):
    """Up to where float32 numbers round to at most a threshold."""
    near = np.float32(threshold)
    return (F(float(near)) + F(float(np.nextafter(near, np.float32(np.inf))))) / 2


HALF, TENTH = F(1, 2), {"x": form(F(1, 10), x=1)}
END = tie(0.5)  # 0.5 is even, so the tie belongs to it
NEAR = {"x": (F(-1), HALF)}
CASES = [  # (name, system and profile, claim, whether it holds)
    ("reaches its end", line((0, 1), -5.0), claimed("stays_in", 0, x=(0, 1)), True),
    ("goes beyond its end", line((0, 1), -5.0), claimed("stays_in", 0, x=(0, F(2**53 - 1, 2**53))), False),
    ("goes right alone", line((1, 2), 0.5), claimed("stays_in", 2, x=(1, 2)), True),
    ("goes left at the tie", line((END, END), 0.5), claimed("avoids", 1, x=(1, 2)), False),
    ("goes right beyond it", line((END + F(1, 2**50),) * 2, 0.5), claimed("avoids", 1, x=(1, 2)), True),
    ("goes both ways", line((0, 1), 0.5), claimed("reaches_and_stays", 1, 1, x=(HALF, 1 + END)), True),
    ("goes left once", line((0, 0), 0.5), claimed("reaches", 1, x=(1, 1)), True),
    ("is late", line((0, 0), 0.5), claimed("reaches", 1, x=(2, 2)), False),
    ("is there by then", line((0, 0), 0.5), claimed("reaches_and_stays", 3, 1, x=(1, 1)), True),
    ("is not there at first", line((0, 0), 0.5), claimed("reaches_and_stays", 3, 0, x=(1, 1)), False),
    ("moves by a tenth", line((0, 0), -5.0, move=TENTH), claimed("stays_in", 3, x=(0, F(31, 100))), True),
    ("by no less", line((0, 0), -5.0, move=TENTH), claimed("stays_in", 3, x=(0, F(29, 100))), False),
    ("doubles", line((-1, 1), -5.0, move={"x": form(x=2)}), claimed("stays_in", 1, x=(-2, 2)), True),
    ("more than that", line((-1, 1), -5.0, move={"x": form(x=2)}), claimed("stays_in", 1, x=(-2, F(3, 2))), False),
    ("turns", line((1, 2), -5.0, move={"x": form(x=-1)}), claimed("stays_in", 1, x=(-2, 2)), True),
    ("turns beyond", line((1, 2), -5.0, move={"x": form(x=-1)}), claimed("stays_in", 1, x=(-1, 2)), False),
    ("errs down", line((0, 0), -5.0, error={"x": (F(-1), F(0))}), claimed("stays_in", 1, x=(F(-1, 2), 1)), False),
    ("errs up", line((0, 0), -5.0, error={"x": (F(0), F(1))}), claimed("stays_in", 1, x=(-1, F(1, 2))), False),
    ("sign", line((0, 0), -0.5, Measure.SIGN), claimed("stays_in", 1, x=(0, 0)), True),
    ("negative sign", line((F(-1, 9),) * 2, -0.5, Measure.SIGN), claimed("stays_in", 1, x=(-1, 0)), False),
    ("clipped", line((3, 3), 2.0, Measure.CLIP, (F(0), F(1))), claimed("stays_in", 1, x=(3, 3)), False),
    ("turned test", line((1, 1), -0.5, of=form(x=-1)), claimed("stays_in", 1, x=(1, 1)), False),
    ("turned test, other side", line((0, 0), -0.5, of=form(x=-1)), claimed("stays_in", 1, x=(0, 0)), True),
    ("leaves what is stated", line((0, 0), 0.5, where=NEAR), claimed("stays_in", 2, x=(-1, 3)), False),
    ("stays where it is stated", line((0, 0), -5.0, where=NEAR), claimed("stays_in", 2, x=(-1, 3)), True),
]  # fmt: skip


def after(change):
    """A fault: a function whose answer is changed."""
    return lambda f: lambda *given: change(f(*given))


def always(steps=60, **bounds):
    return SystemClaim(Pattern.ALWAYS, (box(**bounds),), steps)


def thermostat():
    """A room loses a tenth of its warmth beyond 10 degrees a step, and a heater gives 2 degrees below 19."""
    warm = Variable("warm", "1", (F(0), F(40)))
    move, heat = {"warm": form(1, warm=F(9, 10))}, {("heater", "on"): {"warm": form(2)}}
    error = {"warm": (F(-1, 10), F(1, 10))}
    features = {"heater": {"t": Feature(form(warm=1))}}
    system = System("room", (warm,), features, box(warm=(15, 25)), (Piece({}, move, heat, error),), 60)
    return system, team(policy("heater", ["t"], ["on", "off"], ((0, 19.0), 0, 1)))


def answered(asked, claim, **budgets):
    system, profile = asked
    (found,) = decided(profile, system, [claim], Budgets(**budgets))
    return found


def attack_invariants(salt, seeds, each, most, claimed, forge):
    """How many forgeries of false claims there were, and how many claims were proved by searches or forged lists.
    AssertionError for one that an episode breaks. `claimed`: the claim for ever that is asked of a random system;
    `forge`: so many lists of parts; `most`: boxes of a search.
    """
    met = Counter()
    for seed in seeds:
        random = np.random.default_rng([salt, seed])
        system, profile, claim = question(random) if seed % 2 else random_modes.case(random)
        claim = claimed(random, system, claim.regions)
        state = next((found for found in (start(random, system) for _ in range(20)) if found), None)
        if state is None or not all(half.holds(state) for region in claim.assuming for half in region):
            continue
        parts = next(InvariantSearch(profile, system, claim, most).iterate_invariants(), None)
        hashes, taken = (content_hash(profile), documents.content_hash(system)), False
        for listed in [*forge(random, system, each), *([parts] if parts else [])]:
            with suppress(RejectedError):
                taken |= accept(of_hashes(*hashes, claim, state, Invariant(listed)), profile, system) > 0
        broken = refuted(random, (system, profile, claim), 40 if taken else 12)
        assert not (taken and broken), (seed, claim)
        met["forgeries"] += each * broken
        met["proved"] += taken
    return met
