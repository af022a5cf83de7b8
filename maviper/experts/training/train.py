"""Training runs: an expert in a run folder, the best of its checkpoints on held-out episodes, or the best of seeds.

Does: trains with a live line, one seed or several side by side, judges checkpoints, keeps the best in the folder at all
  times, resumes, measures the winner on fresh episodes.
Assumes: the extra `maviper[train]`.
Does not: know how an algorithm learns.

A run folder holds config.json, metrics.jsonl (one line per checkpoint), checkpoints/ (the finalists so far),
state.safetensors (to resume from) and expert.safetensors (the best so far); when it is done also card.json and
learning_curve.svg. An interrupted run goes on from its last checkpoint and gives the same expert, byte for byte.
"""

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from codegen.errors import InputError, MissingToolError
from codegen.ir import Float32
from maviper.console import Console, LiveLine
from maviper.episodes import measures
from maviper.episodes.measures import Estimate, format_estimate
from maviper.experts import cards, network
from maviper.experts.cards import DEFAULT, MAPPO, Judged, Request, Rival, schedule, settings
from maviper.experts.network import ACTOR, ACTOR_CRITIC, NetworkExpert
from maviper.files import resuming, runs
from maviper.files.jobs import Scored, best_of, ensure_counts, folder_of, is_resumed, side_by_side
from maviper.files.runs import working_alone
from maviper.options import TrainOptions, make_request
from maviper.worlds import World, find
from maviper.worlds.world import RETURN

CHECKPOINT_EPISODES = 1_000
FINALISTS = 5
FINAL_EPISODES = 4_000
SLOW = 10  # a world that plays few games at once is judged on so many times fewer episodes
EXPERT_FILE, CARD_FILE, CURVE_FILE = "expert.safetensors", "card.json", "learning_curve.svg"
METRICS_FILE, STATE_FILE, CHECKPOINTS = "metrics.jsonl", "state.safetensors", "checkpoints"
STATE_FORMAT = "maviper-training-3"
MAX_STATE_BYTES = 2**33
SAME = ("world", "algorithm", "recipe", "against")  # in a resumed run's config
CHOOSING, CRITIC = "choosing", "critic"  # stages after the training


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint's place in training and what it scored."""

    steps: int
    score: float
    measured: dict[str, Estimate]  # each team's primary measure
    returns: dict[str, Estimate]


@dataclass(frozen=True)
class Step:
    """The progress of a stage of a training."""

    stage: str  # what teaches the actors; then CHOOSING, CRITIC
    done: int  # joint steps of the stage; finalists
    total: int
    said: str = ""  # how it goes


OnStep = Callable[[Step], None]


def train(
    world: World,
    folder: Path,
    request: Request,
    on_checkpoint: Callable[[Checkpoint, int], None] = lambda checkpoint, total: None,
    resume: bool = False,
    on_step: OnStep = lambda step: None,
) -> dict[str, Any]:
    """Trains an expert for `world` into `folder`; returns its card. `on_checkpoint` also gets the number of all steps.

    MissingToolError without torch; InputError for settings, a device or a folder that cannot be used, and for a
    training whose loss stops being a number before there is a checkpoint.
    """
    request = request.complete()
    trainer_of, chosen = _trainer(request.algorithm), settings_of(world, request)
    _check_device(request.device)
    experts = _against(world, request)
    met = {name: expert.hash for name, expert in experts.items()}
    config = {**cards.config(world, request, chosen, _rule(world)), "against": met}
    done = _prepare_folder(folder, config, resume)
    if done is not None:
        return done
    trainer = trainer_of.trainer(world, chosen, request.device)
    if experts:
        trainer.meet(list(experts.values()))
    if request.begin is not None:
        trainer.begin(request.begin)
    with working_alone(folder):
        run = _Run(folder, config, trainer, on_step)
        run.restore()
        fault = run.finish_training(on_checkpoint)
        closing = time.monotonic()
        card, tensors = run.best(fault, request.critic)
        runs.write(folder / EXPERT_FILE, network.encode(tensors, card))
        runs.write(folder / CURVE_FILE, cards.learning_curve(world, run.lines))
        seconds = run.seconds + time.monotonic() - closing
        card |= {"seconds": round(seconds, 1), "machine": cards.machine(request.device)}
        runs.write(folder / CARD_FILE, runs.as_json(card))
    return card


def settings_of(world: World, request: Request) -> Any:
    """The settings of a training, a dataclass; errors as those of `train`."""
    known = request.complete()
    algorithm = known.algorithm
    if world.masked and algorithm != MAPPO:
        advice = f"choose --algorithm {MAPPO}, and no other recipe than {DEFAULT}"
        raise InputError(f"{algorithm} takes no heed of illegal actions", world.name, advice)
    if world.continuous:
        unfit = {  # what needs numbered actions
            f"--algorithm {known.algorithm}": known.algorithm != MAPPO,
            f"--recipe {known.recipe}": known.recipe != DEFAULT,
            "--against": bool(known.against),
        }
        for option, given in unfit.items():
            if given:
                what = f"{option} is for numbered actions, and here agents give numbers"
                raise InputError(what, world.name, f"leave it out: Gaussian actors learn by {MAPPO}")
    return settings(world, request, _trainer(algorithm).settings)


class _Algorithm(NamedTuple):
    settings: type
    trainer: Callable[[World, Any, str], Any]


def _trainer(algorithm: str) -> _Algorithm:
    try:
        import torch  # pyright: ignore[reportMissingImports]

        from maviper.experts.training import mappo, off_policy

        import_module("matplotlib")  # which draws the curve at the end, and is missed now rather than then
    except ImportError as error:
        advice = "install the extra: pip install 'maviper[train]'"
        raise MissingToolError(f"training needs {error.name or 'torch'}", "", advice) from None
    torch.set_num_threads(1)  # small products: threads cost more than they give, and one thread repeats bit for bit
    return {
        MAPPO: _Algorithm(mappo.Settings, mappo.Mappo),
        "maddpg": _Algorithm(off_policy.MaddpgSettings, off_policy.Maddpg),
        "vdn": _Algorithm(off_policy.VdnSettings, off_policy.Vdn),
    }[algorithm]


def _against(world: World, request: Request) -> Mapping[str, Any]:
    from maviper.experts.training.mappo import by_reward_alone

    return by_reward_alone(world, request.against)


def _check_device(device: str) -> None:
    import torch  # pyright: ignore[reportMissingImports]

    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, ValueError, NotImplementedError):
        here = ["cpu", *(f"cuda:{index}" for index in range(torch.cuda.device_count()))]
        raise InputError(
            f"there is no device '{device[:40]}'", "--device", f"devices here: {', '.join(here)}"
        ) from None


def _episodes(world: World) -> tuple[int, int]:
    """On how many episodes checkpoints, and in the end finalists, are judged."""
    slow = 1 if world.games is None else SLOW
    return CHECKPOINT_EPISODES // slow, FINAL_EPISODES // slow


def _rule(world: World) -> str:
    """Describes in words the rule by which the expert is chosen."""
    checkpoint, final = _episodes(world)
    score, again = "the mean over teams of the primary measure among experts (of a share, its log-odds)", ""
    if cards.is_rated(world):
        score = (
            f"its rating against the {cards.N_RIVALS} best checkpoints before it in the same run (their ratings plus "
            "what it gains on them in every team's place)"
        )
        again = "each against all others, "
    return (
        f"a checkpoint's score, on {checkpoint} episodes, is {score}; no script takes part; the {FINALISTS} best are "
        f"scored again on {final} fresh episodes, {again}and the best of these is the expert; `measured` comes from "
        f"{final} other episodes that no choice has seen"
    )


def _prepare_folder(folder: Path, config: Mapping[str, Any], resume: bool) -> dict[str, Any] | None:
    """Makes sure that the folder is this run's; the card when the run is done already."""
    place = folder / CARD_FILE
    same = (*SAME, *(name for name in (cards.BEGINS_WITH,) if name in config))
    if not runs.claim(folder, config, same, resume) or not place.exists():
        return None
    try:
        return json.loads(runs.read(place, runs.MAX_CONFIG_BYTES))
    except ValueError:
        raise InputError("not a readable run folder", str(place), "start again in another folder") from None


class _Run:
    """A training in its folder."""

    def __init__(self, folder: Path, config: Mapping[str, Any], trainer: Any, on_step: OnStep) -> None:
        self.folder, self.config, self.trainer, self.world = folder, config, trainer, trainer.world
        self.on_step = on_step
        self.lines: list[dict[str, Any]] = []
        self.seconds = 0.0
        self.learned: dict[str, int] = dict.fromkeys((cards.IMITATION, cards.VALUES, cards.REWARD), 0)  # joint steps

    def finish_training(self, on_checkpoint: Callable[[Checkpoint, int], None]) -> str:
        """Trains to the end; returns what went wrong, or ""."""
        trainer, every = self.trainer, self.trainer.settings.checkpoint_steps
        started, before = time.monotonic(), self.seconds
        while trainer.steps < trainer.settings.steps:
            due = (trainer.steps // every + 1) * every
            logged: dict[str, float] = {}
            told = self._here(logged)
            while trainer.steps < min(due, trainer.settings.steps):
                told = self._here(logged)
                self.on_step(told)
                logged = self._advance()
                if not all(math.isfinite(value) for value in logged.values()):
                    return f"stopped after {trainer.steps} steps: the loss was no longer a number"
            best = self._finalists()[: cards.N_RIVALS] if cards.is_rated(self.world) else []
            rivals = [Rival(self._load_checkpoint(line["steps"]), line["score"]) for line in best]
            judged = self._judge(trainer.tensors(), measures.CHECKPOINT_SEEDS, _episodes(self.world)[0], rivals)
            self.seconds = before + time.monotonic() - started
            self._save(judged, logged)
            returns = {m.team: estimate for m, estimate in judged.among.items() if m.name == RETURN}
            on_checkpoint(
                Checkpoint(trainer.steps, judged.score, judged.primary(self.world), returns), trainer.settings.steps
            )
            self.on_step(replace(told, done=self.learned[told.stage]))
        return ""

    def _here(self, logged: Mapping[str, float]) -> Step:
        """Where the training is, in what teaches next."""
        kind = self.trainer.teaches
        done, left = self.learned[kind], self.trainer.until - self.trainer.steps
        agreed = f"fidelity {logged['fidelity']:.2f}" if kind == cards.IMITATION and "fidelity" in logged else ""
        return Step(kind, done, done + left, agreed)

    def _advance(self) -> dict[str, float]:
        kind, before = self.trainer.teaches, self.trainer.steps
        logged = self.trainer.advance()
        self.learned[kind] += self.trainer.steps - before
        return logged

    def _card(self, **more: Any) -> dict[str, Any]:
        return {**self.config, "networks": self.trainer.networks, **more}

    def _judge(self, tensors: Mapping[str, Float32], first: int, episodes: int, rivals: Sequence[Rival] = ()) -> Judged:
        expert = network.build_expert(self.world, tensors, {"world": self.world.name})
        return cards.judge(self.world, expert, range(first, first + episodes), rivals)

    def _load_checkpoint(self, steps: int) -> NetworkExpert:
        data = runs.read(self._checkpoint(steps), network.MAX_BYTES)
        return network.decode(data, "checkpoint", self.world)

    def _save(self, judged: Judged, logged: Mapping[str, float]) -> None:
        """Writes a checkpoint so that an interruption at any point leaves a run that can go on."""
        trainer, tensors = self.trainer, self.trainer.tensors()
        steps = trainer.steps
        best = max((line["score"] for line in self.lines), default=-math.inf)
        learned = dict(self.learned)
        row = {"steps": steps, "score": judged.score, "learned": learned}
        self.lines.append({**row, **logged, **cards.table(judged)})
        card = self._card(steps=steps, learned=learned, measured={"note": "interrupted before the final measurement"})
        data = network.encode(tensors, card)
        runs.write(self._checkpoint(steps), data)
        runs.write(self.folder / METRICS_FILE, "".join(json.dumps(line) + "\n" for line in self.lines))
        if judged.score > best:
            runs.write(self.folder / EXPERT_FILE, data)
        runs.write(self.folder / STATE_FILE, self._state())
        kept = {self._checkpoint(line["steps"]).name for line in self._finalists()}
        for path in (self.folder / CHECKPOINTS).iterdir():
            if path.name not in kept:
                path.unlink()

    def _checkpoint(self, steps: int) -> Path:
        return self.folder / CHECKPOINTS / f"{steps:012d}.safetensors"

    def _finalists(self) -> list[dict[str, Any]]:
        return sorted(self.lines, key=lambda line: (-line["score"], line["steps"]))[:FINALISTS]

    def _state(self) -> bytes:
        from safetensors.torch import save  # pyright: ignore[reportMissingImports]

        tensors, facts = self.trainer.state()
        known = {"facts": facts, "seconds": self.seconds, "learned": self.learned}
        return save(tensors, metadata={STATE_FORMAT: json.dumps(known)})

    def restore(self) -> None:
        """Goes back to the state that the folder holds, if it holds one."""
        place = self.folder / STATE_FILE
        if not place.exists():
            return
        from safetensors import SafetensorError
        from safetensors.torch import load  # pyright: ignore[reportMissingImports]

        data = runs.read(place, MAX_STATE_BYTES)
        try:
            header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
            known = json.loads(header["__metadata__"][STATE_FORMAT])
            self.trainer.restore(load(data), known["facts"])
            self.seconds, self.learned = known["seconds"], known["learned"]
            lines = runs.read(self.folder / METRICS_FILE, 2**28).decode().splitlines()
            read = [json.loads(line) for line in lines]
        except (SafetensorError, ValueError, LookupError, TypeError, AttributeError, RuntimeError):
            advice = "start again in another folder; expert.safetensors is still the best checkpoint"
            raise InputError("the training state is damaged, or belongs to another run", str(place), advice) from None
        self.lines = [line for line in read if line["steps"] <= self.trainer.steps]

    def best(self, fault: str, critic: bool = True) -> tuple[dict[str, Any], dict[str, Float32]]:
        """The winner among the finalists, with a critic where one is asked for, and its card."""
        if not self.lines:
            raise InputError(f"the training {fault}", str(self.folder), "try a lower learning rate")
        episodes = _episodes(self.world)[1]
        learned = {line["steps"]: line["learned"] for line in self.lines}
        finalists = {line["steps"]: self._load_checkpoint(line["steps"]) for line in self._finalists()}
        self.on_step(Step(CHOOSING, 0, len(finalists)))
        seeds = range(measures.FINALIST_SEEDS, measures.FINALIST_SEEDS + episodes)
        score, steps = max(zip(cards.scores(self.world, list(finalists.values()), seeds), finalists, strict=True))
        tensors = finalists[steps].tensors
        judged = self._judge(tensors, measures.MEASUREMENT_SEEDS, episodes)
        self.on_step(Step(CHOOSING, len(finalists), len(finalists)))
        networks, played = self.trainer.networks, {"training": self.trainer.steps}
        if networks == ACTOR and critic and not self.world.continuous:
            fitted, played[CRITIC] = self._critic(tensors)
            tensors, networks = {**tensors, **fitted}, ACTOR_CRITIC
        measured = {"episodes": episodes, "first_episode_seed": measures.MEASUREMENT_SEEDS, **cards.table(judged)}
        card = self._card(steps=steps, learned=learned[steps], played=played, score=score, measured=measured)
        card["networks"] = networks
        return card | ({"stopped": fault} if fault else {}), dict(tensors)

    def _critic(self, actors: Mapping[str, Float32]) -> tuple[dict[str, Float32], int]:
        """A critic for the actors, and the joint steps that it took."""
        from maviper.experts.training import off_policy

        chosen = self.trainer.settings
        shared = {name: getattr(chosen, name) for name in ("hidden", "gamma", "scaled", "seed")}
        shared["shaping"] = chosen.shaping * chosen.critic_shaping
        wanted = off_policy.CriticSettings(**shared)
        if self.world.games is not None:
            wanted = replace(wanted, steps=min(wanted.steps, chosen.steps))
        steps: list[int] = []

        def tell_progress(done: int, total: int, loss: float) -> None:
            steps[:] = [done]
            self.on_step(Step(CRITIC, done, total, f"loss {loss:.3g}" if done else ""))

        return off_policy.fit_critic(self.world, actors, wanted, self.trainer.device, tell_progress), steps[0]


MAX_SEED = 2**32


def train_expert(name: str, folder: Path, console: Console, **options: Unpack[TrainOptions]) -> dict[str, Any]:
    """Trains an expert for the named world into a run folder; returns its card.

    The card says `stopped` where a training had to stop early.
    """
    asked = make_request(TrainOptions, options)
    overrides: dict[str, Any] = {"seed": asked.seed}
    overrides |= {} if asked.steps is None else {"steps": asked.steps}
    for text in asked.settings:
        key, separator, value = text.partition("=")
        if not separator:
            raise InputError(f"'{text[:40]}' is not a setting", "--set", "write --set NAME=VALUE")
        overrides[key] = value
    request = Request(asked.algorithm, asked.recipe, overrides, asked.device, asked.against).complete()
    world = find(name, giving=True)
    seeds = range(asked.seed, asked.seed + asked.seeds)
    ensure_counts(asked.seeds, asked.jobs)
    if not 0 <= seeds[0] <= seeds[-1] < MAX_SEED:
        raise InputError(f"seeds must be from 0 to {MAX_SEED - 1}, not {_seeds(seeds)}", "--seed, --seeds")
    runs.ensure_vacant(folder, EXPERT_FILE, asked.resume)
    resuming.resumable(partial(runs.holds_run, folder))
    console.line("training", f"{world.name}, {request.algorithm}, recipe {request.recipe}, {_seeds(seeds)}")
    console.line("", schedule(request, settings_of(world, request)))
    if len(seeds) == 1:
        return _one(world, folder, request, asked.resume, console)
    # each seed in a folder of its own; the one with the best score on its finalists' episodes becomes the run's
    tasks: list[tuple[Any, ...]] = []
    for seed in seeds:
        place, one = folder_of(folder, seed), replace(request, overrides={**request.overrides, "seed": seed})
        tasks.append((name, place, one, is_resumed(place, asked.resume), console.quiet))
    best, card = best_of(folder, seeds, side_by_side(_beside, tasks, asked.jobs), _read_score, console.line)
    kept = (EXPERT_FILE, CARD_FILE, CURVE_FILE)
    runs.write_all(folder, {file: (folder_of(folder, best) / file).read_bytes() for file in kept})
    return card


def _seeds(seeds: Sequence[int]) -> str:
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def _one(world: World, folder: Path, request: Request, resume: bool, console: Console) -> dict[str, Any]:
    with _Stages(console, resume) as stages:
        return train(world, folder, request, stages.keep_best, resume, stages.show)


class _Stages:
    """A live line for each stage of a training. `resumed`: what is told first was done by an earlier call."""

    def __init__(self, console: Console, resumed: bool) -> None:
        self.console, self.resumed, self.stage, self.best = console, resumed, "", -math.inf
        self._said = ""
        self._open = ExitStack()
        self._live: LiveLine | None = None

    def __enter__(self) -> "_Stages":
        return self

    def __exit__(self, *caught: object) -> None:
        self._open.close()

    def keep_best(self, checkpoint: Checkpoint, total: int) -> None:
        """Keeps what a checkpoint scored, if it is the best so far."""
        del total
        if checkpoint.score > self.best:
            self.best = checkpoint.score
            self._said = (
                f"best {_format_estimates(checkpoint.measured)}; return {_format_estimates(checkpoint.returns)}"
            )

    def show(self, step: Step) -> None:
        """Shows how far a stage is."""
        if step.stage != self.stage or self._live is None:
            self._open.close()
            live = self.console.live(step.stage, step.total, step.done if self.resumed else 0)
            self.stage, self._live = step.stage, self._open.enter_context(live)
        self._live.update(step.done, "  ".join(filter(None, (step.said, self._said))))


def _format_estimates(estimates: Mapping[str, Estimate]) -> str:
    return ", ".join(f"{team} {format_estimate(value)}" for team, value in estimates.items())


def _read_score(card: Mapping[str, Any]) -> Scored:
    return Scored(card["score"], f", best after {card['steps']:,} steps, {card['seconds']:.0f} s", card["measured"])


def _beside(name: str, folder: Path, request: Request, resume: bool, quiet: bool) -> dict[str, Any]:
    """One of several seeds, whose lines say whose they are."""
    return _one(find(name, giving=True), folder, request, resume, Console(quiet, f"seed {request.overrides['seed']}"))
