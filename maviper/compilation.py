"""Compilation as a command: load, emit, prove by replay, write, say how much was compared.

Does: joins profile file, `agreement` and output folder.
Assumes: options come from the command line.
Does not: emit or compare anything itself.
"""

from collections.abc import Iterable
from pathlib import Path

from codegen import vectors
from codegen.errors import ExitCode
from codegen.lower import lower
from maviper import load, runs
from maviper.agreement import Compiled, compile_profile
from maviper.console import Console


def compile_to_folder(
    profile: Path,
    targets: Iterable[str],
    prefix: str | None,
    style: str,
    test_vectors: bool,
    output: Path,
    console: Console,
) -> ExitCode:
    """The command `maviper compile`; its exit code. Nothing is written when any decision differs."""
    loaded, targets = load(profile), list(targets)
    compiled = compile_profile(loaded, targets, prefix, style)
    more = vectors.files(loaded, lower(loaded, prefix, style), targets) if test_vectors else {}
    for name, text in {**compiled.files, **more}.items():
        runs.write(output / name, text)
        console.line("wrote", str(output / name))
    say_agreement(compiled, console)
    return ExitCode.DONE if compiled.complete else ExitCode.INCONCLUSIVE


def say_agreement(compiled: Compiled, console: Console) -> None:
    """The line that says how much was compared, and a line for each part that was skipped."""
    report = compiled.report
    targets = list(dict.fromkeys(item.target for item in report.agreements))
    console.line("agreement", f"{report.observations:,} decisions compared, 0 differ ({', '.join(targets)})")
    if compiled.faithful:
        texts = [f"{item.agent} {item.whole.share:.3f}" for item in compiled.faithful]
        states = compiled.faithful[0].whole.states
        console.line(
            "fidelity", f"share of {states:,} on-policy states in which a tree acts as its expert: {', '.join(texts)}"
        )
    for reason in report.skipped:
        console.line("SKIPPED", reason)
