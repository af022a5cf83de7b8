"""Zips of stable-baselines3: the same actions as the library's, nothing pickled opened, and refusals that say why."""

import base64
import io
import json
import pickle
import re
import shlex
import zipfile
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.cli import main
from maviper.experts import from_sb3
from maviper.experts.finding import find_expert
from maviper.experts.foreign.layers import Normalization
from maviper.worlds import find
from tests.support.zips import changed, data_of

pytestmark = [pytest.mark.interop, pytest.mark.train]
sb3 = pytest.importorskip("stable_baselines3")
torch = pytest.importorskip("torch")
CARTPOLE = "gymnasium:CartPole-v1"
KINDS = {
    "PPO": {"n_steps": 64, "batch_size": 64, "n_epochs": 2},
    "A2C": {"policy_kwargs": {"activation_fn": torch.nn.ReLU, "net_arch": {"pi": [16, 8], "vf": [4]}}},
    "DQN": {"learning_starts": 50, "policy_kwargs": {"net_arch": [32]}},
}


@pytest.fixture(scope="module")
def world():
    return find(CARTPOLE)


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """A model of each kind, trained for a moment, and its zip."""
    torch.set_num_threads(1)
    folder, found = tmp_path_factory.mktemp("sb3"), {}
    for kind, settings in KINDS.items():
        learner = getattr(sb3, kind)("MlpPolicy", "CartPole-v1", seed=1, device="cpu", **settings)
        learner.learn(1_500)
        file = folder / f"{kind}.zip"
        learner.save(file)
        found[kind] = learner, file
    return found


def observations(count=10_000):
    return (np.random.default_rng(7).normal(size=(count, 4)) * [1.2, 1.5, 0.15, 1.5]).astype(np.float32)


@pytest.mark.parametrize("kind", KINDS)
def test_actions_are_the_librarys_on_ten_thousand_observations(kind, models, world):
    learner, file = models[kind]
    expert = from_sb3(file, world, "none")
    obs = observations()
    theirs, _ = learner.predict(obs, deterministic=True)
    assert np.array_equal(expert.act([0], [obs])[:, 0], theirs) and set(theirs) == {0, 1}
    assert expert.card["algorithm"].startswith(kind) and len(expert.hash) == 64
    assert expert.critic == ("learned" if kind == "DQN" else "log-probabilities")


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["PPO", "DQN"])
def test_actions_are_the_librarys_after_a_minute_of_training(kind, tmp_path, world):
    learner = getattr(sb3, kind)("MlpPolicy", "CartPole-v1", seed=2, device="cpu")
    learner.learn(30_000)
    learner.save(tmp_path / "model.zip")
    obs = observations()
    theirs, _ = learner.predict(obs, deterministic=True)
    assert np.array_equal(from_sb3(tmp_path / "model.zip", world, "none").act([0], [obs])[:, 0], theirs)


def test_normalised_observations_are_folded_in_or_refused(tmp_path, world):
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import VecNormalize

    games = VecNormalize(make_vec_env("CartPole-v1", 2, seed=0), clip_obs=2.0)
    learner = sb3.PPO("MlpPolicy", games, n_steps=64, batch_size=64, seed=0, device="cpu")
    learner.learn(500)
    file = tmp_path / "normal.zip"
    learner.save(file)
    with pytest.raises(InputError, match="VecNormalize") as caught:
        from_sb3(file, world)
    assert "normalization=FILE" in str(caught.value)
    known = games.obs_rms
    obs = observations()
    theirs, _ = learner.predict(games.normalize_obs(obs), deterministic=True)
    normal = Normalization(known.mean, known.var, games.clip_obs, games.epsilon)
    assert np.array_equal(from_sb3(file, world, normal).act([0], [obs])[:, 0], theirs)
    facts = {"mean": known.mean.tolist(), "var": known.var.tolist(), "clip": games.clip_obs}
    (tmp_path / "normal.json").write_text(json.dumps(facts))
    found, played = find_expert(f"sb3:{file},normalization={tmp_path / 'normal.json'}", world=CARTPOLE)
    assert np.array_equal(found.act([0], [obs], None)[:, 0], theirs) and played.name == CARTPOLE
    plain = from_sb3(file, world, "none").act([0], [obs])[:, 0]
    assert not np.array_equal(plain, theirs)  # or the test above would show nothing


# --- hostile files


class Trap:
    """Writes a file when it is unpickled."""

    def __init__(self, file):
        self.file = str(file)

    def __reduce__(self):
        return open, (self.file, "w")


def test_pickled_parts_are_never_opened(models, tmp_path, world):
    """Every entry of the JSON, and every other file of the zip, would write a file if it was unpickled."""
    _, file = models["PPO"]
    mark = tmp_path / "written"
    evil = pickle.dumps(Trap(mark))
    pickle.loads(evil).close()
    assert mark.exists()  # the trap works
    mark.unlink()
    data = data_of(file)
    text = base64.b64encode(evil).decode()
    for value in data.values():
        if isinstance(value, dict) and ":serialized:" in value:
            value[":serialized:"] = text
    parts = {"data": json.dumps(data), "pytorch_variables_pth": evil, "policy_optimizer_pth": evil}
    expert = from_sb3(changed(file, tmp_path / "trap.zip", **parts), world)
    assert np.array_equal(expert.act([0], [observations()]), from_sb3(file, world).act([0], [observations()]))
    assert not mark.exists()


@pytest.mark.parametrize("wrapped", [False, True])
def test_weights_that_would_run_code_are_refused(wrapped, models, tmp_path, world):
    _, file = models["PPO"]
    mark = tmp_path / "written"
    if wrapped:
        buffer = io.BytesIO()
        torch.save({"action_net.weight": Trap(mark)}, buffer)
        evil = buffer.getvalue()
    else:
        evil = pickle.dumps(Trap(mark))
    with pytest.raises(InputError, match="weights alone"):
        from_sb3(changed(file, tmp_path / "trap.zip", policy_pth=evil), world)
    assert not mark.exists()


# --- refusals


def with_data(models, tmp_path, kind="PPO", **values):
    _, file = models[kind]
    return changed(file, tmp_path / "changed.zip", data=json.dumps(data_of(file) | values))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"action_space": {":type:": "<class 'gymnasium.spaces.box.Box'>"}}, "a Box, and the world's agents choose"),
        ({"action_space": None}, "unknown"),
        ({"observation_space": {":type:": "<class 'gymnasium.spaces.dict.Dict'>"}}, "a Dict"),
        ({"observation_space": {":type:": "<class 'gymnasium.spaces.box.Box'>", "dtype": "uint8"}}, "pictures"),
        ({"policy_class": {"__module__": "__main__"}}, "__main__"),
        ({"policy_class": None}, "not the library's"),
        ({"policy_class": ["x"]}, "not the library's"),
        ({"policy_kwargs": ["x"]}, "policy_kwargs"),
        (
            {"policy_kwargs": {"features_extractor_class": "<class 'mine.FlattenExtractor'>"}},
            "features_extractor_class",
        ),
        ({"policy_kwargs": {"features_extractor_kwargs": {}}}, "features_extractor_kwargs"),
        ({"policy_kwargs": {"activation_fn": "<class 'mine.Swish'>"}}, "Swish"),
        ({"policy_kwargs": {"activation_fn": "<class 'torch.nn.modules.activation.GELU'>"}}, "GELU"),
    ],
)
def test_what_the_file_cannot_vouch_for_is_refused(values, said, models, tmp_path, world):
    with pytest.raises(InputError, match=said):
        from_sb3(with_data(models, tmp_path, **values), world)


def test_an_unknown_activation_may_be_stated(models, tmp_path, world):
    file = with_data(models, tmp_path, policy_kwargs={"activation_fn": "<function tanh>"})
    stated = from_sb3(file, world, activation="tanh").act([0], [observations()])
    assert np.array_equal(stated, from_sb3(models["PPO"][1], world).act([0], [observations()]))


def weights(**tensors):
    buffer = io.BytesIO()
    torch.save({name.replace("__", "."): value for name, value in tensors.items()}, buffer)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("tensors", "said"),
    [
        ({"features_extractor__cnn__0__weight": torch.zeros(2, 3, 4, 4)}, "MlpPolicy"),
        ({"quantile_net__0__weight": torch.zeros(2, 2)}, "MlpPolicy"),
        (
            {"log_std": torch.zeros(2), "action_net__weight": torch.zeros(2, 4), "action_net__bias": torch.zeros(2)},
            "outputs are means",
        ),
        ({"action_net__weight": torch.zeros(2, 4)}, "missing"),
        ({"action_net__weight": torch.zeros(2, 5), "action_net__bias": torch.zeros(2)}, "5 inputs"),
        ({"q_net__q_net__0__weight": torch.zeros(2, 4), "q_net__q_net__0__bias": torch.zeros(2, 2)}, "connected"),
    ],
)
def test_other_networks_are_refused(tensors, said, models, tmp_path, world):
    file = changed(models["PPO"][1], tmp_path / "other.zip", policy_pth=weights(**tensors))
    with pytest.raises(InputError, match=said):
        from_sb3(file, world)


def test_what_is_no_such_zip_is_refused(tmp_path, world, models):
    text, empty = tmp_path / "text.zip", tmp_path / "empty.zip"
    text.write_text("no zip")
    zipfile.ZipFile(empty, "w").close()
    damaged = changed(models["PPO"][1], tmp_path / "damaged.zip", data="[" * 100_000)
    for file, said in ((text, "not a zip"), (empty, "not a zip"), (damaged, "not a zip"), (tmp_path / "no", "read")):
        with pytest.raises(InputError, match=said):
            from_sb3(file, world)


def test_what_cannot_be_unpacked_is_refused(tmp_path, world):
    file = tmp_path / "short.zip"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("data", json.dumps(list(range(500))))
    whole = file.read_bytes()
    file.write_bytes(whole[:60] + bytes(40) + whole[100:])
    with pytest.raises(InputError, match="not a zip"):
        from_sb3(file, world)


@pytest.mark.parametrize("how", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compressions_that_python_unpacks_without_limit_are_refused(how, tmp_path, world):
    with zipfile.ZipFile(tmp_path / "bomb.zip", "w", how) as archive:
        archive.writestr("data", b" " * 2**20)
    with pytest.raises(InputError, match="compressed in an unknown way"):
        from_sb3(tmp_path / "bomb.zip", world)


# --- commands


def test_extraction_takes_the_zip_and_says_what_weighs_states(models, tmp_path, capsys):
    _, file = models["PPO"]
    asked = ["extract", f"sb3:{file}", "--world", CARTPOLE, "--algorithm", "viper", "--max-depth", "2"]
    few = ["--iterations", "2", "--rollouts", "3", "--set", "selection_episodes=2", "-o", str(tmp_path / "p.json")]
    assert main.run([*asked, *few]) == 0
    said = capsys.readouterr().err
    assert "PPO of stable-baselines3" in said and "log-probabilities" in said
    made = json.loads((tmp_path / "p.json").read_text())
    assert made["provenance"]["training"]["critic"] == "log-probabilities"
    assert main.run(["extract", f"sb3:{file}", "-o", str(tmp_path / "p.json")]) == 2
    assert "--world gymnasium:CartPole-v1" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.compile
def test_the_pages_commands_run_as_written(tmp_path, monkeypatch, capsys):
    """The page's training and statistics too, shortened."""
    from maviper import manual
    from maviper.evaluation import held_out

    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 5)
    monkeypatch.chdir(tmp_path)
    page = manual.page("own")
    train, statistics, python = re.findall(r"```python\n(.*?)```", page, flags=re.S)
    assert "learn(50_000)" in train
    exec(compile(train.replace("50_000", "1_500"), "own.md", "exec"), {})
    exec(compile(python, "own.md", "exec"), {})
    games = SimpleNamespace(obs_rms=SimpleNamespace(mean=np.zeros(4), var=np.ones(4)), clip_obs=5.0, epsilon=1e-8)
    exec(compile(statistics.replace('open("statistics.json", "w").write', "print"), "own.md", "exec"), {"games": games})
    (tmp_path / "statistics.json").write_text(capsys.readouterr().out)
    lines = [line.removeprefix("    maviper ") for line in page.splitlines() if line.startswith("    maviper ")]
    if find_spec("vmas") is None:
        lines = [line for line in lines if "vmas:" not in line]
    assert len(lines) >= 6
    few = {"extract": ["--iterations", "2", "--rollouts", "3", "--set", "selection_episodes=2"]}
    few |= {"evaluate": ["--episodes", "3"], "train": ["--steps", "1600", "--set", "games=16"]}
    for line in lines:
        verb, *words = shlex.split(line)
        words += ["--refinement-episodes", "0"] if "--refinement-episodes" in words else []
        fewer = [] if "--max-episodes" in words else few.get(verb, [])
        assert main.run([verb, *words, *fewer]) == 0, line
