"""Claims about six flows with margins from .01 to .3: verdicts, processor seconds, ratios to each plant's widest claim.

    python -m tests.benchmarks.margins [--dense N] [NAME ...]

The plants are world files in tests/benchmarks/margins; trees of depth 3 to 5 are fitted to rules of one line by
scikit-learn. A margin is how far N simulated episodes (--dense; Runge-Kutta of this file, and the product's own play,
which looks for an episode that leaves the region) stay inside the claim's bounds. Without it nothing is simulated.
"""

from pathlib import Path

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from tests.benchmarks.common import reader, seconds
from tests.support import system_cases as cases
from tests.support.flows import actions, starts_of
from tests.support.stated_play import value
from verify.claims.region import UNBOUNDED
from verify.flows.decide import decide
from verify.flows.episodes import FlowPlay
from verify.question import Question
from verify.subjects import ClosedLoop
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

PLACE = Path(__file__).parent / "margins"
STAYS = '[[property]]\nname = "stays_in"\nregion = {{ box = {{ {} = [{}, {}] }} }}\n'
CLAIMS = {  # a variable and the bounds in which it stays, the widest margin first
    "cruise": ("gap", [(39.05, 60.3), (39.25, 60.1)]),
    "pendulum": ("angle", [(-0.58, 1.0), (-0.307, 0.7224)]),
    "tora": ("x1", [(-0.913, 0.8785), (-0.757, 0.7225)]),
    "unicycle": ("x2", [(-1.035, 1.79), (-0.8556, 1.611)]),
    "vanderpol": ("x", [(-0.8, 1.7), (-0.6207, 1.5204)]),
    "heater": ("room", [(14.75, 25.86), (14.9, 25.81)]),  # errors that change sides once take the room to 25.7478
}
SAMPLES, LEAST = 20_000, 50  # that trees are fitted to, and of each leaf
PARTS = 5  # of a period, at whose ends states are seen


def choose(values, wished):
    """The number of the value that is nearest to each wish."""
    return np.abs(np.asarray(values) - wished[:, None]).argmin(axis=1)


RULES = {  # by plant and agent: depth of the tree, bounds of samples where they are not the ranges, the rule
    "cruise": {"car": (4, [(10, 80), (10, 35)], lambda g, v: choose([-3, -1, 0.2, 1.5], 0.3 * g - 1.16 * v + 14.6))},
    "pendulum": {"motor": (4, None, lambda a, s: choose([-10, -5, 0, 5, 10], -24 * a - 6 * s))},
    "tora": {"arm": (5, None, lambda x1, x2, x3, x4: choose([-0.8, 0, 0.8], 0.5 * x2 - x3 - 1.5 * x4))},
    "unicycle": {
        "pace": (3, None, lambda x1, x4: choose([-1, 0, 1], 1.5 * (np.clip(-0.5 * x1, -1, 1) - x4))),
        "wheel": (4, None, lambda x2, x3: choose([-1, 0, 1], 2 * (np.clip(-0.6 * x2, -0.8, 0.8) - x3))),
    },
    "vanderpol": {"damper": (4, None, lambda x, y: choose([-2, 0, 2], -2 * y - 0.5 * x))},
    "heater": {"valve": (3, None, lambda r, w: choose([0, 0.5], 0.25 + 0.2 * (20 - r) - 0.02 * (w - 30)))},
}


def fit_team(name, system):
    """The trees of a plant."""
    random, policies = np.random.default_rng(0), []
    ranges = {one.name: tuple(map(float, one.range)) for one in system.variables}
    for agent, (depth, bounds, rule) in RULES[name].items():
        features = list(system.features[agent])
        low, high = np.array(bounds or [ranges[each] for each in features]).T
        samples = random.uniform(low, high, (SAMPLES, len(features)))
        fitted = DecisionTreeClassifier(max_depth=depth, random_state=0, min_samples_leaf=LEAST)
        fitted.fit(samples, rule(*samples.T))
        chosen = [action for of, action in system.flow.held if of == agent]
        policies.append(cases.policy(agent, features, chosen, nest(fitted, 0)))
    return cases.team(*policies)


def nest(fitted, node):
    """A node of a fitted tree, as tests/support has trees."""
    tree = fitted.tree_
    if tree.children_left[node] < 0:
        return int(fitted.classes_[tree.value[node, 0].argmax()])
    left, right = nest(fitted, tree.children_left[node]), nest(fitted, tree.children_right[node])
    threshold = float(np.float32(round(tree.threshold[node], 3)))
    return left if left == right else ((int(tree.feature[node]), threshold), left, right)


def simulate(system, profile, column, count):
    """The least and the largest value of a variable over random episodes, errors at their ends."""
    random, names = np.random.default_rng(1), [one.name for one in system.variables]
    state = starts_of(system, count, random)
    ends = np.array([[float(end) for end in system.flow.error.get(name, (0, 0))] for name in names]).T
    error, h = np.zeros_like(state), float(system.flow.period) / PARTS
    low, high = state[:, column].min(), state[:, column].max()
    for period in range(system.steps):
        held, drawn = actions(system, profile, state), np.where(random.random(state.shape) < 0.5, *ends)
        error = np.where((np.arange(count) % 2 == 0)[:, None] & (period > 0), error, drawn)

        def slope(now, held=held, error=error):
            known = held | dict(zip(names, now.T, strict=True))
            rates = [np.broadcast_to(value(system.flow.rates[name], known), count) for name in names]
            return np.stack(rates, axis=1) + error

        for _ in range(PARTS):
            first = slope(state)
            second = slope(state + h / 2 * first)
            third = slope(state + h / 2 * second)
            state = state + h / 6 * (first + 2 * second + 2 * third + slope(state + h * third))
            low, high = min(low, state[:, column].min()), max(high, state[:, column].max())
    return low, high


def main():
    parser = reader(__doc__)
    parser.add_argument("names", nargs="*", default=list(CLAIMS))
    parser.add_argument("--dense", type=int, metavar="N")
    options = parser.parse_args()
    for name in options.names:
        variable, bounds = CLAIMS[name]
        widest = 0.0
        for low, high in bounds:
            text = (PLACE / f"{name}.toml").read_text() + STAYS.format(variable, low, high)
            statement = statement_of(text, f"{name}.toml")
            system, profile = statement.system, fit_team(name, statement.system)
            (claim,) = claims_of(statement, profile, f"{name}.toml")
            margin = ""
            if options.dense:
                column = [one.name for one in system.variables].index(variable)
                least, most = simulate(system, profile, column, options.dense)
                broken = next(FlowPlay(profile, system, claim).breaking(options.dense), None)
                margin = f", margin {min(least - low, high - most):.4f}, own play {'breaks it' if broken else 'agrees'}"
            question = Question(ClosedLoop(profile, system), claim, UNBOUNDED)
            took, found = seconds(lambda asked=question: decide(asked))
            widest = widest or took
            print(f"{name}: {variable} in [{low}, {high}]: {found.verdict.value}, {found.boxes:,} sets, {took:.1f} s, ")
            print(f"    {took / widest:.2f} times the widest claim{margin}", flush=True)


if __name__ == "__main__":
    main()
