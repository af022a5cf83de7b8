"""What was compared and proved of code, as lines.

Does: prints through a console.
Assumes: results of `maviper.compilation`.
Does not: compare.
"""

from typing import TYPE_CHECKING

from maviper.console import Console

if TYPE_CHECKING:
    from maviper.compilation.compile import Compiled
    from maviper.compilation.proofs import Proofs, Proven


def say_agreement(compiled: "Compiled", console: Console) -> None:
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
    for reason in (*report.skipped, *filter(None, [compiled.elsewhere])):
        console.line("SKIPPED", reason)


def say_proofs(proofs: "Proofs", console: Console) -> None:
    """A line for each question, and for each that could not be asked."""
    for proof in proofs.proofs:
        console.line("UNKNOWN" if proof.answer.holds is None else "proved", str(proof))
    for reason in proofs.skipped:
        console.line("SKIPPED", reason)


def say_contracts(proven: "Proven", console: Console) -> None:
    """The line of counts and time, and one for each goal that is open."""
    console.line("proved" if proven.complete else "UNKNOWN", f"contracts: {proven}")
    for name in proven.open_goals:
        console.line("open", name)
