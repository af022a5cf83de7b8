"""What agents of other people's environments observe and do: vectors with names, numbered actions, or bounded numbers.

Does: flattens spaces as `gymnasium.spaces.flatten` does, with a name and a unit for each number, those of Gymnasium's
  classic environments as their documentation has them; takes a mask out of a dictionary and puts it at the end; says
  what an action space asks of an agent, what is wrong with it, and what the environment takes for a choice.
Assumes: Gymnasium's spaces; a mask is under the key `action_mask`, one number per action; numbers are given in a row,
  whatever the shape of their Box; an environment of another length than the table's is another environment.
Does not: wrap or step environments, or judge what is too large for a tree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import MAX_LENGTH, FeatureSpec, OutputSpec
from maviper.worlds.outside.sources import Source, legal_names, space, table
from maviper.worlds.world import CONTINUOUS

if TYPE_CHECKING:
    from gymnasium import spaces


class Described(NamedTuple):
    """An environment in words: feature -> unit, in their order; actions, by their numbers; output -> unit."""

    features: Mapping[str, str]
    actions: Sequence[str]
    outputs: Mapping[str, str] = MappingProxyType({})


FLAG = "0 or 1"
LANDER: Mapping[str, str] = {
    **dict.fromkeys(("x", "y", "velocity_x", "velocity_y"), "none"),
    "angle": "rad",
    "angular_velocity": "none",
    **dict.fromkeys(("left_leg_contact", "right_leg_contact"), FLAG),
}
DESCRIBED: Mapping[str, Described] = {
    "CartPole": Described(
        {"cart_position": "m", "cart_velocity": "m/s", "pole_angle": "rad", "pole_angular_velocity": "rad/s"},
        ("push_left", "push_right"),
    ),
    "MountainCar": Described(
        {"position": "none", "velocity": "none"}, ("accelerate_left", "coast", "accelerate_right")
    ),
    "Acrobot": Described(
        {
            **dict.fromkeys(("cos_angle_1", "sin_angle_1", "cos_angle_2", "sin_angle_2"), "none"),
            **dict.fromkeys(("angular_velocity_1", "angular_velocity_2"), "rad/s"),
        },
        ("torque_minus", "no_torque", "torque_plus"),
    ),
    "LunarLander": Described(LANDER, ("nothing", "left_engine", "main_engine", "right_engine")),
    "LunarLanderContinuous": Described(LANDER, (), {"main_engine": "none", "side_engine": "none"}),
    "Pendulum": Described(
        {"cos_angle": "none", "sin_angle": "none", "angular_velocity": "rad/s"}, (), {"torque": "N m"}
    ),
    "MountainCarContinuous": Described({"position": "none", "velocity": "none"}, (), {"force": "none"}),
    "Blackjack": Described({"player_sum": "none", "dealer_card": "none", "usable_ace": FLAG}, ("stick", "hit")),
    "FrozenLake": Described({}, ("left", "down", "right", "up")),
    "CliffWalking": Described({}, ("up", "right", "down", "left")),
    "Taxi": Described({}, ("south", "north", "east", "west", "pick_up", "drop_off")),
}


MASK = "action_mask"  # the key, in a dictionary of observations or in infos
MAX_FEATURES = 1_024  # of a flattened observation: beyond it, it is a picture
WHOLE = 2**24  # up to which float32 has every whole number
OWN = "return it wrapped from a function of your own, and name that: mygame:make"
Named = tuple[str, str]  # a number's name and unit


def parts_of(space: spaces.Space, n_actions: int) -> tuple[spaces.Space, bool]:
    """Returns the part of a space that is observed beside a mask, and True if it has one."""
    from gymnasium.spaces import Dict

    if not isinstance(space, Dict) or MASK not in space.spaces or len(space.spaces) == 1:
        return space, False
    mask = space.spaces[MASK]
    if int(np.prod(mask.shape or ())) != n_actions:
        return space, False
    return Dict({key: part for key, part in space.spaces.items() if key != MASK}), True


def as_numbers(space: spaces.Space, where: str) -> spaces.Space:
    """The space whose whole numbers are shown as they are, not as one number per value. InputError for numbers that
    float32 cannot tell apart.
    """
    from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Tuple

    if isinstance(space, Dict):
        return Dict({key: as_numbers(part, where) for key, part in space.spaces.items()})
    if isinstance(space, Tuple):
        return Tuple([as_numbers(part, where) for part in space.spaces])
    if not isinstance(space, Discrete | MultiDiscrete):
        return space
    least = np.asarray(space.start)
    most = least + (space.n if isinstance(space, Discrete) else space.nvec) - 1
    if np.abs(np.stack([least, most])).max() > WHOLE:
        what = f"an observation has whole numbers beyond {WHOLE:,}, which float32 does not tell apart"
        raise InputError(what, where, f"observe smaller ones; {OWN}")
    return Box(least.astype(np.float32), most.astype(np.float32), dtype=np.float32)


def unreadable(space: spaces.Space) -> str:
    """The kind of a space, or of a part of it, that has no vector of a fixed length; "" where there is none."""
    from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Tuple

    if isinstance(space, Dict | Tuple):
        inner: list[spaces.Space] = list(space.spaces.values() if isinstance(space, Dict) else space.spaces)
        kinds = [unreadable(part) for part in inner] or ["empty " + type(space).__name__]
        return next(filter(None, kinds), "")
    return "" if isinstance(space, Box | Discrete | MultiBinary | MultiDiscrete) else type(space).__name__


def ensure_small(space: spaces.Space, where: str) -> None:
    """InputError for a space of more numbers than a tree can be learned from."""
    from gymnasium.spaces import flatdim

    size = flatdim(space)
    if not 1 <= size <= MAX_FEATURES:
        advice = f"reduce it: gymnasium.wrappers.TransformObservation; {OWN}"
        raise InputError(f"an observation has {size:,} numbers, of at most {MAX_FEATURES:,}", where, advice)


def vector_space(space: spaces.Space) -> spaces.Box:
    """The space of flattened observations, [n_features] float32."""
    from gymnasium.spaces import Box, flatten_space

    flat: Any = flatten_space(space)
    size = math.prod(flat.shape)
    low, high = (np.asarray(each, np.float32).reshape(size) for each in (flat.low, flat.high))
    return Box(low, high, dtype=np.float32)


def vector(space: spaces.Space, seen: Any) -> Any:
    """An observation as a vector, [n_features]."""
    from gymnasium.spaces import Box, MultiBinary, flatten

    given: object = seen
    row = isinstance(space, Box | MultiBinary) and isinstance(given, np.ndarray) and given.ndim == 1
    return seen if row else flatten(space, seen)


def specs_of(names: Iterable[Named], box: spaces.Box) -> list[FeatureSpec]:
    """The features of a vector, as far as names, units and the bounds of its space tell them."""
    low, high = (np.clip(np.asarray(end, np.float64), -MAX_LENGTH, MAX_LENGTH).tolist() for end in (box.low, box.high))
    parts = zip(names, low, high, strict=True)
    return [FeatureSpec(name, unit, least, most, None) for (name, unit), least, most in parts]


def names_of(space: spaces.Space) -> list[Named]:
    """A legal name and a unit for each number of a flattened space, all names different."""
    found = list(_iterate_names(space, ""))
    names = legal_names([name for name, _ in found], "feature")
    return [(name, unit) for name, (_, unit) in zip(names, found, strict=True)]


def _iterate_names(space: spaces.Space, under: str) -> Iterator[Named]:
    """`under`: the keys that lead to the space, joined."""
    from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Tuple

    if isinstance(space, Dict | Tuple):
        inner = space.spaces.items() if isinstance(space, Dict) else enumerate(space.spaces)
        for key, part in inner:
            name = str(key) if isinstance(space, Dict) else f"part_{key}"
            yield from _iterate_names(part, f"{under}_{name}" if under else name)
        return
    if isinstance(space, Discrete):
        before = f"{under}_" if under else ""
        yield from ((f"{before}is_{spell_number(space.start + k)}", FLAG) for k in range(int(space.n)))
        return
    places = product(*map(range, space.shape or ()))
    if isinstance(space, MultiDiscrete):  # one number per value of each part, side by side
        sizes, starts = np.ravel(space.nvec), np.ravel(space.start)
        for place, size, first in zip(places, sizes, starts, strict=True):
            where = "_".join(filter(None, (under, *map(str, place), "is")))
            yield from ((f"{where}_{spell_number(int(first) + k)}", FLAG) for k in range(int(size)))
        return
    kind, unit = ("feature", "none") if isinstance(space, Box) else ("bit", FLAG)
    single = bool(under) and int(np.prod(space.shape or ())) == 1
    yield from (("_".join([under or kind, *map(str, () if single else place)]), unit) for place in places)


def spell_number(number: int) -> str:
    """A whole number as names have it."""
    return f"{number}".replace("-", "minus_")


NUMBERED = "gymnasium.wrappers.TransformAction(env, lambda k: TABLE[k], gymnasium.spaces.Discrete(len(TABLE)))"
MAX_OUTPUTS = 64  # of an agent
GIVING = "use Discrete(n): agents choose among numbered actions; or a Box of floats with finite bounds"


def width(choices: spaces.Space) -> int:
    """Counts the numbers that the agent gives; 0 where it chooses among actions."""
    from gymnasium.spaces import Box

    return int(np.prod(choices.shape)) if isinstance(choices, Box) else 0


class Fault(NamedTuple):
    """Why an environment cannot be played, and what its author can do."""

    what: str
    next_step: str


def fault_of(choices: spaces.Space) -> Fault | None:
    """Why no tree can act in a space; None where one can."""
    from gymnasium.spaces import Box, Discrete

    if isinstance(choices, Box):
        if not 1 <= width(choices) <= MAX_OUTPUTS:
            return Fault(f"the space has {width(choices):,} numbers, of 1 to {MAX_OUTPUTS}", GIVING)
        ends = np.concatenate([np.ravel(choices.low), np.ravel(choices.high)]).astype(np.float64)
        if not np.issubdtype(choices.dtype, np.floating) or not (np.abs(ends) <= MAX_LENGTH).all():
            return Fault(f"the space is a Box of {choices.dtype} without finite bounds, or not of floats", GIVING)
        return None
    said = f"the space is a {type(choices).__name__}, not Discrete"
    return None if isinstance(choices, Discrete) else Fault(said, GIVING)


def first_action(choices: spaces.Space) -> int:
    """The environment's own number of the first action; 0 where there is none."""
    return int(getattr(choices, "start", 0))


def bounds_of(choices: spaces.Space) -> list[tuple[float, float]]:
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


def taking(choices: spaces.Space) -> Callable[[Any], Any]:
    """From what an agent chose, or the numbers that it gave, to what the environment takes."""
    if not width(choices):
        first = first_action(choices)
        return (lambda chosen: int(chosen) + first) if first else int
    box, size = cast("spaces.Box", choices), width(choices)

    def clip_numbers(given: Any) -> Any:
        return np.clip(np.asarray(given[:size], box.dtype).reshape(box.shape), box.low, box.high)

    return clip_numbers


def random_actions(all_choices: Sequence[spaces.Space], rng: np.random.Generator, steps: int) -> list[list[Any]]:
    """Actions of all agents, step by step: numbers of actions, or rows of numbers, in float32 as trees give them."""
    if not any(map(width, all_choices)):
        sizes = [cast("spaces.Discrete", choices).n for choices in all_choices]
        return rng.integers(sizes, size=(steps, len(sizes))).tolist()
    drawn = rng.random((steps, len(all_choices), max(map(width, all_choices))))
    actions: list[list[Any]] = [[] for _ in range(steps)]
    for place, choices in enumerate(all_choices):
        low, high = np.array(bounds_of(choices)).T
        numbers = (low + drawn[:, place, : len(low)] * (high - low)).astype(np.float32)
        for acted, own in zip(actions, numbers.tolist(), strict=True):
            acted.append(own)
    return actions


def refuse_numbers(text: str) -> InputError:
    """The error where numbered actions are needed, and the environment `text` has a Box."""
    what = "the environment has continuous actions, a Box; here agents choose among numbered ones"
    takes = "train, extract, import, evaluate, show, play, compile, diff and worlds take such an environment"
    asked = next((option for option in text.split(",") if option.startswith(CONTINUOUS)), "")
    numbered = f"leave {asked} out" if asked else f"to number them, {NUMBERED}; {OWN}"
    return InputError(what, text, f"{takes}; {numbered}")
