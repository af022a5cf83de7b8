"""Firmware that reads sensors and moves motors by calls: six files of its kind, their decisions by hand, refusals."""

import numpy as np
import pytest

from codegen.errors import DisagreementError, InputError
from codegen.importers.c import source
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said, read
from codegen.ir import act
from codegen.memory import step_memory
from maviper.importing.trees import import_trees

AVOIDER = """#include <stdint.h>
#define NEAR 300
uint16_t get_proximity(void);
float battery(void);
void stop(void);
void turn_left(void);
void turn_right(void);
static uint8_t turns = 0;
static int near(void) { return get_proximity() > NEAR; }
static void turn(void) { if (turns < 3) { turns++; turn_left(); } else { turn_right(); } }
void step(void)
{
    if (battery() < 3.3f) { stop(); return; }
    if (near()) { turn(); return; }
    turns = 0;
    if (get_proximity() > 200 && battery() < 3.5f) turn_right(); else stop();
}
int main(void) { while (1) step(); }
"""
VACUUM = """#include <stdint.h>
#include <stdbool.h>
typedef enum { CRUISE, BACK, SPIN } mode_t;
extern bool bumper(void);
extern uint8_t cliff(void);
extern void forward(void);
extern void backward(void);
extern void spin(void);
static mode_t mode = CRUISE;
static uint8_t ticks = 0;
void loop(void)
{
    if (cliff() > 200) { mode = BACK; ticks = 0; backward(); return; }
    switch (mode) {
    case CRUISE:
        if (bumper()) { mode = BACK; ticks = 0; backward(); } else forward();
        break;
    case BACK:
        if (++ticks >= 2) { mode = SPIN; ticks = 0; spin(); } else backward();
        break;
    default:
        if (++ticks >= 2) { mode = CRUISE; ticks = 0; }
        spin();
        break;
    }
}
"""
LINE = """static int left_sensor(void) { return *(volatile int *)0x40; }
static int right_sensor(void) { return *(volatile int *)0x44; }
static void steer_left(void) { *(volatile int *)0x50 = 1; }
static void steer_right(void) { *(volatile int *)0x50 = 2; }
static void straight(void) { *(volatile int *)0x50 = 0; }
void follow(void)
{
    int l = left_sensor(), r = right_sensor();
    if (l > 500 && r > 500) straight();
    else if (l > 500) steer_left();
    else if (r > 500) steer_right();
    else straight();
}
"""
PLANTS = """#include <stdbool.h>
double moisture(void);
bool tank_empty(void);
void pump_on(void);
void pump_off(void);
static bool on;
void water(void)
{
    if (tank_empty()) on = false;
    else if (moisture() < 0.25) on = true;
    else if (moisture() > 0.4) on = false;
    on ? pump_on() : pump_off();
}
"""
GATE = """#include <stdint.h>
int16_t current_ma(void);
int limit_open(void);
int limit_closed(void);
void motor_open(void), motor_close(void), motor_stop(void);
static void drive(int to) { if (to > 0) motor_open(); else if (to < 0) motor_close(); else motor_stop(); }
void gate(int wanted)
{
    int to = wanted > 0 ? 1 : -1;
    if (current_ma() > 1500) to = 0;
    if (to > 0 && limit_open()) to = 0;
    if (to < 0 && limit_closed()) to = 0;
    drive(to);
}
"""
LAMP = """#include <stdio.h>
unsigned char light(void);
void index(void);
void lamp_off(void);
void decide(void)
{
    for (int level = 50; level < 250; level += 100) {
        if (light() < level) {
            printf("dark %d\\n", level);
            if (level == 50) index(); else lamp_off();
            return;
        }
    }
    lamp_off();
}
"""
FIRMWARE = {  # source, reads, acts, a walk of observations with what is called at each
    "avoider": (AVOIDER, "get_proximity battery", "stop turn_left turn_right", [
        ((100, 4), "stop"), ((301, 4), "turn_left"), ((301, 4), "turn_left"), ((301, 4), "turn_left"),
        ((301, 4), "turn_right"), ((250, 3.4), "turn_right"), ((999, 3), "stop"), ((301, 4), "turn_left"),
    ]),
    "vacuum": (VACUUM, "bumper cliff", "forward backward spin", [
        ((0, 0), "forward"), ((1, 0), "backward"), ((0, 0), "backward"), ((0, 0), "spin"), ((1, 0), "spin"),
        ((0, 0), "spin"), ((0, 0), "forward"), ((0, 255), "backward"),
    ]),
    "line": (LINE, "left_sensor right_sensor", "steer_left steer_right straight", [
        ((501, 501), "straight"), ((501, 500), "steer_left"), ((0, 501), "steer_right"), ((0, 0), "straight"),
    ]),
    "plants": (PLANTS, "moisture tank_empty", "pump_on pump_off", [
        ((0.3, 0), "pump_off"), ((0.2, 0), "pump_on"), ((0.3, 0), "pump_on"), ((0.3, 1), "pump_off"),
        ((0.3, 0), "pump_off"),
    ]),
    "gate": (GATE, "current_ma limit_open limit_closed", "motor_open motor_close motor_stop", [
        ((1, 0, 0, 0), "motor_open"), ((0, 0, 0, 0), "motor_close"), ((1, 0, 1, 0), "motor_stop"),
        ((1, 1501, 0, 0), "motor_stop"), ((0, 0, 1, 0), "motor_close"), ((0, 0, 0, 1), "motor_stop"),
    ]),
    "lamp": (LAMP, "light", "index lamp_off", [((49,), "index"), ((50,), "lamp_off"), ((200,), "lamp_off")]),
}  # fmt: skip


def said(reads, acts, **more):
    return Said(reads=tuple(reads.split()), acts=tuple(acts.split()), **more)


@pytest.mark.compile
@pytest.mark.parametrize("name", FIRMWARE)
def test_calls_are_features_and_actions(name):
    """The import asks the compiled file, whose sensors and motors are functions that record, and compares."""
    text, reads, acts, walk = FIRMWARE[name]
    profile = profile_of(from_c(text.encode(), "robot.c", said(reads, acts)), Names())
    (policy,) = profile.agents
    assert "C compiler" in profile.provenance.training[f"{policy.agent} replayed by"]
    assert {each.name for each in policy.features} >= {*reads.split()}
    known = np.array([[each.initial for each in policy.memory]])
    for seen, called in walk:
        row = np.array([seen], policy.numbers)
        if policy.memory:
            taken, known = step_memory(policy, known, row)
        else:
            taken = act(policy, row)
        assert policy.actions[taken[0]].name == called, seen


REFUSED = {
    "two": ("< 3.5f) turn_right(); else stop();", "< 3.5f) turn_right(); stop();", "turn_right and stop"),
    "none": ("turn_right(); else stop();", "turn_right();", "none"),
    "unnamed": ("turns = 0;\n    if", "turns = 0; beep();\n    if", "beep is not read"),
    "given": ("uint16_t get_proximity(void)", "uint16_t get_proximity(int pin)", "get_proximity is given something"),
    "gives": ("void stop(void)", "int stop(void)", "stop is an action, and gives a value"),
    "no number": ("float battery(void)", "float *battery(void)", "battery"),
    "undeclared": ("void turn_left(void);", "", "declares no function turn_left"),
    "returns": ("void step(void)", "int step(void)", "ends without a return|returned"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_one_decision_is_refused(name):
    old, new, told = REFUSED[name]
    text = AVOIDER.replace(old, new, 1)
    assert text != AVOIDER
    with pytest.raises(InputError, match=told):
        from_c(text.encode(), "robot.c", said(*FIRMWARE["avoider"][1:3], run=False))


@pytest.mark.compile
def test_the_second_reading_sees_a_call_too_many(monkeypatch):
    """The reader is made to forget all calls but the last: the compiled file says that there were several."""
    label = source._Follower._label

    def forget(machine, returned):
        machine.memory[source.DONE] = machine.memory[source.DONE][-1:]
        return label(machine, returned)

    monkeypatch.setattr(source._Follower, "_label", forget)
    twice = LINE.replace("else if (r > 500) steer_right();", "else if (r > 500) { straight(); steer_right(); }")
    with pytest.raises(DisagreementError, match=r"where its origin takes '\?'"):
        profile_of(from_c(twice.encode(), "robot.c", said(*FIRMWARE["line"][1:3])), Names())


@pytest.mark.compile
def test_the_command_line_names_calls_by_their_parentheses(tmp_path):
    (tmp_path / "robot.c").write_text(LINE)
    features, actions = ["left=left_sensor()", "right=right_sensor()"], ["straight()", "steer_left()", "steer_right()"]
    profile = import_trees(tmp_path / "robot.c", feature_names=features, action_names=actions)
    (policy,) = profile.agents
    assert [each.name for each in policy.features] == ["left", "right"]
    assert [each.name for each in policy.actions] == [each.removesuffix("()") for each in actions]
    with pytest.raises(InputError, match="if/else Python"):
        read(b"def a(x):\n    return 1 if x > 0 else 0\n", "a.py", Said(reads=("get",)))
