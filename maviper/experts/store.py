"""Expert files: safetensors with a card, read without running any code.

Does: encodes and decodes an expert; finds the shipped ones, in package or clone; says what is wrong with a bad file.
Assumes: the tensor names and shapes of network.py.
Does not: load pickles or TorchScript.
"""

import hashlib
import json
from collections.abc import Mapping
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import Float32
from codegen.legality import Mask
from maviper.experts.network import ACTOR_CRITIC, CRITIC, LAYERS, NETS, NetworkExpert
from maviper.files import kinds, runs
from maviper.worlds import World, find_built_in
from maviper.worlds.outside.sources import is_named_by_user
from maviper.worlds.world import bounds

ZIP = b"PK\x03\x04"  # how such an archive begins
FORMAT = "maviper-expert-1"
MAX_HIDDEN = 4096
MAX_BYTES = 64 * 2**20
# world -> (file name, trained seeds, the one of the best score on its finalists' episodes)
CLONES = {  # networks that imitated a script first
    "physical-deception": ("physical_deception.clone", (0, 1, 2), 2),
    "physical-deception,velocity=1": ("physical_deception_velocity.clone", (0, 1, 2), 1),
    "cooperative-navigation": ("cooperative_navigation.clone", (0, 1, 2), 1),
    "predator-prey": ("predator_prey.clone", (0, 1, 2), 0),
    "predator-prey,observation=mpe2": ("predator_prey_mpe2.clone", (0, 1), 0),
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
    advice = "train it again, or use a shipped expert (see `maviper worlds`)"
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
    ends = tuple(bounds(outputs) for outputs in world.outputs)
    return NetworkExpert(world.agents, n_actions, tensors, card, digest, _masks(world), ends)


def _masks(world: World) -> tuple[Mask | None, ...]:
    return tuple(world.mask(agent) for agent in range(len(world.agents))) if world.masked else ()


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
        if missing and path.suffix == "" and path.parent == Path():
            raise UnknownNameError("expert", name_or_path, SHIPPED, "neither a shipped expert nor a file or run folder")
        expert = decode(runs.read(path, MAX_BYTES), str(path), world)
    return expert, world or find_built_in(str(expert.card["world"]))
