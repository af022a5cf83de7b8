"""Where a decision stands in the generated C: the lines of the header that its path runs through.

Does: finds the tests and the leaf of a path in the header's text, by their numbers.
Assumes: the header that `maviper compile` writes without options, in the nested style; of other styles nothing is said.
Does not: decide or compile.
"""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

from codegen.ir import PolicyProfile
from codegen.lowering.lower import NESTED
from codegen.targets.rendered import usual_c

_FUNCTION = re.compile(r"^static inline int (\w+)\(const (?:float|double) \*x\)$")
_NUMBER = re.compile(r"/\* (?:node|leaf) (\d+)\b")


def code_of(profile: PolicyProfile, agent: str, nodes: Sequence[int]) -> dict[str, Any] | None:
    """The header's name, and the numbered lines of an agent's nodes; None where the C has no line for each node."""
    name, lines = _lines(profile)
    own = lines.get(agent, {})
    if not own:
        return None
    return {"file": name, "lines": [{"number": own[node][0], "text": own[node][1]} for node in nodes]}


@lru_cache(maxsize=4)
def _lines(profile: PolicyProfile) -> tuple[str, Mapping[str, Mapping[int, tuple[int, str]]]]:
    """The header's name; agent -> node -> (number, text) of its line."""
    model, name, header = usual_c(profile)
    if model.style != NESTED:
        return name, {}
    functions = {agent.name: (agent.twin or agent.names).act for agent in model.agents}  # equal trees share their code
    lines: dict[str, dict[int, tuple[int, str]]] = {function: {} for function in functions.values()}
    own: dict[int, tuple[int, str]] | None = None
    for number, line in enumerate(header.split("\n"), 1):
        if begins := _FUNCTION.match(line):
            own = lines.get(begins[1])
        elif line == "}":
            own = None
        elif own is not None and (node := _NUMBER.search(line)):
            own[int(node[1])] = number, line.strip()
    return name, {agent: lines[function] for agent, function in functions.items()}
