"""Why an episode is a counterexample, and how far: which starts fail alike, other ways to fail, by how much it fails.

Does: per coordinate of the start an interval by bisection, checked at its ends and between; looks for an episode that
  fails by other actions of the team among sampled starts; the radius with which the claim would hold.
Assumes: a start from which the claim fails, exactly, in the course given.
Does not: prove anything: between the values that were played nothing is claimed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.ir import PolicyProfile
from verify.claims.episodes import EpisodeClaim
from verify.claims.region import goal_text
from verify.counterexamples.explanation import format_ends
from verify.exact import MAX_NUMBER
from verify.question import EpisodeQuestion
from verify.states.episodes import Episode, at_rest, courses, fails, first_failing, meets_claim, play
from verify.states.shares import SAMPLE_SEED
from verify.states.state import State, inside, sample, state_at

BISECTIONS = 40  # of an interval's ends; of the radius too
AT_ONCE = 4  # bisections whose possible values are played together: an episode more costs little, a batch more a lot
BETWEEN = 32  # values between the ends of an interval that are played
STARTS = 2_000  # sampled for other ways to fail
MAX_TRIED = 20  # of those that fail by other actions, looked at exactly
STAYS = (
    f"start values from which the team takes the same actions and the claim fails, with everything else unchanged; "
    f"played at both ends and {BETWEEN} values in between, not proved"
)


@dataclass(frozen=True)
class StartSpan:
    """Values of one coordinate of the start: at both ends and between, wherever it was played, the team takes the same
    actions and the claim fails.
    """

    name: str
    low: float
    high: float
    whole: bool  # the ends are those of the region's box

    @property
    def free(self) -> bool:
        """True if the coordinate made no difference; one that the region fixes was not varied."""
        return self.whole and self.low < self.high

    def __str__(self) -> str:
        if self.whole and not self.free:
            return "fixed by the region"
        return " to ".join(format_ends(self.low, self.high)) if self.low < self.high else "only this"

    def document(self) -> dict[str, Any]:
        """The interval as plain data."""
        return {"low": self.low, "high": self.high, "whole": self.whole, "says": str(self)}


@dataclass(frozen=True)
class EpisodeExplanation:
    """The answers to a safety engineer's questions about an episode that fails, beside its course and its replays."""

    spans: tuple[StartSpan, ...]
    other: State | None  # a sampled start from which the claim fails by other actions
    starts: int  # that were sampled for it
    change: float  # of the radius, with which the claim would hold in this very course (length units); infinite: none

    def says(self) -> dict[str, str]:
        """The finding in a few short lines, by their headings."""
        others = f"other counterexamples exist: of {self.starts:,} sampled starts, another fails with other actions"
        none = f"not decided: none of {self.starts:,} sampled starts fails with other actions"
        whole = ", ".join(span.name for span in self.spans if span.free) or "none"
        side = "larger" if self.change > 0 else "smaller"
        change = f"{abs(self.change):.3g} (with a radius {side} by that, the claim holds here)"
        return {
            "unique": none if self.other is None else others,
            "fails by": change if math.isfinite(self.change) else "any radius",
            "free": f"coordinates that made no difference, changed one at a time to {BETWEEN + 2} values each: {whole}",
        }

    def document(self) -> dict[str, Any]:
        """The finding as plain data; null stands for an infinite number."""
        other = None
        if self.other is not None:
            other = {"goal": goal_text(self.other.goal), "position": dict(self.other.position)}
        return {
            "says": self.says(),
            "stays": STAYS,
            "coordinates": {span.name: span.document() for span in self.spans},
            "other": other,
            "starts": self.starts,
            "change_of_radius": self.change if math.isfinite(self.change) else None,
        }


def explain_episode(question: EpisodeQuestion, state: State, episode: Episode) -> EpisodeExplanation:
    """Explains a start from which the claim fails, and its course."""
    return EpisodeExplanation(
        spans=_spans(question, state, episode),
        other=_other(question, episode),
        starts=STARTS,
        change=_change_of_radius(question.profile, question.claim, episode),
    )


class _Starts:
    """Starts that differ from a failing one in one coordinate, played together; each is refereed when asked about."""

    def __init__(
        self, question: EpisodeQuestion, state: State, episode: Episode, moved: Sequence[tuple[str, float]]
    ) -> None:
        """`moved`: for each start the coordinate and its value."""
        self._question = question
        self._states = [State({**state.position, name: value}, state.goal) for name, value in moved]
        team = _team(question.profile, question.claim)
        if self._states:
            self._coordinates, actions = courses(question.profile, self._states, question.claim.steps)
            self._alike = (actions[..., team] == episode.actions[:, None, team]).all(axis=(0, 2))

    def stands(self, row: int) -> bool:
        """Returns True if a start lies in the region, leads to the team's actions and fails the claim."""
        question, state = self._question, self._states[row]
        if not self._alike[row] or not inside(question.region, state):
            return False
        return fails(question.profile, question.claim, self._coordinates[:, row])


def _team(profile: PolicyProfile, claim: EpisodeClaim) -> list[int]:
    """The places of the team's agents among the world's."""
    team = {policy.agent for policy in profile.team(claim.team)}
    return [place for place, entity in enumerate(profile.world.agents) if entity.name in team]


def _spans(question: EpisodeQuestion, state: State, episode: Episode) -> tuple[StartSpan, ...]:
    region = question.region

    def play_starts(moved: Sequence[tuple[str, float]]) -> _Starts:
        return _Starts(question, state, episode, moved)

    names = [name for name in region.box if not name.endswith((".vx", ".vy"))]
    sides = [(name, side) for name in names for side in (0, 1)]
    ends = [_round_inwards(region.box[name][side], side) for name, side in sides]
    good = [float(state.position[name]) for name, _ in sides]
    reached = play_starts([(name, end) for (name, _), end in zip(sides, ends, strict=True)])
    good = [end if reached.stands(k) else start for k, (start, end) in enumerate(zip(good, ends, strict=True))]
    for _ in range(0, BISECTIONS, AT_ONCE):
        middles = [_list_middles(a, b) for a, b in zip(good, ends, strict=True)]
        places = [(k, n) for k, values in enumerate(middles) for n in values]
        if not places:
            break
        tried = play_starts([(sides[k][0], middles[k][n]) for k, n in places])
        rows = {place: row for row, place in enumerate(places)}
        for k, values in enumerate(middles):
            n = 1
            while n in values:
                there = tried.stands(rows[k, n])
                good[k], ends[k] = (values[n], ends[k]) if there else (good[k], values[n])
                n = 2 * n + there
    lows, highs = good[::2], good[1::2]
    between = [
        (name, float(value))
        for name, low, high in zip(names, lows, highs, strict=True)
        for value in (np.linspace(low, high, BETWEEN + 2)[1:-1] if low != high else ())
    ]
    in_between = play_starts(between)
    gaps = [moved for row, moved in enumerate(between) if not in_between.stands(row)]
    spans: list[StartSpan] = []
    for name, low, high in zip(names, lows, highs, strict=True):
        here, inner = float(state.position[name]), [value for other, value in between if other == name]
        holes = [value for other, value in gaps if other == name]
        floor = max((value for value in holes if value < here), default=-math.inf)
        roof = min((value for value in holes if value > here), default=math.inf)
        left = [value for value in (low, *inner, here, high) if floor < value < roof]
        box = tuple(_round_inwards(region.box[name][side], side) for side in (0, 1))
        spans.append(StartSpan(name, min(left), max(left), whole=(min(left), max(left)) == box))
    return tuple(spans)


def _list_middles(good: float, end: float) -> dict[int, float]:
    """All values that the next bisections of good to end may come to: 1 is the middle, 2n follows n where that does not
    stand, 2n + 1 where it does. What no number lies between has none.
    """
    pairs, values = {1: (good, end)}, dict[int, float]()
    for n in range(1, 2**AT_ONCE):
        if n not in pairs:
            continue
        low, high = pairs[n]
        middle = (low + high) / 2
        if middle not in (low, high):
            values[n] = middle
            pairs |= {2 * n: (low, middle), 2 * n + 1: (middle, high)}
    return values


def _round_inwards(bound: Fraction, side: int) -> float:
    """The float64 number at a bound of a box, or next to it on the inside."""
    value = float(bound)
    if side == 0:
        return value if Fraction(value) >= bound else math.nextafter(value, math.inf)
    return value if Fraction(value) <= bound else math.nextafter(value, -math.inf)


def _other(question: EpisodeQuestion, episode: Episode) -> State | None:
    """A sampled start from which the claim fails by other actions of the team, refereed exactly."""
    profile, claim, region = question.profile, question.claim, question.region
    team = _team(profile, claim)
    coordinates, goals = sample(at_rest(region), profile.world, STARTS, SAMPLE_SEED)
    played, actions = play(profile, coordinates, claim.steps)
    others = ~meets_claim(profile, claim, played) & (actions[..., team] != episode.actions[:, None, team]).any(
        axis=(0, 2)
    )
    rows = np.flatnonzero(others)[:MAX_TRIED]
    states = [state_at(region, profile.world, coordinates[row], int(goals[row])) for row in rows]
    return first_failing(question, states)


def _change_of_radius(profile: PolicyProfile, claim: EpisodeClaim, episode: Episode) -> float:
    """By how much larger (or smaller, below 0) the radius would have to be for the claim to hold in this course."""

    def holds(change: Fraction) -> bool:
        return not fails(profile, replace(claim, radius=claim.radius + change), episode.coordinates)

    away = [Fraction(MAX_NUMBER), -claim.radius]
    far = next((change for change in away if holds(change)), None)
    if far is None:
        return math.inf
    near = Fraction(0)
    for _ in range(BISECTIONS + 30):  # the first ones bring it down from MAX_NUMBER
        middle = (near + far) / 2
        near, far = (near, middle) if holds(middle) else (middle, far)
    return float(far)
