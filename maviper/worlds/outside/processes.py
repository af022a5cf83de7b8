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
from typing import Any, cast

import numpy as np

from codegen.errors import InputError, MaviperError
from codegen.ir import Float32
from codegen.legality import Mask
from maviper.worlds.outside.acting import random_actions, taking
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.silence import output_aside
from maviper.worlds.outside.sources import Source, fault, is_row, parse_source, read_legal_features, space, table
from maviper.worlds.world import Outcome, draw_legal

BESIDE = "beside"  # the request that `_beside` answers
PROBED = 10  # steps of an episode that is played alone, then beside another one
# seconds, of machines that do other work too: to write and read a message, to wake a process that waits for one
MESSAGE, WAKING = 1e-4, 1e-3
GRACE = 2.0  # seconds in which a copy may end by itself


class Copy:
    """One copy of an environment in play.

    An agent whose episode has ended keeps its last observation; its reward is 0, its actions are ignored, and it does
    not come back before the next reset.
    """

    def __init__(self, env: Any, source: Source) -> None:
        self.env, self.source = env, source
        self.names = list(env.possible_agents)  # the environment's own
        self.truncated = False  # whether the last step cut an agent's episode
        self._sizes = [space(env, "observation", name).shape[0] for name in self.names]
        self._taking = [taking(space(env, "action", name)) for name in self.names]
        self._seen: list[Float32] = []
        self._ended: set[Any] = set()
        self._cut: set[Any] = set()  # those of them whose episode did not end by itself
        self.masks = [_mask(env, name, source, size) for name, size in zip(self.names, self._sizes, strict=True)]

    def ask(self, verb: str, argument: Any) -> Outcome:
        """`reset` with a seed or `step` with all agents' actions; InputError when the environment raises."""
        with output_aside():
            return self.answer(verb, argument)

    def answer(self, verb: str, argument: Any) -> Outcome:
        """As `ask`, where output is aside already."""
        try:
            return self._reset(argument) if verb == "reset" else self._step(argument)
        except (Exception, SystemExit) as error:
            raise fault(error, self.source, f"the environment's {verb}") from error

    def close(self) -> None:
        """Ends it, whatever it says to that: it did what we wanted of it."""
        with suppress(Exception):
            self.env.close()

    def _reset(self, seed: int) -> Outcome:
        observations, _ = self._parts(self.env.reset(seed=seed), "reset", "observations and infos")
        missing = [str(name) for name in self.names if name not in observations or name not in self.env.agents]
        if missing:
            what = f"reset: no observation of {', '.join(missing)}, or missing from `agents`"
            advice = "all of possible_agents must observe and act from the start"
            raise InputError(what, self.source.text, advice)
        self._ended, self._cut = set(), set()
        self._seen = [np.zeros(size, np.float32) for size in self._sizes]
        return self._outcome([], observations, {})

    def _step(self, actions: Sequence[Any]) -> Outcome:
        live = self._live()
        self.truncated = False
        if not live:
            return self._outcome([], {}, {})
        acted = zip(self.names, self._taking, actions, strict=True)
        chosen = {name: taken(action) for name, taken, action in acted if name in live}
        parts = "observations, rewards, terminations, truncations and infos"
        observations, rewards, terminated, truncated, _ = self._parts(self.env.step(chosen), "step", parts)
        ended = {name for name in live if terminated.get(name) or truncated.get(name) or name not in self.env.agents}
        self._ended |= ended
        self._cut |= {name for name in ended if truncated.get(name) and not terminated.get(name)}
        self.truncated = any(truncated.get(name) for name in live)
        return self._outcome(live, observations, rewards)

    def _live(self) -> list[Any]:
        return [name for name in self.names if name not in self._ended]

    def _outcome(self, acted: Sequence[Any], observations: Mapping[Any, Any], rewards: Mapping[Any, Any]) -> Outcome:
        live = self._live()
        for index, (name, size) in enumerate(zip(self.names, self._sizes, strict=True)):
            if name in observations and (name in acted or name in live):
                self._seen[index] = seen = single(observations[name])
                if seen.shape != (size,):
                    mismatch = f"{name} observes an array of shape {seen.shape}, its space says ({size},)"
                    raise InputError(mismatch, self.source.text, "return what observation_space says")
        gained = [float(rewards.get(name, 0.0)) if name in acted else 0.0 for name in self.names]
        done, ended = ([name in which for name in self.names] for which in (self._ended, self._ended - self._cut))
        turn = getattr(self.env, "acting", None)
        acting = [name not in self._ended and (turn is None or name in turn) for name in self.names]
        return Outcome(list(self._seen), gained, done, ended, acting)

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


def single(given: Any) -> Float32:
    """An observation as float32, a copy; a double beyond the format rounds to infinity."""
    if type(given) is np.ndarray and given.dtype == np.float32:  # numpy's warnings need not be held back
        return given.copy()
    with np.errstate(over="ignore"):
        return np.array(given, dtype=np.float32)


def _mask(env: Any, name: Any, source: Source, size: int) -> Mask | None:
    """The places of an agent's mask among its `size` features, if the environment says that it has one."""
    legal, given = read_legal_features(env, name, source), table(env, "features", source).get(name)
    stated = [getattr(each, "name", "") for each in given] if is_row(given) else []
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
            self.apart = not self._quicker_here()
        if not self.apart:
            while len(self._here) < len(arguments):
                self._here.append(Copy(self.make(), self.source))
            with output_aside():  # once for all of them: to enter and leave takes as long as a small game's step
                return [copy.answer(verb, argument) for copy, argument in zip(self._here, arguments, strict=False)]
        try:
            while len(self._processes) < len(arguments):
                self._processes.append(_Process(self.source))
            asked = self._processes[: len(arguments)]
            for process, argument in zip(asked, arguments, strict=True):
                process.send(verb, argument)
            return [process.outcome() for process in asked]
        except BaseException:  # a Ctrl-C too: answers on their way would be taken for later ones
            self.close()
            raise

    def _quicker_here(self) -> bool:
        """Whether two copies in one process leave each other alone, and all of them play sooner here than apart. It is
        tried in another process, which an environment may end.
        """
        trial = _Process(self.source)
        try:
            trial.send(BESIDE, None)
            seconds, alike = trial.outcome()
        except InputError:  # let it come up in play
            return False
        finally:
            trial.dismiss()
            trial.end()
        return alike and self.at_once * seconds < seconds + self.at_once * MESSAGE + WAKING

    def close(self) -> None:
        """Ends all copies; the next request starts fresh ones."""
        for copy in self._here:
            copy.close()
        processes, self._processes, self._here = self._processes, [], []
        for process in processes:
            process.dismiss()
        for process in processes:
            process.end()


def _beside(one: Copy, other: Copy) -> tuple[float, bool]:
    """How long a step of a copy takes at best, and whether an episode is the same while another copy plays between its
    steps: copies that share a module's generator or simulator would disturb each other.
    """
    rng = np.random.default_rng(0)
    actions = random_actions([space(one.env, "action", name) for name in one.names], rng, PROBED)
    alone, times = [one.ask("reset", 0)], list[float]()
    for acted in actions:
        chosen, started = one.lawful(acted, alone[-1]), time.perf_counter()
        alone.append(one.ask("step", chosen))
        times.append(time.perf_counter() - started)
    beside, others = [one.ask("reset", 0)], other.ask("reset", 1)
    for acted in actions:
        beside.append(one.ask("step", one.lawful(acted, beside[-1])))
        others = other.ask("step", other.lawful(acted, others))
    return min(times), [each.bytes for each in alone] == [each.bytes for each in beside]


def is_undisturbed(one: Copy, other: Copy) -> bool:
    """Whether copies play in one process as each would alone; False where they fail."""
    try:
        return _beside(one, other)[1]
    except MaviperError:  # let it come up in play
        return False
    finally:
        one.close()


class _Process:
    """A copy in a process of its own, and our end of its pipe."""

    def __init__(self, source: Source) -> None:
        context = multiprocessing.get_context("spawn")
        self.source = source
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(theirs, source.text, str(Path.cwd())), daemon=True)
        with _deaf_to_interrupts():
            self.process.start()
        theirs.close()  # or its end would not end the pipe

    def send(self, verb: str, argument: Any) -> None:
        with suppress(OSError):  # `outcome` says that it has ended
            self.pipe.send((verb, argument))

    def outcome(self) -> Any:
        try:
            raised, answer = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join(GRACE)
            what = f"a copy of the environment ended by itself, exit code {self.process.exitcode}"
            advice = "its last output is on standard error; a script of your own needs `if __name__ == '__main__':`"
            raise InputError(what, self.source.text, advice) from None
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
    os.dup2(2, 1)  # standard output is for results
    os.chdir(folder)  # spawned processes start where their parent did
    source = parse_source(text)
    copy = None
    with suppress(EOFError, OSError):  # nobody asks any more
        while (request := pipe.recv()) is not None:
            try:
                copy = copy or Copy(make_environment(import_maker(source), source), source)
                beside = request[0] == BESIDE
                reply = (
                    _beside(copy, Copy(make_environment(import_maker(source), source), source))
                    if beside
                    else copy.ask(*request)
                )
                answer: tuple[bool, Any] = (False, reply)
            except InputError as error:
                answer = (True, (error.what, error.where, error.next_step))
            pipe.send(answer)
    if copy is not None:
        copy.env.close()


def cores() -> int:
    """How many CPU cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def copies_at_once(function: Callable[..., Any], source: Source) -> int:
    """One a core; 1 where another process would not find the same function, or none may be started."""
    module = sys.modules.get(source.module)
    shared = source.module != "__main__" and getattr(module, source.function, None) is function
    shared = shared and getattr(module, "__spec__", None) is not None
    return cores() if shared and not multiprocessing.current_process().daemon else 1
