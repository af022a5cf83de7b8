"""The page of a comparison: both profiles side by side, hatched where they act differently.

Does: turns a comparison into what a page shows, with an example of the largest zones behind a button each.
Assumes: `maviper.verification.diff` compared.
Does not: decide.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from maviper.page.document import Contents, Second, Stored
from maviper.page.page import page, visits_of
from maviper.verification.diff import Compared
from maviper.worlds.matching import matching_world
from verify.kinds import REAL

SHOWN = 3  # zones of an agent that have a button
ALIKE, DIFFERENT, OPEN = "alike in the whole region", "acts differently in the region", "no answer for the region"
WORDS = {"PROVED": ALIKE, "VIOLATED": DIFFERENT}


def page_of(compared: Compared) -> str:
    """The page of two profiles."""
    first, second = compared.found.first, compared.found.second
    facts = compared.facts["agents"]
    agents = tuple(one["agent"] for one in facts)
    within = " in real arithmetic" if compared.found.question.semantics == REAL else ""
    verdicts = tuple(WORDS.get(one["verdict"], OPEN) + within for one in facts)
    states = tuple(
        state for place, one in enumerate(facts) for state in _iterate_states(one, place + (len(agents) > 1))
    )
    world = matching_world(first)
    if world is None:
        return page(first, Contents((), states, second=Second(second, agents, verdicts)))
    other = Second(second, agents, verdicts, visits_of(second, world))
    return page(first, Contents((), states, visits_of(first, world), second=other))


def _iterate_states(one: Mapping[str, Any], claim: int) -> Iterator[Stored]:
    """A state of each of an agent's largest zones. `claim`: the place of what is said of it on the page."""
    shown = [zone for zone in one["zones"] if zone["example"]][:SHOWN]
    if not shown and one["example"]:
        yield Stored(f"{one['agent']} acts differently", claim, *_read_state(one["example"]))
    for zone in shown:
        named = f"{one['agent']}: {' or '.join(zone['actions'])}, leaf {' or '.join(map(str, zone['leaves']))}"
        yield Stored(named, claim, *_read_state(zone["example"]))


def _read_state(state: Mapping[str, Any]) -> tuple[dict[str, float], str | None]:
    position = {name: float(value) for name, value in state["position"].items()}
    return position, state["goal"] or None
