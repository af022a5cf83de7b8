"""World states: points with names, batches of them, and what a team does there.

Does: evaluates a property exactly in one world state (the referee), and over batches for shares, by either arithmetic;
  compares the replays of a state; walks a tree for one observation, and puts each test on the path into words.
Assumes: the deployed arithmetic observes finite float64 positions by `codegen.observe`, real arithmetic by real.py.
Does not: search for world states, or say why a tree was grown so.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from codegen import ir, wording
from codegen.deciding import list_operands
from codegen.errors import DisagreementError
from codegen.ir import Bool, Float64, Floats, Int32, PolicyProfile
from codegen.numbers import nearest_number
from codegen.observe import observe
from verify.claims.decisions import DecisionClaim, engages
from verify.claims.formula import Formula, for_goal, holds
from verify.claims.region import Region
from verify.kinds import MACHINE, REAL
from verify.question import DecisionQuestion
from verify.states.real import Value, comparable, leaf_of, leaves_of, measure_feature, value_of
from verify.states.values import Batch, worth


@dataclass(frozen=True)
class State:
    """One world state: coordinates (velocities that are left out are zero) and the goal landmark (None without one).

    `errors`: by how much a feature is off as an agent measures it, by `error_name`; what is left out is exact.
    """

    position: Mapping[str, Value]
    goal: str | None
    errors: Mapping[str, Value] = field(default_factory=dict[str, Value])

    @property
    def floats(self) -> bool:
        """True if it is a float64 state, errors included: the deployed arithmetic knows no others."""
        return not any(isinstance(value, Fraction) for value in (*self.position.values(), *self.errors.values()))

    def coordinates(self, profile: PolicyProfile) -> Float64:
        """All world coordinates of a float64 state in the world's order, [1, n_coordinates]."""
        assert self.floats, f"no float64 state: {self}"
        return np.array([list(self._values(profile.world).values())])

    def exactly(self, profile: PolicyProfile) -> dict[str, Fraction]:
        """All world coordinates by name, in the world's order."""
        return {name: Fraction(value) for name, value in self._values(profile.world).items()}

    def _values(self, world: ir.WorldSpec) -> dict[str, Value]:
        values: dict[str, Value] = dict.fromkeys(world.coordinates(), 0.0)
        values |= self.position
        if self.goal is not None:
            values |= {f"goal.{axis}": self.position[f"{self.goal}.{axis}"] for axis in "xy"}
        return {name: values[name] for name in world.coordinates()}


def error_name(agent: str, feature: str) -> str:
    """The name of the error of one feature as one agent measures it; no coordinate has a colon."""
    return f"{agent}:{feature}"


def measurable(meaning: ir.Meaning) -> bool:
    """Returns True if a feature is measured and may be off: not a constant, nor a test that two things are equal."""
    return bool(meaning.terms) and meaning.function != "zero"


def observe_state(profile: PolicyProfile, policy: ir.AgentPolicy, state: State) -> Floats:
    """Returns what an agent of the deployed arithmetic observes in a float64 state, errors included, [1, n_features].

    An error is added to the exact coordinate or difference; then float64, the feature's function and the agent's
    numbers follow as without it.
    """
    seen = observe(policy.features, state.coordinates(profile), profile.world, policy.numbers)
    exact = measurements(profile, policy, state) if state.errors else []
    for place, feature in enumerate(policy.features):
        if state.errors.get(error_name(policy.agent, feature.name)) and measurable(meaning_of(feature)):
            seen[0, place] = float(exact[place])
    return seen


def meaning_of(feature: ir.FeatureSpec) -> ir.Meaning:
    """The meaning of a feature that is known to have one."""
    assert feature.meaning is not None, feature
    return feature.meaning


def measurements(profile: PolicyProfile, policy: ir.AgentPolicy, state: State) -> list[Fraction]:
    """Measures an agent's features in a world state without rounding, errors included, [n_features]."""
    at, values = state.exactly(profile), list[Fraction]()
    for feature in policy.features:
        meaning = meaning_of(feature)
        error = Fraction(state.errors.get(error_name(policy.agent, feature.name), 0.0))
        values.append(measure_feature(meaning, at, error if measurable(meaning) else Fraction(0)))
    return values


def leaf_at(profile: PolicyProfile, policy: ir.AgentPolicy, state: State, semantics: str = MACHINE) -> int:
    """The leaf that an agent reaches in a world state; the deployed arithmetic knows float64 states only."""
    if semantics == REAL:
        return leaf_of(policy.tree, measurements(profile, policy, state))
    return int(ir.apply(policy.tree, observe_state(profile, policy, state))[0])


def leaves_at(profile: PolicyProfile, team: str, state: State, semantics: str = MACHINE) -> dict[str, int]:
    """Agent -> the leaf that it reaches in a world state, of a team."""
    return {policy.agent: leaf_at(profile, policy, state, semantics) for policy in profile.team(team)}


def actions_at(profile: PolicyProfile, team: str, state: State, semantics: str = MACHINE) -> dict[str, int]:
    """Agent -> what it does in a world state, of a team."""
    leaves = leaves_at(profile, team, state, semantics)
    return {policy.agent: int(policy.tree.action[leaves[policy.agent]]) for policy in profile.team(team)}


def find_leaves(policy: ir.AgentPolicy, coordinates: Float64, world: ir.WorldSpec, semantics: str = MACHINE) -> Int32:
    """The leaves that one agent reaches in a batch of float64 states. [batch]"""
    if semantics == REAL:
        return leaves_of(policy.tree, comparable(policy.features, coordinates, world))
    return ir.apply(policy.tree, observe(policy.features, coordinates, world, policy.numbers))


def choose_actions(
    policy: ir.AgentPolicy, coordinates: Float64, world: ir.WorldSpec, semantics: str = MACHINE
) -> Int32:
    """The actions of one agent in a batch of float64 states. [batch]"""
    return policy.tree.action[find_leaves(policy, coordinates, world, semantics)]


def violates(question: DecisionQuestion, state: State) -> bool:
    """The referee: whether the claim fails in this world state, with exact arithmetic for the claim itself."""
    return violates_by(question, state, leaves_at(question.profile, question.claim.team, state, question.semantics))


def violates_by(question: DecisionQuestion, state: State, leaves: Mapping[str, int]) -> bool:
    """Returns what `violates` does, where the leaves that the team reaches in the state are known."""
    team = question.profile.team(question.claim.team)
    actions = {policy.agent: int(policy.tree.action[leaves[policy.agent]]) for policy in team}
    return not holds(question.formula_for(state.goal), state.exactly(question.profile), actions)


def shortfall(question: DecisionQuestion, state: State) -> Fraction | float:
    """By how much the claim fails in a world state that violates it, exact: the least s such that, actions as they are,
    it would hold with each bound of its inequalities relaxed by more than s. Infinite when no relaxing would do.

    In the unit of the bounds, which is a length for the built-in properties. It is the value of the claim in the usual
    quantitative semantics (`values.worth`) without its sign.
    """
    actions = actions_at(question.profile, question.claim.team, state, question.semantics)
    return -worth(question.formula_for(state.goal), state.exactly(question.profile), actions)


def find_engaged(
    profile: PolicyProfile, claim: DecisionClaim, state: State, actions: Mapping[str, int]
) -> dict[str, tuple[str, ...]]:
    """Agent -> the landmarks that it is engaged with in a world state by its action, exactly."""
    return {
        policy.agent: tuple(
            landmark.name
            for landmark in profile.world.landmarks
            if true_at(profile, engages(policy, landmark.name, claim), state, actions)
        )
        for policy in profile.team(claim.team)
    }


def true_at(profile: PolicyProfile, asked: Formula, state: State, actions: Mapping[str, int]) -> bool:
    """Returns True if a formula holds in a world state in which the agents have chosen, exactly."""
    return holds(for_goal(asked, state.goal), state.exactly(profile), actions)


def exact_point(model: Mapping[str, Fraction], region: Region, goal: str | None) -> State:
    """An exact model as a point: `model` as for `nearest`."""
    errors = {name: value_of(value) for name, value in model.items() if name not in region.box and value}
    return State({name: _up(region, name, value_of(model[name])) for name in region.box}, goal, errors)


def _up(region: Region, name: str, value: Value) -> Value:
    """A value of a coordinate of a region; of a whole one the whole number that agents decide by."""
    if name not in region.whole:
        return value
    return float(math.ceil(nearest_number(Fraction(value), region.whole[name])))


def inside(region: Region, state: State) -> bool:
    """Returns True if a point lies in a region, exactly."""
    at = {name: Fraction(value) for name, value in state.position.items()}
    if region.goals and state.goal not in region.goals:
        return False
    if any(not low <= at[name] <= high for name, (low, high) in region.box.items()):
        return False
    if any(at[name].denominator != 1 for name in region.whole):
        return False
    if any(not low <= at[a] - at[b] <= high for a, b, (low, high) in region.differences):
        return False
    return all(max(abs(at[f"{a}.{axis}"] - at[f"{b}.{axis}"]) for axis in "xy") >= d for a, b, d in region.apart)


def nearest(model: Mapping[str, Fraction], region: Region, goal: str | None, eps: Fraction = Fraction(0)) -> State:
    """The float64 point nearest to an exact one, each value rounded towards the inside of its interval.

    `model`: every coordinate of the region, and errors by `error_name`, at most `eps`.
    """
    values: dict[str, float] = {}
    for name, value in model.items():
        low, high = region.box.get(name, (-eps, eps))
        near = float(value)
        if Fraction(near) > high:
            near = math.nextafter(near, -math.inf)
        elif Fraction(near) < low:
            near = math.nextafter(near, math.inf)
        values[name] = float(_up(region, name, near))
    errors = {name: value for name, value in values.items() if name not in region.box and value}
    return State({name: values[name] for name in region.box}, goal, errors)


@dataclass(frozen=True)
class Step:
    """One test on a decision path: `value` of `feature` against `threshold`."""

    node: int
    feature: str
    value: Value
    threshold: float
    left: bool

    def __str__(self) -> str:
        value, near = float(self.value), wording.is_zero(float(self.value)) and self.value != 0
        told = wording.holds(self.threshold) if self.left else wording.fails(self.threshold)
        if math.isnan(value):
            return f"{self.feature} = nan, not {wording.holds(self.threshold)}"
        if near or (f"{value:.6g}" == wording.number(self.threshold) and self.value not in (self.threshold, 0)):
            return f"{self.feature} = {self.value} {'<=' if self.left else '>'} {self.threshold!r}"
        return f"{self.feature} = {value:.6g} {told}"


def path(policy: ir.AgentPolicy, seen: Sequence[Value]) -> tuple[Step, ...]:
    """The tests that lead to the decision for one observation, rounded or exact: [n_features], and then the sums that
    the tree tests.
    """
    tree, node, steps = policy.tree, ir.ROOT, list[Step]()
    names = list_operands(policy)
    while tree.feature[node] != ir.NO_FEATURE:
        feature, threshold = int(tree.feature[node]), float(tree.threshold[node])
        left = seen[feature] <= threshold
        steps.append(Step(node, names[feature], seen[feature], threshold, left))
        node = int(tree.left[node] if left else tree.right[node])
    return tuple(steps)


REFERENCE = "reference"
EXACTLY = "judged in exact arithmetic"
NO_FLOATS = "not replayed: the state is no float64 state, and the deployed arithmetic knows no others"
Replay = Callable[[State], list[int]]  # a world state -> the team's actions


@dataclass(frozen=True)
class Deployed:
    """The effect of the deployed arithmetic in a float64 state that real arithmetic was asked about."""

    actions: Mapping[str, str]  # agent -> the name of its action
    violated: bool  # the claim fails by them


@dataclass(frozen=True)
class Acted:
    """A team's actions in a world state, and by what they were taken."""

    actions: Mapping[str, int]  # agent -> its action, by the arithmetic asked about
    by: tuple[str, ...]  # what replays took these
    says: str  # what judged them and who replayed them, in words
    deployed: Deployed | None = None  # of real arithmetic; None where the state is no float64 state


def confirm_actions(
    profile: PolicyProfile,
    claim: Formula,
    team: str,
    state: State,
    replays: Mapping[str, Replay],
    semantics: str = MACHINE,
) -> Acted:
    """Returns what the team does; DisagreementError when a replay acts differently from the reference."""
    actions = actions_at(profile, team, state, semantics)
    if semantics == REAL and not state.floats:
        return Acted(actions, (), f"{EXACTLY}; {NO_FLOATS}")
    machine = actions_at(profile, team, state, MACHINE)
    for name, replay in replays.items():
        repeated = list(replay(state))
        if repeated != list(machine.values()):
            what = f"the {name} does not reproduce the counterexample"
            raise DisagreementError(what, f"reference {list(machine.values())}, {name} {repeated}", "this is a bug")
    by = (REFERENCE, *replays)
    replayed = f"replayed by {', '.join(by)}"
    if semantics == MACHINE:
        return Acted(actions, by, replayed)
    names = {policy.agent: policy.actions[machine[policy.agent]].name for policy in profile.team(team)}
    deployed = Deployed(names, not true_at(profile, claim, state, machine))
    if machine == actions:
        return Acted(actions, by, f"{EXACTLY}, {replayed}", deployed)
    other = ", ".join(f"{agent} takes {name}" for agent, name in names.items() if machine[agent] != actions[agent])
    claimed = "fails there too" if deployed.violated else "holds there"
    return Acted(actions, (), f"{EXACTLY}; the deployed arithmetic differs: {other}, and the claim {claimed}", deployed)


# --- batches, for shares: float64 arithmetic, which can only misjudge states within a rounding of a boundary


def contains(region: Region, coordinates: Float64, world: ir.WorldSpec) -> Bool:
    """Returns which world states of a batch lie in a region's box, differences and distances (goals aside), [batch]."""
    at = {name: coordinates[:, place] for place, name in enumerate(world.coordinates())}
    within = np.ones(len(coordinates), dtype=bool)
    for name, (low, high) in region.box.items():
        within &= (at[name] >= float(low)) & (at[name] <= float(high))
    for a, b, (low, high) in region.differences:
        within &= (at[a] - at[b] >= float(low)) & (at[a] - at[b] <= float(high))
    for a, b, least in region.apart:
        gaps = [np.abs(at[f"{a}.{axis}"] - at[f"{b}.{axis}"]) for axis in "xy"]
        within &= np.maximum(*gaps) >= float(least)
    return within


def sample(region: Region, world: ir.WorldSpec, count: int, seed: int) -> tuple[Float64, Int32]:
    """Uniform world states of a region: coordinates [n, n_coordinates] and goals [n] (landmark indices).

    At most `count`: states outside the region's differences and distances are drawn and dropped.
    """
    rng = np.random.default_rng(seed)
    names = world.coordinates()
    coordinates = np.zeros((len(names), count)).T
    for name, (low, high) in region.box.items():
        drawn = rng.uniform(float(low), float(high) + (name in region.whole), count)
        coordinates[:, names.index(name)] = np.floor(drawn) if name in region.whole else drawn
    landmarks = [entity.name for entity in world.landmarks]
    allowed = np.array([landmarks.index(goal) for goal in region.goals] or [0], dtype=np.int32)
    goal = allowed[rng.integers(len(allowed), size=count)]
    if region.goals:
        for axis in "xy":
            columns = np.array([names.index(f"{landmark}.{axis}") for landmark in landmarks])
            coordinates[:, names.index(f"goal.{axis}")] = coordinates[np.arange(count), columns[goal]]
    within = contains(region, coordinates, world)
    # in planes: what reads coordinates reads one after the other, and strides take ten times as long
    return coordinates.T.compress(within, axis=1).T, goal[within]


def state_at(region: Region, world: ir.WorldSpec, coordinates: Float64, goal: int) -> State:
    """One sampled world state (a row [n_coordinates] and its goal's index) as a point of the region."""
    names = world.coordinates()
    position = {name: _up(region, name, float(coordinates[names.index(name)])) for name in region.box}
    return State(position, world.landmarks[goal].name if region.goals else None)


def batch(coordinates: Float64, world: ir.WorldSpec) -> Batch:
    """Formulas over a batch of world states."""
    return Batch(dict(zip(world.coordinates(), coordinates.T, strict=True)), len(coordinates))
