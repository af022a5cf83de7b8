"""Compilation as a command: load, emit, prove by replay, write, say how much was compared.

Does: joins profile file, `agreement`, `proofs` and output folder.
Assumes: options come from the command line.
Does not: emit or compare anything itself.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from codegen import vectors
from codegen.errors import ExitCode
from codegen.lower import lower
from maviper import load, runs
from maviper.agreement import Compiled, compile_profile
from maviper.console import Console

if TYPE_CHECKING:
    from maviper.proofs import Proofs


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
    passes: Sequence[str] = (),
    region: str | None = None,
) -> ExitCode:
    """The command `maviper compile`; its exit code. Nothing is written when any decision differs.

    `prove`: also for all observations, by a solver with so many resource units a question (`budget`).
    `passes`, `region`: as `maviper.transform.transformed`.
    """
    loaded, targets = load(profile), list(targets)
    if prove:
        from maviper import proofs  # here, so that compiling alone loads no solver

        proofs.ensure_askable(targets, budget)
    if passes or region is not None:
        from maviper.transform import transformed  # here, for the same reason

        found_better = transformed(loaded, passes, region)
        loaded = found_better.profile
        for note in found_better.notes:
            console.line("pass", note)
    compiled = compile_profile(loaded, targets, prefix, style)
    model = lower(loaded, prefix, style)
    more = vectors.files(loaded, model, targets) if test_vectors else {}
    found = proofs.prove(loaded, compiled.files, model, budget) if prove else None
    more |= proofs.files_of(loaded, found, model) if found else {}
    for name, text in {**compiled.files, **more}.items():
        runs.write(output / name, text)
        console.line("wrote", str(output / name))
    say_agreement(compiled, console)
    if found:
        say_proofs(found, console)
    complete = compiled.complete and (found is None or found.complete)
    return ExitCode.DONE if complete else ExitCode.INCONCLUSIVE


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


def say_proofs(found: "Proofs", console: Console) -> None:
    """A line for each question, and for each that could not be asked."""
    for proof in found.proofs:
        console.line("UNKNOWN" if proof.answer.holds is None else "proved", str(proof))
    for reason in found.skipped:
        console.line("SKIPPED", reason)
