"""What catches a fault in a reading of stated systems: questions and courses whose answers are known, and forgeries.

One of these catches it: a claim is proved that an episode breaks; a claim that holds is no longer proved; a forged
certificate is accepted; a verdict is another one; points of a symbolic state are lost; an episode is judged otherwise;
or the solver, which reads all on its own, says something else.
"""

from contextlib import suppress
from dataclasses import replace
from fractions import Fraction as F
from functools import cache
from itertools import product
from unittest.mock import patch

import numpy as np
import z3

from codegen.errors import MaviperError
from codegen.policy_json import content_hash
from tests.support.altered import altered, of_hashes
from tests.support.covers import line
from tests.support.system_cases import box, decided, double_integrator, form, policy, stays, switching, team
from tests.verify.reach import random_systems
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import FollowedPart, Hull, Walks
from verify.checker.systems.reading import Branch, Direction, Motion, Row
from verify.claims.formula import Acts, Linear, Or, negate
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach import decide as deciding
from verify.reach.replay import Course, replay_course
from verify.result import Verdict
from verify.solver import unrolled
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, HalfSpace, Measure, Piece, System, Variable

SEARCHED = Budgets(max_boxes=40_000, covers=False, samples=0)  # by proofs alone
PLAYED = Budgets(max_boxes=2_000_000, covers=False)
BROKEN, HELD, FORGED = "a broken claim is proved", "a true claim is lost", "a forgery passes"
ANSWERED, POINTS, JUDGED = "a verdict turns", "points are lost", "an episode is judged otherwise"
OPINED = "the solver has another opinion"
QUESTIONS = 150


# --- the questions


def avoids(steps, **bounds):
    return SystemClaim(Pattern.AVOIDS, (box(**bounds),), steps)


def single(threshold):
    """The float32 nearest to a number, and the next one."""
    near = np.float32(threshold)
    return F(float(near)), F(float(np.nextafter(near, np.float32(np.inf))))


def by_hand():
    """Questions whose answers hang on a single number."""
    found = []
    for low, high, at in ((0, F(1, 8), F(1, 8)), (F(-1, 8), 0, F(-1, 8))):  # an end of an error
        system, profile = line((0, 0), -5.0, error={"x": (F(low), F(high))})
        found.append((system, profile, avoids(1, x=(at, at))))
    system, profile = line((0, 1), -5.0)
    found.append((system, profile, avoids(0, x=(1, 2))))
    pair = team(*(policy(agent, ["f"], ["go", "rest"], 0) for agent in "ab"))
    push = {(agent, "go"): {"x": form(1)} for agent in "ab"}
    system = replace(system, pieces=(Piece({}, {"x": form(x=1)}, push, {}),), start=box(x=(0, 0)))
    system = replace(system, features=dict.fromkeys("ab", system.features["a"]))
    found.append((system, pair, avoids(1, x=(2, 3))))
    exact, after = single(0.1)
    region = box(x=((3 * exact + after) / 4, (2 * exact + 2 * after) / 4))
    rests = SystemClaim(Pattern.DECIDES, (region,), formula=Acts("a", 1))
    found.append((*line((0, 1), 0.1), rests))
    found.append((*line((0, 1), 0.1), replace(rests, regions=(box(x=((exact + 3 * after) / 4, after)),))))
    near = Or((Linear(((F(1), "x"),), F(1, 2), True), Acts("a", 1)))  # rests from 1/2 on
    found.append((*line((0, 1), 0.25), SystemClaim(Pattern.DECIDES, formula=near)))
    above = (HalfSpace(form(1, x=-1), True),)  # above 1, where no start is
    found.append((*line((0, 1), -5.0), SystemClaim(Pattern.AVOIDS, (above,))))
    for measure, bounds in ((Measure.SIGN, None), (Measure.POSITIVE, None), (Measure.CLIP, (F(-1, 2), F(1, 2)))):
        for threshold in (-1.0, -0.5, 0.0, 0.5, 1.0):
            for end in (0, F(1, 2), F(-1, 2), 1, -1):
                asked = SystemClaim(Pattern.DECIDES, (box(x=(end, end)),), formula=Acts("a", 1))
                found.append((*line((0, 1), threshold, measure, bounds), asked))
    boxes = [{"x": (F(-9), F(0))}, {"x": (F(0), F(9))}]
    system, profile = line((-1, 1), -5.0)
    second = tuple(Piece(where, {"x": form(n, x=1)}, {}, {}) for n, where in enumerate(boxes))
    found.append((replace(system, pieces=second), profile, avoids(1, x=(F(3, 2), 9))))
    for moves, errors in (((1, 1), (0, 1)), ((1, 2), (0, 0))):  # pieces that differ in errors, or in what they multiply
        pieces = zip(boxes, moves, errors, strict=True)
        both = tuple(Piece(where, {"x": form(x=n)}, {}, {"x": (F(0), F(e))}) for where, n, e in pieces)
        past = avoids(1, x=(F(3, 2), 9))
        found.append((replace(system, pieces=both), profile, past))
    sideways = {("a", "go"): {"x": form(1)}, ("a", "rest"): {"x": form(-1)}}
    aside = Piece({}, {name: form(**{name: 1}) for name in "xy"}, sideways)
    plane = tuple(Variable(name, "1", (F(-9), F(9))) for name in "xy")
    unseen = System("plane", plane, {"a": {"f": Feature(form(y=1))}}, box(x=(0, 0), y=(-1, 1)), (aside,), 3)
    for bounds in ((F(-1, 2), 9), (-9, F(1, 2))):  # a test of what is not followed
        found.append((unseen, profile, stays(unseen, 1, x=bounds, y=(-8, 8))))
    space = tuple(Variable(name, "1", (F(-9), F(9))) for name in "xyz")
    still = Piece({}, {name: form(**{name: 1}) for name in "xyz"}, sideways)
    seeing = {"a": {name: Feature(form(**{name: 1})) for name in "xyz"}}
    spread = System("space", space, seeing, box(x=(-1, 1), y=(-1, 1), z=(-1, 1)), (still,), 1)
    by_z = ((2, 0.0), 0, 1)
    for left in (((0, 0.0), 0, 1), 1):  # what is not followed chooses between two tests, or a test and an action
        chosen = team(policy("a", ["x", "y", "z"], ["go", "rest"], ((1, 0.0), left, by_z)))
        found.append((spread, chosen, avoids(1, x=(F(3, 2), 2), z=(-1, 1))))
    twice = Piece({}, {"x": form(x=1, y=1), "y": form(x=1)}, {}, {})  # the start of x comes back by y
    coupled = System("coupled", plane, {"a": {"f": Feature(form(y=1))}}, box(x=(0, 1), y=(0, 0)), (twice,), 3)
    found.append((coupled, profile, avoids(2, x=(F(3, 2), 9))))
    drifting = (Piece({"x": (F(-1), F(1))}, {"x": form(1, x=1)}, {}, {}),)
    leaving = avoids(3, x=(5, 6))
    found.append((replace(system, start=box(x=(0, 0)), pieces=drifting), profile, leaving))
    noisy = double_integrator(axes=1, error=F(1, 50), steps=12)
    aside = replace(double_integrator(axes=1, steps=12), start=box(x=(F(2, 5), F(1, 2)), vx=(0, 0)))
    crossing = avoids(12, x=(F(-1, 5), F(1, 5)))
    found.append((noisy, switching(axes=1), stays(noisy, 12, x=(F(-101, 200), F(101, 200)))))
    found.append((aside, switching(axes=1), crossing))
    both = double_integrator(axes=2, steps=6)
    found.append((both, switching(axes=2), stays(both, 6, x=(F(-3, 5), F(3, 5)), y=(F(-3, 5), F(3, 5)))))
    return found


def drawn(seed):
    """A random question; every third one about decisions."""
    random = np.random.default_rng(seed)
    system, profile, claim = random_systems.case(random)
    if seed % 3:
        return system, profile, claim
    names = [one.name for one in system.variables]
    acts = [Acts(one.agent, int(random.integers(len(one.actions)))) for one in profile.agents]
    atoms = SystemClaim(Pattern.AVOIDS, (random_systems.polytope(random, names),)).inside
    regions = tuple(random_systems.polytope(random, names) for _ in range(int(random.integers(0, 3))))
    return system, profile, SystemClaim(Pattern.DECIDES, regions, formula=Or((negate(atoms), *acts)))


@cache
def asked():
    """All questions, with the verdict of each."""
    questions = [*by_hand(), *map(drawn, range(QUESTIONS))]
    return [(question, answer(question, PLAYED)) for question in questions]


def answer(question, budget):
    """The verdict; None where checker and engine do not come to one."""
    system, profile, claim = question
    with suppress(RejectedError, MaviperError, ArithmeticError, LookupError, AssertionError):
        return decided(profile, system, [claim], budget)[0].verdict
    return None


@cache
def opinions():
    """What the solver says of each question."""
    return [opinion(question) for question, _ in asked()]


def opinion(question):
    """The second engine's verdict; None where its query cannot be written."""
    system, profile, claim = question
    with suppress(z3.Z3Exception, LookupError, AssertionError):
        return unrolled.opinion(Question(ClosedLoop(profile, system), claim, UNBOUNDED)).verdict
    return None


# --- points and episodes


def holds(row, point):
    total = sum(weight * point[unknown] for unknown, weight in row.direction.weights)
    end = row.end if row.upper else -row.end
    total = total if row.upper else -total
    return total < end or (total == end and not row.strict)


def points(branch):
    """The points of a grid that lie in a branch of two unknowns, by its box and rows."""

    def inside(point):
        for unknown, (low, low_open, high, high_open) in branch.box.items():
            at = point[unknown]
            if not (low < at or (low == at and not low_open)) or not (at < high or (at == high and not high_open)):
                return False
        return all(holds(row, point) for row in branch.rows)

    grid = [F(number, 4) for number in range(5)]
    return {point for point in product(grid, grid) if inside(point)}


def points_lost():
    """Whether rows, and what branches say of them, are wrong of some point: what is settled, and what contradicts."""
    random = np.random.default_rng(0)
    sums = (((0, 1),), ((1, 1),), ((0, 1), (1, 1)), ((0, 1), (1, -1)), ((0, 2), (1, -1)))
    directions = list(map(Direction, sums))

    def drawn_row():
        upper, strict = (bool(random.random() < 0.5) for _ in range(2))
        return Row(random_systems.some(random, directions), upper, F(int(random.integers(-4, 9)), 4), strict)

    narrow = Branch(0, Motion({}, ()), {}).with_row(Row(directions[0], True, F(1, 4), False))
    if not narrow.is_contradicted([(Row(directions[2], False, F(3, 2), False), 1)]):
        return True
    everywhere = set(product([F(number, 4) for number in range(5)], repeat=2))
    for _ in range(400):
        branch, kept = Branch(0, Motion({}, ()), {}), everywhere
        for _ in range(int(random.integers(1, 4))):
            row = drawn_row()
            branch, kept = branch.with_row(row), {point for point in kept if holds(row, point)}
        row = drawn_row()
        said = branch.decide_row(row)
        used = [(each, int(random.integers(1, 3))) for each in (*branch.rows, row)]
        if (
            points(branch) != kept
            or any(holds(row, point) == holds(row.opposite(), point) for point in everywhere)
            or (said is not None and any(holds(row, point) is not said for point in kept))
            or (branch.is_contradicted(used) and any(holds(row, point) for point in kept))
        ):
            return True
    return False


def judged(system, profile, claim, course):
    return replay_course(profile, system, claim, course) is None


def episodes():
    """Questions with a course, and whether it keeps the claim, or is no episode of the system."""
    crossing = avoids(1, x=(1, 2))
    still = (*line((0, F(1, 2)), -5.0, error={"x": (F(0), F(1, 4))}), crossing)
    pushed = (*line((0, F(1, 2)), 5.0), crossing)
    exact, after = single(0.1)
    rests = SystemClaim(Pattern.DECIDES, (), formula=Acts("a", 1))
    return [
        (still, Course({"x": F(1)}), True),  # no start
        (still, Course({"x": F(1, 2)}, [{"x": F(1)}]), True),  # an error is cut to its bounds
        (still, Course({"x": F(1, 2)}), True),
        (pushed, Course({"x": F(0)}), False),
        (pushed, Course({"x": F(1, 2)}), False),
        ((*line((0, 1), 0.1), rests), Course({"x": (exact + 3 * after) / 4}), True),
    ]


# --- the certificates


def with_hulls():
    """A question whose proof merges states into hulls, if that is what is tried first."""
    system = double_integrator(axes=1, error=F(1, 1000), steps=12)
    return system, switching(axes=1), stays(system, 12, x=(F(-7, 10), F(7, 10)))


@cache
def forgeries():
    """Certificates that the checker refuses: with another number, one more or one less, or with other hulls."""
    random, found = np.random.default_rng(0), []
    system, profile = line((0, 0), 5.0)
    claim = avoids(1, x=(1, 2))
    for bounds in ((F(-1, 2), F(-1, 4)), (F(1, 2), F(3, 2))):  # hulls that do not hold what is put in, or go wrong
        part = FollowedPart(("x",), (0,), (Hull(1, box(x=bounds)),), b"\1")
        hashes = content_hash(profile), documents.content_hash(system)
        found.append((of_hashes(*hashes, claim, {"x": F(0)}, Walks((part,))), profile, system))
    coupled, profile, past = next(question for question in by_hand() if question[0].name == "coupled")
    hashes = content_hash(profile), documents.content_hash(coupled)
    alone = FollowedPart(("x",), (0,), (), b"")  # without y, on which x depends
    forged = of_hashes(*hashes, replace(past, steps=0), {"x": F(0), "y": F(0)}, Walks((alone,)))
    found.append((forged, profile, coupled))
    assert not any(passes(*each) for each in found)
    axes = double_integrator(axes=2, steps=10)
    cases = [with_hulls()]
    cases.append((axes, switching(axes=2), stays(axes, 10, x=(F(-3, 5), F(3, 5)), y=(F(-3, 5), F(3, 5)))))
    cases += [question for question, verdict in asked() if verdict is Verdict.PROVED][:30]
    for place, (system, profile, claim) in enumerate(cases):
        with patch.object(deciding, "STAGES", deciding.STAGES[1:] if not place else deciding.STAGES):
            (result,) = decided(profile, system, [claim])
        made = result.certificate
        assert place or sum(len(part.hulls) for part in made.proof.parts) >= 4
        others = [altered(made, parts=made.proof.parts[1:])]
        others.append(altered(made, inhabitant={name: F(99) for name in made.header.inhabitant}))
        for number, part in enumerate(made.proof.parts):
            changed = [altered(part, proof=part.proof + b"\0"), altered(part, shows=part.shows[1:])]
            changed.append(altered(part, followed=part.followed[1:]))
            for at, (step, region) in enumerate((hull.step, hull.region) for hull in part.hulls):
                narrow = tuple(replace(half, form=half.form.plus(form(F(1, 10)))) for half in region)
                for wrong in (Hull(step, narrow), Hull(step + 1, region)):
                    changed.append(altered(part, hulls=(*part.hulls[:at], wrong, *part.hulls[at + 1 :])))
            for _ in range(12 if part.proof else 0):
                proof = bytearray(part.proof)
                at = int(random.integers(len(proof)))
                proof[at] = (proof[at] + int(random.integers(1, 4))) % 128
                changed.append(altered(part, proof=bytes(proof)))
            others += [
                altered(made, parts=(*made.proof.parts[:number], each, *made.proof.parts[number + 1 :]))
                for each in changed
            ]
        found += [(each, profile, system) for each in others if not passes(each, profile, system)]
    return found


def passes(certificate, profile, system):
    with suppress(RejectedError, MaviperError):
        return accept(certificate, profile, system) >= 0
    return False


def find_case(guard, first=None):
    """The number of a guard's case that speaks, or None. `first`: the number of the one that is asked first."""
    if guard == FORGED:
        return find_speaking(forgeries(), lambda forged: passes(*forged), first)
    if guard == POINTS:
        return 0 if points_lost() else None
    if guard == JUDGED:
        return find_speaking(episodes(), lambda each: judged(*each[0], each[1]) != each[2], first)
    if guard == OPINED:
        said = list(zip(asked(), opinions(), strict=True))
        return find_speaking(said, lambda each: opinion(each[0][0]) is not each[1], first)
    if guard == ANSWERED:
        return find_speaking(asked(), lambda each: answer(each[0], PLAYED) is not each[1], first)
    proved = Verdict.PROVED
    if guard == BROKEN:
        broken = [question for question, verdict in asked() if verdict is not proved and verdict is not Verdict.VACUOUS]
        return find_speaking(broken, lambda question: answer(question, SEARCHED) is proved, first)
    held = [question for question, verdict in asked() if verdict is proved]
    return find_speaking(held, lambda question: answer(question, SEARCHED) is not proved, first)


def find_speaking(cases, speaks, first):
    """The number of a case that speaks, or None once all were asked."""
    order = sorted(range(len(cases)), key=lambda number: number != first)
    return next((number for number in order if speaks(cases[number])), None)
