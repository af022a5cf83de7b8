"""Experts as numpy arrays: per agent an actor and a centralized critic, or one value network; and their files.

Does: the forward pass of actors (argmax of logits, or numbers within bounds), critics (Q of joint actions) and value
  networks (Q of own actions); encodes and decodes an expert as safetensors with a card; finds the shipped ones, in
  package or clone; says what is wrong with a bad file.
Assumes: two hidden ReLU layers; a critic reads all observations, then all agents' actions one-hot.
Does not: learn, need torch, or load pickles or TorchScript.

Weights are float32, the pass runs in float64: libraries for matrix products add up in different orders on different
processors, and in float64 that is too small to turn a decision, so an extraction gives the same trees everywhere.
Greedy actions ask float32 first, which takes half the time, and keep its answer where the best logit leads by more than
rounding can turn.
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import Float32, Float64
from codegen.paths import Mask
from maviper.episodes.play import in_columns
from maviper.experts.expert import AS_GIVEN
from maviper.files import kinds, runs
from maviper.worlds import World, find_built_in
from maviper.worlds.outside.sources import is_named_by_user
from maviper.worlds.world import Int, legal_in

LAYERS = (1, 2, 3)
ROWS = 512  # at once: what a layer gives for so many stays in the cache, twice as fast as thousands together
FEW = 256  # rows, which float64 alone decides as soon
ERROR = 2.0**-24 + 2.0**-53  # of one operation in float32, and of the same in float64, relative
LARGEST = 2.0**100  # a sum that is certain to stay below it does not overflow in float32
TINIEST = 2.0**-100  # more than products lose that are too small for float32
NO_CRITIC = "finish its training, or measure Q: --critic measured"
ACTOR, CRITIC, VALUE = "actor", "critic", "value"
# what an expert's file may hold for each agent, and its card says
ACTOR_CRITIC = "actor-critic"
NETS = {ACTOR_CRITIC: (ACTOR, CRITIC), ACTOR: (ACTOR,), VALUE: (VALUE,)}


@dataclass(frozen=True)
class NetworkExpert:
    """Weights of all agents' networks.

    `tensors` holds, for each agent name A, each net (actor and critic, or value) and each layer L in 1, 2, 3,
    `A.net.L.weight` [inputs, outputs] and `A.net.L.bias` [outputs], float32. `card` says what made them and how
    good they are; `hash` is the SHA-256 of the file.
    """

    agents: tuple[str, ...]
    n_actions: tuple[int, ...]
    tensors: Mapping[str, Float32]
    card: Mapping[str, Any]
    hash: str
    masks: tuple[Mask | None, ...] = ()  # each agent's; (): all actions are always legal
    bounds: tuple[tuple[Float64, Float64], ...] = ()  # of the numbers that each agent gives; (): agents have actions
    _wide: Mapping[str, Float64] = field(init=False, repr=False)
    _errors: Mapping[str, tuple[Float64, Float64]] = field(init=False, repr=False)  # by acting network

    def __post_init__(self) -> None:
        object.__setattr__(self, "_wide", {name: tensor.astype(np.float64) for name, tensor in self.tensors.items()})
        nets = [self._net(agent) for agent in range(len(self.agents))]
        object.__setattr__(self, "_errors", {net: _largest_errors(net, self._wide) for net in nets})

    @property
    def centralized(self) -> bool:
        """Critics see all agents; value networks see their own."""
        return not self._has(VALUE)

    def _has(self, net: str) -> bool:
        return f"{self.agents[0]}.{net}.1.weight" in self.tensors

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any = None) -> Int:
        """Returns each agent's greedy action, among legal ones if any is, or its numbers, means clipped to the bounds;
        see `Controller.act`.
        """
        if self.bounds:
            return in_columns([self._give(agent, observations[agent]) for agent in agents])
        return np.stack([self._greedy(agent, observations[agent]) for agent in agents], axis=1)

    def _give(self, agent: int, obs: Float32) -> Float32:
        """[batch, n_outputs]; the least batch is two rows, as in `_greedy`."""
        rows = obs if len(obs) > 1 else np.resize(obs, (2, obs.shape[1]))
        return give_numbers(self.logits(agent, rows), *self.bounds[agent])[: len(obs)]

    def _greedy(self, agent: int, obs: Float32) -> Int:
        """In float64 only where float32 leaves a doubt; the least batch of a product is two rows, as one row alone is
        added up in another order.
        """
        doubt = self._doubt(agent, obs) if len(obs) >= FEW and obs.dtype == np.float32 else np.inf
        if doubt == np.inf:
            return np.argmax(self._legal(agent, obs, self.logits(agent, obs)), axis=1)
        actions, lead = _best(self._legal(agent, obs, self._logits(agent, obs, self.tensors)))
        doubtful = np.flatnonzero(~(lead > doubt))
        if len(doubtful):
            rows = np.resize(doubtful, max(2, len(doubtful)))
            actions[rows] = np.argmax(self._legal(agent, obs[rows], self.logits(agent, obs[rows])), axis=1)
        return actions

    def _legal(self, agent: int, obs: Float32, logits: Any) -> Any:
        """The same logits, but for illegal actions."""
        mask = self.masks[agent] if self.masks else None
        return logits if mask is None else np.where(legal_in(mask, obs), logits, -np.inf)

    def _doubt(self, agent: int, obs: Float32) -> float:
        """By how much the difference of two logits in float32 may be off from the one in float64, in every row; inf
        where sums may overflow or are of no numbers.

        Each sum of n products is off by at most n * ERROR of the sum of their sizes (Higham, Accuracy and Stability of
        Numerical Algorithms, 3.1), in whatever order it is added up, and ReLU makes no difference larger.
        """
        size = max(float(obs.max()), -float(obs.min()))
        per_unit, constant = self._errors[self._net(agent)]
        largest, error = (per_unit * size + constant).tolist() if size < LARGEST else (np.inf, np.inf)
        return 2 * error + TINIEST if largest < LARGEST else np.inf

    def _net(self, agent: int) -> str:
        return f"{self.agents[agent]}.{ACTOR if self.centralized else VALUE}"

    def logits(self, agent: int, obs: Float32) -> Float64:
        """Returns the values whose argmax is the greedy action, [batch, n_actions]."""
        return self._logits(agent, obs, self._wide)

    def _logits(self, agent: int, obs: Float32, tensors: Mapping[str, Any]) -> Any:
        """Logits in the precision of `tensors`."""
        net = self._net(agent)
        weight, bias = (tensors[f"{net}.1.{part}"] for part in ("weight", "bias"))
        return _in_parts(lambda rows: self._head(net, np.asarray(rows, weight.dtype) @ weight + bias, tensors), obs)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns Q. The first layer's part for observations and given actions is computed once per state."""
        if not self.centralized:
            chosen = np.where(joint[:, agent] == AS_GIVEN, given[:, agent, None], joint[:, agent])
            return np.take_along_axis(self.logits(agent, observations[agent]), chosen, axis=1)
        if not self._has(CRITIC):
            raise InputError("this expert has no critic", self.card.get("world", ""), NO_CRITIC)
        net = f"{self.agents[agent]}.{CRITIC}"
        weight = self._wide[f"{net}.1.weight"]
        seen = np.concatenate(list(observations), axis=1).astype(np.float64)
        shared = seen @ weight[: seen.shape[1]] + self._wide[f"{net}.1.bias"]
        first_row = seen.shape[1] + np.concatenate([[0], np.cumsum(self.n_actions)[:-1]])
        asked = np.zeros((len(joint), shared.shape[1]))
        for other, row in enumerate(first_row):
            if joint[0, other] == AS_GIVEN:
                shared = shared + weight[row + given[:, other]]
            else:
                asked = asked + weight[row + joint[:, other]]
        first = shared[:, None, :] + asked
        flat = _in_parts(lambda rows: self._head(net, rows, self._wide), first.reshape(-1, first.shape[-1]))
        return flat.reshape(first.shape[:2])

    def _head(self, net: str, first: Any, tensors: Mapping[str, Any]) -> Any:
        """Computes the layers after the first layer's sums, [batch, n_actions]. `first` is overwritten."""
        hidden = np.maximum(first, 0, out=first) @ tensors[f"{net}.2.weight"]
        hidden += tensors[f"{net}.2.bias"]
        outputs = np.maximum(hidden, 0, out=hidden) @ tensors[f"{net}.3.weight"]
        outputs += tensors[f"{net}.3.bias"]
        return outputs


def give_numbers(parts: Any, low: Float64, high: Float64) -> Float32:
    """Numbers within bounds, [batch, n_outputs]: -1 stands for the low one, 1 for the high one, and what is beyond them
    is clipped.
    """
    given = (low + high) / 2 + np.asarray(parts, np.float64) * ((high - low) / 2)
    return np.clip(given, low, high).astype(np.float32)


def _largest_errors(net: str, wide: Mapping[str, Float64]) -> tuple[Float64, Float64]:
    """Bounds the size of an output and its error in float32: the parts for each unit of the largest input, and the
    constant parts.
    """
    inputs = len(wide[f"{net}.1.weight"])
    size, error = np.array([np.ones(inputs), np.zeros(inputs)]), np.zeros((2, inputs))  # [per unit and constant, width]
    for layer in LAYERS:
        weight, bias = (np.abs(wide[f"{net}.{layer}.{part}"]) for part in ("weight", "bias"))
        terms = (len(weight) + 1) * ERROR
        size, error = size @ weight, error @ weight
        size[1] += bias
        error += terms / (1 - terms) * (size + error)
    per_unit, constant = np.stack([(size + error).max(axis=1), error.max(axis=1)], axis=1)
    return per_unit, constant


def _best(logits: Any) -> tuple[Int, Any]:
    """Each row's first largest entry, and by how much it is above the second, both [batch]; no NaN. Column by column:
    reductions over rows that are so short take three times as long.
    """
    first, *others = logits.T.copy()
    actions, second = np.zeros(len(logits), np.int64), np.full(len(logits), -np.inf, logits.dtype)
    for action, column in enumerate(others, 1):
        actions[column > first] = action
        np.maximum(second, np.minimum(first, column), out=second)
        np.maximum(first, column, out=first)
    with np.errstate(invalid="ignore"):  # none is legal: no number, and no lead
        return actions, first - second


def _in_parts(function: Callable[[Any], Any], rows: Any) -> Any:
    """Applies a function to all rows, ROWS of them at a time, and returns its results, [batch, outputs]."""
    return np.concatenate([function(rows[low : low + ROWS]) for low in range(0, max(1, len(rows)), ROWS)])


ZIP = b"PK\x03\x04"  # how such an archive begins
FORMAT = "maviper-expert-1"
MAX_HIDDEN = 4096
MAX_BYTES = 64 * 2**20
# world -> (file name, trained seeds, the one of the best score on its finalists' episodes)
CLONES = {  # networks that imitated a script first
    "physical-deception": ("physical_deception.clone", (2,), 2),
    "cooperative-navigation": ("cooperative_navigation.clone", (1,), 1),
    "predator-prey": ("predator_prey.clone", (0,), 0),
}
LEARNED = {  # networks that learned by reward alone
    "physical-deception": ("physical_deception", (0, 1, 2), 2),
    "physical-deception,velocity=1": ("physical_deception_velocity", (0, 1, 2), 1),
    "physical-deception,shuffled=1": ("physical_deception_shuffled", (0,), 0),
    "cooperative-navigation": ("cooperative_navigation", (0, 1, 2), 1),
    "predator-prey": ("predator_prey", (0, 1, 2), 0),
    "predator-prey,observation=mpe2": ("predator_prey_mpe2", (0, 1, 2), 0),
}
MADDPG = {  # by the paper's algorithm, reward alone
    "physical-deception": ("physical_deception.maddpg", (0,), 0),
    "cooperative-navigation": ("cooperative_navigation.maddpg", (0,), 0),
    "predator-prey": ("predator_prey.maddpg", (0,), 0),
}
CLONE = "clone"
REPOSITORY = "maviper/experts/shipped"  # in a clone, all of them


def _name_files(trained: Mapping[str, tuple[str, tuple[int, ...], int]], kind: str = "") -> dict[str, str]:
    """Name on the command line -> file: NAME or NAME@KIND is the best seed's, NAME@1 or NAME@KIND-1 seed 1's."""
    plain, dash = (f"@{kind}", "-") if kind else ("", "")
    named = {f"{world}{plain}": file_of(stem, best) for world, (stem, _, best) in trained.items()}
    for world, (stem, seeds, _) in trained.items():
        named |= {f"{world}@{kind}{dash}{seed}": file_of(stem, seed) for seed in seeds}
    return named


def file_of(stem: str, seed: int) -> str:
    """The shipped file of one training seed."""
    return f"{stem}.{seed}.safetensors"


SHIPPED = {**_name_files(LEARNED), **_name_files(MADDPG, "maddpg"), **_name_files(CLONES, CLONE)}


def encode(tensors: Mapping[str, Float32], card: Mapping[str, Any]) -> bytes:
    """The file of an expert. One metadata entry only: with several, safetensors does not fix their order."""
    from safetensors.numpy import save

    contiguous = {name: np.ascontiguousarray(tensors[name], dtype=np.float32) for name in sorted(tensors)}
    return save(contiguous, metadata={FORMAT: json.dumps(card, sort_keys=True)})


def decode(data: bytes, where: str, world: World | None = None) -> NetworkExpert:
    """The expert in a file's bytes; InputError when it is damaged, not an expert of ours, or another world's.

    `world`: what it plays; needed for a user's environment, since a file's word is not enough to import code.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    kinds.ensure(data, where, kinds.EXPERT.called, kinds.EXPERT)
    advice = "train it again, or use a shipped expert (see `maviper worlds list`)"
    try:
        tensors = load(data)
        header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
        card = json.loads(header["__metadata__"][FORMAT])
        name = str(card["world"])
        hidden = range(1, MAX_HIDDEN + 1)[int(card["hidden"]) - 1]
        networks = card.get("networks", ACTOR_CRITIC)
        NETS[networks]
    except (SafetensorError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        if data.startswith(ZIP):
            advice = f"a file of Stable-Baselines3 is named sb3:{where}"
        raise InputError("not an expert file", where, advice) from None
    if world is None and is_named_by_user(name):
        raise InputError("the expert plays your own environment", f"{where}: {name}", f"name it: --world {name}")
    world = world or find_built_in(name)
    if name != world.name:
        raise InputError("the expert plays another world", f"{where}: {name}, not {world.name}", advice)
    for name, shape in shapes(world, hidden, networks).items():
        actual = tensors[name].shape if name in tensors else None
        if actual != shape or not np.isfinite(tensors[name]).all():
            raise InputError(
                "the expert file is damaged", f"{where}: {name}: shape {actual}, expected {shape}, finite", advice
            )
    return build_expert(world, tensors, card, hashlib.sha256(data).hexdigest())


def build_expert(
    world: World, tensors: Mapping[str, Float32], card: Mapping[str, Any], digest: str = ""
) -> NetworkExpert:
    """An expert from its parts. `digest`: of its file, if there is one."""
    n_actions = tuple(len(choices) for choices in world.actions)
    masks = tuple(world.mask(agent) for agent in range(len(world.agents))) if world.masked else ()
    return NetworkExpert(world.agents, n_actions, tensors, card, digest, masks, world.bounds)


def shapes(world: World, hidden: int, networks: str = ACTOR_CRITIC) -> dict[str, tuple[int, ...]]:
    """Names and shapes of the tensors that an expert for `world` consists of."""
    n_all = sum(len(features) for features in world.features) + sum(len(choices) for choices in world.actions)
    expected: dict[str, tuple[int, ...]] = {}
    for agent, features, choices in zip(world.agents, world.features, world.decided, strict=True):
        for net in NETS[networks]:
            inputs, outputs = (n_all, 1) if net == CRITIC else (len(features), len(choices))
            sizes = (inputs, hidden, hidden, outputs)
            for layer in LAYERS:
                expected[f"{agent}.{net}.{layer}.weight"] = sizes[layer - 1 : layer + 1]
                expected[f"{agent}.{net}.{layer}.bias"] = sizes[layer : layer + 1]
    return expected


def is_here(file: str) -> bool:
    """Returns True if the shipped file can be read: an installation has one expert per game, a checkout has all."""
    return any((place / file).is_file() for place in _places())


def load_shipped(file: str, world: World | None = None) -> NetworkExpert:
    """The expert in a shipped file; InputError, which says where it is, when neither package nor folder has it."""
    for place in _places():
        if (place / file).is_file():
            return decode((place / file).read_bytes(), f"shipped expert {file}", world)
    where = f"{file}: an installation has the best expert per game"
    advice = f"run in a clone of the repository, which has it in {REPOSITORY}, or name its file"
    raise InputError("this expert is not installed", where, advice)


def _places() -> tuple[Traversable, ...]:
    return resources.files("maviper.experts.shipped"), Path(REPOSITORY)


def load(name_or_path: str, world: World | None = None) -> tuple[NetworkExpert, World]:
    """A shipped expert by its world's name, or one from a file or run folder, with the world that it plays."""
    if name_or_path in SHIPPED:
        expert = load_shipped(SHIPPED[name_or_path], world)
    else:
        path = Path(name_or_path)
        try:
            path = path / "expert.safetensors" if path.is_dir() else path
            missing = not path.exists()
        except (OSError, ValueError) as error:  # too long, or not a path at all
            raise InputError("cannot read the file", f"{name_or_path[:80]}: {error}"[:200], "check the path") from None
        if missing and path.parent == Path():
            where = "neither a shipped expert, a file nor a run folder; a function of your own is named module:function"
            raise UnknownNameError("expert", name_or_path, SHIPPED, where)
        expert = decode(runs.read(path, MAX_BYTES), str(path), world)
    return expert, world or find_built_in(str(expert.card["world"]))
