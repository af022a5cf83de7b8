"""Flows of world files are read exactly, faults are told with their lines, and what knows only steps refuses."""

from fractions import Fraction as F

import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from maviper.worlds.stated.deviation import deviation
from tests.support.altered import of_hashes
from tests.support.flows import PENDULUM
from tests.support.system_cases import policy, team
from verify.checker.accept import accept
from verify.checker.systems.proofs import Cover, Walks
from verify.claims.region import UNBOUNDED
from verify.kinds import MACHINE
from verify.question import Question
from verify.reach import decide
from verify.reach.replay import Course, replay_course
from verify.reach.written import WrittenReplay
from verify.solver import unrolled
from verify.subjects import ClosedLoop
from verify.systems import documents, motion
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.expressions import affine
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

LEAF = team(policy("motor", ("angle", "spin"), ("left", "off", "right"), 1))
LEAF_HASH = content_hash(LEAF)


def system_of(text=PENDULUM):
    return statement_of(text, "pendulum.toml").system


def changed(old, new):
    assert PENDULUM.count(old) == 1, PENDULUM.count(old)
    return PENDULUM.replace(old, new)


def test_a_flow_is_read_exactly():
    flow = system_of(changed("[dynamics.flow]", "error = { spin = [-0.1, 0.2] }\n[dynamics.flow]")).flow
    assert flow.period == F(1, 20)
    assert flow.held["motor", "left"] == {"motor.torque": -8} and flow.held["motor", "off"] == {"motor.torque": 0}
    assert flow.error == {"spin": (F(-1, 10), F(1, 5))}
    assert set(flow.rates) == {"angle", "spin"}


def test_times_of_whole_values_are_converted():
    assert system_of(changed("0.05 s", "0.5 min")).flow.period == 30
    assert documents.content_hash(system_of(changed("0.05 s", "50 ms"))) == documents.content_hash(system_of())
    text = changed('angle = "spin"\nspin', 'angle = "60[s/min]*spin"\nspin')
    text = text.replace("[dynamics.flow]", 'error = { spin = "6 1/s/min" }\n[dynamics.flow]')
    flow = system_of(text).flow
    state = {"spin": F(3), "angle": F(0), "motor.torque": F(0)}
    assert affine(flow.rates["angle"]).at(state) == 3 and flow.error == {"spin": (F(-1, 10), F(1, 10))}
    with pytest.raises(InputError, match="units do not fit"):
        system_of(changed('angle = "spin"', 'angle = "spin + 1[1/min]"'))


def test_a_change_of_the_flow_changes_the_hash():
    texts = [
        PENDULUM,
        changed("0.05 s", "0.06 s"),
        changed("2[1/s^2]*sin", "2[1/s^2]*cos"),
        changed('"8 1/s^2"', '"9 1/s^2"'),
        changed("[dynamics.flow]", "error = { spin = 1 }\n[dynamics.flow]"),
    ]
    assert len({documents.content_hash(system_of(text)) for text in texts}) == len(texts)


WRONG = [
    ('angle = "spin"\nspin = "2', 'angle = "angle"\nspin = "2', "units do not fit: the unit is 1, and 1/s is needed"),
    ('angle = "spin"\nspin = "2', 'spin = "2', "nothing says how angle moves"),
    ("2[1/s^2]*sin(angle)", "2*sin(angle)", "units do not fit"),
    ("sin(angle) +", "clip(angle, 0, 1) +", "clip beside a flow cannot be enclosed"),
    ('period = "0.05 s"', "", "a flow needs the period"),
    ('period = "0.05 s"', "period = 0", "the period 0 is not above 0"),
    ('period = "0.05 s"', 'period = "0.05 m"', "units do not fit"),
    ("[dynamics.flow]", "[dynamics.cuts]\nangle = 4\n[dynamics.flow]", "both flow and cuts"),
    ("steps = 20", 'steps = 20\nreference = "gymnasium:X"', "a flow is not compared with an environment"),
    ("[dynamics.flow]", "error = { speed = 1 }\n[dynamics.flow]", "unknown variable 'speed'"),
    ("[dynamics.flow]", "error = { spin = -1 }\n[dynamics.flow]", "the error -1 is below 0"),
    ('"8 1/s^2"', '"1[1/s]*spin"', "action right of motor sets motor.torque to what is no number"),
]


def test_a_flow_has_as_many_cases_as_steps_may_have_rules(monkeypatch):
    monkeypatch.setattr(motion, "MAX_RULES", 3)
    text = changed("[dynamics.flow]", '[dynamics.next]\nspin = "choice(spin, 0[1/s], 1[1/s], MORE)"\n[dynamics.flow]')
    assert len(list(system_of(text.replace(", MORE", "")).flow.each)) == 3
    with pytest.raises(InputError, match="more than 3 cases and choices"):
        system_of(text.replace("MORE", "2[1/s]"))


@pytest.mark.parametrize(("old", "new", "said"), WRONG)
def test_what_is_wrong_in_a_flow_is_told_with_its_line(old, new, said):
    with pytest.raises(InputError, match=said.replace("(", r"\(")) as error:
        system_of(changed(old, new))
    assert "pendulum.toml" in str(error.value) and "line" in str(error.value)


CLAIM = '[[property]]\nname = "stays_in"\nregion = { box = { angle = [0, 1] } }\n'


def test_claims_hold_at_all_times_unless_they_say_samples():
    always, samples = (
        claims_of(statement_of(PENDULUM + CLAIM + more, "p.toml"), LEAF, "p.toml")[0]
        for more in ("", "at_samples = true\n")
    )
    assert always.at_samples is False and always.sentence.endswith("at all times")
    assert samples.at_samples is True and samples.sentence.endswith("at samples")
    assert always != samples
    with pytest.raises(InputError, match="not true or false"):
        claims_of(statement_of(PENDULUM + CLAIM + "at_samples = 1\n", "p.toml"), LEAF, "p.toml")


def test_what_knows_only_steps_refuses_a_flow():
    statement = statement_of(PENDULUM, "p.toml")
    system = statement.system
    claim = SystemClaim(Pattern.STAYS_IN, (system.start,), 3, at_samples=False)
    question = Question(ClosedLoop(LEAF, system), claim, UNBOUNDED, MACHINE)
    start = {"angle": F(1), "spin": F(0)}
    of = LEAF_HASH, documents.content_hash(system), claim, start
    asks = [
        lambda: decide.decide(question),
        lambda: unrolled.opinion(question),
        lambda: replay_course(LEAF, system, claim, Course(start)),
        lambda: accept(of_hashes(*of, Walks(())), LEAF, system),
        lambda: accept(of_hashes(*of, Cover({}, b"\0")), LEAF, system),
        lambda: deviation(statement),
        lambda: WrittenReplay(statement, LEAF, claim),
    ]
    for ask in asks:
        with pytest.raises(InputError, match=r"(?s)does not know continuous time.*pendulum: dynamics\.flow"):
            ask()
