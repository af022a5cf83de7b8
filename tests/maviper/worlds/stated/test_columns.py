"""Rules over tables of states: each row is what the rule says of that one state, to the last bit."""

import numpy as np
import pytest

from maviper.worlds.stated.deviation import RuleColumns, deviation
from maviper.worlds.stated.systems import MovingRule
from tests.support.systems import MOUNTAIN
from verify.systems.files import statement_of

CASES = """
name = "cases"
steps = 3
[variables]
x = { range = [-2, 2] }
y = { range = [-2, 2] }
[agents.one.features]
x = "x"
[agents.one.actions]
on = { push = 1 }
off = {}
[start]
box = { x = [-1, 1], y = [-1, 1] }
[[dynamics.piece]]
when = "x + y <= 0"
next = { x = "sin(x)**3 + sqrt(y + 3)/(2 + cos(y)) + 0.1*one.push*exp(x)", y = "min(max(x*y, -1), 0.5) + pi*tan(x/4)" }
[[dynamics.piece]]
when = "x + y > 0"
next = { x = "abs(x) - 0.3*y + one.push", y = "y**2/7" }
"""


@pytest.mark.parametrize("text", [CASES, MOUNTAIN], ids=["cases", "mountain"])
def test_rows_are_single_states(text):
    statement = statement_of(text, "f")
    random, rows = np.random.default_rng(4), 200
    names = [one.name for one in statement.system.variables]
    ends = {one.name: list(map(float, one.range)) for one in statement.system.variables}
    state = {name: random.uniform(*ends[name], rows) for name in names}
    (agent,) = statement.agents
    taken = random.choice(list(agent.actions), rows).tolist()
    held = 0
    for rule in statement.rules:
        one, columns = MovingRule(rule), RuleColumns(rule)
        singles = [{name: float(state[name][row]) for name in names} for row in range(rows)]
        holding = columns.holding(state)
        assert holding.tolist() == [one.holds(each) for each in singles]
        at = np.flatnonzero(holding)
        held += len(at)
        moved = columns.move_states(
            {name: each[at] for name, each in state.items()}, {agent.name: [taken[k] for k in at]}
        )
        expected = [one.move_state(singles[row], {agent.name: taken[row]}) for row in at.tolist()]
        assert {name: each.tolist() for name, each in moved.items()} == {
            name: [each[name] for each in expected] for name in moved
        }
    assert held == rows


def test_what_is_measured_does_not_depend_on_how_many_are_compared_together(monkeypatch):
    statement = statement_of(MOUNTAIN.replace("0.0025", "0.0024"), "f")
    whole = deviation(statement, 300)
    monkeypatch.setattr("maviper.worlds.stated.deviation.AT_ONCE", 1)
    assert deviation(statement, 300) == whole and whole.beyond
