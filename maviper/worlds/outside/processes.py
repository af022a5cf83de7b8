"""A user's environment in play: copies of it, here or each in a process of its own.

Does: resets and steps the copies; turns what an environment raises into an InputError.
Assumes: spaces in which `pettingzoo.faults` found nothing; all live agents act at once.
Does not: send an environment through a pipe, only numbers; know what a world is.
"""

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.errors import InputError, MaviperError
from codegen.ir import Float32
from codegen.paths import Mask
from maviper.worlds.outside import sources
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.sources import Source, asking, output_aside
from maviper.worlds.outside.spaces import random_actions, taking
from maviper.worlds.world import Outcome, draw_legal

PROBE, ALONE, BESIDE = "probe", "alone", "beside"  # requests of other kinds than `reset` and `step`
PROBED = 10  # steps of an episode that is played alone, then beside another one
TRIAL, LONGER = 10.0, 20  # seconds that two copies may take, and how many times what one took alone
# seconds, of machines that do other work too: to write and read a message, to wake a process that waits for one
MESSAGE, WAKING = 1e-4, 1e-3
SPAWN, LOKY = "spawn", "loky"  # the latter in joblib's workers; a copy is told it, and does not know it
GRACE = 2.0  # seconds in which a copy may end by itself
UNGUARDED = 113  # exit code of a copy whose process, as it started, ran a script that wants copies itself


class Copy:
    """One copy of an environment in play.

    An agent whose episode has ended keeps its last observation; its reward is 0, its actions are ignored, and it does
    not come back before the next reset.
    """

    def __init__(self, env: Any, source: Source) -> None:
        self.env, self.source = env, source
        self.names = list(env.possible_agents)  # the environment's own
        self.truncated = False  # whether the last step cut an agent's episode
        self._sizes = [sources.space(env, "observation", name).shape[0] for name in self.names]
        self._taking = [taking(sources.space(env, "action", name)) for name in self.names]
        self._keys = [each.key for each in sources.read_told(env, source)]
        self._seen: list[Float32] = []
        self._ended: set[Any] = set()
        self._cut: set[Any] = set()  # those of them whose episode did not end by itself
        self.masks = [_mask(env, name, source, size) for name, size in zip(self.names, self._sizes, strict=True)]

    def ask(self, verb: str, argument: Any) -> Outcome:
        """`reset` with a seed or `step` with all agents' actions; InputError when the environment raises."""
        with output_aside(f"{self.source.text}: {verb}"):
            return self.answer(verb, argument)

    def answer(self, verb: str, argument: Any) -> Outcome:
        """Answers like `ask`, where output is aside already."""
        try:
            return self._reset(argument) if verb == "reset" else self._step(argument)
        except (Exception, SystemExit) as error:
            raise sources.fault(error, self.source, f"the environment's {verb}") from error

    def close(self) -> None:
        """Ends it, whatever it says to that: it did what we wanted of it."""
        with suppress(Exception, SystemExit), output_aside(f"{self.source.text}: close"):
            self.env.close()

    def _reset(self, seed: int) -> Outcome:
        observations, infos = self._parts(self.env.reset(seed=seed), "reset", "observations and infos")
        missing = [str(name) for name in self.names if name not in observations or name not in self.env.agents]
        if missing:
            what = f"reset: no observation of {', '.join(missing)}, or missing from `agents`"
            advice = "all of possible_agents must observe and act from the start"
            raise InputError(what, self.source.text, advice)
        self._ended, self._cut = set(), set()
        self._seen = [np.zeros(size, np.float32) for size in self._sizes]
        return self._outcome([], observations, {}, infos)

    def _step(self, actions: Sequence[Any]) -> Outcome:
        live, self.truncated = self._live(), False
        if not live:
            return self._outcome([], {}, {}, {})
        acted = zip(self.names, self._taking, actions, strict=True)
        chosen = {name: taken(action) for name, taken, action in acted if name in live}
        parts = "observations, rewards, terminations, truncations and infos"
        observations, rewards, terminated, truncated, infos = self._parts(self.env.step(chosen), "step", parts)
        ended = {name for name in live if terminated.get(name) or truncated.get(name) or name not in self.env.agents}
        self._ended |= ended
        self._cut |= {name for name in ended if truncated.get(name) and not terminated.get(name)}
        self.truncated = any(truncated.get(name) for name in live)
        return self._outcome(live, observations, rewards, infos)

    def _live(self) -> list[Any]:
        return [name for name in self.names if name not in self._ended]

    def _outcome(
        self,
        acted: Sequence[Any],
        observations: Mapping[Any, Any],
        rewards: Mapping[Any, Any],
        infos: Mapping[Any, Any],
    ) -> Outcome:
        live = self._live()
        for index, (name, size) in enumerate(zip(self.names, self._sizes, strict=True)):
            if name in observations and (name in acted or name in live):
                self._seen[index] = seen = single(observations[name], name, (size,), self.source)
                if name in live and np.isnan(seen).any():
                    where = f"number {int(np.isnan(seen).argmax())}"
                    raise InputError(f"{name} observes NaN, {where}", self.source.text, "observe numbers")
        gained = [float(rewards.get(name, 0.0)) if name in acted else 0.0 for name in self.names]
        ensure_finite(gained, self.source)
        done, ended = ([name in which for name in self.names] for which in (self._ended, self._ended - self._cut))
        turn = getattr(self.env, "acting", None)
        acting = [name not in self._ended and (turn is None or name in turn) for name in self.names]
        told = [[float(infos.get(name, {}).get(key, np.nan)) for key in self._keys] for name in self.names]
        return Outcome(list(self._seen), gained, done, ended, acting, told)

    def lawful(self, drawn: Sequence[Any], seen: Outcome) -> list[Any]:
        """Legal actions in place of drawn ones, agent by agent, after an outcome."""
        triples = zip(self.masks, seen.observations, drawn, strict=True)
        return [
            action if mask is None else int(draw_legal(mask, obs[None], np.array([(action + 0.5) / len(mask)]))[0])
            for mask, obs, action in triples
        ]

    def _parts(self, given: Any, verb: str, wanted: str) -> tuple[Any, ...]:
        n = 2 if verb == "reset" else 5
        parts = cast("tuple[Any, ...]", given) if isinstance(given, tuple) else ()
        if len(parts) != n:
            raise InputError(f"{verb} does not return {wanted}", self.source.text, "see PettingZoo's parallel API")
        return parts


def ensure_finite(gained: Any, source: Source) -> None:
    """InputError for rewards that are not finite."""
    if not np.isfinite(gained).all():
        wrong = [each for each in np.ravel(gained).tolist() if not np.isfinite(each)]
        raise InputError(f"a reward is {wrong[0]}", source.text, "give finite rewards")


def single(given: Any, name: Any, shape: tuple[int, ...], source: Source) -> Float32:
    """An agent's observation as float32, a copy; a double beyond the format rounds to infinity. InputError for one of
    another shape.
    """
    if type(given) is np.ndarray and given.dtype == np.float32:  # numpy's warnings need not be held back
        seen = given.copy()
    else:
        with np.errstate(over="ignore"):
            seen = np.array(given, dtype=np.float32)
    if seen.shape != shape:
        what = f"{name} observes an array of shape {seen.shape}, its space says {shape}"
        raise InputError(what, source.text, "return what observation_space says")
    return seen


def _mask(env: Any, name: Any, source: Source, size: int) -> Mask | None:
    """The places of an agent's mask among its `size` features, if the environment says that it has one."""
    legal, given = sources.read_legal_features(env, name, source), sources.table(env, "features", source).get(name)
    stated = [getattr(each, "name", "") for each in given] if sources.is_row(given) else []
    places = {each: place for place, each in enumerate(stated or [f"feature_{k}" for k in range(size)])}
    return tuple(places.get(each) for each in legal) if legal else None  # "" for what is always legal


class Copies:
    """Copies of one environment, made when first asked: in this process, or each in its own.

    `apart`: each in its own; None: whichever is quicker, which never changes an outcome.
    """

    def __init__(self, source: Source, make: Callable[[], Any], at_once: int, apart: bool | None = None) -> None:
        self.source, self.make, self.at_once = source, make, at_once
        self.apart = False if at_once == 1 else apart
        self._here: list[Copy] = []
        self._processes: list[_Process] = []

    def ask(self, verb: str, arguments: Sequence[Any]) -> list[Outcome]:
        """One request to each of the first copies, all at once; InputError when one raises or ends."""
        if self.apart is None:
            self.apart = not may_share(self.source, self.at_once)
        if not self.apart:
            while len(self._here) < len(arguments):
                self._here.append(Copy(self.make(), self.source))
            words = f"{self.source.text}: {verb}"
            with output_aside(words):  # once for all of them: to enter and leave takes as long as a small game's step
                return [copy.answer(verb, argument) for copy, argument in zip(self._here, arguments, strict=False)]
        try:
            while len(self._processes) < len(arguments):
                self._processes.append(_Process(self.source))
            asked = self._processes[: len(arguments)]
            for process, argument in zip(asked, arguments, strict=True):
                process.send(verb, argument)
            with asking(f"{self.source.text}: {verb}"):
                return [process.outcome() for process in asked]
        except BaseException:  # a Ctrl-C too: answers on their way would be taken for later ones
            self.close()
            raise

    def close(self) -> None:
        """Ends all copies; the next request starts fresh ones."""
        copies, self._here = self._here, []
        for copy in copies:
            copy.close()
        processes, self._processes = self._processes, []
        for process in processes:
            process.dismiss()
        for process in processes:
            process.end()


def may_share(source: Source, at_once: int = 0) -> bool:
    """Returns True if copies in one process leave each other alone; and, of `at_once` copies, if all of them play
    sooner so than apart. It is tried in another process, which an environment may end or keep for ever. A copy plays
    alone first: where its steps are slow, there is no second one.
    """
    trial = _Process(source)
    try:
        with asking(f"{source.text}: whether copies may share a process"):
            trial.send(ALONE, None)
            seconds, took = trial.outcome()
            if at_once and at_once * seconds >= seconds + at_once * MESSAGE + WAKING:
                return False
            trial.send(BESIDE, None)
            return trial.outcome(max(TRIAL, LONGER * took))
    except InputError:  # let it come up in play
        return False
    finally:
        trial.dismiss()
        trial.end()


class Probe(NamedTuple):
    """A random episode: how long it was, how it ended, what it paid."""

    steps: int
    ended: bool  # within the steps that it was given
    cut: bool  # by the environment, not by itself
    rewards: list[list[float]]  # [steps][n_agents]; NaN for who did not act


def probe_episode(copy: Copy, most: int) -> Probe:
    """A random episode of a copy, of at most so many steps."""
    rng, choices = np.random.default_rng(0), [sources.space(copy.env, "action", name) for name in copy.names]
    paid = list[list[float]]()
    with asking(f"{copy.source.text}: a random episode, to see how long it is and what it pays"):
        outcome = copy.ask("reset", 0)
        while len(paid) < most and not all(outcome.done):
            acting = outcome.acting
            outcome = copy.ask("step", copy.lawful(random_actions(choices, rng, 1)[0], outcome))
            paid.append([each if acts else np.nan for each, acts in zip(outcome.rewards, acting, strict=True)])
    return Probe(len(paid), all(outcome.done), copy.truncated, paid)


def probe_apart(source: Source, most: int) -> Probe:
    """Probes like `probe_episode`, in a process of its own, which the environment may end."""
    process = _Process(source)
    try:
        process.send(PROBE, most)
        with asking(f"{source.text}: a random episode, to see how long it is and what it pays"):
            return process.outcome()
    finally:
        process.dismiss()
        process.end()


def _play_alone(copy: Copy) -> tuple[float, float, list[Outcome]]:
    """Returns the seconds that a step of a copy takes at best, the seconds that all took, and the outcomes."""
    began = time.perf_counter()
    outcomes, times = [copy.ask("reset", 0)], list[float]()
    for acted in _probe_actions(copy):
        chosen, started = copy.lawful(acted, outcomes[-1]), time.perf_counter()
        outcomes.append(copy.ask("step", chosen))
        times.append(time.perf_counter() - started)
    return min(times), time.perf_counter() - began, outcomes


def _probe_actions(copy: Copy) -> Sequence[list[Any]]:
    rng = np.random.default_rng(0)
    return random_actions([sources.space(copy.env, "action", name) for name in copy.names], rng, PROBED)


def _plays_alike(alone: Sequence[Outcome], one: Copy, other: Copy) -> bool:
    """Returns True if an episode is as it was alone while another copy plays between its steps: copies that share a
    module's generator or simulator would disturb each other.
    """
    beside, others = [one.ask("reset", 0)], other.ask("reset", 1)
    for acted in _probe_actions(one):
        beside.append(one.ask("step", one.lawful(acted, beside[-1])))
        others = other.ask("step", other.lawful(acted, others))
    return [each.bytes for each in alone] == [each.bytes for each in beside]


def is_undisturbed(one: Copy, other: Copy) -> bool:
    """Returns True if copies of an environment that is known not to wait for others play here as each would alone;
    False where they fail.
    """
    try:
        return _plays_alike(_play_alone(one)[2], one, other)
    except MaviperError:  # let it come up in play
        return False
    finally:
        one.close()


class _Process:
    """A copy in a process of its own, and our end of its pipe."""

    def __init__(self, source: Source) -> None:
        if getattr(multiprocessing.current_process(), "_inheriting", False):  # it is importing the main script
            raise SystemExit(UNGUARDED)
        if multiprocessing.get_start_method(allow_none=True) == LOKY:
            multiprocessing.set_start_method(SPAWN, force=True)
        context = multiprocessing.get_context(SPAWN)
        self.source = source
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(theirs, source.text, str(Path.cwd())), daemon=True)
        with _deaf_to_interrupts():
            self.process.start()
        theirs.close()  # or its end would not end the pipe

    def send(self, verb: str, argument: Any) -> None:
        with suppress(OSError):  # `outcome` says that it has ended
            self.pipe.send((verb, argument))

    def outcome(self, limit: float | None = None) -> Any:
        """The answer; InputError for an error, the process's end, or none within `limit` seconds. MaviperError where
        the process ended since the main script has no guard: no other way to play would help.
        """
        try:
            if not self.pipe.poll(limit):
                self.process.kill()
            raised, answer = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join(GRACE)
            if self.process.exitcode == UNGUARDED:
                what = f"copies of {self.source.text} play in processes, and each of these runs the script again"
                script = getattr(sys.modules["__main__"], "__file__", "the script")
                advice = "write `if __name__ == '__main__':` above what it runs, and indent that"
                raise MaviperError(f"{what} from its first line", script, advice) from None
            what = f"a copy of the environment ended by itself, exit code {self.process.exitcode}"
            raise InputError(what, self.source.text, "its last output is on standard error") from None
        if raised:
            raise InputError(*answer)
        return answer

    def dismiss(self) -> None:
        with suppress(OSError):
            self.pipe.send(None)
        self.pipe.close()

    def end(self) -> None:
        self.process.join(GRACE)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()
        self.process.close()


@contextmanager
def _deaf_to_interrupts() -> Generator[None]:
    """A process that starts here never sees a Ctrl-C: that one is for us, and the process ends with its pipe."""
    resource_tracker.ensure_running()  # starting it lifts the mask
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(pipe: Connection, text: str, folder: str) -> None:
    """A copy's process: answers (raised, outcome or the error's three parts) until the pipe or a None ends it."""
    os.dup2((sources.open_log() or sys.stderr).fileno(), 1)  # standard output is for results
    os.chdir(folder)  # spawned processes start where their parent did
    source = sources.parse_source(text)
    copies, alone = list[Copy](), list[Outcome]()
    with suppress(EOFError, OSError):  # nobody asks any more
        while (request := pipe.recv()) is not None:
            try:
                while len(copies) < 1 + (request[0] == BESIDE):
                    copies.append(Copy(make_environment(import_maker(source), source), source))
                if request[0] == PROBE:
                    reply = probe_episode(copies[0], request[1])
                elif request[0] == ALONE:
                    *reply, alone = _play_alone(copies[0])
                else:
                    reply = _plays_alike(alone, *copies) if request[0] == BESIDE else copies[0].ask(*request)
                answer: tuple[bool, Any] = (False, reply)
            except InputError as error:
                answer = (True, (error.what, error.where, error.next_step))
            pipe.send(answer)
    for copy in copies:
        copy.close()


def cores() -> int:
    """Counts the CPU cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_importable(function: Callable[..., Any], source: Source) -> bool:
    """Returns True if another process would find the same function, and may be started."""
    module = sys.modules.get(source.module)
    shared = source.module != "__main__" and getattr(module, source.function, None) is function
    shared = shared and getattr(module, "__spec__", None) is not None
    return shared and not multiprocessing.current_process().daemon


def copies_at_once(function: Callable[..., Any], source: Source) -> int:
    """One a core; 1 where another process cannot have one."""
    return cores() if is_importable(function, source) else 1
