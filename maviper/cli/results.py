"""Results on a terminal: verdicts as their report words them, what a repair changed, what was compared of code.

Does: prints results through a console; gives verdicts as an exit code.
Assumes: results of `maviper.verification` and `maviper.compilation`; this module is heavy, so commands import it when
  they run.
Does not: decide, write files or print what belongs on standard output.
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from codegen.errors import ExitCode
from codegen.ir import PolicyProfile
from maviper.console import Console
from verify.reports.report import NOWHERE, WEAK, as_lines, telling_of
from verify.result import AnyResult, Verdict

CAVEATS = (NOWHERE, WEAK, "no certificate", "not replayed", "proved again")  # in lines on what a verdict rests on
EXAMPLE = "counterexample: "  # begins the line of a report that says who does what
OBSERVED = ("at ", "if agents observe ")  # begin lines of a counterexample over observations

if TYPE_CHECKING:
    from maviper.compilation.compile import Compiled
    from maviper.compilation.proofs import Proofs, Proven
    from maviper.verification.repair import Repaired


def say_results(profile: PolicyProfile, results: Sequence[AnyResult], console: Console) -> None:
    """One block of lines a result, from the facts of its report."""
    for result in results:
        named, lines = as_lines(profile, result)
        console.line(result.verdict.value, named)
        for line in lines:
            console.line("", line)


def say_verdict(profile: PolicyProfile, result: AnyResult, console: Console) -> None:
    """The line of a claim: its verdict, and what was asked where."""
    console.result(result.verdict.value, as_lines(profile, result)[0])


class Said:
    """What says each result as soon as it is known, of so many: under the verdict why it is none, and what it is not;
    under the first that is violated, or the only one, also who does what there, or what is known.
    """

    def __init__(self, profile: PolicyProfile, count: int, console: Console) -> None:
        self.profile, self.alone, self.console = profile, count == 1, console
        self.violated = False  # whether one was

    def __call__(self, result: AnyResult) -> None:
        """Says a result."""
        named, lines = as_lines(self.profile, result)
        first = result.verdict is Verdict.VIOLATED and not self.violated
        self.violated = self.violated or first
        self.console.result(result.verdict.value, named)
        for line in _pick_lines(result, lines, first or self.alone):
            self.console.result("", line.removeprefix(EXAMPLE))


def _pick_lines(result: AnyResult, lines: Sequence[str], shown: bool) -> Sequence[str]:
    """The lines of a result that are told without -v: caveats; where it is shown, also who does what, or the first
    ones; all where a system is stated, since the last ones say what its counterexample is worth.
    """
    caveats = [line for line in lines if any(words in line for words in CAVEATS)]
    if not shown:
        open_ = result.verdict in (Verdict.UNKNOWN, Verdict.VACUOUS)
        return [*filter(None, [result.reason if open_ else ""]), *caveats]
    if telling_of(result).lines is not None:
        return lines
    told = [line for line in lines if line.startswith(EXAMPLE)] or [*filter(None, [result.reason, *lines])]
    told = told[: 2 if result.verdict is Verdict.VIOLATED else 1]
    if result.viewed is not None:
        told += [line for line in lines if line.startswith(OBSERVED)]
    return [*told, *(line for line in caveats if line not in told)]


def exit_code(verdicts: Collection[Verdict]) -> int:
    """The worst verdict as an exit code: violated before inconclusive before proved."""
    if Verdict.VIOLATED in verdicts:
        return ExitCode.VIOLATED
    return ExitCode.DONE if {*verdicts} == {Verdict.PROVED} else ExitCode.INCONCLUSIVE


def say_repair(done: "Repaired", console: Console) -> None:
    """What a repair changed, and what it costs."""
    from maviper.evaluation.comparison import say_sizes

    before, repair = done.before, done.repair
    if not repair.guards:
        as_it_is = "each claim holds as it is" if done.file else "no state of the region violates the property"
        console.line("repaired", f"nothing: {as_it_is}")
        return
    guards = "guard" if len(repair.guards) == 1 else "guards"
    roles = ", ".join(f"{agent} for {landmark}" for agent, landmark in repair.roles.items())
    console.line("repaired", f"{len(repair.guards)} {guards}, {roles}")
    console.line("", say_sizes(before, repair.profile, list(repair.roles)))
    if done.cost is not None:
        done.cost.say(console)


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
    for reason in report.skipped:
        console.line("SKIPPED", reason)
    if compiled.elsewhere:  # which lowers no exit code
        console.line("episodes", f"not replayed: {compiled.elsewhere.partition(': ')[2]}")


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


def write_junit(suite: str, claims: Sequence[tuple[str, Verdict, str]]) -> str:
    """Claims as a test suite in JUnit's XML: in words, with verdict and reason. A violated claim is a failure, one
    without an answer an error, as CI passes what is skipped.
    """
    violated = sum(verdict is Verdict.VIOLATED for _, verdict, _ in claims)
    unclear = sum(verdict not in (Verdict.PROVED, Verdict.VIOLATED) for _, verdict, _ in claims)
    counts = {"tests": str(len(claims)), "failures": str(violated), "errors": str(unclear), "skipped": "0"}
    from xml.etree import ElementTree

    root = ElementTree.Element("testsuite", {"name": suite, **counts})
    for words, verdict, reason in claims:
        case = ElementTree.SubElement(root, "testcase", {"name": words, "classname": suite})
        if verdict is not Verdict.PROVED:
            kind = "failure" if verdict is Verdict.VIOLATED else "error"
            ElementTree.SubElement(case, kind, {"message": f"{verdict.value}: {reason}".rstrip(": ")})
    ElementTree.indent(root)
    return f"<?xml version='1.0' encoding='utf-8'?>\n{ElementTree.tostring(root, encoding='unicode')}\n"
