"""Environments by name: `module:function,option=value`, `gymnasium:ID`, `vmas:SCENARIO` or `system:FILE`.

Does: reads such a name; asks an environment for its spaces and attributes; turns what it raises into an InputError;
  keeps what other people's code prints off standard output, which is for results: in a file of a run, or on standard
  error; has a command say what a long wait is for.
Assumes: whoever names an environment means to run its code; what is printed meanwhile by other threads may go to
  standard error as well; a command keeps descriptor 1 to itself (`exits.keep_output`).
Does not: import or make an environment (making.py), play one, or know what a world is; touch what programs write past
  Python's streams; stop what takes long.
"""

import os
import re
import sys
import threading
import time
import traceback
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple, TextIO, TypeGuard, cast

import numpy as np

from codegen.check import identifier
from codegen.errors import InputError, MaviperError, escape_text
from codegen.ir import Float64
from codegen.process import silence_warnings
from maviper import console
from maviper.files import runs
from maviper.worlds.world import RETURN

FIRST, NEXT = 5.0, 10.0  # seconds of a wait before it is said, and before it is said again
SUM, MEAN, LAST = HOW = "sum", "mean", "last"  # of a number in infos over an episode
LOWER, HIGHER = BETTER = "lower", "higher"
LOG_FILE = "environment.log"
LOG = "MAVIPER_ENVIRONMENT_LOG"  # the variable that names it for this process, and for those that it starts
_lock = threading.RLock()  # a collected world closes its copies, and so comes here, wherever memory is asked for
_log: TextIO | None = None  # the open file
_inside: list[TextIO] = []  # standard output as each found it that is within: the first one's is the real one
_asked: list[tuple[str, float]] = []  # what other people's code is asked for, the outermost first, and since when
_watch: list[threading.Thread] = []


@contextmanager
def output_aside(words: str = "") -> Generator[None]:
    """Standard output is the log of a run, else standard error, until the last thread has left. `words`: as in
    `asking`.
    """
    with _lock:
        _inside.append(sys.stdout)
        sys.stdout = open_log() or sys.stderr
    try:
        with asking(words):
            yield
    finally:
        with _lock:
            if len(_inside) == 1:
                sys.stdout = _inside[0]
            _inside.pop()


@contextmanager
def logging_output(folder: Path, say: Callable[[str, str], None]) -> Generator[None]:
    """What environments print to standard output goes to LOG_FILE in a run's folder, here and in processes that start
    meanwhile; in a command also what their C code and child processes print. `say`: shows a label and a line, where
    there is something in it.
    """
    global _log
    path = folder.absolute() / LOG_FILE
    with runs.folder_while_filled(folder):
        before = path.stat().st_size if path.exists() else 0
        os.environ[LOG] = str(path)
        try:
            with cast("TextIO", open_log()), _descriptor_aside():
                yield
        finally:
            _log = None
            del os.environ[LOG]
            if path.exists() and path.stat().st_size > before:
                say("output", f"of the environment: {folder / LOG_FILE}")
            elif not before:
                path.unlink(missing_ok=True)


@contextmanager
def _descriptor_aside() -> Generator[None]:
    """Descriptor 1 is the log, in a command that keeps another one for its results."""
    if _log is None or console.current is None or sys.stdout is None or sys.stdout is sys.__stdout__:
        yield
        return
    kept = os.dup(1)
    os.dup2(_log.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def open_log() -> TextIO | None:
    """The log of the run that this process works for; None where there is none."""
    global _log
    if _log is None and (name := os.environ.get(LOG)):
        try:
            _log = Path(name).open("a", encoding="utf-8", errors="replace", buffering=1)  # noqa: SIM115
        except OSError as error:
            raise runs.unwritten(Path(name), error) from None
    return _log


@contextmanager
def asking(words: str) -> Generator[None]:
    """A command says what it waits for, in these words, where this takes long; "" says nothing."""
    if not words:
        yield
        return
    if not _watch and console.current is not None:
        _watch.append(threading.Thread(target=_say_waits, daemon=True))
        _watch[0].start()
    mine = (words, time.monotonic())
    _asked.append(mine)
    try:
        yield
    finally:
        _asked.remove(mine)


def _say_waits() -> None:
    """Says, while the process lives, what is asked for long."""
    said: dict[tuple[str, float], float] = {}
    while True:
        time.sleep(FIRST / 5)
        now, asked = time.monotonic(), list(_asked)
        if not asked or console.current is None:
            continue
        since = asked[0][1]
        if now - since >= FIRST and now - said.get(asked[0], -NEXT) >= NEXT:
            said = {asked[0]: now}
            console.current.line("waiting", f"{', '.join(words for words, _ in asked)}: {now - since:.0f} s")


GYMNASIUM = "gymnasium"  # the module whose functions are the ids of its registered environments
MAX_NAME = 50
SYSTEM = "system"  # the module whose functions are paths of world files
VMAS = "vmas"  # the module whose functions are the names of its scenarios
MAX_STEPS, WRAP = "max_steps", "wrap"  # the options that are ours: how long an episode may be, and wrappers
INSTALLED = {"site-packages", "dist-packages"}  # folders of packages, which are not what a user would fix
NUMBER = re.compile(r"-?[0-9]{1,18}")
OURS = Path(__file__).parents[2]
CHECK = "fix it there, then run `maviper worlds check`"
MAX_MESSAGE = 300  # characters of what an environment says when it raises
MAX_ACTIONS = 1 << 16  # of an agent: beyond it, they are numbers rather than choices


@dataclass(frozen=True)
class Source:
    """Where an environment comes from: `module:function,option=value`."""

    module: str
    function: str
    options: Mapping[str, int | str]
    maker: Callable[..., Any] | None = field(default=None, compare=False, repr=False)  # the function itself, if given

    @staticmethod
    def of(function: Callable[..., Any]) -> "Source":
        """A function of Python that was given itself, under the name that it would have."""
        named = cast("Any", function)
        parts = getattr(named, "__module__", ""), getattr(named, "__qualname__", "").rpartition(".")[2]
        module, called = (re.sub(r"[^A-Za-z0-9_.]+", "", part or "") for part in parts)
        legal = module and all(part.isidentifier() for part in module.split("."))
        return Source(module if legal else "given", called if called.isidentifier() else "given", {}, function)

    @property
    def reference(self) -> str:
        """`module:function`; of a world file without its folder."""
        return f"{self.module}:{Path(self.function).name if self.module == SYSTEM else self.function}"

    @property
    def called(self) -> str:
        """A name for the world: the module's and the function's, or that of a world file."""
        if self.module == "__main__":  # a notebook's, or a script's
            return self.function
        return Path(self.function).stem if self.module == SYSTEM else f"{self.module}-{self.function}"

    @property
    def text(self) -> str:
        """The whole, as the command line reads it; options in alphabetical order."""
        chosen = (f"{key}={value}" for key, value in sorted(self.options.items()))
        return ",".join([f"{self.module}:{self.function}", *chosen])


def is_named_by_user(name: str) -> bool:
    """Returns True if a world's name is a `module:function`, not that of one of our games."""
    return ":" in name.split(",")[0]


def parse_source(text: str) -> Source:
    """The parts of `module:function,option=value`; InputError when it has another form."""
    reference, *choices = text.split(",")
    module, _, function = reference.partition(":")
    if module not in (GYMNASIUM, SYSTEM) and not all(part.isidentifier() for part in (*module.split("."), function)):
        raise InputError("not of the form module:function", text, "write it as in `import`: package.module:function")
    options: dict[str, int | str] = {}
    for choice in choices:
        key, _, value = choice.partition("=")
        if not key.isidentifier() or not value:
            raise InputError(f"cannot read the option '{choice}'", text, f"write {reference},OPTION=VALUE")
        options[key] = int(value) if NUMBER.fullmatch(value) else value
    return Source(module, function, options)


def value_of(text: int | str) -> Any:
    """An option's value: True, False and numbers are that, anything else is text."""
    if text in ("True", "False"):
        return text == "True"
    try:
        return float(text) if isinstance(text, str) else text
    except ValueError:
        return text


def fault(error: BaseException, source: Source, doing: str, advice: str = CHECK) -> MaviperError:
    """Returns the error for what a user's code raised, with the line that raised it and, where that is in a package,
    the last one of the user's own before it.
    """
    if isinstance(error, MaviperError):
        return error
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if OURS not in Path(frame.filename).parents]
    frames = [frame for frame in frames if not frame.filename.startswith("<")]
    own = [frame for frame in frames if not INSTALLED.intersection(Path(frame.filename).parts)]
    ends = [*frames[-1:], *(own[-1:] if own[-1:] != frames[-1:] else [])]
    place = ", called at ".join(f"{each.filename}:{each.lineno}, in {each.name}" for each in ends)
    message = " ".join(str(error).split())[:MAX_MESSAGE]
    said = f"{type(error).__name__}: {message}" if message else type(error).__name__
    return InputError(f"{doing} raised {said}", f"{source.text}: {place}" if place else source.text, advice)


def attribute(env: Any, name: str, source: Source) -> Any:
    """An attribute of the environment or of the one that it wraps, or None; InputError when it raises."""
    try:
        with output_aside():
            given = (getattr(place, name, None) for place in (env, getattr(env, "unwrapped", None)))
            return next((value for value in given if value is not None), None)
    except (Exception, SystemExit) as error:
        raise fault(error, source, f"the environment's {name}") from error


def table(env: Any, name: str, source: Source) -> Mapping[Any, Any]:
    """Such an attribute by agents or teams; empty where there is none, or one that means something else."""
    given = attribute(env, name, source)
    return given if is_mapping(given) else {}


def action_names(env: Any, agent: Any, source: Source) -> tuple[str, ...]:
    """A name for each of an agent's actions; () where they are not numbered. InputError for too many actions, and for
    an environment's names that are not as many texts.
    """
    n = int(getattr(space(env, "action", agent), "n", 0))
    if n > MAX_ACTIONS:
        what = f"{agent} has {n:,} actions, of at most {MAX_ACTIONS:,}"
        raise InputError(what, source.text, "let agents choose among fewer, such as a few values of each number")
    given = table(env, "action_names", source).get(agent)
    if not n or given is None:
        first = int(getattr(space(env, "action", agent), "start", 0))
        return tuple(f"action_{first + k}".replace("-", "minus_") for k in range(n))
    names = _texts(given)
    if names is None or len(names) != n:
        what = f"the action names of {agent} are not {n} texts, one for each action"
        raise InputError(what, source.text, "fix the environment's `action_names`, or leave this agent out of it")
    return names


def read_legal_features(env: Any, agent: Any, source: Source) -> tuple[str, ...]:
    """The feature that says whether each action is legal, by the attribute `legal`; () where there are none."""
    names = _texts(table(env, "legal", source).get(agent, ()))
    if names is None:
        what = f"`legal` does not name features for the actions of {agent}"
        raise InputError(what, source.text, 'name one for each action, "" where it is always legal')
    return names


def _texts(given: Any) -> tuple[str, ...] | None:
    """Returns a given row of texts as a tuple; None: it is something else."""
    parts = tuple(given) if is_row(given) else ()
    texts = tuple(part for part in parts if isinstance(part, str))
    return texts if is_row(given) and len(texts) == len(parts) else None


class Told(NamedTuple):
    """A measure that an environment tells by a number in its agents' infos, in each step or in some."""

    name: str
    key: str
    how: str  # of HOW
    lower_is_better: bool

    def reduce(self, series: Float64) -> Float64:
        """The sum, the mean or the last of what was told, [...] from [n_steps, ...]; NaN where nothing was."""
        told = ~np.isnan(series)
        if self.how == LAST:
            last = len(series) - 1 - told[::-1].argmax(axis=0)
            return np.take_along_axis(series, last[None], axis=0)[0]
        total, count = np.where(told, series, 0.0).sum(axis=0), np.where(told.any(axis=0), told.sum(axis=0), np.nan)
        return total / count if self.how == MEAN else total + 0.0 * count


def read_told(env: Any, source: Source) -> tuple[Told, ...]:
    """What the attribute `measures` states; InputError where that is something else."""
    stated = [(name, _texts(given)) for name, given in table(env, "measures", source).items()]
    for name, parts in stated:
        if parts is None or len(parts) != 3 or parts[1] not in HOW or parts[2] not in BETTER or name == RETURN:
            advice = f"give (key of infos, {' | '.join(HOW)}, {' | '.join(BETTER)}), and no measure named {RETURN}"
            raise InputError(f"`measures` does not state the measure {escape_text(name)}", source.text, advice)
    return tuple(Told(str(name), parts[0], parts[1], parts[2] == LOWER) for name, parts in stated if parts)


def read_length(env: Any, source: Source) -> int | None:
    """Returns the largest number of steps of an episode, by option or attribute; None where nobody says it."""
    limit = source.options.get(MAX_STEPS)
    if limit is not None:
        if not isinstance(limit, int) or limit < 1:
            raise InputError(f"{MAX_STEPS} is '{limit}'", source.text, "give a number from 1")
        return limit
    metadata = attribute(env, "metadata", source)
    there = metadata.get("max_cycles") if is_mapping(metadata) else None
    registered = getattr(attribute(env, "spec", source), "max_episode_steps", None)
    for stated in (attribute(env, "max_cycles", source), there, registered):
        if isinstance(stated, (int, np.integer)) and stated > 0:
            return int(cast("int", stated))
    return None


def teams_by_name(agents: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Teams of agents whose names are alike before the last `_`."""
    teams: dict[str, tuple[str, ...]] = {}
    for name in agents:
        team = name.rsplit("_", 1)[0]
        teams[team] = (*teams.get(team, ()), name)
    return teams


def join_equals(
    teams: Mapping[str, tuple[str, ...]], agents: Sequence[str], rewards: Sequence[Sequence[float]]
) -> dict[str, tuple[str, ...]]:
    """The teams, those joined whose agents were all paid the same. `rewards`: [steps][n_agents] of an episode, NaN for
    who did not act. Where nothing was paid, nothing is known.
    """
    paid = np.array(rewards).reshape(-1, len(agents))

    def equal(one: str, other: str) -> bool:
        pair = paid[:, [agents.index(one), agents.index(other)]]
        pair = pair[~np.isnan(pair).any(axis=1)]
        return bool(pair.any() and (pair[:, 0] == pair[:, 1]).all())

    groups: list[list[str]] = []
    for team, members in teams.items():
        alike = (group for group in groups if all(equal(a, b) for each in group for a in teams[each] for b in members))
        group = next(alike, None)
        if group is None:
            groups.append(group := [])
        group.append(team)
    joined = ["team"] if len(groups) == 1 else [f"team_{k}" for k in range(len(groups))]
    names = [group[0] if len(group) == 1 else name for group, name in zip(groups, joined, strict=True)]
    members = [tuple(agent for team in group for agent in teams[team]) for group in groups]
    return dict(zip(legal_names(names, "team"), members, strict=True))


def read_teams(env: Any, called: Mapping[Any, str], source: Source) -> dict[str, tuple[str, ...]]:
    """The attribute `teams` by the agents' legal names; {} where there is none. InputError for what does not match."""
    given = table(env, "teams", source)
    if not given:
        return {}
    members = [agent for team in given.values() for agent in team]
    if sorted(map(str, members)) != sorted(map(str, called)) or not all(given.values()):
        places = f"{source.text}: teams: {', '.join(map(str, members))}; agents: {', '.join(map(str, called))}"
        advice = "put every agent into exactly one team"
        raise InputError("the environment's teams do not match its agents", places, advice)
    names = legal_names([str(team) for team in given], "team")
    members = [tuple(legal for agent, legal in called.items() if agent in team) for team in given.values()]
    return dict(zip(names, members, strict=True))


def is_mapping(given: object) -> TypeGuard[Mapping[Any, Any]]:
    """Returns True if it has values by keys, which are the environment's own."""
    return isinstance(given, Mapping)


def is_row(given: object) -> TypeGuard[Sequence[object]]:
    """Returns True if it has parts in a row, and is no text."""
    return isinstance(given, Sequence) and not isinstance(given, str)


def space(env: Any, kind: str, agent: Any) -> Any:
    """An agent's `action` or `observation` space, by method or, as older environments have it, from a mapping."""
    with silence_warnings(), output_aside():
        return getattr(env, f"{kind}_space")(agent)


def legal_names(names: Sequence[str], kind: str) -> tuple[str, ...]:
    """Names as a profile may have them, all different, each as much like the given one as it can be."""
    by_identifier: dict[str, str] = {}
    for name in names:
        legal = re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:MAX_NAME]
        legal = legal if legal[:1].isalpha() else f"{kind}_{legal}"
        tries = (f"{legal}_{k}" if k > 1 else legal for k in count(1))
        chosen = next(each for each in tries if identifier(each) not in by_identifier)
        by_identifier[identifier(chosen)] = chosen
    return tuple(by_identifier.values())
