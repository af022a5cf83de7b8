"""Torch state dicts with a stated architecture: CleanRL's agents, files of weights alone, and clear refusals."""

import zipfile

import numpy as np
import pytest
from safetensors.numpy import save_file

from codegen.errors import InputError, UnknownNameError
from maviper.experts import from_torch
from maviper.experts.finding import find_expert
from maviper.experts.foreign import weights
from maviper.worlds import find

pytestmark = pytest.mark.train
torch = pytest.importorskip("torch")
CARTPOLE = "gymnasium:CartPole-v1"


@pytest.fixture(scope="module")
def world():
    return find(CARTPOLE)


class Agent(torch.nn.Module):
    """As CleanRL's PPO has it: a critic and an actor side by side."""

    def __init__(self):
        super().__init__()
        made = [torch.nn.Sequential(*self.parts(size)) for size in (1, 2)]
        self.critic, self.actor = made

    def parts(self, outputs):
        linear, tanh = torch.nn.Linear, torch.nn.Tanh
        return linear(4, 8), tanh(), linear(8, 8), tanh(), linear(8, outputs)


@pytest.fixture
def agent():
    torch.manual_seed(3)
    made = Agent()
    with torch.no_grad():  # so that either action is taken
        made.actor[-1].bias -= made.actor(torch.from_numpy(observations())).mean(dim=0)
    return made


def observations():
    return np.random.default_rng(8).normal(size=(10_000, 4)).astype(np.float32)


def test_an_agent_of_cleanrl_acts_as_it_does_there(agent, world, tmp_path):
    obs = observations()
    with torch.no_grad():
        theirs = agent.actor(torch.from_numpy(obs)).argmax(dim=1).numpy()
    stated = {"net": "actor", "activation": "tanh", "outputs": "logits"}
    assert np.array_equal(from_torch(agent.state_dict(), world, **stated).act([0], [obs])[:, 0], theirs)
    torch.save(agent.state_dict(), tmp_path / "ppo.cleanrl_model")
    save_file({key: value.numpy() for key, value in agent.state_dict().items()}, tmp_path / "ppo.safetensors")
    said = ",".join(f"{key}={value}" for key, value in stated.items())
    for file in ("ppo.cleanrl_model", "ppo.safetensors"):
        found, _ = find_expert(f"torch:{tmp_path / file},{said}", world=CARTPOLE)
        assert np.array_equal(found.act([0], [obs], None)[:, 0], theirs) and set(theirs) == {0, 1}


def test_what_is_not_stated_or_not_there_is_refused(agent, world, tmp_path):
    state = agent.state_dict()
    with pytest.raises(UnknownNameError, match="actor"):
        from_torch(state, world, "actr", "tanh", "logits")
    with pytest.raises(InputError, match="1 outputs"):
        from_torch(state, world, "critic", "tanh", "logits")
    with pytest.raises(UnknownNameError, match="logits"):
        from_torch(state, world, "actor", "tanh", "logit")
    torch.save(state, tmp_path / "a.pt")
    with pytest.raises(InputError, match="activation, outputs"):
        find_expert(f"torch:{tmp_path / 'a.pt'},net=actor", world=CARTPOLE)
    with pytest.raises(UnknownNameError, match="option of torch"):
        find_expert(f"torch:{tmp_path / 'a.pt'},nets=actor", world=CARTPOLE)


@pytest.mark.parametrize(
    "parts",
    [
        [torch.nn.Linear(4, 8), torch.nn.LayerNorm(8), torch.nn.Linear(8, 2)],
        [torch.nn.Linear(4, 8), torch.nn.Linear(8, 2)],
        [torch.nn.Linear(4, 8), torch.nn.Dropout(), torch.nn.ReLU(), torch.nn.Linear(8, 2)],
        [torch.nn.Linear(4, 8, bias=False), torch.nn.ReLU(), torch.nn.Linear(8, 2)],
    ],
)
def test_other_architectures_are_refused(parts, world):
    net = torch.nn.ModuleDict({"net": torch.nn.Sequential(*parts)})
    with pytest.raises(InputError, match=r"connected|activations"):
        from_torch(net.state_dict(), world, "net", "relu", "q")


def test_a_whole_module_is_not_loaded(agent, world, tmp_path):
    torch.save(agent, tmp_path / "whole.pt")
    with pytest.raises(InputError, match="weights alone"):
        from_torch(tmp_path / "whole.pt", world, "actor", "tanh", "logits")
    torch.save(torch.zeros(3), tmp_path / "tensor.pt")
    with pytest.raises(InputError, match="state dict"):
        from_torch(tmp_path / "tensor.pt", world, "actor", "tanh", "logits")


@pytest.mark.parametrize(
    ("tensor", "said"),
    [
        (torch.zeros(1).expand(2**20, 2**20), "more than"),
        (torch.zeros(1, dtype=torch.float16).expand(2**20, 2**20), "more than"),
        (torch.eye(3).to_sparse(), "weights alone"),
        (torch.empty(2, 4, device="meta"), "weights alone"),
        (torch.zeros(2, 4, dtype=torch.complex64), "weights alone"),
    ],
)
def test_tensors_that_are_no_plain_numbers_or_too_many_are_refused(tensor, said, world, tmp_path):
    torch.save({"net.0.weight": tensor, "net.0.bias": torch.zeros(2)}, tmp_path / "odd.pt")
    with pytest.raises(InputError, match=said):
        from_torch(tmp_path / "odd.pt", world, "net", "relu", "q")


def test_a_file_that_unpacks_too_much_is_refused(world, tmp_path, monkeypatch):
    torch.save({"net.0.weight": torch.zeros(2, 2**17), "net.0.bias": torch.zeros(2)}, tmp_path / "plain.pt")
    with zipfile.ZipFile(tmp_path / "plain.pt") as plain, zipfile.ZipFile(tmp_path / "bomb.pt", "w") as bomb:
        for name in plain.namelist():
            bomb.writestr(name, plain.read(name), zipfile.ZIP_DEFLATED)
    assert (tmp_path / "bomb.pt").stat().st_size < 2**14
    monkeypatch.setattr(weights, "MAX_BYTES", 2**19)
    with pytest.raises(InputError, match="more than"):
        from_torch(tmp_path / "bomb.pt", world, "net", "relu", "q")
