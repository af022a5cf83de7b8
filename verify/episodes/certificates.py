"""Certificates of claims about whole episodes: the second search, which writes down why each branch is closed.

Does: follows the questions of a part depth first over exact zones, and keeps for each closed branch a cycle of bounds;
  chooses where the starts of two are told apart that may touch; makes the certificate in the first form that closes all
  branches.
Assumes: parts of a claim that the zone engine (unroll.py), which reads trees and moves in its own way, proved before; a
  cut of the checker's reading (checker/episodes/contacts.py) keeps all starts, so any choice is sound.
Does not: decide claims: what it leaves open or finds too large has no proof here; state the form of proofs
  (checker/README.md does), or bound pushes.

A zone has for each axis a closed matrix of exact bounds over the coordinates that questions speak of, and for each of
them the path of explicit bounds that gives it. Closing a branch is then looking up one path.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import msgspec

from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.certificates.proofs import varint
from verify.checker.certificate import Certificate
from verify.checker.decisions import GameHeader
from verify.checker.episodes.certificates import PUSHED, READINGS, EpisodeCertificate, Parts, ProofPart
from verify.checker.episodes.contacts import CUT, ContactReading, coincident
from verify.checker.episodes.reading import (
    AWAY,
    CLAIM,
    GRID,
    REGION,
    Box,
    EpisodeReading,
    Gap,
    Interval,
    Matching,
    Node,
    Now,
    OpenBranchError,
    Place,
    Side,
    matchings,
)
from verify.checker.episodes.unbounded import Edges
from verify.checker.reading import RejectedError, region_formula
from verify.claims.formula import holds
from verify.claims.region import Region, goal_of
from verify.episodes.zones import points_of, starts
from verify.question import Budgets, EpisodeQuestion
from verify.spending import BeyondError, SpentError, tell
from verify.states.shares import SAMPLE_SEED

CELL = GRID >> 5  # gaps of starts that may touch are told apart so far: each piece has a narrower push
MAX_CELLS = 1 << 10  # of one gap; beyond it, it stays whole
GAIN = GRID >> 14  # a bound that is nearer by less is not worth its bytes


def where(episode: ContactReading, gap: Gap, allowed: Box, now: Now, finely: bool) -> int:
    """Where to cut a gap, as a number of the proof; 0 for nowhere. `allowed`: what its zone lets it be; `finely`: also
    where some starts lie on either side.
    """
    if episode.apart(gap, now):
        return 0
    tighter = list[tuple[int, int, Gap]]()  # axis, place, what is left: of cuts that leave nothing out
    for axis in (0, 1):
        (low, high), (least, most) = gap.starts[axis], allowed[axis]
        if low + GAIN < least < high:
            tighter.append((axis, least, gap.within(axis, (least, high))))
        if low < most < high - GAIN:
            tighter.append((axis, most, gap.within(axis, (low, most))))
    enough = [(axis, at) for axis, at, trimmed in tighter if episode.apart(trimmed, now)]
    cuts = enough or [(axis, at) for axis, at, _ in tighter]
    if not cuts and finely:  # beyond these the two are apart on that axis alone
        reach = episode.contacts[gap.pair].reach
        added = episode.gap(Gap(gap.pair, ((0, 0), (0, 0))), now)  # by movements
        for axis, (low, high) in enumerate(added):
            for at in (-((low - reach) // CUT) * CUT, (-reach - high) // CUT * CUT):
                cuts += [(axis, at)] if gap.starts[axis][0] < at < gap.starts[axis][1] else []
    if not cuts and finely and not episode.strange(gap):  # who does anything may soon be anywhere: cells say little
        widths = [high - low for low, high in gap.starts]
        axis = widths.index(max(widths))
        if widths[axis] > CELL and (widths[0] // CELL + 1) * (widths[1] // CELL + 1) <= MAX_CELLS:
            cuts.append((axis, sum(gap.starts[axis]) // 2 // CUT * CUT))
    if not cuts:
        return 0
    axis, place = cuts[0][0], cuts[0][1] // CUT
    return 1 + axis + 2 * (2 * place if place >= 0 else -2 * place - 1)  # as `ContactReading.cut` reads it


MAX_ANSWERS = 2_000_000  # looked at for a claim whose zones are not limited otherwise
GO_ON = b"\0"


class TooLongError(SpentError):
    """The proof would need more answers than the limit."""


class AxisBounds(NamedTuple):
    """The bounds along one axis: `most` closed, `through` the nodes that a path of explicit bounds passes between."""

    most: list[list[int]]
    through: list[list[tuple[int, ...]]]


Zone: TypeAlias = tuple[AxisBounds, AxisBounds]


class Only(NamedTuple):
    """All starts of a zone give one answer; `walk` closes the sides that lead to others."""

    answer: int
    walk: bytes
    zone: Zone


class Several(NamedTuple):
    """The continuation of each side: a closed one is its cycle. `left`: whether any start is left."""

    sides: tuple[tuple[Side, "bytes | Only | Several"], ...]
    left: bool


class EpisodeProver:
    """The search for one part, once. `finely`: starts of those who may touch are told apart by how they do."""

    def __init__(self, episode: EpisodeReading, limit: int = MAX_ANSWERS, finely: bool = True) -> None:
        self._episode, self._limit, self._finely, self.looked = episode, limit, finely, 0
        asked = sorted(find_used_nodes(episode.region, episode.questions, episode.nodes))
        self._nodes = [[0, *(node for node in asked if episode.names[node].endswith(axis))] for axis in (".x", ".y")]
        self._at = {node: (axis, place) for axis, nodes in enumerate(self._nodes) for place, node in enumerate(nodes)}

    def run(self) -> bytes:
        """The proof. OpenBranchError where a start may fail, TooLongError beyond the limit."""
        out, episode = bytearray(), self._episode
        first, second = (
            AxisBounds(
                [[0 if p == q else episode.far for q in nodes] for p in nodes], [[()] * len(nodes) for _ in nodes]
            )
            for nodes in self._nodes
        )
        work: list[bytes | tuple[Zone, Place]] = [((first, second), (REGION, episode.region, (), episode.start))]
        while work:
            tell(self.looked, self._limit, "answers looked at for the certificate")
            item = work.pop()
            if isinstance(item, bytes):
                out += item
                continue
            zone, place = item
            if isinstance(place[1], Gap):
                work += reversed(list(self._write_gap(zone, place, place[1])))
                continue
            finding = self._look(zone, place)
            code = b"" if isinstance(place[1], int) else None
            work += reversed(list(self._write_answer(finding, place, code)))
        return bytes(out)

    def _look(self, zone: Zone, place: Place) -> Only | Several:
        """Finds what each side of a question leads to, without going on after its end."""
        stage, node, chosen, now = place
        if isinstance(node, int):
            return Only(node, b"", zone)
        assert isinstance(node, tuple), node  # gaps are asked after the last tree
        sides: list[tuple[Side, bytes | Only | Several]] = []
        for side in node:
            cut = self._cut(zone, side, now)
            sides.append((side, cut if isinstance(cut, bytes) else self._look(cut, (stage, side.child, chosen, now))))
        left = [one for _, one in sides if isinstance(one, Only) or (isinstance(one, Several) and one.left)]
        answers = {one.answer if isinstance(one, Only) else None for one in left}
        several = Several(tuple(sides), bool(left))
        answer = answers.pop() if len(answers) == 1 and stage != REGION else None
        return several if answer is None else Only(answer, _walk(several, answer), zone)

    def _write_answer(
        self, answered: Only | Several, place: Place, code: bytes | None = None
    ) -> Iterator[bytes | tuple[Zone, Place]]:
        """The numbers for what was found, with the questions that follow in between. `code`: of an end."""
        stage, node, chosen, now = place
        if isinstance(answered, Several):
            yield GO_ON
            for side, one in answered.sides:
                if isinstance(one, bytes):
                    yield one
                else:
                    yield from self._write_answer(one, (stage, side.child, chosen, now), GO_ON)
            return
        if isinstance(node, int):
            yield GO_ON if code is None else code
        else:
            yield varint(1 + answered.answer)
            if (stage, answered.answer) != (CLAIM, AWAY):
                yield answered.walk
        following = self._episode.onward(stage, answered.answer, chosen, now)
        if following is not None:
            yield answered.zone, following

    def _write_gap(self, zone: Zone, place: Place, gap: Gap) -> Iterator[bytes | tuple[Zone, Place]]:
        """The number for a gap, and what follows: its parts, or the next question where it is left as it is."""
        stage, _, chosen, now = place
        episode = self._episode
        assert isinstance(episode, ContactReading)
        # multiples of CUT just below and just above all that the zone allows the gap of starts to be
        pair, unit, allowed = episode.contacts[gap.pair], CUT * episode.unit, list[Interval]()
        for axis, bounds in enumerate(zone):
            p, q = (self._at[episode.places[one][axis]][1] for one in (pair.first, pair.second))
            allowed.append(((-(bounds.most[q][p] // unit) - 1) * CUT, (bounds.most[p][q] // unit + 1) * CUT))
        number = where(episode, gap, (allowed[0], allowed[1]), now, self._finely)
        yield varint(number)
        if not number:
            following = episode.onward(stage, gap, chosen, now)
            if following is not None:
                yield zone, following
            return
        for side in episode.cut(gap, number):
            cut = self._cut(zone, side, now)
            if isinstance(cut, bytes):
                yield cut
            else:
                yield GO_ON
                yield cut, (stage, side.child, chosen, now)

    def _cut(self, zone: Zone, side: Side, now: Now) -> bytes | Zone:
        """The part of a zone that gives an answer, or the cycle that shows that there is none."""
        self.looked += 1
        if self.looked > self._limit:
            raise TooLongError
        upper, lower, limit = self._episode.bound(side, now)
        if upper == lower:
            return zone if limit >= 0 else self._cycle(())
        if upper not in self._at or lower not in self._at:
            return zone
        axis = self._at[upper or lower][0]
        p, q = self._at[upper][1], self._at[lower][1]
        most, through = zone[axis]
        if limit + most[q][p] < 0:
            return self._cycle(through[q][p])
        if limit >= most[p][q]:
            return zone
        cut = self._tighten_bounds(zone[axis], axis, p, q, limit)
        return (cut, zone[1]) if axis == 0 else (zone[0], cut)

    def _tighten_bounds(self, bounds: AxisBounds, axis: int, p: int, q: int, limit: int) -> AxisBounds:
        nodes, unbounded = self._nodes[axis], self._episode.far // 2
        onward = [
            (j, limit + far, ((nodes[q],) if q != j else ()) + bounds.through[q][j])
            for j, far in enumerate(bounds.most[q])
            if far < unbounded
        ]
        rows: list[list[int]] = []
        paths: list[list[tuple[int, ...]]] = []
        for i, (row, path) in enumerate(zip(bounds.most, bounds.through, strict=True)):
            if row[p] + limit < row[q]:  # else nothing in this row gets closer
                row, path, before, way = row.copy(), path.copy(), row[p], path[p] + ((nodes[p],) if p != i else ())
                for j, far, rest in onward:
                    if before + far < row[j]:
                        row[j], path[j] = before + far, way + rest
            rows.append(row)
            paths.append(path)
        return AxisBounds(rows, paths)

    def _cycle(self, through: Sequence[int]) -> bytes:
        return b"".join(map(varint, [self._episode.answers + 1 + len(through), *through]))


def _walk(several: Several, answer: int) -> bytes:
    """Closes the sides that do not end in an answer."""
    told: list[bytes] = []
    for side, one in several.sides:
        if side.child != answer:
            rest = one if isinstance(one, bytes) else one.walk if isinstance(one, Only) else _walk(one, answer)
            told += [rest] if isinstance(one, bytes) else [GO_ON, rest]
    return b"".join(told)


def find_used_nodes(region: Node, questions: Iterable[Node], nodes: int) -> set[int]:
    """Nodes, of so many, of which a question after the region's box speaks. `questions`: after the region."""
    mentioned: set[int] = set()
    seen: set[int] = set()
    waiting: list[tuple[Node, bool]] = [(region, True), *((asked, False) for asked in questions)]
    while waiting:
        node, of_region = waiting.pop()
        if not isinstance(node, tuple) or id(node) in seen:
            continue
        seen.add(id(node))
        for side in node:
            ends = {end for end in side[:2] if 0 < end < nodes}
            mentioned |= ends if len(ends) == 2 or not of_region else set()
            waiting.append((side.child, of_region))
    return mentioned


class NoCertificateError(BeyondError):
    """Why a proved claim has no certificate: it is beyond the second reading, or its proof is too large."""


class LeftOpenError(NoCertificateError):
    """The second reading leaves a start open, so the claim is not proved."""


def build_certificate(
    question: EpisodeQuestion, proved: Sequence[ProofPart], most: int | None = None
) -> EpisodeCertificate:
    """The certificate of a claim whose parts were proved (with or without a proof in them).

    LeftOpenError when the second search leaves a start open in some part, NoCertificateError when it looks at more than
    `most` answers: by default as many more than MAX_ANSWERS as more zones may be visited than by default.
    """
    profile, claim, region = question.profile, question.claim, question.region
    allowed = MAX_ANSWERS * question.budgets.max_zones // Budgets().max_zones
    most = max(MAX_ANSWERS, allowed) if most is None else most
    start, opened = inhabitant(profile, region), ""
    pushed = claim.apart or any(agent.collides for agent in profile.world.agents)
    for form in (form for form in READINGS if (form == PUSHED) == pushed):  # the simplest first
        try:
            parts = _prove_parts(READINGS[form], question, proved, most)
            return certify(question, form, start, Parts(parts))
        except OpenBranchError as error:
            opened = str(error)
        except RejectedError as error:
            raise NoCertificateError(str(error)) from None
    raise LeftOpenError(opened)


def certify(
    question: EpisodeQuestion, form: str, start: Mapping[str, Fraction], proof: Parts | Edges
) -> EpisodeCertificate:
    """The certificate of a claim with a proof. `start`: one of the region."""
    header = GameHeader(form, content_hash(question.profile), start, question.semantics, question.region)
    return Certificate(header, question.claim, proof)


def _prove_parts(
    reading: type[EpisodeReading], question: EpisodeQuestion, proved: Sequence[ProofPart], most: int
) -> tuple[ProofPart, ...]:
    """The parts that are needed, with their proofs. OpenBranchError, or NoCertificateError where they are too large."""
    profile, claim, region = question.profile, question.claim, question.region
    chosen: dict[ProofPart, None] = {}  # what shows the claim for all goals, each once
    allowed = matchings(profile, claim)
    for goal in question.goals:
        by_pair = {(part.agent, part.landmark): part for part in proved if part.goal in ("", goal)}
        ways = [own for own in allowed if by_pair.keys() >= set(own)]
        for pair in ways[0] if ways else (("", ""),):
            if pair not in by_pair:
                raise LeftOpenError("not all parts of the claim were proved one by one")
            chosen[by_pair[pair]] = None
    parts, needed, left = list[ProofPart](), list(chosen), most
    for part in needed:
        own: list[Matching] = [((part.agent, part.landmark),)] if part.agent else allowed
        # a part that is too large keeps no other one from being searched: that may hold an open branch
        limit = max(left, most // len(needed))
        proof, looked = _search_proof(reading(profile, claim, region, goal_of(part.goal), part.followed, own), limit)
        parts += [msgspec.structs.replace(part, proof=proof)] if proof is not None else []
        left -= looked
    if len(parts) < len(needed):
        raise NoCertificateError(f"its proof takes more than {most:,} answers; a larger --effort allows more")
    return tuple(parts)


def _search_proof(episode: EpisodeReading, limit: int) -> tuple[bytes | None, int]:
    """A proof, None where it is too large, and how many answers were looked at. OpenBranchError.

    Where agents push each other, starts are told apart by how they touch only if it does not close otherwise.
    """
    if isinstance(episode, ContactReading):
        coarse = EpisodeProver(episode, limit, finely=False)
        with suppress(OpenBranchError, TooLongError):
            return coarse.run(), coarse.looked
    prover = EpisodeProver(episode, limit)
    with suppress(TooLongError):
        return prover.run(), prover.looked
    return None, prover.looked


def inhabitant(profile: PolicyProfile, region: Region) -> Mapping[str, Fraction]:
    """A float64 start of the region, at rest, that claims are about."""
    still = {name: Fraction(0) for name in region.box}
    for point in points_of(starts(region, profile.world), SAMPLE_SEED):
        state = still | {name: Fraction(value) for name, value in point.items()}
        if holds(region_formula(region), state, {}) and not coincident(profile.world, state):
            return {name: state[name] for name in region.box}
    raise NoCertificateError("no float64 start of the region was found")
