"""Agents whose episodes end early: nothing that comes after an agent's end is learned, voted, weighed or counted."""

from functools import partial
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from codegen import ir
from maviper.episodes import measures
from maviper.episodes.play import Policies, points, rollout, tree_policies
from maviper.evaluation import held_out, run
from maviper.experts.expert import AS_GIVEN, labels
from maviper.extraction import baselines, refine, released
from maviper.extraction import released as released_grow
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import Arena
from maviper.extraction.dagger import weights
from maviper.extraction.dataset import Dataset, collect, resample
from maviper.extraction.extraction import Extraction
from maviper.extraction.growth.growing import Growth
from maviper.extraction.growth.joint import grow_jointly
from maviper.extraction.growth.weights import iviper_weights, maviper_weights
from maviper.extraction.settings import ALGORITHMS, FITTED_Q, HISTOGRAM, PRESETS, VIPER, Settings
from tests.support.ends import LEFT, OVER, PLACE, Expert, train_joint_trees, world_of
from tests.support.tiers import first_of

SMALL = {"iterations": 2, "rollouts": 12, "selection_episodes": 6, "max_depth": 3, "refinement": 0}
EVERY = [each for each in product(ALGORITHMS, PRESETS) if each != (FITTED_Q, "released")]


@pytest.fixture
def relay():
    return world_of("relay")


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 8)
    monkeypatch.setattr(released, "WARM_UP", 8)


def met(world, expert=None, agents=(0, 1, 2)):
    expert = expert or Expert(world)
    weigh = partial(weights, Extraction(world, expert, Settings().complete()), agents)
    return collect(world, expert, [expert] * 3, agents, range(10), weigh)


def steps_of(world, seeds):
    """How many steps each agent takes, [n_agents]: as many as it is paid 1 for."""
    return sum(episodes.returns.sum(axis=1) for episodes in rollout(world, [Expert(world)] * len(world.agents), seeds))


# --- the episodes


def test_episodes_say_who_is_in_play(relay):
    for seed in range(4):
        (episodes,) = rollout(relay, [Expert(relay)] * 3, [seed])
        over = np.stack([seen[..., OVER] for seen in episodes.observations], axis=2)
        assert episodes.alive.dtype == bool and (episodes.alive == (over == 0)).all()
        assert episodes.alive.sum(axis=0)[0].tolist() == episodes.returns[:, 0].tolist()
        assert episodes.alive[:, 0, 2].all() and len(episodes.actions) == 8
        last = episodes.states[-1]
        assert not relay.alive(last).any()
        assert relay.terminated(last).tolist() == [[True, True, False]]  # the chaser was cut


def test_an_episode_stops_with_its_last_agent():
    world = world_of("alone")
    (episodes,) = rollout(world, [Expert(world)], [0])
    assert len(episodes.actions) == len(episodes.states) - 1 == episodes.returns[0, 0] < world.spec.episode_steps


# --- data


def test_data_are_the_steps_that_agents_took(relay):
    found = met(relay)
    assert found.data.alive.sum(axis=0).tolist() == steps_of(relay, range(10)).tolist()
    assert len(found.data) == 80  # some agent acts in each
    for agent, seen in enumerate(found.data.observations):
        assert (found.data.alive[:, agent] == (seen[:, OVER] == 0)).all()
    assert not found.data.weights[~found.data.alive].any() and found.data.weights[found.data.alive].all()
    assert found.fidelity == 1
    one = met(relay, agents=[0]).data
    assert len(one) == steps_of(relay, range(10))[0] and one.alive[:, 0].all()


def test_only_steps_that_an_agent_took_are_drawn(relay):
    """Whatever they weigh, and where all weights are zero too."""
    rng, alive = np.random.default_rng(0), np.array([True, False, True, False])
    assert resample(np.zeros(4), alive, 100, rng).sum() == 2
    drawn = sum(resample(np.zeros(4), alive, 100, rng) for _ in range(100))
    assert (drawn > 0).tolist() == alive.tolist()
    assert released._draw_counts(np.zeros(4), alive, np.arange(3), 100, rng).tolist() == [1, 0, 1, 0]
    experts = [Expert(relay)] * 3
    found = collect(relay, experts[0], experts, [0, 1, 2], range(5), lambda seen, state, acted: np.ones(acted.shape))
    assert (found.data.weights == found.data.alive).all()


def test_fidelity_counts_the_steps_that_agents_took(relay):
    """Agents who never do what the expert wants agree in no step, whatever it says of those who have left."""
    wrong = Policies([lambda seen: np.where(seen[:, PLACE] > 0, 0, 1)] * 3)
    left = Policies([lambda seen: np.full(len(seen), LEFT)] * 3)
    for controller in (wrong, left):
        found = collect(relay, Expert(relay), [controller] * 3, [0, 1, 2], range(5), lambda seen, state, acted: acted)
        assert found.fidelity == 0


@pytest.mark.parametrize(("name", "preset"), first_of(10, EVERY))
def test_nothing_is_learned_from_those_who_have_left(name, preset, monkeypatch):
    """No tree looks at whether an agent has left, or acts as the expert does then; and no tree depends on it."""
    trees = []
    for over in (1, 9):
        world = world_of(f"relay,over={over}")
        agent = {"agent": "runner_0"} if name == VIPER else {}
        found = extract(world, Expert(world), Settings.of({"algorithm": name, "preset": preset, **SMALL, **agent}))
        for policy in found.agents:
            assert OVER not in policy.tree.feature, policy.agent
            if name != FITTED_Q:  # it does not look at the expert's actions
                assert LEFT not in policy.tree.action, policy.agent
        trees.append(
            [(p.tree.feature.tolist(), p.tree.threshold.tolist(), p.tree.action.tolist()) for p in found.agents]
        )
    assert trees[0] == trees[1]


def test_a_pole_is_balanced_by_a_tree():
    """CartPole as a parallel environment of one agent; its expert is a line through the state."""
    world = world_of("cart_pole")

    class Balancing(Expert):
        def act(self, agents, observations, state):
            return np.stack([(observations[0] @ [0.05, 0.3, 3.0, 1.0] > 0).astype(int)], axis=1)

        def q(self, agent, observations, state, joint, given):
            wanted = self.act([0], observations, state)
            return (joint[None, :, 0] == wanted).astype(float)

    expert = Balancing(world)
    settings = Settings(max_depth=2, iterations=3, rollouts=6, selection_episodes=6)
    profile = extract(world, expert, settings)
    tree = Policies([lambda seen: ir.act(profile.agents[0], seen)])
    chance = Policies([lambda seen: np.arange(len(seen)) % 2])
    for controller in (expert, tree, chance):
        data = collect(world, expert, [controller], [0], range(6), lambda seen, state, acted: np.ones(acted.shape)).data
        returns = measures.values(world, [controller], range(6))
        assert len(data) == next(iter(returns.values())).sum() == data.alive.sum()
    assert next(iter(measures.values(world, [tree], range(6)).values())).mean() > 150


# --- weights


def everything_met(world):
    """All steps of some episodes, those after an agent's end among them."""
    parts = rollout(world, [Expert(world)] * 3, range(12))
    observations, states = zip(*(points(episodes) for episodes in parts), strict=True)
    seen = tuple(np.concatenate(each) for each in zip(*observations, strict=True))
    return seen, type(states[0]).concatenate(states), np.concatenate([each.alive.reshape(-1, 3) for each in parts])


def test_weights_are_the_papers_formula_among_those_in_play(relay):
    """E over the actions of opponents who act of [Q(expert's a_i) - min over a_i of Q]; nothing for who does not."""
    expert = Expert(relay)
    seen, state, alive = everything_met(relay)
    wanted = labels(expert, seen, state)
    found = maviper_weights(relay, expert, seen, state, wanted)
    teams = [[0, 1], [0, 1], [2]]
    expected = np.zeros(wanted.shape)
    for row, agent in np.argwhere(alive):
        opponents = [other for other in range(3) if other not in teams[agent] and alive[row, other]]
        one, total = [each[row : row + 1] for each in seen], 0.0
        for theirs in product(range(3), repeat=len(opponents)):
            joint = np.tile(wanted[row], (3, 1))
            joint[:, agent], joint[:, opponents] = np.arange(3), theirs
            q = expert.q(agent, one, state[row : row + 1], joint, wanted[row : row + 1])[0]
            total += q[wanted[row, agent]] - q.min()
        expected[row, agent] = total / 3 ** len(opponents)
    assert found == pytest.approx(expected, rel=1e-12)
    assert len({tuple(row) for row in alive}) >= 4  # none, one, the other and both runners have left


def test_critics_are_asked_about_those_in_play(relay):
    """By all ways to weigh. Who has left is in nobody's joint actions but as it is."""
    seen, state, alive = everything_met(relay)
    for weigh in (maviper_weights, released.weights):
        for name in ("maviper", "maviper-iviper-resampling"):
            expert = Expert(relay)
            wanted = labels(expert, seen, state)
            settings = Settings(algorithm=name)
            given = (relay, expert, seen, state, wanted)
            found = weigh(*given) if weigh is maviper_weights else weigh(relay, expert, settings, *given[2:])
            assert (found > 0).tolist() == alive.tolist()
            for agent, asked, joint in expert.asked:
                assert not asked[agent][:, OVER].any()
                out = [other for other in range(3) if asked[other][:, OVER].any()]
                assert name != "maviper" or (joint[:, out] == AS_GIVEN).all()
    expert = Expert(relay)
    found = np.stack([iviper_weights(relay, expert, seen, state, wanted, agent) for agent in range(3)], axis=1)
    assert (found > 0).tolist() == alive.tolist()
    assert not any(asked[agent][:, OVER].any() for agent, asked, _ in expert.asked)


# --- votes


def some_points(seed, n=150, members=3):
    rng = np.random.default_rng(seed)
    observations = [rng.normal(size=(n, 3)).astype(np.float32) for _ in range(members)]
    wanted = np.stack([(obs[:, 0] > 0) + 2 * (obs[:, 1] > 0.3) for obs in observations], axis=1)
    wanted = np.where(rng.random(wanted.shape) < 0.3, rng.integers(4, size=wanted.shape), wanted)
    alive = rng.random(wanted.shape) < 0.7
    alive[:, 0] |= ~alive.any(axis=1)
    counts = [rng.integers(0, 3, size=n) * column for column in alive.T]
    return observations, wanted, counts, alive


def by_released(observations, wanted, counts, alive):
    rng = np.random.default_rng(0)
    return released_grow.grow_team(observations, wanted, counts, [4] * len(counts), 3, rng, True, alive)


def by_cart(observations, wanted, counts, alive):
    return train_joint_trees(observations, wanted, counts, [4] * len(counts), 3, [0] * len(counts), None, alive)


def by_histogram(observations, wanted, counts, alive):
    world = SimpleNamespace(actions=[range(4)] * len(counts), outputs=(), continuous=False)
    data = Dataset(tuple(observations), wanted, np.ones(wanted.shape), alive)
    members = list(range(len(counts)))
    growth = Growth(world, Settings(splits=HISTOGRAM, max_depth=3))
    return growth.team(members, data, counts, [0] * len(counts), len(counts) - 1)


@pytest.mark.parametrize("grow", [by_cart, by_histogram, by_released])
@pytest.mark.parametrize("seed", first_of(2, range(5)))
def test_trees_do_not_depend_on_what_is_left_of_those_who_have_left(grow, seed):
    """Whatever they would observe and do: they are not predicted, and nobody learns it."""
    observations, wanted, counts, alive = some_points(seed)
    before = grow(observations, wanted, counts, alive)
    rng = np.random.default_rng(seed + 100)
    other = [
        np.where(column[:, None], obs, rng.normal(size=obs.shape).astype(np.float32))
        for obs, column in zip(observations, alive.T, strict=True)
    ]
    moved = np.where(alive, wanted, rng.integers(4, size=wanted.shape))
    for ours, theirs in zip(before, grow(other, moved, counts, alive), strict=True):
        assert all(np.array_equal(getattr(ours, part), getattr(theirs, part)) for part in ("feature", "threshold"))
        assert (ours.action == theirs.action).all()
    everybody = grow(observations, wanted, counts, np.ones_like(alive))
    assert any(a.threshold.tobytes() != b.threshold.tobytes() for a, b in zip(before, everybody, strict=True))


class Member:
    """A tree that predicts the labels 1, where it acts at all; keeps the points that it grows on."""

    def __init__(self, obs, labels, *rest):
        self.labels, self.kept = labels, []

    def check_predictions(self):
        return self.labels == 1

    right = check_predictions

    def build(self, keep):
        self.kept.append(keep.tolist())

    def grow(self, level, keep):
        self.build(keep)

    def tree(self):
        return self


def test_who_has_left_is_left_out_of_the_vote(monkeypatch):
    """Of those who act, all but one must be predicted right; in the released code more than half."""
    right = np.array([[1, 1, 0], [1, 0, 0], [1, 0, 1], [0, 1, 1], [0, 1, 1]])
    alive = np.array([[1, 1, 1], [1, 1, 1], [1, 1, 0], [1, 0, 0], [0, 1, 0]], dtype=bool)
    team = [Member(None, column) for column in right.T]
    for member in grow_jointly(team, 1, 2, alive):
        assert member.kept == [[True, False, True, True, True]]
    monkeypatch.setattr(released_grow, "_Growing", Member)
    rng = np.random.default_rng(0)
    for member in released_grow.grow_team([None] * 3, right, [None] * 3, [2] * 3, 0, rng, True, alive):
        assert member.kept == [[True, False, False, False, True]]


# --- what is counted


def test_shares_of_decisions_are_of_the_steps_that_agents_took(relay):
    """A tree that acts as the expert only where agents have left agrees nowhere; and it compares there too often."""
    feature, threshold = np.array([OVER, ir.NO_FEATURE, ir.NO_FEATURE]), np.array([0.5, 0, 0])
    children = np.array([1, ir.NO_CHILD, ir.NO_CHILD]), np.array([2, ir.NO_CHILD, ir.NO_CHILD])
    tree = ir.Tree(feature, threshold, *children, np.array([ir.NO_ACTION, 2, LEFT]))
    policies = [
        ir.AgentPolicy(agent, relay.team_of(agent), relay.features[k], relay.actions[k], tree)
        for k, agent in enumerate(relay.agents)
    ]
    expert = Expert(relay)
    contest = run.Contest(relay, [tree_policies(policies)] * 3, {"expert": [expert] * 3}, expert, policies)
    found = run.evaluate(contest, episodes=6)
    for facts in found.trees.values():
        assert facts.fidelity_own.value == facts.fidelity_expert.value == 0 and facts.comparisons.value == 1


def test_refinement_looks_at_the_steps_that_agents_took(relay):
    leaf = ir.GrownTree(*(np.array([value]) for value in (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, 1)))
    arena = Arena(relay, Expert(relay), [0, 1], range(50))
    arena.scores([[leaf, leaf]], 1)
    assert [len(seen) for seen in arena.seen] == steps_of(relay, [0])[:2].tolist()
    assert not any(seen[:, OVER].any() for seen in arena.seen)


def test_refinement_looks_at_all_episodes_though_few_are_played_at_once(relay, monkeypatch):
    leaf = ir.GrownTree(*(np.array([value]) for value in (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, 1)))
    arena = Arena(relay, Expert(relay), [0, 1], range(50))
    arena.scores([[leaf, leaf], [leaf, leaf]], 5)
    assert [len(seen) for seen in arena.seen] == steps_of(relay, range(5))[:2].tolist()
    monkeypatch.setattr(refine, "FIRST", 3)
    monkeypatch.setattr(refine, "LEAST_ROWS", 1_000)  # so that there is nothing to propose
    trees, values = refine.refine_once(arena, [leaf, leaf], [[], []], refine.Limits(3), np.random.default_rng(0))
    assert trees == [leaf, leaf] and values.tolist() == arena.values[0].tolist() and len(values) == 3


def test_q_ends_with_an_agent_that_leaves_and_goes_on_after_a_cut(relay):
    """Fitted Q, 1 per step: who leaves after four steps at most gains no more than four of them; a cut is no end."""
    played = rollout(relay, [Expert(relay)] * 3, range(40))
    runner, chaser = (baselines._Agent(relay, agent, played, Settings(max_depth=6)) for agent in (0, 2))
    assert len(runner.seen) == steps_of(relay, range(40))[0] and (~runner.goes_on).sum() == 40
    assert chaser.goes_on.all() and len(chaser.seen) == 40 * 8
    for agent in (runner, chaser):
        for _ in range(8):
            agent.round()
    worth = [agent.tree.predict(agent._inputs(agent.seen, agent.acted)).max() for agent in (runner, chaser)]
    assert worth[0] <= 1 + 0.95 + 0.95**2 + 0.95**3 and worth[1] > 6


# --- training

TRAINED = {
    "mappo": {"steps": 60, "minibatch": 20, "epochs": 2},
    "maddpg": {"steps": 60, "batch": 8, "steps_per_update": 4},
    "vdn": {"steps": 60, "batch": 8, "steps_per_update": 4},
}


def trainer_of(name, text, **more):
    from maviper.experts.training import train

    kind = train._trainer(name)
    chosen = kind.settings(**{"games": 1, "hidden": 8, "seed": 1, **TRAINED[name], **more})
    return kind.trainer(world_of(text), chosen, "cpu")


def critic_of(text, **more):
    """The fit of a critic to random actors."""
    from maviper.experts.training import off_policy
    from maviper.experts.training.nets import Joint, Nets

    world = world_of(text)
    joint, generator = Joint(world, "cpu"), __import__("torch").Generator().manual_seed(0)
    actor = Nets((joint.widest, 8, 8, joint.n_actions), joint.widths, generator, "cpu")
    settings = off_policy.CriticSettings(**{"steps": 120, "games": 1, "updates": 2, "batch": 32, "hidden": 16, **more})
    return off_policy.CriticFit(world, joint.export_actors(actor), settings, "cpu")


def trained(trainer):
    while trainer.steps < trainer.settings.steps:
        trainer.advance()
    return {name: weights.tobytes() for name, weights in trainer.tensors().items()}


@pytest.mark.train
@pytest.mark.parametrize("name", [*TRAINED, "critic"])
def test_experts_and_critics_do_not_see_what_follows_an_end(name):
    """What an agent observes at its end, and gains afterwards, is in none of what is learned."""
    make = critic_of if name == "critic" else lambda text: trainer_of(name, text)
    assert trained(make("alone")) == trained(make("alone,over=9"))
    if name == "vdn":  # the others learn from what all observe
        assert trained(make("relay")) == trained(make("relay,over=9"))


@pytest.mark.train
@pytest.mark.parametrize("name", ["maddpg", "vdn", "critic"])
def test_only_steps_that_somebody_takes_are_kept(name):
    for text in ("alone", "relay"):
        trainer = critic_of(text) if name == "critic" else trainer_of(name, text)
        trainer.advance()
        steps, kept = 3 if text == "alone" else 8, trainer.replay
        assert trainer.steps == kept.filled == steps
        over = kept.columns["seen"][: kept.filled, OVER:-1:3] > 0
        assert ((kept.columns["alive"][: kept.filled] == 1) == ~over).all()
        ends = (kept.columns["alive"] - kept.columns["goes_on"])[: kept.filled].sum(dim=0).tolist()
        assert ends == ([1] if text == "alone" else [1, 1, 0])  # the chaser is cut
        assert trainer.running.count.tolist() == kept.columns["alive"].sum(dim=0).tolist()
        assert trainer.running.scale()[0].tolist() == [0] * len(ends)  # or who leaves would lose, or gain, the mean
        assert trainer.running.scale()[1].tolist() == [1] * len(ends)


@pytest.mark.train
def test_a_critic_of_those_who_leave_is_right():
    """1 per step for three steps: what is left is worth 1 + 0.95 + 0.95^2, 1 + 0.95 and 1, whatever is done."""
    from maviper.experts.training.nets import torch

    fit = critic_of("alone", steps=600, updates=8, learning_rate=1e-2, tau=0.1)
    trained(fit)
    seen = torch.tensor([[0.0, time, 0, 0] for time in range(3)])
    for action in range(3):
        acted = fit.joint.one_hot(torch.full((3, 1), action))
        worth = fit.critic(fit.joint.critic_input(seen, acted))[0, :, 0].tolist()
        assert worth == pytest.approx([1 + 0.95 + 0.95**2, 1.95, 1], abs=0.15)


@pytest.mark.train
def test_advantages_stop_at_an_agents_end():
    """Written out for one agent in three games: to the last step, ended by itself after two, cut after two."""
    from maviper.experts.training.nets import torch

    trainer = trainer_of("mappo", "alone")
    rewards, values = torch.rand(1, 3, 3), torch.rand(1, 4, 3)
    alive = torch.tensor([[[1.0, 1, 1], [1, 1, 1], [1, 0, 0]]])
    goes_on = torch.tensor([[[1.0, 1, 1], [1, 0, 1], [1, 0, 0]]])
    found = trainer._advantages(rewards, values, alive, goes_on)
    gamma, trace = trainer.settings.gamma, trainer.settings.trace
    for game, steps in enumerate((3, 2, 2)):
        for first in range(steps):
            expected = 0.0
            for step in range(first, steps):
                later = 0.0 if (game, step) == (1, 1) else gamma * float(values[0, step + 1, game])
                surprise = float(rewards[0, step, game]) + later - float(values[0, step, game])
                expected += (gamma * trace) ** (step - first) * surprise
            assert float(found[0, first, game]) == pytest.approx(expected, rel=1e-5)
