"""Build: a profile with its lowered model, the files written from it and, once asked for, the header as a library.

Does: lowers once, writes once and compiles at most once, for everyone who checks, proves or replays the files.
Assumes: a checked profile; used as a context manager where the library is asked for, which removes it at the end.
Does not: compare anything (selfcheck.py).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from codegen.agreement.compiled import CompiledC, find_compiler
from codegen.ir import PolicyProfile
from codegen.lowering.lower import AUTO, lower
from codegen.lowering.model import Model
from codegen.targets import USUAL, emit_model


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


class ReplayBuild(Build):
    """The header alone, for a few decisions: written and compiled when the first one is asked for, not optimised."""

    @classmethod
    def of(cls, profile: PolicyProfile) -> "ReplayBuild":
        """The build of a profile that has no file yet. Errors as `build`."""
        return cls(profile, lower(profile), {}, optimised=False)

    @property
    def compilable(self) -> bool:
        """True if there is a compiler."""
        return self.compiler is not None

    @cached_property
    def library(self) -> CompiledC:
        """The header, written and compiled when it is first asked for. Only where it is `compilable`."""
        return Build(self.profile, self.model, emit_model(self.model, self.profile, ["c"]), self.optimised).library


def build(
    profile: PolicyProfile, targets: Iterable[str] = USUAL, prefix: str | None = None, style: str = AUTO
) -> Build:
    """The build of a profile for the chosen targets; errors as `codegen.targets.emit`."""
    model = lower(profile, prefix, style)
    return Build(profile, model, emit_model(model, profile, targets))
