"""Experts of other libraries, by `sb3:FILE.zip` or `torch:FILE.pt,net=actor,activation=tanh,outputs=logits`.

Does: parts such a text; reads PPO, A2C, DQN, SAC, TD3 and DDPG of stable-baselines3 from the zip that `model.save`
  writes, its weights and the plain part of its JSON, and infers the network; reads plain torch state dicts, CleanRL's
  among them, with the architecture that the user states.
Assumes: the zip's layout since stable-baselines3 1.8: `data` (JSON) and `policy.pth` (a state dict); for state dicts an
  `nn.Sequential` of linear layers with one activation after each but the last.
Does not: decode or open the pickled entries of that JSON, whatever they hold; need the library; guess what a state dict
  does not hold: activations, and what its outputs mean.
"""

import hashlib
import io
import json
import re
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from codegen.errors import InputError, UnknownNameError
from maviper.experts.foreign.layers import (
    ACTIVATIONS,
    LOGITS,
    MEANS,
    SQUASHED,
    LayersExpert,
    Linear,
    Normalization,
    Q,
)
from maviper.experts.foreign.weights import MAX_BYTES, Tensors, layers, of_torch, part, read, single
from maviper.files import runs
from maviper.worlds import World
from maviper.worlds.outside.sources import is_mapping

NONE = "none"  # said of a normalisation: there was not any
MAX_DATA, MAX_FILE = 64 * 2**20, 2**30
DATA, WEIGHTS, SAFE_WEIGHTS, VERSION = "data", "policy.pth", "policy.safetensors", "_stable_baselines3_version"
# arguments of a policy that do not change what its network computes, beside those that are read
HARMLESS = {
    *("net_arch", "activation_fn", "features_extractor_class", ":type:", ":serialized:"),
    *("optimizer_class", "optimizer_kwargs", "ortho_init", "share_features_extractor"),
    *("log_std_init", "use_expln", "full_std", "normalize_images", "n_critics", "use_sde"),
}
FLATTEN = "<class 'stable_baselines3.common.torch_layers.FlattenExtractor'>"
USUAL = {LOGITS: "tanh", MEANS: "tanh", Q: "relu", SQUASHED: "relu"}  # activations, where the file names none
CRITICS = r"critic(_target)?\.qf\d\.\d+"
# what else the weights of an algorithm may hold, and where its policy is: layers in a row, and a last one
KNOWN: Mapping[str, tuple[str, str, str]] = {
    LOGITS: (r"mlp_extractor\.(policy|value)_net\.\d+|action_net|value_net", "mlp_extractor.policy_net", "action_net"),
    Q: (r"q_net(_target)?\.q_net\.\d+", "q_net.q_net", ""),
    "SAC": (rf"actor\.latent_pi\.\d+|actor\.(mu|log_std)|{CRITICS}", "actor.latent_pi", "actor.mu"),
    "TD3": (rf"actor(_target)?\.mu\.\d+|{CRITICS}", "actor.mu", ""),
}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
SAC_ENTROPY = "target_entropy"  # which SAC alone has
GSDE = "SAC's generalised exploration (use_sde) clips its means by a number that the file does not say"
UNREADABLE = (
    *(zipfile.BadZipFile, zlib.error, EOFError, KeyError, ValueError),
    *(RecursionError, NotImplementedError, RuntimeError),
)
BY_HAND = "bring it by module:function: `maviper guide experts`"


def from_sb3(
    file: str | Path,
    world: World,
    normalization: Normalization | str | None = None,
    activation: str | None = None,
) -> LayersExpert:
    """The expert in a zip of stable-baselines3; every agent of `world` plays by it.

    `normalization`: of a training in VecNormalize, whose statistics are in a file of their own; `none` where its
    observations were not normalised. `activation`: where the file cannot say it. InputError for another algorithm, a
    network that is not fully connected, or an answer that is missing.
    """
    path, where = Path(file), str(file)
    whole = runs.read(path, MAX_FILE)
    try:
        with zipfile.ZipFile(io.BytesIO(whole)) as archive:
            names = set(archive.namelist())
            data = json.loads(part(archive, DATA, MAX_DATA))
            version = part(archive, VERSION, 64).decode("ascii") if VERSION in names else ""
            safe = SAFE_WEIGHTS in names
            weights = part(archive, SAFE_WEIGHTS if safe else WEIGHTS, MAX_BYTES)
    except UNREADABLE as error:
        said = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        raise InputError("not a zip of stable-baselines3", f"{path}: {said}", "write it by model.save(file)") from None
    if not is_mapping(data):
        raise InputError("not a zip of stable-baselines3", f"{path}: {DATA}", "write it by model.save(file)")
    plain = re.fullmatch(r"\s*([0-9A-Za-z.+-]{1,40})\s*", version)
    tensors = read(weights, f"{path}: {WEIGHTS}", safe)
    _ensure_spaces(data, world, where)
    algorithm, outputs = _algorithm(data, tensors, where)
    network = _network(tensors, algorithm, where)
    told = f"{algorithm} of stable-baselines3 {plain[1] if plain else ''}".strip()
    card = {"algorithm": told, "steps": data.get("num_timesteps")}
    normal = _normalization(data, normalization, algorithm, where)
    chosen = activation or _activation(data, outputs, where)
    return LayersExpert(world, network, chosen, outputs, normal, card, hashlib.sha256(whole).hexdigest())


def _algorithm(data: Mapping[str, Any], tensors: Tensors, where: str) -> tuple[str, str]:
    """The algorithm that a zip is of, and what its network's outputs are."""
    given = data.get("policy_kwargs")
    own: Mapping[str, Any] = given if is_mapping(given) else {}
    if any(name.startswith("q_net.") for name in tensors):
        return "DQN", Q
    if any(name.startswith("actor.") for name in tensors):
        if own.get("use_sde") or (any(name.startswith("actor.mu.0.") for name in tensors) and SAC_ENTROPY in data):
            raise InputError(GSDE, where, BY_HAND)
        if SAC_ENTROPY in data:
            return "SAC", SQUASHED
        return "DDPG" if own.get("n_critics") == 1 and data.get("policy_delay") == 1 else "TD3", SQUASHED
    return "PPO" if "clip_range" in data else "A2C", MEANS if "log_std" in tensors else LOGITS


def _network(tensors: Tensors, algorithm: str, where: str) -> list[Linear]:
    """The layers of an algorithm's policy; InputError where there is anything that may change what it does."""
    known, name, last = KNOWN[{"DQN": Q, "PPO": LOGITS, "A2C": LOGITS, "DDPG": "TD3"}.get(algorithm, algorithm)]
    names = {each.rpartition(".")[0] for each in tensors if each != "log_std"}
    strange = sorted(each for each in names if not re.fullmatch(known, each))
    if strange:
        what = "not PPO, A2C, DQN, SAC, TD3 or DDPG with a fully connected policy (MlpPolicy)"
        raise InputError(what, f"{where}: {strange[0] or min(tensors)}", BY_HAND)
    return [*layers(tensors, name, where), *([single(tensors, last, where)] if last else [])]


def _ensure_spaces(data: Mapping[str, Any], world: World, where: str) -> None:
    """Refuses what changes observations before the network sees them, and policies of classes of the user's."""
    seen, acts = (_class(data.get(f"{kind}_space")) for kind in ("observation", "action"))
    if acts not in ("Discrete", "Box"):
        raise InputError(f"the policy's actions are a {acts or 'space unknown'}, not Discrete or a Box", where, BY_HAND)
    if (acts == "Box") != world.continuous:
        ours = "give numbers" if world.continuous else "choose among numbered actions"
        what = f"the policy's actions are a {acts}, and the world's agents {ours}"
        raise InputError(what, f"{where}: {world.name}", "name the world that it was trained in")
    if acts == "Box":
        _ensure_bounds(data["action_space"], world, where)
    if seen not in ("Box", "Discrete", "MultiBinary") or data["observation_space"].get("dtype") == "uint8":
        raise InputError(f"the policy's observations are a {seen or 'space unknown'} or pictures", where, BY_HAND)
    kind = data.get("policy_class")
    own = str(kind.get("__module__", "")) if is_mapping(kind) else ""
    if not own.startswith("stable_baselines3."):
        raise InputError(f"the policy's class is not the library's, but of {own[:60] or 'nowhere'}", where, BY_HAND)
    given: Any = data.get("policy_kwargs") or {}
    unknown = sorted(str(each) for each in given.keys() - HARMLESS) if is_mapping(given) else ["policy_kwargs"]
    if not unknown and given.get("features_extractor_class", FLATTEN) != FLATTEN:
        unknown = ["features_extractor_class"]
    if unknown:
        raise InputError(f"the policy has an argument {unknown[0][:40]} whose effect is unknown", where, BY_HAND)


def _ensure_bounds(space: Mapping[str, Any], world: World, where: str) -> None:
    """InputError where a zip's Box has other bounds than the world's agents: its numbers would mean something else."""
    for outputs in world.given:
        for end in ("low", "high"):
            told = [float(each) for each in NUMBER.findall(str(space.get(end, "")))]
            ours = [float(np.float32(getattr(each, end))) for each in outputs]
            if len(told) != len(ours) or not np.allclose(told, ours, rtol=1e-6, atol=1e-8):
                what = f"the policy's actions have {end} {str(space.get(end, 'unknown'))[:60]}, the world's {ours}"
                raise InputError(what, f"{where}: {world.name}", "name the world that it was trained in")


def _class(space: Any) -> str:
    """The name of the class of a space that the JSON describes, or ""."""
    match = re.fullmatch(r"<class '[\w.]+\.(\w+)'>", str(space.get(":type:", ""))) if is_mapping(space) else None
    return match[1] if match else ""


def _activation(data: Mapping[str, Any], outputs: str, where: str) -> str:
    given: Any = data.get("policy_kwargs") or {}
    if "activation_fn" not in given:
        return USUAL[outputs]
    match = re.fullmatch(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>", str(given["activation_fn"]))
    if not match or match[1].lower() not in ACTIVATIONS:
        what = f"the policy's activation is {str(given['activation_fn'])[:60]}"
        raise InputError(what, where, f"known are {', '.join(ACTIVATIONS)}; state one of them: activation=NAME")
    return match[1].lower()


def _normalization(
    data: Mapping[str, Any], said: Normalization | str | None, algorithm: str, where: str
) -> Normalization | None:
    """Returns the normalization that a user stated; refuses a file that shows one where nobody said anything.

    In VecNormalize alone PPO and A2C remember an original observation beside the last one. The others always do.
    """
    if isinstance(said, Normalization):
        return said
    if said not in (None, NONE):
        raise InputError(f"normalization is '{said}'", where, "give a Normalization, a file of it, or none")
    if said is None and algorithm in ("PPO", "A2C") and data.get("_last_original_obs") is not None:
        advice = "state its statistics: normalization=FILE.json, or normalization=none where it changed rewards only"
        raise InputError("the policy was trained in VecNormalize", where, advice)
    return None


SAFETENSORS = ".safetensors"


def from_torch(
    weights: str | Path | Mapping[str, Any],
    world: World,
    net: str,
    activation: str,
    outputs: str,
    normalization: Normalization | None = None,
) -> LayersExpert:
    """The expert in a state dict, or in a file of one (torch's or safetensors); every agent of `world` plays by it.

    `net`: the name before the layers' numbers (CleanRL: `actor` of PPO, `network` of DQN); `activation`: relu, tanh,
    elu, leakyrelu or sigmoid; `outputs`: logits or q. InputError where that does not describe what is there.
    """
    if isinstance(weights, Mapping):
        tensors, where, digest = of_torch(weights, "state dict"), "state dict", ""
    else:
        path = Path(weights)
        data = runs.read(path, MAX_BYTES)
        where, digest = str(path), hashlib.sha256(data).hexdigest()
        tensors = read(data, where, path.suffix == SAFETENSORS)
    known = dict.fromkeys(name.rsplit(".", 2)[0] for name in tensors if name.count(".") >= 2)
    if net not in known:
        raise UnknownNameError("network", net, known, where)
    linear_layers = layers(tensors, net, where)
    if not linear_layers:
        raise InputError("there are no layers under that name", f"{where}: {net}", "name what comes before `.0.weight`")
    return LayersExpert(
        world, linear_layers, activation, outputs, normalization, {"algorithm": "torch state dict"}, digest
    )


NORMALIZATION = "normalization"
# kind -> what reads it, options that it must have, options that it may have
KINDS: Mapping[str, tuple[Callable[..., LayersExpert], tuple[str, ...], tuple[str, ...]]] = {
    "sb3": (from_sb3, (), ("activation", NORMALIZATION)),
    "torch": (from_torch, ("net", "activation", "outputs"), (NORMALIZATION,)),
}
MAX_STATISTICS = 2**20


class Statistics(msgspec.Struct, forbid_unknown_fields=True):
    """A JSON file of normalisation statistics; the defaults are VecNormalize's."""

    mean: list[float]
    var: list[float]
    clip: float = 10.0
    epsilon: float = 1e-8


def is_file(text: str) -> bool:
    """Returns True if a text names an expert in another library's file."""
    return text.partition(":")[0] in KINDS


def from_name(text: str, world: World | None) -> LayersExpert:
    """The expert that a text names; InputError where the text or the file is wrong, or the world is not said."""
    kind, _, rest = text.partition(":")
    make, needed, optional = KINDS[kind]
    file, *choices = re.split(rf",(?=(?:{'|'.join((*needed, *optional))}|\w+)=)", rest)
    options: dict[str, Any] = {}
    for choice in choices:
        key, _, value = choice.partition("=")
        if key not in (*needed, *optional):
            raise UnknownNameError(f"option of {kind}:", key, (*needed, *optional), text)
        options[key] = value
    missing = [key for key in needed if key not in options]
    if missing:
        example = f"{kind}:{file},net=actor,activation=tanh,outputs=logits"
        raise InputError(f"the file cannot say its {', '.join(missing)}", text, f"state it: {example}")
    if world is None:
        raise InputError("the file does not say which game it plays", text, "name it: --world gymnasium:CartPole-v1")
    if options.get(NORMALIZATION, NONE) != NONE:
        options[NORMALIZATION] = statistics(Path(options[NORMALIZATION]))
    elif kind != "sb3":
        options.pop(NORMALIZATION, None)
    return make(file, world, **options)


def statistics(path: Path) -> Normalization:
    """The normalisation that a JSON file states: `mean`, `var`, and `clip` and `epsilon` where they are unusual."""
    try:
        parsed = msgspec.json.decode(runs.read(path, MAX_STATISTICS), type=Statistics)
    except msgspec.DecodeError as error:
        advice = 'write {"mean": [...], "var": [...]}, with clip and epsilon where they are not 10 and 1e-8'
        raise InputError("not a file of normalisation statistics", f"{path}: {error}"[:200], advice) from None
    return Normalization(parsed.mean, parsed.var, parsed.clip, parsed.epsilon)  # type: ignore[arg-type]
