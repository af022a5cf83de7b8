"""World files in continuous time, small trees for them, and trajectories by other people's integrators."""

import numpy as np
from scipy.integrate import solve_ivp

from codegen.ir import act
from tests.support.stated_play import value
from tests.support.system_cases import ends_of, policy, team
from tests.support.systems import world
from verify.checker.flows.intervals import Program, Spans
from verify.checker.flows.series import FlowReading
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

PENDULUM, MIXED, TURNING = map(world, ("pendulum", "mixed", "turning"))
BRAKING = team(
    policy(
        "motor",
        ["angle", "spin"],
        ["left", "off", "right"],
        ((0, 0.5), ((1, -0.1), 2, ((1, 0.3), 1, 0)), ((1, -1.0), 2, 0)),
    )
)
LOWERED = '[[property]]\nname = "reaches_and_stays"\nby = 10\nregion = { box = { angle = [0, 1] } }\n'
SIDES = team(policy("one", ["x"], ["low", "high"], ((0, 0.0), 1, 0)))
NEAR = '[[property]]\nname = "stays_in"\nregion = { box = { x = [-2, 2] } }\n'


def case(text, profile, claim):
    """A system, its team and a claim about it."""
    statement = statement_of(text + claim, "case.toml")
    return statement.system, profile, claims_of(statement, profile, "case.toml")[0]


CASES = {
    "pendulum": (PENDULUM, BRAKING, LOWERED),
    "mixed": (MIXED, SIDES, NEAR),
    "turning": (TURNING, SIDES, NEAR.replace("[-2, 2]", "[-9, 9]")),
}


# x = cos t, with samples one turn apart, for two turns
EXACTLY = TURNING.replace("error = { x = 0.001, y = [-0.002, 0.001] }", "").replace('"0.5 s"', '"6.283185307 s"')
EXACTLY = EXACTLY.replace("[0.9, 1.1]", "1").replace("[-0.1, 0.1]", "0").replace("0.2", "0").replace("= 12", "= 2")


def coefficients(flow, start, order):
    """Bounds of the coefficients 0 to `order` of each variable, for solutions from a point [variables]."""
    names = list(flow.rates)
    tape, series = FlowReading(flow, names).series(order, sloped=False)
    places = [None if each is None else each.value for of in series for each in of]
    given = {name: Spans(np.array([value]), np.array([value])) for name, value in zip(names, start, strict=True)}
    found = Program(tape, places).run(given, 1)
    ends = zip(found.low[:, 0].tolist(), found.high[:, 0].tolist(), strict=True)
    return [[next(ends) for _ in range(order + 1)] for _ in names]


def actions(system, profile, states):
    """What a team does in some states [n, variables], and what that holds the inputs at, name -> [n]."""
    names = [one.name for one in system.variables]
    joint = []
    for agent in profile.agents:
        seen = np.stack([states[:, names.index(feature.name)] for feature in agent.features], axis=1)
        joint.append((agent, act(agent, seen.astype(np.float32))))
    held = {}
    for agent, chosen in joint:
        values = [system.flow.held[agent.agent, each.name] for each in agent.actions]
        for name in values[0]:
            held[name] = np.array([float(each[name]) for each in values])[chosen]
    return held


def trajectories(system, profile, starts, steps, errors=None):
    """States at the ends of all steps of all periods, [periods, steps, n, variables], by scipy at 1e-12. `errors`: of
    the derivatives, [n, variables], which stay.
    """
    names, (count, size) = [one.name for one in system.variables], starts.shape
    period = float(system.flow.period)
    now, found = starts.copy(), []
    for _ in range(system.steps):
        held = actions(system, profile, now)

        def slope(_, flat, held=held):
            state = flat.reshape(count, size)
            known = held | {name: state[:, place] for place, name in enumerate(names)}
            rates = [np.broadcast_to(value(system.flow.rates[name], known), count) for name in names]
            return (np.stack(rates, axis=1) + (0.0 if errors is None else errors)).ravel()

        ends = np.linspace(0.0, period, steps + 1)[1:]
        done = solve_ivp(slope, (0.0, period), now.ravel(), "DOP853", t_eval=ends, rtol=1e-12, atol=1e-12)
        found.append(done.y.T.reshape(steps, count, size))
        now = found[-1][-1]
    return np.array(found)


def starts_of(system, count, random):
    """Random starts of a box, corners among them, [count, variables]."""
    low, high = np.array([[float(end) for end in ends] for ends in ends_of(system).values()]).T
    where = random.random((count, len(low)))
    where[::3] = np.round(where[::3])
    return low + where * (high - low)


def outside(seen, states, tubes):
    """By how much states [periods, steps, n, variables] leave all sets that a sweep saw; of steps, or of their
    tubes.
    """
    worst = 0.0
    for (period, step), boxes in seen.items():
        worst = max(worst, off_by(boxes[tubes], states[period, step]))
    return worst


def off_by(boxes, points):
    """By how much some of the points [n, variables] leave all boxes, which may bound more variables behind these."""
    low, high = (np.concatenate(ends)[:, : points.shape[1]] for ends in zip(*boxes, strict=True))
    if not len(low):
        return np.inf
    return np.maximum(low[None] - points[:, None], points[:, None] - high[None]).max(axis=2).min(axis=1).max()


def watched(sweep, plan):
    """The boxes of a sweep by period and step: those after it, and its tubes."""
    found = {}

    def see(told):
        ends = found.setdefault((told.period, told.step), ([], []))
        ends[0].append((told.after.low, told.after.high))
        ends[1].append((told.tube.low, told.tube.high))

    sweep.watch = see
    sweep.run(plan)
    return found
