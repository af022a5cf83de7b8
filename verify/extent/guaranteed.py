"""What is sure of the answers of starts that are followed together: questions, their limits, and how agents move.

Does: says which question comes after which answer, up to where an answer is possible, and up to where it is sure.
Assumes: the checker's questions (checker/episodes/reading.py); who acts reads nobody who does not.
Does not: cut starts into cells (sure.py).
"""

from collections.abc import Sequence
from math import sqrt

from codegen.ir import PolicyProfile, splits
from verify.checker.episodes.reading import CLAIM, GRID, Matching, Now, PartedReading, Place, Side, compute_push
from verify.claims.episodes import Arrival
from verify.claims.region import Region


class GuaranteedEpisode:
    """One part of a claim: what is asked after which answer, and what is sure of an answer. Only those `acting` move.

    The questions are the checker's. What follows an answer and how agents move is a reading of its own, in which a
    speed that nothing has ever changed is exactly 0.
    """

    def __init__(
        self, profile: PolicyProfile, claim: Arrival, region: Region, goal: str | None, acting: Sequence[str],
        allowed: Sequence[Matching],
    ) -> None:  # fmt: skip
        """All trees are read whoever acts, so that all readings of a question have the same unit."""
        everybody, world = [policy.agent for policy in profile.agents], profile.world
        reading = PartedReading(profile, claim, region, goal, everybody, allowed)
        self.names, self.nodes, self.unit, self.far = reading.names, reading.nodes, reading.unit, reading.far
        self.region, self.claim, self.steps = reading.region, reading.claim, claim.steps
        self.trees = [reading.trees[everybody.index(agent)] for agent in acting]
        self.questions = self.claim, *self.trees
        self.start = reading.start._replace(speeds=((0.0, 0.0),) * len(acting))
        self._always, self._dt, self._kept = claim.always, world.dt, 1.0 - world.damping
        entities = {entity.name: entity for entity in world.agents}
        self._movers = [entities[agent] for agent in acting]
        self._pushes = [
            [compute_push(action.effect, entities[agent], world) for action in profile.policy(agent).actions]
            for agent in acting
        ]
        numbers = {name: number for number, name in enumerate(reading.names)}
        self._places, self._speeds = (
            [[numbers[f"{agent}.{axis}"] for axis in axes] for agent in acting] for axes in (("x", "y"), ("vx", "vy"))
        )
        tested = [one.features[int(one.tree.feature[node])] for one in profile.agents for node in splits(one.tree)]
        read = {name for feature in tested if feature.meaning for _, name in feature.meaning.terms}
        self._sees_speed = any(numbers.get(name, 0) >= self.nodes for name in read)

    def limits(self, side: Side, now: Now) -> tuple[int, int, int, int]:
        """(upper, lower, most, room): an answer is possible up to most + room, and sure up to most - room."""
        upper, lower, most, slack, _ = side
        most += now.shift[lower] - now.shift[upper]
        room = abs(slack) if now.moved[upper] or now.moved[lower] else 0
        return (upper if upper < self.nodes else 0), (lower if lower < self.nodes else 0), most, room

    def first(self) -> Place:
        """What is asked first of the starts of the region."""
        return self._ask_claim((), self.start)

    def onward(self, stage: int, answer: int, chosen: tuple[int, ...], now: Now) -> Place:
        """The question after an answer that ends nothing. Nobody has moved when agents choose for the second time, so
        then, if no speed is read, all choose as before; the last choice moves nobody before the end.
        """
        if stage == CLAIM:
            return self._going_on(chosen, now)
        chosen = (*chosen, answer)
        if len(chosen) < len(self.trees):
            return len(chosen), self.trees[len(chosen)], chosen, now
        return self._ask_claim(chosen, self._later(now, chosen))

    def _ask_claim(self, chosen: tuple[int, ...], now: Now) -> Place:
        """The claim, where it is asked now."""
        if self._always or now.step == self.steps:
            return CLAIM, self.claim, chosen, now
        return self._going_on(chosen, now)

    def _going_on(self, chosen: tuple[int, ...], now: Now) -> Place:
        if now.step < self.steps - 1 and (now.step != 1 or self._sees_speed):
            return 0, self.trees[0], (), now
        return self._ask_claim(chosen, self._later(now, chosen))

    def _later(self, now: Now, chosen: Sequence[int]) -> Now:
        """One step: positions move with the old velocity, then actions push; who has not chosen yet is not pushed."""
        shift, moved, speeds = now.shift.copy(), now.moved.copy(), list[tuple[float, float]]()
        for agent, (old, mover) in enumerate(zip(now.speeds, self._movers, strict=True)):
            push = self._pushes[agent][chosen[agent]] if chosen else (0.0, 0.0)
            x, y = (part * self._kept + more for part, more in zip(old, push, strict=True))
            size = sqrt(x * x + y * y)
            if mover.max_speed is not None and size > mover.max_speed:
                x, y = x / size * mover.max_speed, y / size * mover.max_speed
            for axis, speed in enumerate((x, y)):
                place, number = self._places[agent][axis], self._speeds[agent][axis]
                shift[place] += round(old[axis] * self._dt * GRID) * self.unit
                moved[place] |= old[axis] != 0
                shift[number] = round(speed * GRID) * self.unit
                moved[number] |= bool(old[axis] or push[axis])
            speeds.append((x, y))
        return Now(now.step + 1, tuple(speeds), shift, moved)
