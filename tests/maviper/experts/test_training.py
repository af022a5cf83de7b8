"""Training: every algorithm learns, repeats, resumes to the same bytes, and stops with an error that helps."""

import json
import re
import sys
from dataclasses import replace
from types import FunctionType

import numpy as np
import pytest

from codegen.errors import InputError, MissingToolError, UnknownNameError
from maviper.cli import main
from maviper.episodes import measures
from maviper.experts import cards, network
from maviper.experts import scripted as scripts
from maviper.experts.cards import Request, settings
from maviper.experts.expert import AS_GIVEN
from maviper.experts.training.train import train
from maviper.worlds import WORLDS, find

TINY = {"games": 128, "checkpoint_steps": 6_400, "steps": 19_200, "hidden": 16}
ALGORITHMS = {
    "mappo": {**TINY, "minibatch": 1_600},
    "maddpg": {**TINY, "steps_per_update": 400, "batch": 512},
    "vdn": {**TINY, "steps_per_update": 400, "batch": 512},
}


@pytest.fixture(autouse=True)
def quick(request, monkeypatch):
    """Fewer episodes a judgement, a short fit of the critic."""
    if not request.node.get_closest_marker("train"):
        return
    from maviper.experts.training import off_policy
    from maviper.experts.training import train as training

    monkeypatch.setattr(training, "CHECKPOINT_EPISODES", 50)
    monkeypatch.setattr(training, "FINAL_EPISODES", 50)
    whole = off_policy.CriticSettings
    quick_fit = {"steps": 6_400, "games": 128, "updates": 4}
    monkeypatch.setattr(off_policy, "CriticSettings", lambda **given: whole(**{**quick_fit, **given}))


FILES = ("expert.safetensors", "metrics.jsonl", "config.json", "learning_curve.svg")


def request_of(algorithm, **more):
    return Request(algorithm, overrides={**ALGORITHMS[algorithm], "seed": 3, **more})


@pytest.mark.train
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", ["physical-deception", "cooperative-navigation,agents=2", "predator-prey,prey=1"])
def test_every_algorithm_trains_every_game(name, algorithm, tmp_path):
    world = find(name)
    seen = []
    card = train(world, tmp_path, request_of(algorithm), lambda checkpoint, total: seen.append(checkpoint))
    loaded, played = network.load(str(tmp_path))
    assert played.name == name and {**card, **loaded.card} == card
    assert [checkpoint.steps for checkpoint in seen] == [6_400, 12_800, 19_200]
    lines = [json.loads(line) for line in (tmp_path / "metrics.jsonl").read_text().splitlines()]
    assert [line["steps"] for line in lines] == [checkpoint.steps for checkpoint in seen]
    assert all(f"{team} return" in line for line in lines for team in world.teams)
    observations = world.observe(world.start(4, np.random.default_rng(0)))
    given = loaded.act(range(len(world.agents)), observations)
    joint = np.full((1, len(world.agents)), AS_GIVEN)
    assert np.isfinite(loaded.q(0, observations, None, joint, given)).all()


@pytest.mark.train
@pytest.mark.parametrize(
    ("name", "algorithm", "more"),
    [
        ("physical-deception", "mappo", {}),
        ("physical-deception", "mappo", {"imitate_steps": 9_600, "value_steps": 3_200}),
        ("predator-prey,prey=1", "mappo", {"past": 0.25}),
        ("predator-prey", "mappo", {"past": 0.25, "against": 0.125, "scaled": 1}),
        ("physical-deception", "maddpg", {"scaled": 1}),
        ("physical-deception", "vdn", {}),
    ],
)
def test_a_resumed_run_gives_the_same_bytes(name, algorithm, more, tmp_path):
    """Stopped in the middle of a checkpoint's interval, right after it, and in the middle of writing."""
    world = find(name)
    met = ("predator-prey", "predator-prey,observation=mpe2") if "against" in more else ()
    asked = replace(request_of(algorithm, **more), against=met)
    train(world, tmp_path / "whole", asked)
    for stop in (1, 2):

        class Killed(Exception):
            pass

        def kill(checkpoint, total, stop=stop):
            if checkpoint.steps == 6_400 * stop:
                raise Killed

        folder = tmp_path / f"cut {stop}"
        with pytest.raises(Killed):
            train(world, folder, asked, kill)
        # an interruption between two files: metrics are ahead of the state
        with (folder / "metrics.jsonl").open("a") as file:
            file.write(json.dumps({"steps": 10**9, "score": 9.0}) + "\n")
        train(world, folder, asked, resume=True)
        for file in FILES:
            assert (folder / file).read_bytes() == (tmp_path / "whole" / file).read_bytes(), file


def raising(*args, **kwargs):
    raise AssertionError("a script was asked")


def without_scripts(monkeypatch):
    """Every function of scripted.py raises, under whatever name a module has imported it."""
    own = [each for each in vars(scripts).values() if getattr(each, "__module__", "") == scripts.__name__]
    for each in own:
        if isinstance(each, FunctionType):
            monkeypatch.setattr(each, "__code__", raising.__code__)
            continue
        for name, inside in list(vars(each).items()):
            if isinstance(inside, (FunctionType, property)):
                monkeypatch.setattr(each, name, raising)
    with pytest.raises(AssertionError, match="a script was asked"):
        scripts.build_script(find("physical-deception"))


@pytest.mark.train
@pytest.mark.parametrize("name", ["physical-deception", "cooperative-navigation", "predator-prey"])
def test_no_script_takes_part_in_the_default_recipe(name, tmp_path, monkeypatch):
    world, tiny = find(name), {key: value for key, value in ALGORITHMS["mappo"].items() if key != "hidden"}
    asked = Request("mappo", overrides={**tiny, "hidden": 8, "seed": 3})
    train(world, tmp_path / "a", asked)
    without_scripts(monkeypatch)
    train(world, tmp_path / "b", asked)
    for file in FILES:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes(), file
    with pytest.raises(AssertionError, match="a script was asked"):
        train(world, tmp_path / "c", replace(asked, recipe="clone"))


@pytest.mark.train
def test_a_finished_run_is_not_trained_again(tmp_path):
    world, asked = find("physical-deception"), request_of("mappo")
    card = train(world, tmp_path, asked)
    before = (tmp_path / "expert.safetensors").stat().st_mtime_ns
    assert train(world, tmp_path, asked, resume=True) == card
    assert (tmp_path / "expert.safetensors").stat().st_mtime_ns == before
    with pytest.raises(InputError, match="already holds a run"):
        train(world, tmp_path, asked)
    with pytest.raises(InputError, match="hidden differ"):
        train(world, tmp_path, request_of("mappo", hidden=8), resume=True)
    with pytest.raises(InputError, match=r"world.* differ"):
        train(find("predator-prey"), tmp_path, asked, resume=True)


@pytest.mark.train
def test_bad_folders_and_devices_are_refused(tmp_path):
    world, asked = find("physical-deception"), request_of("mappo")
    with pytest.raises(InputError, match="no run to resume"):
        train(world, tmp_path / "none", asked, resume=True)
    with pytest.raises(InputError, match="no device 'cuda:99'"):
        train(world, tmp_path / "a", Request("mappo", overrides=ALGORITHMS["mappo"], device="cuda:99"))
    with pytest.raises(InputError, match="no device 'toaster'"):
        train(world, tmp_path / "a", Request("mappo", overrides=ALGORITHMS["mappo"], device="toaster"))

    def stop(checkpoint, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(world, tmp_path / "a", asked, stop)
    assert network.load(str(tmp_path / "a"))[1].name == world.name  # what an interruption leaves is an expert
    state = (tmp_path / "a" / "state.safetensors").read_bytes()
    for bad in (state[:-7], b"", state[:100]):
        (tmp_path / "a" / "state.safetensors").write_bytes(bad)
        with pytest.raises(InputError, match="damaged, or belongs to another run"):
            train(world, tmp_path / "a", asked, resume=True)
    (tmp_path / "a" / "config.json").write_text("{")
    with pytest.raises(InputError, match="not a readable run folder"):
        train(world, tmp_path / "a", asked, resume=True)


@pytest.mark.train
def test_a_loss_that_is_no_number_stops_with_the_last_good_checkpoint(tmp_path, monkeypatch):
    from maviper.experts.training.mappo import Mappo

    advance = Mappo.advance

    def failing(self):
        logged = advance(self)
        return logged | ({"loss": float("nan")} if self.steps > 12_800 else {})

    monkeypatch.setattr(Mappo, "advance", failing)
    card = train(find("physical-deception"), tmp_path / "a", request_of("mappo"))
    assert "no longer a number" in card["stopped"] and card["steps"] in (6_400, 12_800)
    assert network.load(str(tmp_path / "a"))[0].card["stopped"] == card["stopped"]
    monkeypatch.setattr(Mappo, "advance", lambda self: advance(self) | {"loss": float("nan")})
    with pytest.raises(InputError, match="lower learning rate"):
        train(find("physical-deception"), tmp_path / "b", request_of("mappo"))


@pytest.mark.train
def test_imitation_and_scripted_opponents(tmp_path):
    """The networks come to do what the script does, and agents that the script plays are not learned from."""
    from maviper.experts.training.mappo import Mappo, Settings

    world = find("physical-deception,velocity=1")
    trainer = Mappo(world, Settings(**{**TINY, "steps": 10**6, "imitate_steps": 10**6}), "cpu")
    agreed = [trainer.advance()["fidelity"] for _ in range(12)]
    assert agreed[-1] > 0.5 > agreed[0]

    world = find("predator-prey")
    for share in ({"scripted": 0.25}, {"past": 0.25}):
        trainer = Mappo(world, Settings(**TINY, **share), "cpu")
        assert trainer.mine.sum(axis=1).tolist() == [96, 96, 96, 96]
        assert not trainer.mine[2:, :32].any() and not trainer.mine[:2, 32:64].any() and trainer.mine[:, 64:].all()
        seen, acted, *_ = trainer._collect()
        assert acted.shape == (25, 128, 4) and len(seen) == 26
    with pytest.raises(InputError, match="more games than there are"):
        Mappo(world, Settings(**TINY, past=0.25, scripted=0.3), "cpu")


@pytest.mark.train
def test_experts_are_met_in_their_share_of_games_and_are_not_learned_from(monkeypatch):
    """Each team meets them in a quarter of the games, on top of its own past; one that sees more sees for itself."""
    from maviper.experts.training import mappo
    from maviper.experts.training.mappo import Mappo, Settings

    world, names = find("predator-prey"), ("predator-prey", "predator-prey,observation=mpe2")
    trainer = Mappo(world, Settings(**TINY, past=0.25, against=0.25), "cpu")
    trainer.meet(list(mappo.by_reward_alone(world, names).values()))
    assert trainer.mine.sum(axis=1).tolist() == [64] * 4
    assert not trainer.mine[2:, 64:96].any() and not trainer.mine[:2, 96:].any()
    _, met = trainer.meetings
    for index, name in enumerate(names):
        monkeypatch.setattr(trainer, "rng", np.random.default_rng(5))
        monkeypatch.setattr(met.opponents, "begin", lambda progress: None)
        met.opponents.drawn = met.opponents.experts[index]
        played = trainer._collect()
        expert, theirs = network.load(name)
        state = world.start(128, np.random.default_rng(5))
        for acted in played.acted:
            wanted = expert.act(range(4), theirs.observe(state), state)
            assert (acted == wanted)[met.theirs.T].all() and (acted != wanted)[trainer.mine.T].any()
            state = world.step(state, acted)


@pytest.mark.train
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("predator-prey@clone", "learned from a script"),
        ("physical-deception", "another game"),
        ("predator-pray", "predator-prey"),
    ],
)
def test_only_what_learned_by_reward_alone_is_met(name, said, tmp_path):
    with pytest.raises((InputError, UnknownNameError), match=said):
        train(find("predator-prey"), tmp_path, replace(request_of("mappo"), against=(name,)))


@pytest.mark.train
def test_the_card_names_the_experts_that_were_met(tmp_path):
    name = "predator-prey,observation=mpe2@0"
    card = train(find("predator-prey"), tmp_path / "a", replace(request_of("mappo"), against=(name,)))
    assert card["against"] == {name: network.load(name)[0].hash} and card["command"].endswith(f" --against {name}")
    with pytest.raises(InputError, match="against differ"):
        train(find("predator-prey"), tmp_path / "a", request_of("mappo"), resume=True)
    with pytest.raises(InputError, match="meets no experts"):
        train(find("predator-prey"), tmp_path / "b", replace(request_of("vdn"), against=(name,)))


@pytest.mark.train
def test_earlier_actors_are_kept_as_they_were_and_played_as(monkeypatch):
    from maviper.experts.training.mappo import Mappo, Settings

    trainer = Mappo(find("predator-prey"), Settings(**{**TINY, "steps": 38_400}, past=0.5), "cpu")
    first = [parameter.detach().clone() for parameter in trainer.actor.parameters]
    for _ in range(4):
        trainer.advance()
    (past,) = trainer.meetings
    kept = past.opponents.versions
    assert len(kept) == 4  # fewer steps than versions: each batch begins with one
    assert all((a == b).all() for a, b in zip(kept[0], first, strict=True))
    assert any((a != b).any() for a, b in zip(kept[1], kept[0], strict=True))
    sure = [torch_zeros(parameter) for parameter in first]
    sure[-1][..., 3] = 1e6  # the last bias: an actor that always takes action 3
    past.opponents.versions = [sure]
    monkeypatch.setattr(past.opponents, "begin", lambda progress: None)
    past.opponents.drawn = 0
    acted = trainer._collect().acted
    assert (acted[:, ~trainer.mine.T] == 3).all() and (acted[:, trainer.mine.T] != 3).any()


def torch_zeros(like):
    import torch

    return torch.zeros_like(like)


class Always:
    """Everybody takes one action."""

    def __init__(self, action):
        self.action = action

    def act(self, agents, observations, state):
        return np.full((len(observations[0]), len(agents)), self.action)


def test_rivals_rate_a_checkpoint_by_what_it_gains_on_them():
    """Touches of predators a and prey b, written out: a gains on b what b loses."""
    world, seeds = find("predator-prey"), range(7_000_000, 7_000_200)
    still, script = Always(0), scripts.build_script(world)

    def touches(predators, prey):
        lineup = [predators if agent in world.members("predators") else prey for agent in range(4)]
        found = measures.evaluate(world, lineup, seeds)
        return found[world.primary("predators")].value

    gain = touches(script, still) - touches(still, script)
    assert cards.is_rated(world) and gain > 1
    assert cards.advantage(world, script, still, seeds) == pytest.approx(gain)
    assert cards.judge(world, script, seeds).score == 0.0
    rivals = [cards.Rival(still, 2.0), cards.Rival(script, 5.0)]
    assert cards.judge(world, script, seeds, rivals).score == pytest.approx((2.0 + gain + 5.0) / 2)
    low, high, middle = cards.scores(world, [still, script, Always(0)], seeds)
    assert (low, high, middle) == pytest.approx((-gain / 2, gain, -gain / 2))


@pytest.mark.parametrize("name", ["physical-deception", "cooperative-navigation,agents=2"])
def test_shares_and_a_single_team_are_judged_among_themselves(name):
    world, seeds = find(name), range(7_000_000, 7_000_200)
    assert not cards.is_rated(world)
    script, still = scripts.build_script(world), Always(0)
    better, worse = cards.scores(world, [script, still], seeds)
    assert better > worse and better == cards.judge(world, script, seeds, [cards.Rival(still, 9.0)]).score


@pytest.mark.parametrize("name", [name for name in WORLDS if find(name).shaped])
def test_shaping_does_not_change_when_team_mates_or_landmarks_are_permuted(name):
    """Whoever is paid is told apart by the world's roles alone: not by an agent's number, nor by a landmark's."""
    world = find(name)
    rng = np.random.default_rng(5)
    n_agents, n_landmarks = len(world.agents), len(world.spec.landmarks)
    state = world.start(40, rng)
    for _ in range(6):
        state = world.step(state, rng.integers(5, size=(40, n_agents)))
    order = list(range(n_agents))
    for team in world.teams:
        members = world.members(team)
        for place, agent in zip(members, members[1:] + members[:1], strict=True):
            order[place] = agent
    marks = [*range(1, n_landmarks), 0]
    places = [*order, *(n_agents + mark for mark in marks)]
    goal = np.array([marks.index(mark) for mark in state.goal])
    moved = type(state)(state.position[:, places], state.velocity[:, order], goal)
    assert world.shaping(moved) == pytest.approx(world.shaping(state)[:, order], rel=1e-9, abs=1e-12)
    assert np.abs(world.shaping(state)).max() > 0


@pytest.mark.train
@pytest.mark.parametrize("recipe", ["default", "paper"])
def test_a_training_says_what_it_plays_and_does_that(recipe, tmp_path, capsys):
    chosen = ["games=128", "checkpoint_steps=6400", "hidden=8", "batch=256", "steps_per_update=800"]
    given = [word for setting in chosen for word in ("--set", setting)]
    asked = ["train", "physical-deception", "--algorithm", "maddpg", "--recipe", recipe, "--steps", "12800", *given]
    assert main.run([*asked, "-o", str(tmp_path)]) == 0
    said = capsys.readouterr().err.replace(",", "")
    found = re.search(r"(\d+) steps in (\d+) parallel games a checkpoint every (\d+)", said)
    steps = [json.loads(line)["steps"] for line in (tmp_path / "metrics.jsonl").read_text().splitlines()]
    settings = json.loads((tmp_path / "config.json").read_text())["settings"]
    assert found and [int(number) for number in found.groups()] == [steps[-1], settings["games"], steps[1] - steps[0]]
    assert ("released: one game" in said) == (recipe == "paper") == ("; batch 256 (recipe: 25600)" in said)
    assert "shaping 0" not in said
    assert found[0] in json.loads((tmp_path / "card.json").read_text())["schedule"].replace(",", "")


@pytest.mark.train
@pytest.mark.parametrize("learned", [(6_400, 3_200, 9_600), (5_000, 1_000, 2_025)], ids=["whole batches", "parts"])
def test_the_card_counts_what_taught_the_expert(learned, tmp_path, monkeypatch):
    """Counted here by what is played: rounds of imitation, episodes of the learner's own, those for the critic."""
    from maviper.experts.training.mappo import Imitation, Mappo
    from maviper.experts.training.off_policy import CriticFit

    played = {"imitation": 0, "own": 0, "critic": 0}
    imitate, collect = Imitation.round, Mappo._collect

    def imitating(self, games, *rest):
        played["imitation"] += games * 25
        return imitate(self, games, *rest)

    def collecting(self):
        found = collect(self)
        played["own"] += found.acted.shape[0] * found.acted.shape[1]
        return found

    monkeypatch.setattr(Imitation, "round", imitating)
    monkeypatch.setattr(Mappo, "_collect", collecting)
    rewards = CriticFit.rewards

    def paid(self, state):
        played["critic"] += len(state)
        return rewards(self, state)

    monkeypatch.setattr(CriticFit, "rewards", paid)
    wanted = dict(zip(("imitation", "values alone", "reward"), learned, strict=True))
    asked = request_of("mappo", steps=sum(learned), imitate_steps=learned[0], value_steps=learned[1])
    card = train(find("physical-deception"), tmp_path, asked)
    last = json.loads((tmp_path / "metrics.jsonl").read_text().splitlines()[-1])
    assert played == {"imitation": learned[0], "own": learned[1] + learned[2], "critic": card["played"]["critic"]}
    assert last["learned"] == wanted and card["played"]["training"] == last["steps"] == sum(learned)
    assert sum(card["learned"].values()) == card["steps"] and network.load(str(tmp_path))[0].card["learned"]


@pytest.mark.train
@pytest.mark.parametrize("algorithm", ["maddpg", "vdn"])
def test_as_many_steps_are_played_as_are_asked_for(algorithm, tmp_path):
    """The last batch has fewer games: 5,000 steps are one whole one of 3,200 and 72 episodes."""
    card = train(find("physical-deception"), tmp_path, request_of(algorithm, steps=5_000))
    assert card["played"] == {"training": 5_000} and card["steps"] == 5_000


@pytest.mark.train
def test_every_stage_of_a_training_shows_how_far_it_is(tmp_path):
    steps = []
    asked = request_of("mappo", imitate_steps=6_400, value_steps=3_200)
    train(find("physical-deception"), tmp_path, asked, on_step=steps.append)
    ends = {step.stage: (step.done, step.total) for step in steps}
    assert ends == {
        "imitation": (6_400, 6_400), "values alone": (0, 3_200), "reward": (9_600, 9_600),
        "choosing": (3, 3), "critic": (6_400, 6_400),
    }  # fmt: skip
    assert [step.done for step in steps if step.stage == "imitation"] == [0, 3_200, 6_400]
    assert "fidelity" in steps[1].said and "loss" in steps[-1].said


@pytest.mark.train
@pytest.mark.parametrize(("share", "said"), [(1, "environment + 2 * shaping"), (0, "environment")])
def test_critics_are_fitted_to_the_reward_that_the_card_names(share, said, tmp_path, monkeypatch):
    from maviper.experts.training.off_policy import CriticFit

    world = find("physical-deception")
    gap = []
    rewards = CriticFit.rewards

    def paid(self, state):
        found = rewards(self, state)
        gap.append(np.abs(found - world.rewards(state)).max())
        return found

    monkeypatch.setattr(CriticFit, "rewards", paid)
    sizes = {**ALGORITHMS["mappo"], "steps": 6_400, "shaping": 2, "critic_shaping": share}
    card = train(world, tmp_path, Request("mappo", overrides=sizes))
    assert card["critic_reward"] == said and (max(gap) > 0) == bool(share) and len(gap) >= 25


@pytest.mark.train
def test_several_seeds_keep_the_best(tmp_path, capsys):
    from maviper.console import Console
    from maviper.experts.training.train import train_expert

    chosen = {name: value for name, value in ALGORITHMS["vdn"].items() if name != "steps"}
    asked = {"algorithm": "vdn", "seed": 5, "seeds": 2, "steps": 12_800, "settings": chosen}
    card = train_expert("physical-deception", tmp_path, Console(), **asked)
    assert "stopped" not in card
    said = capsys.readouterr().err
    assert all(re.search(rf"^seed {seed} +reward 12800/12800", said, re.MULTILINE) for seed in (5, 6))
    table = json.loads((tmp_path / "seeds.json").read_text())
    scores = {seed: row["score"] for seed, row in table["seeds"].items()}
    assert set(scores) == {"5", "6"} and scores[str(table["best"])] == max(scores.values())
    best = tmp_path / f"seed-{table['best']}" / "expert.safetensors"
    assert (tmp_path / "expert.safetensors").read_bytes() == best.read_bytes()
    assert "stopped" not in train_expert("physical-deception", tmp_path, Console(quiet=True), **asked, resume=True)


@pytest.mark.train
@pytest.mark.parametrize("name", ["physical-deception", "predator-prey,observation=mpe2"])
def test_numpy_and_torch_networks_agree(name):
    import torch

    from maviper.experts.training.off_policy import Maddpg, MaddpgSettings

    world = find(name)
    n_agents = len(world.agents)
    trainer = Maddpg(world, MaddpgSettings(buffer=1_000), "cpu")
    expert = network.decode(network.encode(trainer.tensors(), {"world": world.name, "hidden": 64}), "x")
    observations = world.observe(world.start(64, np.random.default_rng(0)))
    acted = np.random.default_rng(1).integers(5, size=(64, n_agents))
    joint = trainer.joint.tensor(observations)
    with torch.no_grad():
        logits = trainer._logits("actor", joint).numpy()
        one_hot = trainer.joint.one_hot(torch.from_numpy(acted))
        q = trainer.nets["critic"](trainer.joint.critic_input(joint, one_hot)).numpy()[..., 0]
    assert (logits.argmax(axis=2) == expert.act(range(n_agents), observations).T).all()
    for agent in range(n_agents):
        asked = expert.q(agent, observations, None, np.full((1, n_agents), AS_GIVEN), acted)[:, 0]
        assert asked == pytest.approx(q[agent], rel=1e-4, abs=1e-5)


@pytest.mark.train
def test_a_fitted_critic_predicts_the_returns_of_the_frozen_policy():
    """Against measured Q: the order of one agent's actions, and the spread over states, agree."""
    from scipy.stats import spearmanr

    from maviper.experts.expert import Measured
    from maviper.experts.training.off_policy import CriticSettings, fit_critic

    world = find("physical-deception")
    expert = network.load("physical-deception")[0]
    actors = {name: tensor for name, tensor in expert.tensors.items() if ".actor." in name}
    chosen = CriticSettings(steps=76_800, games=512, updates=60, hidden=32, learning_rate=4e-3, explore=0.3)
    fitted = network.build_expert(world, {**actors, **fit_critic(world, actors, chosen, "cpu")}, {})
    state = world.start(150, np.random.default_rng(4))
    observations = world.observe(state)
    given = expert.act(range(3), observations)
    joint = np.array([[AS_GIVEN, k, AS_GIVEN] for k in range(5)])
    wanted = Measured(world, fitted, shaping=1.0, horizon=20).q(1, observations, state, joint, given)
    found = fitted.q(1, observations, state, joint, given)
    assert spearmanr(found.ravel(), wanted.ravel()).statistic > 0.8


@pytest.mark.train
@pytest.mark.filterwarnings("ignore:`torch.jit")  # deprecated by torch, and what many experts still lie in
def test_torch_modules_and_torchscript_are_experts(world, expert, tmp_path, monkeypatch):
    import torch

    from maviper.experts.adapter import TorchExpert
    from maviper.experts.finding import find_expert

    def module(agent, net):
        layers = []
        for layer in (1, 2, 3):
            weight, bias = (torch.from_numpy(expert.tensors[f"{agent}.{net}.{layer}.{k}"]) for k in ("weight", "bias"))
            linear = torch.nn.Linear(*weight.shape)
            linear.weight.data, linear.bias.data = weight.T.contiguous(), bias
            layers += [linear, torch.nn.ReLU()]
        return torch.nn.Sequential(*layers[:-1])

    class Critic(torch.nn.Module):
        def __init__(self, body):
            super().__init__()
            self.body = body

        def forward(self, seen, acted):
            return self.body(torch.cat([seen, acted], dim=1))

    actors = [module(agent, "actor") for agent in world.agents]
    critics = [Critic(module(agent, "critic")) for agent in world.agents]
    state = world.start(30, np.random.default_rng(0))
    observations = world.observe(state)
    given = expert.act(range(3), observations)
    joint = np.array([[0, AS_GIVEN, 3], [4, AS_GIVEN, 1]])
    examples = torch.zeros(2, sum(len(f) for f in world.features)), torch.zeros(2, 15)
    scripts = [torch.jit.trace(critic, examples) for critic in critics]
    for found in (TorchExpert(world, actors, critics), TorchExpert(world, actors, scripts)):
        assert (found.act(range(3), observations, state) == given).all()
        for agent in range(3):
            wanted = expert.q(agent, observations, state, joint, given)
            assert found.q(agent, observations, state, joint, given) == pytest.approx(wanted, rel=1e-4, abs=1e-4)
    valued = TorchExpert(world, actors, value_based=True)
    assert valued.q(1, observations, state, np.full((1, 3), AS_GIVEN), given).shape == (30, 1)
    with pytest.raises(InputError, match="has no critic"):
        TorchExpert(world, actors).q(0, observations, state, joint, given)
    with pytest.raises(InputError, match="2 actors for 3 agents"):
        TorchExpert(world, actors[:2])
    with pytest.raises(InputError, match="torch module failed"):
        TorchExpert(world, actors[::-1])
    with pytest.raises(InputError, match=r"returns shape \(2, 4\)"):
        TorchExpert(world, [torch.nn.Linear(8, 4), *actors[1:]])

    (tmp_path / "brought_along.py").write_text("EXPERT = None\n\n\ndef expert():\n    return EXPERT\n")
    monkeypatch.syspath_prepend(tmp_path)
    import brought_along

    brought_along.EXPERT = TorchExpert(world, actors, critics)
    assert find_expert("brought_along:expert")[1] is world


def test_training_without_torch_says_what_to_install(world, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(MissingToolError, match=r"maviper\[train\]"):
        train(world, tmp_path, Request())


def test_settings_come_from_recipe_and_user(world):
    from dataclasses import dataclass

    @dataclass(frozen=True)
    class Some:
        steps: int = 1_000_000
        games: int = 10
        learning_rate: float = 0.1
        imitate_steps: int = 0
        hidden: int = 64
        shared: int = 0
        epochs: int = 4
        minibatch: int = 6_400
        checkpoint_steps: int = 102_400
        entropy: float = 0.0
        scripted: float = 0.0
        seed: int = 0

    found = settings(find("cooperative-navigation,agents=4"), Request(overrides={"games": "20"}).complete(), Some)
    assert found.games == 20 and found.shared == 1  # the game's recipe also where its options differ
    cloned = Request(recipe="clone").complete()
    assert settings(find("cooperative-navigation,agents=4"), cloned, Some).imitate_steps == 2_048_000
    with pytest.raises(UnknownNameError, match="did you mean 'learning_rate'"):
        settings(world, Request(overrides={"learning_rat": 1}).complete(), Some)
    with pytest.raises(InputError, match="must be a whole number"):
        settings(world, Request(overrides={"games": "many"}).complete(), Some)
    with pytest.raises(InputError, match="games must be from 1"):
        settings(world, Request(overrides={"games": 0}).complete(), Some)
    with pytest.raises(InputError, match="shared must be from 0 to 1, not 2") as caught:
        settings(world, Request(overrides={"shared": "2"}).complete(), Some)
    assert caught.value.where == "--set shared"
    for odd in (0.5, float("inf"), float("nan")):
        with pytest.raises(InputError, match="must be a whole number"):
            settings(world, Request(overrides={"shared": odd}).complete(), Some)
    with pytest.raises(InputError, match="steps must be at least 250"):
        settings(world, Request(overrides={"steps": 249}).complete(), Some)
    with pytest.raises(InputError, match="seed"):
        settings(world, Request(overrides={"seed": 2**32}).complete(), Some)


def test_recipes_and_the_algorithms_that_they_are_for():
    with pytest.raises(InputError, match="no recipe for vdn"):
        Request("vdn", "paper").complete()
    with pytest.raises(InputError, match="vdn cannot imitate"):
        Request("vdn", "clone").complete()
    assert Request(recipe="paper").complete().algorithm == "maddpg"
    assert Request(recipe="clone").complete().algorithm == "mappo"
