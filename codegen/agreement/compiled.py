"""A build: a profile with its lowered model, its files, and the emitted C compiled strictly and loaded to be asked.

Does: finds compilers; lowers once, writes once and compiles at most once, every warning being an error, for everyone
  who checks, proves or replays the files; calls the functions of the header.
Assumes: a scratch folder that it may write to; what is loaded is built by `cc`, `gcc` or `clang` on the path, or $CC;
  used as a context manager.
Does not: know what the right answers are (selfcheck.py).
"""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from codegen.agreement.programs import find_compiler, run
from codegen.errors import DisagreementError, InputError, MissingToolError
from codegen.floats import as_whole, observations
from codegen.ir import Float64, Floats, Int32, Int64, PolicyProfile
from codegen.lowering.lower import AUTO, lower
from codegen.lowering.model import Model
from codegen.targets import USUAL, emit_model
from codegen.targets.rendered import harness, usual_c

STRICT = (
    "-std=c99 -pedantic -Wall -Wextra -Werror -Wconversion -Wdouble-promotion -Wshadow -Wfloat-equal".split()  # noqa: SIM905
)
OTHERS = ("gcc -std=c99", "clang -std=c99", "g++ -x c++ -std=c++17", "clang++ -x c++ -std=c++20")


def ensure_strict(header: str, model: Model) -> tuple[str, ...]:
    """The compilers, of OTHERS, that are installed and read the header without a warning.

    DisagreementError when one that works finds something.
    """
    clean: list[str] = []
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        (Path(folder) / f"{model.prefix}.h").write_text(header)
        (Path(folder) / "harness.c").write_text(harness(model, "c"))
        (Path(folder) / "empty.c").write_text("extern int nothing;\n")
        for named in OTHERS:
            command = [*named.split(), *STRICT[1:], "-fsyntax-only"]
            if shutil.which(command[0]) is None:
                continue
            read = run([*command, "harness.c"], folder)
            if read.returncode == 0:
                clean.append(named)
            elif run([*command, "empty.c"], folder).returncode == 0:  # else the compiler itself does not work
                lines = "\n".join(read.stderr.strip().splitlines()[:5])
                raise DisagreementError(f"the generated C does not compile with {named}", lines, "this is a bug")
    return tuple(clean)


class CompiledC:
    """The header, compiled strictly into a library and loaded. Use as a context manager."""

    flags, whole = STRICT, True  # how it is compiled, and whether all functions of the header can be called

    def __init__(self, header: str, model: Model, compiler: list[str], optimised: bool = True) -> None:
        self._level = "-O2" if optimised else "-O0"
        self._folder = tempfile.TemporaryDirectory(prefix="maviper-")
        folder = Path(self._folder.name)
        (folder / f"{model.prefix}.h").write_text(header)
        (folder / "harness.c").write_text(harness(model, "c", self.whole))
        built = self._build(compiler, "harness.c")
        if built.returncode != 0:
            (folder / "empty.c").write_text("extern int nothing;\n")
            works = self._build(compiler, "empty.c").returncode == 0
            self._folder.cleanup()
            lines = "\n".join(built.stderr.strip().splitlines()[:5])
            if not works:
                raise MissingToolError(f"the C compiler {compiler[0]} does not work", lines, "set CC to another one")
            raise DisagreementError("the generated C does not compile", lines, "this is a bug; nothing was written")
        try:
            self._library = ctypes.CDLL(str(folder / "policy.so"))
        except OSError as error:
            self._folder.cleanup()
            advice = "set CC to another compiler, or TMPDIR to a folder that may hold programs"
            raise MissingToolError(f"cannot load what {compiler[0]} built", str(error), advice) from None
        self._names = model.names
        self._agents = {agent.name: agent for agent in model.agents}
        self._n_coordinates = len(model.names.coordinates)

    def _build(self, compiler: list[str], source: str) -> subprocess.CompletedProcess[str]:
        command = [*compiler, *self.flags, self._level, "-fPIC", "-shared", "-o", "policy.so", source]
        try:
            return run(command, self._folder.name)
        except BaseException:
            self._folder.cleanup()
            raise

    def __enter__(self) -> "CompiledC":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Removes the library's file."""
        self._folder.cleanup()

    def act(self, agent: str, rows: Floats) -> Any:
        """The compiled decisions, [batch] int32, or numbers given, [batch, n_outputs]. `rows`: [batch, n_features] in
        the agent's numbers.
        """
        return self.act_and_check(agent, rows)[0]

    def checks(self, agent: str, rows: Floats) -> Int32:
        """The compiled input checks, [batch] int32: 1 for finite, 2 for within the ranges, their sum for both."""
        return self.act_and_check(agent, rows)[1]

    def batch(self, agent: str, rows: Floats) -> tuple[Any, Any]:
        """The decisions of the batch functions, over rows and over columns, [batch] or [batch, n_outputs] each."""
        rows, lowered = self._pack_rows(agent, rows), self._agents[agent]
        by_rows = self._answers(agent, len(rows), lowered.batch_type)
        by_columns = by_rows.T.copy()
        run = self._library[lowered.names.exported_batch]
        given = (_pointer(rows), _pointer(np.ascontiguousarray(rows.T)), ctypes.c_long(len(rows)))
        run(*given, _pointer(by_rows), _pointer(by_columns))
        return by_rows.astype(lowered.answer_type), by_columns.T.astype(lowered.answer_type)

    def all(self, rows: Sequence[Floats]) -> Int32:
        """All agents' actions in one call, [batch, n_agents]. `rows`: each agent's observations, equally many."""
        held = [self._pack_rows(agent, each) for agent, each in zip(self._agents, rows, strict=True)]
        if len({len(each) for each in held}) != 1:
            raise InputError("the agents have different numbers of observations", "", "give each the same number")
        pointers = (ctypes.c_void_p * len(held))(*(each.ctypes.data for each in held))
        actions = np.full((len(held[0]), len(held)), -1, dtype=np.int32)
        self._library[self._names.exported_all](pointers, ctypes.c_long(len(actions)), _pointer(actions))
        return actions

    def team(self, worlds: Float64) -> Int32:
        """The team's actions in world states [batch, n_coordinates], [batch, n_agents]."""
        worlds = self._states(worlds)
        actions = np.full((len(worlds), len(self._agents)), -1, dtype=np.int32)
        self._library[self._names.exported_team](_pointer(worlds), ctypes.c_long(len(worlds)), _pointer(actions))
        return actions

    def worlds(self, agent: str, worlds: Float64) -> tuple[Floats, Any]:
        """An agent's observations in world states [batch, n_coordinates], [batch, n_features], and its answers."""
        worlds, lowered = self._states(worlds), self._agents[agent]
        seen = np.zeros((len(worlds), len(lowered.features)), dtype=lowered.numbers)
        actions = self._answers(agent, len(worlds))
        run = self._library[lowered.names.exported_observe]
        run(_pointer(worlds), ctypes.c_long(len(worlds)), _pointer(seen), _pointer(actions))
        return seen, actions

    def constants(self) -> list[float]:
        """Time of a step, damping, and every agent's force."""
        found = np.zeros(2 + len(self._agents))
        self._library[self._names.exported_constants](_pointer(found))
        return found.tolist()

    def region(self, worlds: Float64) -> Int32:
        """The compiled check of the region, [batch] int32: 1 within, else 0. `worlds`: [batch, n_coordinates]."""
        worlds = self._states(worlds)
        within = np.full(len(worlds), -1, dtype=np.int32)
        self._library[self._names.exported_region](_pointer(worlds), ctypes.c_long(len(worlds)), _pointer(within))
        return within

    def steps(self, agent: str, rows: Float64) -> Int64:
        """An agent's memory after a reset, then its actions and the memory after each, [1 + batch, 1 + n_memories].
        `rows`: [batch, n_features], one call after the other; where a memory is NaN, its state stays as it is.
        """
        lowered, held = self._agents[agent], np.ascontiguousarray(rows, np.float64)
        assert lowered.machine is not None and held.shape[1] == len(lowered.features), "rows with memory"
        told = np.zeros((1 + len(held), 1 + len(lowered.machine.memory)), ctypes.c_long)
        self._library[lowered.names.exported_steps](_pointer(held), ctypes.c_long(len(held)), _pointer(told))
        return told.astype(np.int64)

    def _answers(self, agent: str, count: int, kind: str = "") -> Any:
        """Room for an agent's answers, of a numpy type, filled with what is none: NaN, or the largest whole number."""
        lowered = self._agents[agent]
        made = np.empty((count, *lowered.answer_shape), kind or lowered.answer_type)
        made.fill(np.nan if made.dtype.kind == "f" else np.iinfo(made.dtype).max)
        return made

    def act_and_check(self, agent: str, rows: Floats) -> tuple[Any, Int32]:
        """Returns what `act` and `checks` give, from one call."""
        rows = self._pack_rows(agent, rows)
        actions = self._answers(agent, len(rows))
        checks = np.full(len(rows), -1, dtype=np.int32)
        run = self._library[self._agents[agent].names.exported_rows]
        run(_pointer(rows), ctypes.c_long(len(rows)), _pointer(actions), _pointer(checks))
        return actions, checks

    def _pack_rows(self, agent: str, rows: Any) -> Floats:
        """Rows as the library reads them, which knows of no length: another one is an InputError."""
        lowered = self._agents[agent]
        rows = observations(rows, len(lowered.features), agent, lowered.numbers)
        return np.ascontiguousarray(as_whole(rows, lowered.whole) if lowered.whole else rows)

    def _states(self, worlds: Any) -> Float64:
        """World states as the library reads them."""
        held = np.ascontiguousarray(worlds, dtype=np.float64)
        if held.ndim != 2 or held.shape[1] != self._n_coordinates:
            what = f"world states have {self._n_coordinates} coordinates, given an array of shape {held.shape}"
            raise InputError(what, "", "see the world's coordinates")
        return held


class ReplayedC(CompiledC):
    """The header, compiled for a few decisions: it can `act` and tell `checks`. Optimising, warnings and what nobody
    calls take compilers five times as long.
    """

    flags, whole = ("-std=c99", "-w"), False

    @classmethod
    def of(cls, profile: PolicyProfile) -> "ReplayedC":
        """The C of a profile; errors as `codegen.targets.emit`. MissingToolError without a compiler."""
        compiler = find_compiler()
        if compiler is None:
            raise MissingToolError("no C compiler was found", "", "set CC to one")
        model, _, header = usual_c(profile)
        return cls(header, model, compiler, optimised=False)


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


@dataclass(frozen=True, eq=False)
class Build:
    """`files`: name -> text; bytes of targets that are none. They may be some, or others than the model's own.

    `optimised`: whether the library and the program in Rust are; for a few decisions compilers take three times as long
    to optimise them.
    """

    profile: PolicyProfile
    model: Model
    files: Mapping[str, str | bytes]
    optimised: bool = True

    def text(self, ending: str) -> str | None:
        """The file PREFIX.ending, where it is there and a text."""
        found = self.files.get(f"{self.model.prefix}.{ending}")
        return found if isinstance(found, str) else None

    @cached_property
    def compiler(self) -> list[str] | None:
        """The C compiler's command, or None. MissingToolError when $CC cannot be read as a command."""
        return find_compiler()

    @property
    def compilable(self) -> bool:
        """True if there are a header and a compiler for it."""
        return self.text("h") is not None and self.compiler is not None

    @cached_property
    def library(self) -> CompiledC:
        """The header, compiled when it is first asked for. Only where it is `compilable`."""
        header, compiler = self.text("h"), self.compiler
        assert header is not None and compiler is not None, "nothing to compile, or nothing to compile with"
        return CompiledC(header, self.model, compiler, self.optimised)

    def __enter__(self) -> "Build":
        return self

    def __exit__(self, *_: object) -> None:
        library = self.__dict__.pop("library", None)
        if library is not None:
            library.close()


def build(
    profile: PolicyProfile, targets: Iterable[str] = USUAL, prefix: str | None = None, style: str = AUTO
) -> Build:
    """The build of a profile for the chosen targets; errors as `codegen.targets.emit`."""
    model = lower(profile, prefix, style)
    return Build(profile, model, emit_model(model, profile, targets))
