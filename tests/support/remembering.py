"""Small controllers in C that remember, and a world for one of them."""

from dataclasses import replace

import numpy as np

from codegen.sums import DOUBLE_SUMS, Sum

HEATER = """#include <stdbool.h>
bool act(float t) {
    static bool heating = false;
    if (t < 19.0f) heating = true;
    else if (t > 21.0f) heating = false;
    return heating;
}"""
DEBOUNCE = """#include <stdbool.h>
#include <stdint.h>
static uint16_t count = 0;
static bool stable = false;
bool act(float x) {
    bool raw = x > 0.0f;
    if (raw == stable) { count = 0; return stable; }
    if (++count >= 50) { stable = raw; count = 0; }
    return stable;
}"""
LIGHT = """typedef enum { RED, GREEN, YELLOW } phase_t;
typedef struct { phase_t phase; int green_for, waiting; } light_t;
static light_t s = { GREEN, 7, 3 };
phase_t act(float queue) {
    switch (s.phase) {
    case RED:
        if (queue > 0.5f && s.waiting < 60) s.waiting++;
        if (s.waiting >= 60 || queue > 10.0f) { s.phase = GREEN; s.waiting = 0; s.green_for = 0; }
        break;
    case GREEN:
        if (s.green_for < 30) s.green_for++;
        else if (queue < 0.5f) s.phase = YELLOW;
        break;
    default:
        s.phase = RED;
        break;
    }
    return s.phase;
}"""
WATCHDOG = """#include <stdint.h>
enum { OK, TRIP };
int act(float pulse) {
    static uint32_t silent;
    if (pulse > 0.5f) silent = 0;
    else if (silent < 1000) silent++;
    return silent >= 1000 ? TRIP : OK;
}"""
EDGE = """#include <stdbool.h>
#include <stdint.h>
int act(float x) {
    static bool before = false;
    static uint8_t presses = 250;
    static int level = 1;
    const bool button = x > 0.0f;
    if (button && !before) { presses++; level = (level + 1) % 4; }
    before = button;
    return presses > 200 ? 9 : level;
}"""
WHOLE = """#include <stdint.h>
int act(int16_t t, int16_t u) {
    if (t < -20) return 1;
    if (u > 200) return 2;
    return t > 800 ? 0 : 1;
}"""  # this and the next remember nothing
GIVING = """#include <math.h>
#pragma STDC FP_CONTRACT OFF
double act(double x, double v) {
    if (x + 2*v > 1) return fmin(fmax(0.5*x - v, -2.0), 3.0);
    return 0.25;
}"""
# tests of sums beside memory: read before and after it changes, behind early returns, up to a counter's end
PUMP = """#include <stdbool.h>
#pragma STDC FP_CONTRACT OFF
static bool on = false;
static int held = 0;
int act(double inlet, double outlet) {
    double gap = inlet - outlet;
    if (held < 5) { held++; return on; }
    if (on ? gap < 0.5 : gap > 1.5) { on = !on; held = 0; }
    return on;
}"""
TIMER = """#include <stdint.h>
#pragma STDC FP_CONTRACT OFF
int act(float x, float y) {
    static uint8_t low = 0, trips = 0;
    if (0.5f * x + y > 3.0f) low = 0;
    else if (low < 9) ++low;
    if (low == 9 && trips < 3 && x - y > 0.25f) { trips++; low = 2; return 4 + trips; }
    if (trips == 3) return 2;
    return low > 4 && 0.5f * x + y <= -1.0f;
}"""
TANK = """#pragma STDC FP_CONTRACT OFF
typedef struct { int mode, timer, alarm; } tank_t;
typedef struct { float x, y; } input_t;
void tank_init(tank_t *s) { s->mode = 0; s->timer = 4; s->alarm = -2; }
int act(tank_t *s, const input_t *in) {
    if (in->x - in->y < 0.0f) { if (s->alarm < 2) s->alarm++; }
    else if (s->alarm > -2) s->alarm--;
    if (s->alarm >= 1) { s->mode = 2; return 2; }
    if (s->timer > 0) { s->timer -= 1; if (in->y < 0.0f) return 0; }
    else if (0.5f * in->x + 0.25f * in->y > 3.0f) { s->mode = 1; s->timer = 4; }
    else s->mode = 0;
    return s->mode;
}"""
RISING = """#pragma STDC FP_CONTRACT OFF
int act(float x, float y) {
    static int n = 0;
    if (x - y > 0.1f + 0.3f * n) { n = 0; return 1; }
    if (n < 5) n++;
    return 0;
}"""  # memory in a sum is one number after the other
SUMMING = {"pump": PUMP, "rising": RISING, "timer": TIMER, "tank": TANK}
SOURCES = {"heater": HEATER, "debounce": DEBOUNCE, "light": LIGHT, "watchdog": WATCHDOG, "edge": EDGE}
WORLD = """name = "room"
steps = 40
dt = "1 min"
[variables]
t = {{ unit = "K", range = [-100, 100] }}
[agents.act.features]
{feature} = "t"
[agents.act.actions]
{actions}
[start]
box = {{ t = [18, 22] }}
[dynamics.next]
t = "t - 0.02*(t - 10[K]) + act.power*0.5[K]"
"""


def adding(profile):
    """A policy whose tests of its first feature, t, test t + 2*m instead, of its first memory m."""
    (policy,), count = profile.agents, len(profile.agents[0].features)
    sums = (Sum(((1.0, 0), (2.0, count - len(policy.memory)))),)
    feature = np.where(policy.tree.feature == 0, count, policy.tree.feature)
    tree = replace(policy.tree, feature=feature, sums=sums, arithmetic=DOUBLE_SUMS)
    return replace(profile, agents=(replace(policy, tree=tree, grown=None),))


def make_world(policy, claims=""):
    """A world file for an agent with one feature."""
    names = [each.name for each in policy.actions if not each.acts]
    actions = "\n".join(f"{name} = {{ power = {place} }}" for place, name in enumerate(names))
    return WORLD.format(feature=policy.features[0].name, actions=actions) + claims
