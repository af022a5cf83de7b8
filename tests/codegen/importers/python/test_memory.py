"""Python that remembers: attributes that the decision sets, beside the class itself in long walks."""

import random

import pytest

from codegen.errors import DisagreementError, InputError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.symbolic import memory
from maviper.team import Team

PUMP = """
from enum import Enum

class Mode(Enum):
    IDLE = "idle"
    RUN = "run"
    COOL = "cool"

class Pump:
    def __init__(self):
        self.mode = Mode.RUN
        self.left = 5
        self.on = True

    def reset(self):
        self.mode = Mode.RUN

    def act(self, obs):
        level, heat = obs
        if self.mode is Mode.IDLE:
            if level > 0.8:
                self.mode = Mode.RUN
        elif self.mode is Mode.RUN:
            if heat > 90:
                self._cool(20)
            elif level < 0.2:
                self.mode = Mode.IDLE
        else:
            if self.left > 0:
                self.left -= 1
            if self.left == 0:
                self.mode = Mode.IDLE
        self.on = self.mode is Mode.RUN
        return "pump" if self.on else "rest"

    def _cool(self, calls):
        self.mode, self.left = Mode.COOL, calls
"""
HEATER = """
class Heater:
    state = "off"

    def act(self, obs):
        t, _ = obs
        if t < 19:
            self.state = "on"
        elif t > 21:
            self.state = "off"
        return self.state
"""
COUNT = """
class Count:
    def __init__(self):
        self.n = 3
        self.last = None

    def __call__(self, obs):
        x, y = obs
        if x > 0.5 and self.n < 100:
            self.n += 1
        elif x < -0.5:
            self.n = 0
        was, self.last = self.last, y > 0
        return 2 if was and self.n > 50 else 1
"""
SOURCES = {"Pump": PUMP, "Heater": HEATER, "Count": COUNT}
RANGES = {
    "Pump": {"mode": (0, 2, 0), "left": (0, 20, 5), "on": (0, 1, 0)},
    "Heater": {"state": (0, 1, 0)},
    "Count": {"n": (0, 100, 3), "last": (0, 2, 0)},
}


@pytest.mark.parametrize("name", SOURCES)
def test_an_object_that_remembers_acts_as_python_runs_it(name):
    profile = profile_of(from_python(SOURCES[name].encode(), "policy.py"), Names())
    (policy,), team, space, rng = profile.agents, Team.of(profile), {}, random.Random(0)
    assert {each.name: (each.low, each.high, each.initial) for each in policy.memory} == RANGES[name]
    exec(SOURCES[name], space)
    made = space[name]()
    act, names = made if name == "Count" else made.act, [each.name for each in policy.actions]
    seen = [0.0, 0.0]
    for _ in range(20_000):
        if rng.random() < 0.1:
            seen = [rng.choice([rng.uniform(-1, 25), 0.5, 19.0, 0.2]), rng.choice([rng.uniform(-1, 100), 90.0, 0.0])]
        wanted = act(seen)
        assert team.act(seen) == (names.index(wanted) if isinstance(wanted, str) else wanted)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("self.s = 0.0\n    def act(self, x):\n        self.s += x\n        return self.s > 1", "no whole number"),
        ("self.s = 0\n    def act(self, x):\n        self.s += 1\n        return self.s > 9", "counted without an end"),
        (
            "self.s = 0\n    def put(self, n):\n        self.s = n\n    def act(self, x):\n"
            "        if x > 1:\n            self.s = 1\n        return self.s",
            "put sets it, too",
        ),
    ],
)
def test_what_has_no_end_or_another_master_is_refused(text, said):
    with pytest.raises(InputError, match=said):
        from_python(f"class A:\n    def __init__(self):\n        {text}\n".encode(), "policy.py")


@pytest.mark.parametrize("fault", ["keeps", "begins"])
def test_memory_that_is_misread_is_seen(fault, monkeypatch):
    if fault == "keeps":
        monkeypatch.setattr(memory.Memories, "settle", lambda *_: ())
    else:
        post = memory.Memory.__post_init__

        def begin(self):
            self.initial = 6 if self.initial == 5 else self.initial
            post(self)

        monkeypatch.setattr(memory.Memory, "__post_init__", begin)
    with pytest.raises(DisagreementError, match="where its origin takes"):
        profile_of(from_python(PUMP.encode(), "policy.py"), Names())
