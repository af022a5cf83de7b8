"""What agents of other people's environments do: choose among numbered actions, or give numbers within bounds.

Does: says what an action space asks of an agent, what is wrong with it, and what the environment takes for a choice;
  draws random actions.
Assumes: Gymnasium's spaces. Numbers are given in a row, whatever the shape of their Box.
Does not: step an environment.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import MAX_LENGTH, OutputSpec
from maviper.worlds.outside.flattening import OWN
from maviper.worlds.outside.sources import Source, space, table
from maviper.worlds.world import CONTINUOUS

if TYPE_CHECKING:
    from gymnasium import spaces

    Choices = spaces.Space  # the action space of an agent

NUMBERED = "gymnasium.wrappers.TransformAction(env, lambda k: TABLE[k], gymnasium.spaces.Discrete(len(TABLE)))"
MAX_OUTPUTS = 64  # of an agent
GIVING = "use Discrete(n): agents choose among numbered actions; or a Box of floats with finite bounds"


def width(choices: Choices) -> int:
    """Counts the numbers that the agent gives; 0 where it chooses among actions."""
    from gymnasium.spaces import Box

    return int(np.prod(choices.shape)) if isinstance(choices, Box) else 0


def fault_of(choices: Choices) -> tuple[str, str] | None:
    """Why no tree can act in a space, and what its author can do; None where one can."""
    from gymnasium.spaces import Box, Discrete

    if isinstance(choices, Box):
        if not 1 <= width(choices) <= MAX_OUTPUTS:
            return f"the space has {width(choices):,} numbers, of 1 to {MAX_OUTPUTS}", GIVING
        ends = np.concatenate([np.ravel(choices.low), np.ravel(choices.high)]).astype(np.float64)
        if not np.issubdtype(choices.dtype, np.floating) or not (np.abs(ends) <= MAX_LENGTH).all():
            return f"the space is a Box of {choices.dtype} without finite bounds, or not of floats", GIVING
        return None
    if not isinstance(choices, Discrete):
        return f"the space is a {type(choices).__name__}, not Discrete", GIVING
    return (f"actions count from {choices.start}", "make the space Discrete(n), from 0") if choices.start else None


def bounds_of(choices: Choices) -> list[tuple[float, float]]:
    """The bounds of each number, as float32."""
    box = cast("spaces.Box", choices)
    ends = (np.ravel(each).astype(np.float32).tolist() for each in (box.low, box.high))
    return list(zip(*ends, strict=True))


def outputs_of(env: Any, agent: Any, source: Source) -> tuple[OutputSpec, ...]:
    """The numbers that an agent gives, by the environment's `outputs` where it has them; () where it chooses."""
    choices = space(env, "action", agent)
    bounds = bounds_of(choices) if width(choices) else []
    given = table(env, "outputs", source).get(agent)
    if given is None:
        return tuple(OutputSpec(f"output_{k}", "none", *ends) for k, ends in enumerate(bounds))
    parts = list(cast("Iterable[object]", given)) if isinstance(given, Iterable) else []
    named = [each for each in parts if isinstance(each, OutputSpec)]
    if not len(bounds) == len(parts) == len(named):
        what = f"the outputs of {agent} are not {len(bounds)} OutputSpecs, one for each number that it gives"
        raise InputError(what, source.text, "fix the environment's `outputs`, or leave this agent out of it")
    # the space says the bounds: it is what the environment refuses by
    return tuple(OutputSpec(each.name, each.unit, *ends) for each, ends in zip(named, bounds, strict=True))


def taking(choices: Choices) -> Callable[[Any], Any]:
    """From what an agent chose, or the numbers that it gave, to what the environment takes."""
    if not width(choices):
        return int
    box, size = cast("spaces.Box", choices), width(choices)

    def clip_numbers(given: Any) -> Any:
        return np.clip(np.asarray(given[:size], box.dtype).reshape(box.shape), box.low, box.high)

    return clip_numbers


def random_actions(all_choices: Sequence[Choices], rng: np.random.Generator, steps: int) -> list[list[Any]]:
    """Actions of all agents, step by step: numbers of actions, or rows of numbers."""
    if not any(map(width, all_choices)):
        sizes = [cast("spaces.Discrete", choices).n for choices in all_choices]
        return rng.integers(sizes, size=(steps, len(sizes))).tolist()
    drawn = rng.random((steps, len(all_choices), max(map(width, all_choices))))
    ends = [np.array(bounds_of(choices)).T for choices in all_choices]
    return [
        [(low + part[: len(low)] * (high - low)).tolist() for (low, high), part in zip(ends, row, strict=True)]
        for row in drawn
    ]


def refuse_numbers(text: str) -> InputError:
    """The error where numbered actions are needed, and the environment `text` has a Box."""
    what = "the environment has continuous actions, a Box; here agents choose among numbered ones"
    takes = "train, extract, import, evaluate, show, play, compile, diff and worlds take such an environment"
    asked = next((option for option in text.split(",") if option.startswith(CONTINUOUS)), "")
    numbered = f"leave {asked} out" if asked else f"to number them, {NUMBERED}; {OWN}"
    return InputError(what, text, f"{takes}; {numbered}")
