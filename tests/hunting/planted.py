"""Faults in the verifier, each of which a kind of question must notice: mended false words, and forgotten steps.

Does: patches what proofs read of claims, agents and world files, what checks them, and what answers a file's claims.
Assumes: pytest's monkeypatch, or anything with its `setattr`. Forgotten roundings of agents show at bounds that lie
  below an extreme by less than a rounding; those of features in games are too small for a hunt, since tests of a
  claim's states rarely lie at its bound: test_game_sums.py looks for them.
Does not: look for faults.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from maviper.verification import stated, worlds
from maviper.verification.stated import StatedWorld
from maviper.worlds.stated import observing
from verify.checker import decisions as checking
from verify.checker.covers.sweep import CoverSweep
from verify.checker.systems import branch_proofs
from verify.checker.systems.branch_proofs import SystemQuestions
from verify.checker.systems.reading import Branch
from verify.claims import claim, decisions
from verify.claims.formula import disjunction
from verify.counterexamples import search
from verify.episodes import certificates as making
from verify.episodes import unroll
from verify.kinds import MACHINE
from verify.question import DecisionQuestion
from verify.reach import programs
from verify.reach.decide import ClaimSearch
from verify.solver.solve import Answer
from verify.states import shares
from verify.systems import lowered, properties
from verify.systems.lowered import Errors
from verify.systems.system import Affine
from verify.verdicts import decisions as judging

Plant = Callable[[Any], None]
Reading = lowered._Reading


def put(owner: Any, attribute: str, change: Callable[[Any], Any]) -> Plant:
    """A fault: what stands there is changed."""
    return lambda patch: patch.setattr(owner, attribute, change(getattr(owner, attribute)))


# --- false words that were mended: what the hunt must find again


@dataclass(frozen=True)
class Planted:
    """A false word, and among which questions it shows."""

    name: str
    kind: str
    plant: Plant
    shows: str  # what is wrong then says so


def _signs(patch: Any) -> None:
    """Two tests of a sign at thresholds on either side of 0 are one test, so starts at 0 are lost; what the search for
    a certificate leaves open stays proved.
    """
    line = unroll._line

    def one_test(*given: Any) -> tuple[float, bool] | bool:
        found = line(*given)
        return found if isinstance(found, bool) else (found[0], False)

    patch.setattr(unroll, "_line", one_test)
    patch.setattr(making, "LeftOpenError", making.NoCertificateError)


def _nobody(patch: Any) -> None:
    """A claim about a team that there is not is true of all of nobody, also in a certificate."""
    known_names = checking.ensure_known_names
    patch.setattr(decisions, "ensure_team", lambda profile, team: None)
    patch.setattr(claim, "ensure_team", lambda profile, team: None)
    patch.setattr(
        checking, "ensure_known_names", lambda profile, header, team, *rest: known_names(profile, header, None, *rest)
    )


def _real(patch: Any) -> None:
    """States that violate a claim in real arithmetic are sought by it, but judged and simplified by the machine's."""
    violates, violating, shortfall = search.violates, shares.violating, search.shortfall
    confirmed, ask = search.confirm_point, search.ask

    def float_states_only(question: DecisionQuestion, *given: Any) -> Any:
        try:
            return confirmed(question, *given)
        except StopIteration:
            return None, 0

    patch.setattr(search, "violates", lambda question, state: violates(question.by(MACHINE), state))
    patch.setattr(search, "draw_states", shares.draw_states.__wrapped__)  # nothing that was drawn without the fault
    patch.setattr(shares, "violating", lambda question, states: violating(question.by(MACHINE), states))
    patch.setattr(search, "shortfall", lambda question, state: shortfall(question.by(MACHINE), state))
    patch.setattr(search, "in_both", lambda *given: None)  # what fails in both arithmetics is not asked
    patch.setattr(search, "ask", lambda query, units: Answer(None, None, 0) if query is None else ask(query, units))
    patch.setattr(search, "_simplify_model", lambda question, goal, model: (None, 0))
    patch.setattr(search, "confirm_point", float_states_only)
    patch.setattr(judging, "confirm_point", float_states_only)


PLANTED = (
    Planted("starts at which a sign is 0 are lost", "episodes", _signs, "proved, but fails"),
    Planted("a certificate about a team that there is not is accepted", "decisions", _nobody, "about nobody"),
    Planted("real arithmetic is judged by the machine's", "decisions", _real, "where the claim holds"),
)


# --- answers that depend on the other claims of a file


def _answer_equal(answer: Any) -> Any:
    """Claims that are equal but for labels and invariants have the answer of the first."""

    def of_first(self: Any, question: Any, beside: bool = True) -> Any:
        return answer(self, next(each for each in self._questions if each.claim == question.claim), beside)

    return of_first


def _witness(patch: Any) -> None:
    """The start that shows that there is one is asked of the first claim about episodes."""
    inhabitant, known = programs.inhabitant, list[tuple[Any, Any]]()

    def noted(search: Any) -> None:
        if not search.claim.about_decisions:
            _first(known, search.system, search.claim)

    _after_making(patch, noted)
    patch.setattr(programs, "inhabitant", lambda system, claim: inhabitant(system, _first(known, system, claim)))


def _budget(patch: Any) -> None:
    """All claims share one budget."""
    known = list[tuple[Any, Any]]()
    _after_making(patch, lambda search: setattr(search, "spending", _first(known, search.system, search.spending)))


def _after_making(patch: Any, do: Callable[[Any], None]) -> None:
    """Does something with each search that is made."""
    made = ClaimSearch.__init__

    def then(self: Any, *given: Any) -> None:
        made(self, *given)
        do(self)

    patch.setattr(ClaimSearch, "__init__", then)


def _first(known: list[tuple[Any, Any]], system: Any, value: Any) -> Any:
    """The value that was first named with a system."""
    known.append((system, value))
    return next(kept for one, kept in known if one is system)


FILES: dict[str, Plant] = {
    "equal claims": put(StatedWorld, "answer", _answer_equal),
    "the first one's start": _witness,
    "one budget": _budget,
}


# --- claims about sums and outputs: readings of agents, of formulas, of `robust`, and the walk of the checker


def _form(change: Callable[[Any, Any], Any]) -> Plant:
    """Sums are read as a change of a tree and of a sum has them."""
    return put(Reading, "_form", lambda form: lambda self, each: form(self, change(self._tree, each)))


def _shorten(tree: Any, each: Any) -> Any:
    tested = each in tree.sums and len(each.terms) > 1
    return replace(each, terms=each.terms[:-1]) if tested else each


def _turn(tree: Any, each: Any) -> Any:
    given = any(each in vector for vector in tree.vectors) and each not in tree.sums
    (weight, place), *others = each.terms
    return replace(each, terms=((-weight, place), *others)) if given else each


def _swap(tree: Any, each: Any) -> Any:
    return replace(each, terms=tuple((weight, 1 - at if at in (0, 1) else at) for weight, at in each.terms))


def _later(split: Any) -> Any:
    def later(self: Any, plain: Any, threshold: Any, left: Any, right: Any) -> Any:
        tested = len(list(self._features.values())[plain].form.terms) > 1
        return split(self, plain, threshold + 0.125 * tested, left, right)

    return later


def _within_bounds(beyond: Any) -> Any:
    """States in which a leaf's number lies within its bounds are those of which nothing is asked."""

    def within(*given: Any) -> Any:
        parts = list(beyond(*given))
        yield from [properties.Not(disjunction(*parts))] if parts else []

    return within


def _one_input(compared: Any) -> Any:
    """A comparison of two outputs reads the first of them alone."""

    def alone(formula: Any, statement: Any, acting: Any, where: Any) -> Any:
        inputs = [name for _, name in formula.terms if any(name in each.inputs for each in statement.agents)]
        kept = tuple(term for term in formula.terms if term[1] not in inputs[1:])
        return compared(formula._replace(terms=kept), statement, acting, where)

    return alone


def _half_region(region: Any) -> Any:
    """Of every range the upper half is left out."""

    def half(*given: Any) -> Any:
        found = region(*given)
        return replace(found, box={name: (low, (low + high) / 2) for name, (low, high) in found.box.items()})

    return half


def _proofs_alone(owner: Any, attribute: str, change: Callable[[Any], Any]) -> Plant:
    """A fault of the walk; nothing is played before it is proved, so that only proofs answer."""

    def plant(patch: Any) -> None:
        patch.setattr(ClaimSearch, "_play", lambda *given, **named: None)
        put(owner, attribute, change)(patch)

    return plant


def _tighten(row: Any) -> Any:
    """A row of a little less: a sixteenth of what its sum may be."""
    less = (row.direction.high - row.direction.low) / 16
    return row._replace(end=row.end - less * (1 if row.upper else -1))


def _left_only(_: Any) -> Any:
    def leaves(self: Any, branch: Any, decision: Any) -> Any:
        while isinstance(decision, branch_proofs.Split):
            branch, _ = self._sides(branch, decision.left_if)
            if branch is None:
                return
            decision = decision.left
        yield branch, decision

    return leaves


def small(_: Any) -> Any:
    """No rounding to speak of."""
    return lambda self, each: Fraction(1, 1 << 200)


REGION = "regions: half of the ranges", put(stated, "resolve_region", _half_region)
OUTPUTS: dict[str, Plant] = {
    "roundings: sums are exact": put(Errors, "of", small),
    "roundings: features are observed exactly": put(Errors, "bound_feature", small),
    "roundings: the last one is forgotten": put(Errors, "bound_output", small),
    "leaves: numbers are not cut": put(Reading, "_reach", lambda f: lambda self, form: (Fraction(0), Fraction(0))),
    "sums: two features are swapped": _form(_swap),
    "tests: right sides are left out": put(
        Reading, "_split", lambda f: lambda self, plain, at, left, right: f(self, plain, at, left, left)
    ),
    "tests of sums: a term is left out": _form(_shorten),
    "tests of sums: the threshold is another one": put(Reading, "_split", _later),
    "tests: the sides are swapped": put(
        Reading, "_split", lambda f: lambda self, plain, at, left, right: f(self, plain, at, right, left)
    ),
    "leaves: a weight has the opposite sign": _form(_turn),
    "leaves: constants are those of the first": put(
        Reading, "_constant", lambda f: lambda self, vector, output: f(self, 0, output) + 0 * vector
    ),
    "leaves: what is asked within bounds and beyond is swapped": put(properties, "_cut_off", _within_bounds),
    "formulas: the second of two outputs is left out": put(properties, "_put_settings", _one_input),
    "robust: errors are forgotten": put(
        properties,
        "box_of",
        lambda box: lambda ends: box({name: (0 * low, 0 * high) for name, (low, high) in ends.items()}),
    ),
    REGION[0]: REGION[1],
    "checker: any sum of rows is a contradiction": put(Branch, "is_contradicted", lambda f: lambda self, used: True),
    "checker: bounds settle more than they should": _proofs_alone(
        Branch, "decide_row", lambda f: lambda self, row: f(self, _tighten(row))
    ),
    "checker: ways to break a claim are forgotten": _proofs_alone(
        SystemQuestions, "_within_some", lambda f: lambda self, branch, parts: f(self, branch, parts[:1])
    ),
    "checker: right sides are forgotten": _proofs_alone(SystemQuestions, "_leaves", _left_only),
}


# --- systems that numbers drive: what proofs read of a world file, and the checker of covers


def _played(change: Callable[[Any, Any], tuple[Any, Any]]) -> Plant:
    """What proofs read is what a change makes of it: of a statement and a profile."""
    return put(stated, "as_played", lambda played: lambda *given: change(*played(*given)))


def _pieces(change: Callable[[Any], Any]) -> Plant:
    def changed(statement: Any, profile: Any) -> tuple[Any, Any]:
        system = statement.system
        return replace(statement, system=replace(system, pieces=tuple(map(change, system.pieces)))), profile

    return _played(changed)


def _half_starts(statement: Any, profile: Any) -> tuple[Any, Any]:
    system = statement.system
    halves = [each for each in system.start if len(each.form.terms) == 1]
    first, low = next((each, one) for each in halves for one in halves if one.form.terms[0] == _turned(each)[0])
    middle = (first.form.constant - low.form.constant) / 2
    nearer = replace(first, form=Affine(first.form.terms, middle))
    return replace(statement, system=replace(system, start=(*system.start, nearer))), profile


def _turned(half: Any) -> list[Any]:
    return [(name, -factor) for name, factor in half.form.terms]


def _halve(form: Any, name: str) -> Affine:
    return Affine.of({each: factor / 2 if each == name else factor for each, factor in form.terms}, form.constant)


COVERS = (
    "checker: covers are asked about at first only",
    put(CoverSweep, "_ask_claim", lambda ask: lambda self, sets, step: ask(self, sets, step) if step < 1 else sets),
)
DRIVEN: dict[str, Plant] = {
    "starts: half of them": _played(_half_starts),
    "motion: errors are forgotten": _pieces(lambda piece: replace(piece, error={})),
    "motion: the first agent moves nothing": _pieces(
        lambda piece: replace(piece, effect={key: forms for key, forms in piece.effect.items() if key[0] != "agent_0"})
    ),
    "motion: a variable follows half of itself": _pieces(
        lambda piece: replace(piece, move={name: _halve(form, name) for name, form in piece.move.items()})
    ),
    COVERS[0]: COVERS[1],
    **{name: plant for name, plant in OUTPUTS.items() if name.startswith(("roundings", "leaves: n", "sums"))},
}


# --- games whose teams test sums: what a file states of motion, of observations, of errors, or of a claim


def _shorter(property_: Any) -> Any:
    def shorter(label: Any, name: str, steps: int, regions: Any, by: int | None = None) -> Any:
        return property_(label, name, steps - 1, regions, by and min(by, steps - 1))

    return shorter


def _nearly(near: Any) -> Any:
    """Who is a sixteenth too far is near."""

    def nearly(one: Any, other: Any, radius: Any, strict: bool = False) -> Any:
        return near(one, other, radius * (Fraction(15, 16) if strict else Fraction(17, 16)), strict)

    return nearly


def _undamped(spell: Any) -> Any:
    def fast(profile: Any, name: str) -> str:
        kept = f"{worlds.plain(Fraction(1.0 - profile.world.damping))}*{name}"
        return spell(profile, name).replace(kept, f"1.0*{name}")

    return fast


def _elsewhere(spell: Any) -> Any:
    """Agents take the other landmark for their goal."""
    other = {"landmark_0": "landmark_1", "landmark_1": "landmark_0"}

    def elsewhere(policy: Any, noise: Any, actions: Any, mark: str = worlds.PLACE) -> Any:
        return spell(policy, noise, actions, other.get(mark, mark))

    return elsewhere


def _without_last(statement: Any, profile: Any) -> tuple[Any, Any]:
    """The last leaf of each tree does what the first one does."""

    def changed(policy: Any) -> Any:
        action = policy.tree.action.copy()
        leaves = [place for place, each in enumerate(action.tolist()) if each >= 0]
        action[leaves[-1]] = action[leaves[0]]
        return replace(policy, tree=replace(policy.tree, action=action))

    return statement, replace(profile, agents=tuple(map(changed, profile.agents)))


GAMES: dict[str, Plant] = {
    COVERS[0]: COVERS[1],
    "distances: what is a little too far is near": put(worlds, "_near", _nearly),
    "distances: a side is forgotten": put(worlds, "_sides", lambda sides: lambda *given: sides(*given)[:1]),
    "motion: nothing is damped": put(worlds, "_spell_next", _undamped),
    "goals: the other landmark": put(worlds, "describe_agent", _elsewhere),
    "trees: the last leaf is left out": _played(_without_last),
    "motion: pushes are half as hard": put(
        worlds, "_list_pushes", lambda pushes: lambda *given: [(x / 2, y / 2) for x, y in pushes(*given)]
    ),
    "episodes: a step is left out": put(worlds, "_property", _shorter),
    "steady: errors are forgotten": put(
        worlds, "list_noise", lambda noise: lambda profile, ranges, errors: noise(profile, ranges, {})
    ),
    "observations: the sign is turned": put(
        observing, "_spell_feature", lambda spell: lambda *given: f"0 - ({spell(*given)})"
    ),
    REGION[0]: REGION[1],
}
