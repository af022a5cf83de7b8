"""A batch of games with one agent each, stepped in this process: what they show and pay, written into arrays.

Does: resets and steps the copies one after the other, those whose episode goes on.
Assumes: `step_alone` and copies that leave each other alone (`processes.is_undisturbed`); one output_aside for a batch.
Does not: step in other processes, or environments of several agents (processes.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32
from maviper.worlds.outside.playing import EnvStates
from maviper.worlds.outside.processes import Copy, ensure_finite, single
from maviper.worlds.outside.silence import output_aside
from maviper.worlds.outside.sources import Source, fault

FLOAT32 = np.dtype(np.float32)


def steps_alone(env: Any) -> bool:
    """Returns True if it tells the parts of a step of its one agent without dictionaries."""
    return callable(getattr(cast("type[object]", type(env)), "step_alone", None))


class Together:
    """Copies that `make` makes when first asked. Outcomes are those of `processes.Copy`, one by one; here a step costs
    little beside the environment's own.
    """

    def __init__(self, source: Source, make: Callable[[], Any]) -> None:
        self.source, self.make = source, make
        self._copies: list[Copy] = []
        self._steps: list[Callable[[int], tuple[Any, ...]]] = []  # theirs
        self._live: list[int] = []  # games that go on
        self._last: EnvStates | None = None

    def ask(self, verb: str, arguments: Sequence[Any]) -> EnvStates:
        """`reset` with seeds, or `step` with each game's actions; InputError when an environment raises."""
        while len(self._copies) < len(arguments):
            self._copies.append(Copy(self.make(), self.source))
            self._steps.append(self._copies[-1].env.step_alone)
        with output_aside(
            f"{self.source.text}: {verb}"
        ):  # once for all of them: to enter and leave takes as long as a small game's step
            self._last = self._start_games(arguments) if verb == "reset" else self._step_games(arguments)
        return self._last

    def _start_games(self, seeds: Sequence[int]) -> EnvStates:
        outcomes = [copy.answer("reset", seed) for copy, seed in zip(self._copies, seeds, strict=False)]
        self._live = list(range(len(seeds)))
        seen = np.array([outcome.observations[0] for outcome in outcomes])
        nobody = np.zeros((len(seeds), 1), bool)
        return EnvStates((seen,), np.zeros((len(seeds), 1)), nobody, nobody, ~nobody)

    def _step_games(self, actions: Sequence[Sequence[Any]]) -> EnvStates:
        last = self._last
        assert last is not None, "games are reset before they are stepped"
        seen, rewards = last.observations[0].copy(), np.zeros_like(last.rewards)
        over: list[tuple[int, bool]] = []  # games that end, and whether by themselves
        paid, shape, steps = rewards[:, 0], seen.shape[1:], self._steps
        try:
            for place in self._live:
                shown, reward, ended, cut, _ = steps[place](actions[place][0])
                if type(shown) is not np.ndarray or shown.dtype is not FLOAT32 or shown.shape != shape:
                    shown = self._vector(shown, place, shape)
                seen[place] = shown  # at once: copies may have one array between them
                paid[place] = float(reward)
                if ended or cut:
                    over.append((place, bool(ended)))
        except (Exception, SystemExit) as error:
            raise fault(error, self.source, "the environment's step") from error
        ensure_finite(paid, self.source)
        if np.isnan(seen).any():
            what = f"{self._copies[0].names[0]} observes NaN"
            raise InputError(what, self.source.text, "observe numbers")
        if not over:
            return replace(last, observations=(seen,), rewards=rewards)
        done, terminated = last.done.copy(), last.terminated.copy()
        for place, ended in over:
            done[place], terminated[place] = True, ended
        self._live = [place for place in self._live if not done[place]]
        return EnvStates((seen,), rewards, done, terminated, ~done)

    def _vector(self, shown: Any, place: int, shape: tuple[int, ...]) -> Float32:
        """An observation as float32; InputError for one of another shape."""
        vector = single(shown)
        if vector.shape != shape:
            what = f"{self._copies[place].names[0]} observes an array of shape {vector.shape}, its space says {shape}"
            raise InputError(what, self.source.text, "return what observation_space says")
        return vector

    def close(self) -> None:
        """Ends all copies; the next reset starts fresh ones."""
        copies, self._copies, self._steps, self._last = self._copies, [], [], None
        for copy in copies:
            copy.close()
