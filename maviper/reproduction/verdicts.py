"""Verdicts on the paper's claims: AGREES, DIFFERS, NOT DECIDED with the effect that could be seen, NOT COMPARABLE.

Does: makes the comparisons of each claim, corrects them within their family, and says what follows for the claim.
Assumes: the register was written before the cells were played. Experts are judged apart, never pooled.
Does not: choose which comparisons there are, or show verdicts.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from maviper.reproduction import register
from maviper.reproduction.cells.cell import CROSSPLAY, EXTRACTION
from maviper.reproduction.cells.cell import EXPLOITABILITY as EXPLOITING
from maviper.reproduction.recipes import OPPONENTS, Book, Finder, Number, Part, Place, game_of, less, times
from maviper.reproduction.register import Claim, Register, playing
from maviper.reproduction.statistics import holm, size, untestable
from maviper.worlds.world import RETURN

AGREES, DIFFERS, NOT_DECIDED, NOT_COMPARABLE = "AGREES", "DIFFERS", "NOT DECIDED", "NOT COMPARABLE"
WORDS = (AGREES, DIFFERS, NOT_DECIDED, NOT_COMPARABLE)
UNTESTABLE = "UNTESTABLE"
RATIOS = (register.INDIVIDUAL, register.JOINT, register.ROBUSTNESS, register.EACH)  # statistics that are ratios
BETTER, WORSE, ALIKE, ABOVE, BELOW, OPEN = "better", "worse", "equal", "above", "below", "not decided"
SUPPORTS = {
    register.GREATER: (BETTER,),
    register.EQUAL: (ALIKE,),
    register.SECOND: (BETTER, ALIKE),
    register.ABOVE: (ABOVE,),
    register.SOME_ABOVE: (ABOVE,),
    register.BELOW: (BELOW,),
}
KIND_OF = {
    register.EXPLOITABILITY: EXPLOITING,
    register.ROBUSTNESS: CROSSPLAY,
    register.EACH: CROSSPLAY,
    register.SHARE_EACH: CROSSPLAY,
}


@dataclass(frozen=True)
class Comparison:
    """One number of a claim: a difference, better when positive, or a value with a bound. `number` None: not run."""

    claim: Claim
    label: str
    number: Number | None
    p: Mapping[str, float]  # what is tested -> p-value
    adjusted: Mapping[str, float]  # the same, by Holm in the claim's family
    word: str = OPEN
    visible: float = math.inf  # the smallest difference that would have been detected
    depth: int = 0
    base: Number | None = None  # what is compared with, as a ratio to the expert, where it is one

    @property
    def size(self) -> str:
        """The word for the size of the difference beside the paper's effect; "" where there is none."""
        paper = self.claim.published
        if self.number is None or self.claim.test != register.GREATER or paper is None or paper.effect is None:
            return ""
        return size(paper.effect, *self.number.estimate.interval())

    @property
    def untestable(self) -> bool:
        """True if the baseline keeps so much of the expert that a lead over it cannot be seen."""
        return self.base is not None and untestable(self.base.estimate.interval()[0])


@dataclass(frozen=True)
class Verdict:
    """The verdict on a claim with one expert."""

    claim: Claim
    expert: str
    word: str
    reason: str
    comparisons: tuple[Comparison, ...]
    notes: tuple[str, ...] = ()  # what a reader must know beside it, such as a weak expert

    @property
    def run(self) -> tuple[Comparison, ...]:
        """The comparisons whose cells are there."""
        return tuple(each for each in self.comparisons if each.number is not None)

    @property
    def by_depth(self) -> dict[int, str]:
        """Depth -> the claim's word there, and how many of its comparisons are UNTESTABLE or have which size."""
        depths = sorted({each.depth for each in self.run if self.claim.test in SUPPORTS})
        return {depth: self._at([each for each in self.run if each.depth == depth]) for depth in depths}

    def _at(self, pairs: Sequence[Comparison]) -> str:
        words = [each.size for each in pairs if each.size] + [UNTESTABLE for each in pairs if each.untestable]
        counted = [f"{words.count(word)} {word}" for word in dict.fromkeys(words)]
        said = _of_claim(self.claim, pairs)
        return f"{said} ({', '.join(counted)} of {len(pairs)})" if counted else said

    @property
    def visible(self) -> float:
        """The smallest difference that would have been detected in all that is not decided."""
        return max((each.visible for each in self.run if each.word == OPEN), default=math.inf)


def judge_claims(book: Book, known: Register, expert: str) -> list[Verdict]:
    """The verdicts on all claims, with an expert of that label."""
    comparisons = {claim.id: list(_comparisons(book, claim, expert)) for claim in known.claims}
    for family in known.families:
        claims = [claim.id for claim in known.claims if claim.family == family]
        members = iter(decide_family([each for claim in claims for each in comparisons[claim]], known))
        comparisons |= {claim: [next(members) for _ in comparisons[claim]] for claim in claims}
    return [_verdict(book, known, claim, expert, comparisons[claim.id]) for claim in known.claims]


# --- comparisons


def _comparisons(book: Book, claim: Claim, expert: str) -> Iterator[Comparison]:
    """Everything that a claim says, one by one, also where cells are missing."""
    kind = KIND_OF.get(claim.statistic, EXTRACTION)
    opponents = OPPONENTS if kind == CROSSPLAY else ()  # a mean over fewer would be another number
    apart = claim.statistic == register.EACH or (kind == CROSSPLAY and claim.test in register.BOUNDED)
    groups = {each: (each,) for each in opponents} if apart else {"": opponents}
    for place, first, second in product(_places(claim, expert), claim.first, claim.second or [""]):
        versus = f"{first} less {second}" if second else first
        about = [place.measure or place.game, *claim.list_values("lineup")]
        label = f"{versus}, {' '.join(about)}, depth {place.depth}"
        numbers: dict[str, list[list[Part]]] = {}  # opponent, or "" -> the parts of the first, and of the second
        try:
            algorithms = [each for each in (first, second) if each]
            seeds = book.finder.seeds(place, algorithms, kind)
            for opponent, group in groups.items():
                numbers[opponent] = [_statistic(book.finder, claim, place, each, seeds, group) for each in algorithms]
        except KeyError:
            numbers = {"": []}
        for opponent, parts in numbers.items():
            told = f"{label}, against {opponent}" if opponent else label
            name = f"claim/{claim.id}/{expert}/{told}"
            whole = less(*parts) if len(parts) > 1 else [each for part in parts for each in part]
            compared = comparison(claim, told, _number(book, name, whole))
            base = None
            if second and claim.statistic in RATIOS and compared.number is not None:
                base = _number(book, f"{name}/base", parts[1])
            yield replace(compared, depth=place.depth, base=base)


def _number(book: Book, name: str, parts: Sequence[Part]) -> Number | None:
    try:
        return book.number(name, parts) if parts else None
    except KeyError:
        return None


def comparison(claim: Claim, label: str, number: Number | None) -> Comparison:
    """A number with the p-values that the claim's test asks for, not yet corrected."""
    if number is None or claim.test == register.NUMBER:
        return Comparison(claim, label, number, {}, {})
    estimate = number.estimate
    if claim.test in register.COMPARING:
        return Comparison(claim, label, number, {"differs": estimate.p_differs()}, {})
    bound = claim.bound or 0.0
    return Comparison(claim, label, number, {"above": estimate.p_above(bound), "below": estimate.p_below(bound)}, {})


def _places(claim: Claim, expert: str) -> Iterator[Place]:
    """The cells that a claim is about, up to algorithm and seed."""
    measures = claim.list_values("measure") or [""]
    presets = claim.list_values("preset") or ["paper"]
    for game, measure in product(claim.list_values("game"), measures):
        world = game_of(game)
        labels = {each.label for each in world.measures} | {f"{team} {RETURN}" for team in world.teams}
        if measure and measure not in labels:
            continue
        for depth, preset in product(claim.list_values("depth") or [4], presets):
            yield Place(game, expert, preset, depth, measure, *claim.list_values("splits")[:1])


def _statistic(
    finder: Finder, claim: Claim, place: Place, algorithm: str, seeds: Sequence[int], opponents: Sequence[str]
) -> list[Part]:
    """The parts of a claim's number for one algorithm; greater is better where it is compared."""
    if claim.statistic in (register.ROBUSTNESS, register.EACH):
        return finder.robustness(place, algorithm, opponents, seeds)
    if claim.statistic == register.SHARE_EACH:
        return finder.against(place, algorithm, opponents, seeds)
    if claim.statistic in (register.APART, register.TO_THE_GOAL):
        return finder.attention(place, algorithm, claim.statistic, seeds)
    if claim.statistic == register.EXPLOITABILITY:
        gained = finder.exploitability(place, algorithm, claim.list_values("lineup")[0], seeds)
        return times(-1.0, gained) if claim.test in register.COMPARING else gained
    return finder.performance(place, algorithm, claim.statistic, seeds)


# --- decisions


def decide_family(family: Sequence[Comparison], known: Register) -> list[Comparison]:
    """The comparisons of a family, each with its adjusted p-values, its word and the effect that could be seen.

    All tests of all comparisons are corrected together. Each comparison has two, and only one of their hypotheses can
    be true: no difference, or one of the margin at least; a value up to the bound, or above it. Its false words are
    those of the true one, a wrong sign included, since that needs more than "equal" does. So as many hypotheses are
    true at once as there are comparisons, and this bounds the chance of any false word in the family by `alpha`.
    """
    tested = [replace(each, p=_tests(each, known.margin)) for each in family]
    asked = [(place, test) for place, each in enumerate(tested) for test in each.p]
    count = len({place for place, _ in asked})
    adjusted: list[dict[str, float]] = [{} for _ in tested]
    for (place, test), value in zip(asked, holm([tested[place].p[test] for place, test in asked], count), strict=True):
        adjusted[place][test] = value
    corrected: list[Comparison] = []
    for each, values in zip(tested, adjusted, strict=True):
        if each.number is None or not values:
            corrected.append(each)
            continue
        enough = each.number.seeds >= known.least_seeds  # fewer show nothing, whatever its size
        visible = each.number.estimate.detectable(known.alpha / count, known.power) if enough else math.inf
        corrected.append(replace(each, adjusted=values, word=_word(each, values, known), visible=visible))
    return corrected


def _tests(comparison: Comparison, margin: float) -> dict[str, float]:
    if comparison.number is None or "differs" not in comparison.p:
        return dict(comparison.p)
    return {**comparison.p, "equal": comparison.number.estimate.p_equal(margin)}


def _word(comparison: Comparison, adjusted: Mapping[str, float], known: Register) -> str:
    """Returns the word for what a comparison shows; too few seeds show nothing."""
    assert comparison.number is not None
    if comparison.number.seeds < known.least_seeds:
        return OPEN
    if adjusted.get("equal", 1.0) <= known.alpha:
        return ALIKE
    if adjusted.get("differs", 1.0) <= known.alpha:
        return BETTER if comparison.number.value > 0 else WORSE
    return next((word for word in (ABOVE, BELOW) if adjusted.get(word, 1.0) <= known.alpha), OPEN)


def _verdict(book: Book, known: Register, claim: Claim, expert: str, pairs: Sequence[Comparison]) -> Verdict:
    verdict = Verdict(claim, expert, NOT_DECIDED, "", tuple(pairs))
    word = NOT_COMPARABLE if claim.test == register.NUMBER else _of_claim(claim, pairs)
    return replace(verdict, word=word, reason=_reason(verdict, word, known), notes=tuple(_weak(book, known, verdict)))


def _of_claim(claim: Claim, pairs: Sequence[Comparison]) -> str:
    supports = [each.word in SUPPORTS[claim.test] for each in pairs]
    against = [each.word != OPEN and not yes for each, yes in zip(pairs, supports, strict=True)]
    if claim.test == register.SOME_ABOVE:
        supports, against = [any(supports)], [all(against)]
    if claim.test == register.SECOND:
        groups = [[each.word for each in group] for group in _by_place(pairs)]
        supports = [sum(word in SUPPORTS[claim.test] for word in words) >= len(words) - 1 for words in groups]
        against = [words.count(WORSE) > 1 for words in groups]
    if any(against):
        return DIFFERS
    return AGREES if supports and all(supports) else NOT_DECIDED


def _by_place(pairs: Sequence[Comparison]) -> list[list[Comparison]]:
    """Comparisons of the same measure and depth, against the same opponent."""
    groups: dict[str, list[Comparison]] = {}
    for each in pairs:
        groups.setdefault(each.label.partition(", ")[2], []).append(each)
    return list(groups.values())


def _reason(verdict: Verdict, word: str, known: Register) -> str:
    """Returns the reason that stands beside the word; for AGREES nothing needs to."""
    claim, run, lacking = verdict.claim, verdict.run, len(verdict.comparisons) - len(verdict.run)
    if word == NOT_COMPARABLE:
        return claim.reason
    if not run:
        return _missing(verdict)
    if word == AGREES:
        return ""
    if word == DIFFERS:
        against = [each for each in run if each.word not in (OPEN, *SUPPORTS[claim.test])]
        if claim.test == register.SECOND:  # one at each opponent does not count
            against = [each for group in _by_place(against) if len(group) > 1 for each in group]
        return f"contradicted by {len(against)} of {len(run)} comparisons: {against[0].label}: {against[0].word}"
    told = [f"{lacking} of {len(verdict.comparisons)} comparisons {_missing(verdict)}"] if lacking else []
    least = min(each.number.seeds for each in run if each.number is not None)
    if least < known.least_seeds:
        return "; ".join([*told, f"{least} of at least {known.least_seeds} seeds"])
    if any(each.word == OPEN and math.isinf(each.visible) for each in run):
        told.append("a ratio to nothing is no number")
    elif any(each.word == OPEN for each in run):
        told.append(f"a difference of {verdict.visible:.3g} would have been detected")
    return "; ".join(told)


def _missing(verdict: Verdict) -> str:
    """Describes how missing cells are made; `--algorithms` may have left opponents out."""
    against = f" against all of {', '.join(OPPONENTS)}" if KIND_OF.get(verdict.claim.statistic) == CROSSPLAY else ""
    return f"not run{against}: {playing(verdict.claim, verdict.expert)}"


def _weak(book: Book, known: Register, verdict: Verdict) -> Iterator[str]:
    """The expert, where it is far below the paper's in a measure of the claim."""
    measured = {place.measure: place for place in _places(verdict.claim, verdict.expert)}
    for measure, place in measured.items():
        paper = known.experts.get(measure)
        if paper is None or not verdict.run:
            continue
        try:
            ours = expert_number(book, place).value
        except KeyError:
            continue
        most, least = (paper.value, ours) if book.results.higher[measure] else (ours, paper.value)
        if least < known.weak_expert * most:
            yield f"weak expert: {measure} {ours:.3g}, the paper's {paper.value:g}"


def expert_number(book: Book, place: Place) -> Number:
    """Returns the expert's number against itself, in the episodes of ten seeds. KeyError where it was not played."""
    finder = book.finder
    return book.number(f"expert/{place.game}/{place.expert}/{place.measure}", [Part(1.0, finder.alone(place))])
