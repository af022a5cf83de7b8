"""Python that remembers: attributes that the decision sets, beside the class itself in long walks."""

import random
import re

import pytest

from codegen.errors import DisagreementError, InputError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
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


SUMMING = """
class Pump:
    def __init__(self):
        self.on, self.held, self.trips = False, 0, 0

    def act(self, inlet, outlet):
        gap = inlet - outlet
        if self.held < 5:
            self.held += 1
            return self.on
        before = self.on
        if (gap < 0.5) if self.on else (gap > 1.5):
            self.on = not self.on
            self.held = 0
        if self.on and not before and 0.5 * inlet + outlet > 3.0:
            self.trips = min(self.trips + 1, 4)
        return "trip" if self.trips == 4 and gap > 0.25 else ("on" if before else "off")
""".replace("return self.on\n", "return 'on' if self.on else 'off'\n")


def test_what_tests_sums_beside_memory_acts_as_python_runs_it():
    said = Said(arrays="floats")
    profile = profile_of(from_python(SUMMING.encode(), "policy.py", said), Names())
    (policy,), team, space, rng = profile.agents, Team.of(profile), {}, random.Random(0)
    known = {each.name: (each.low, each.high, each.initial) for each in policy.memory}
    assert known == {"held": (0, 5, 0), "on": (0, 1, 0), "trips": (0, 4, 0)} and policy.tree.sums
    exec(SUMMING, space)
    made, names, taken, seen = space["Pump"](), [each.name for each in policy.actions], set(), [0.0, 0.0]
    for _ in range(20_000):
        if rng.random() < 0.3:  # near the ties of sums
            x = rng.uniform(-4, 9)
            seen = [x, rng.choice([x - 1.5, x - 0.5, 3 - x / 2, x - 0.25, rng.uniform(-4, 9)])]
        answer = made.act(*seen)
        assert names[team.act(seen)] == answer
        taken.add(answer)
    assert taken == {"on", "off", "trip"}


RISING = """
class Rising:
    def __init__(self):
        self.n = 0

    def act(self, x, y):
        if x - y > 0.1 + 0.3 * self.n:
            self.n = 0
            return 1
        self.n = min(self.n + 1, 5)
        return 0
"""


def test_memory_in_a_sum_is_one_number_after_the_other():
    """Each sum is compared with what Python computes of the memory, to the last bit."""
    profile = profile_of(from_python(RISING.encode(), "policy.py", Said(arrays="floats")), Names())
    (policy,) = profile.agents
    asked = {float(each) for each in policy.tree.threshold[policy.tree.feature >= len(policy.features)]}
    assert asked == {0.1 + 0.3 * n for n in range(6)} and 0.9999999999999999 in asked
    with pytest.raises(InputError, match="is compared with a feature, or stands in a sum"):
        many = RISING.replace("1, 5)", "1, 500)").encode()
        profile_of(from_python(many, "policy.py", Said(arrays="floats")), Names())


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


ODD = {
    "class's own": "class A:\n    n = 3\n    def act(self, x):\n        if x > 0 and self.n > 0:\n"
    "            self.n -= 1\n        return self.n > 1",
    "early": "self.n = 0|if x < 0: return self.n|self.n = self.n + 1 if self.n < 3 else 0|return self.n",
    "nothing first": "self.n = None|if self.n is None: self.n = 0|elif x > 0 and self.n < 3: self.n += 1|return self.n",
    "recursive": "self.n = 0|if self.n < 3:|    self.n += 1|    return self.act(x)|self.n = int(x > 0)|return self.n",
    "swap": "self.a, self.b = 1, 2|if x > 0: self.a, self.b = self.b, self.a|return self.a",
    "alias": "self.n = 0|me = self|if x > 0: me.n = 1 - me.n|return self.n",
    "clipped": "self.n = 0|was = self.n|self.n = max(0, min(3, int(x)))|return was",
    "negated": "self.n = -3|if x > 0: self.n = -self.n|return self.n > 0",
    "compared": "self.n = 2|if x > self.n and self.n < 4: self.n += 1|return self.n",
    "texts": "self.s, self.t = 'ab'|if x > 0: self.s = self.t|if x > 2: self.t = 'c'|return self.s + self.t",
}
REFUSED = {
    "self.s = 0.0|self.s += x|return self.s > 1": "no whole number",
    "self.s = 0|self.s += 1|return self.s > 9": "counted without an end",
    "self.s = 0\n    def put(self, n):\n        self.s = n|if x > 1:|    self.s = 1|return self.s": "put sets it, too",
    "self.s = 0|if x > 0: self.n = 1|return self.n": "'n' is remembered, and __init__ does not set it",
    "self.h = (0, 0)|self.h = (self.h[1], x > 0)|return self.h[0]": "no whole number, text, bool or member: h",
    "self.h = [0, 0]|self.h[0] = 1|return self.h[0]": "changes something that outlives the decision",
    "self.h = [0]|self.h.append(x > 0)|return self.h[-1]": "changes something that outlives the decision",
    "self.n = 250|self.n = (self.n + 100) % 256|return self.n > 127": "mod of a feature",
    "self.n = 1|if x > 0: self.n = None|return 5 if self.n is None else 6": "'n' is set to None, and remembered",
    "self.n = 8|if x > 0: self.n = self.n / 2|return self.n": "no sum of weighted features",
    "self.s = 'a'|self.s = self.s + 'b'|return self.s": "too many values",
    "self.n = 0|self.__dict__['n'] = 1|return self.n": "may change what names stand for",
    "self.n = 0|A.n = 1|return self.n": "no plain attribute of an object",
}


def class_of(lines):
    """A class whose first line begins it, and whose others decide."""
    first, _, rest = lines.partition("|")
    begin = f"class A:\n    def __init__(self):\n        {first}\n    def act(self, x):\n        "
    return begin + rest.replace("|", "\n        ") if rest else first


@pytest.mark.parametrize("name", ODD)
def test_what_is_odd_comes_in_as_python_runs_it(name):
    text, space, rng = class_of(ODD[name]), {}, random.Random(0)
    profile = profile_of(from_python(text.encode(), "policy.py", Said(run=False)), Names())
    exec(text, space)
    made, team = space["A"](), Team.of(profile)
    (names,) = ([each.name for each in policy.actions] for policy in profile.agents)
    for _ in range(2_000):
        x = rng.choice([0.0, 1.0, 2.0, rng.uniform(-3, 6)])
        wanted = made.act(x)
        number = f"action_{wanted}" if type(wanted) is int else str(wanted)
        assert names[team.act([x])] == number


@pytest.mark.parametrize("lines", REFUSED)
def test_what_is_not_followed_is_refused_with_its_line(lines):
    with pytest.raises(InputError, match=REFUSED[lines]) as caught:
        from_python(class_of(lines).encode(), "policy.py")
    assert re.search(r"line \d", str(caught.value)) or "without an end" in REFUSED[lines]  # which no line alone is


def test_ranges_that_never_settle_come_to_an_end():
    one = memory.Memory("n", 0, (-9, 9))
    every = memory.Memories([one], "act.py")
    with pytest.raises(InputError, match="takes too many values"):
        for run in range(memory.MAX_RUNS + 1):
            one.found = (0, run % 2)
            every.widen()
