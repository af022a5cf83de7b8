"""Compilation as a command: load, emit, prove by replay, write, say how much was compared.

Does: joins profile file, `agreement`, `proofs` and output folder.
Assumes: options come from the command line.
Does not: emit or compare anything itself.
"""

from collections.abc import Iterable
from pathlib import Path

from codegen import vectors
from codegen.errors import ExitCode
from codegen.lower import lower
from maviper import load, proofs, runs
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
    prove: bool = False,
    budget: int | None = None,
) -> ExitCode:
    """The command `maviper compile`; its exit code. Nothing is written when any decision differs.

    `prove`: also for all observations, by a solver with so many resource units a question (`budget`).
    """
    loaded, targets = load(profile), list(targets)
    compiled = compile_profile(loaded, targets, prefix, style)
    model = lower(loaded, prefix, style)
    more = vectors.files(loaded, model, targets) if test_vectors else {}
    found = proofs.prove(loaded, compiled.files, model, budget) if prove else proofs.Proofs((), ())
    more |= proofs.files_of(loaded, found, model) if prove else {}
    for name, text in {**compiled.files, **more}.items():
        runs.write(output / name, text)
        console.line("wrote", str(output / name))
    say_agreement(compiled, console)
    say_proofs(found, console)
    return ExitCode.DONE if compiled.complete and found.complete else ExitCode.INCONCLUSIVE


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


def say_proofs(found: proofs.Proofs, console: Console) -> None:
    """A line for each question, and for each that could not be asked."""
    for proof in found.proofs:
        console.line("UNKNOWN" if proof.answer.holds is None else "proved", str(proof))
    for reason in found.skipped:
        console.line("SKIPPED", reason)
