"""Random episodes of stated systems in exact numbers, played by the hunt's judge, which shares no code with verify/.

Starts, errors and pieces are drawn, with the ends of all intervals among them.
"""

from fractions import Fraction as F

from tests.hunting.following import Judge
from tests.hunting.stated import broken, holding, meets, moved, within
from tests.hunting.systems import claimed, plain
from tests.support.system_cases import ends_of
from verify.systems import documents


def drawn(random, low, high):
    """A number of an interval: an end, the middle, or any."""
    return low + (high - low) * [F(0), F(1), F(1, 2), F(int(random.integers(0, 1 << 20)), 1 << 20)][random.integers(4)]


def start(random, system):
    """A start, or None where the one drawn is none."""
    state = {name: drawn(random, F(low), F(high)) for name, (low, high) in ends_of(system).items()}
    return state if all(meets(half, state) for half in plain(documents.plain(system.start))) else None


def episode(random, judge, state, steps):
    """The states of an episode of a start with errors and pieces drawn; the bool: whether it left what is stated."""
    states = [state]
    for _ in range(steps):
        here = holding(judge.system, states[-1])
        if not here:
            return states, True
        number = here[random.integers(len(here))]
        stated = judge.system["pieces"][number]["error"].items()
        errors = {name: drawn(random, F(low), F(high)) for name, (low, high) in stated}
        states.append(moved(judge.system, judge.agents, states[-1], number, errors))
    return states, False


def refuted(random, question, times):
    """Whether one of so many episodes breaks the claim, or leaves what is stated before the claim is fulfilled."""
    system, profile, claim = question
    judge, asked = Judge(system, profile), plain(claimed(claim))
    for _ in range(times):
        first = start(random, system)
        if first is None:
            continue
        states, left = episode(random, judge, first, claim.steps)
        ends = asked["regions"] if asked["name"] == "reaches" else ()
        fulfilled = any(within(ends, state) for state in states)
        fulfilled |= bool(asked["assuming"]) and not all(within(asked["assuming"], state) for state in states)
        if broken(asked, states) or (left and not fulfilled):
            return True
    return False
