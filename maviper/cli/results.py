"""Results of verification on a terminal: verdicts as their report words them, and what a repair changed.

Does: prints results through a console; gives verdicts as an exit code.
Assumes: results of `maviper.verification`; this module is heavy, so commands import it when they run.
Does not: decide, write files or print what belongs on standard output.
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from codegen.errors import ExitCode
from codegen.ir import PolicyProfile
from maviper.console import Console
from verify.reports.report import as_lines
from verify.result import AnyResult, Verdict

if TYPE_CHECKING:
    from maviper.verification.repair import Repaired


def say_results(profile: PolicyProfile, results: Sequence[AnyResult], console: Console) -> None:
    """One block of lines a result, from the facts of its report."""
    for result in results:
        named, lines = as_lines(profile, result)
        console.line(result.verdict.value, named)
        for line in lines:
            console.line("", line)


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
        console.line("repaired", "nothing: no state of the region violates the property")
        return
    guards = "guard" if len(repair.guards) == 1 else "guards"
    roles = ", ".join(f"{agent} for {landmark}" for agent, landmark in repair.roles.items())
    console.line("repaired", f"{len(repair.guards)} {guards}, {roles}")
    console.line("", say_sizes(before, repair.profile, list(repair.roles)))
    if done.cost is not None:
        done.cost.say(console)
