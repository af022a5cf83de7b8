"""Proofs by tools of others: Frama-C's WP proves the contracts of the C, Z3 the axioms that they use.

Does: runs frama-c on the header as it is written, and z3 on the axioms; counts what is proved, names the other goals.
Assumes: frama-c, why3 and z3 on the PATH; a budget of solver steps, not of time.
Does not: write contracts (codegen/equivalence/contracts.py), or trust an answer that is not there.
"""

import os
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from codegen.agreement.compiled import Build
from codegen.agreement.programs import run
from codegen.equivalence.contracts import Contracts
from codegen.errors import MissingToolError
from codegen.form import layout

TOOLS = ("frama-c", "why3", "z3")
INSTALL = "apt-get install frama-c-base why3 z3"
STEPS = 20_000_000  # of Z3 per goal; 64 leaves take 2 million
GOAL_S = 600  # a goal's limit in time, which only says that something hangs
LIMIT_S = 3_600
GOAL = re.compile(r"^\[wp\] \[(?P<by>[^\]]+)\] Goal (?P<name>\S+)(?: : (?P<answer>\w+))?", re.MULTILINE)
TOTAL = re.compile(r"^\[wp\] Proved goals: +(?P<proved>\d+) / (?P<goals>\d+)$", re.MULTILINE)


@dataclass(frozen=True)
class Proven:
    """The tools' answers. `open_goals`: what WP did not prove; `axioms`: of how many Z3 found none false."""

    goals: int
    open_goals: tuple[str, ...]
    axioms: int
    open_axioms: int
    cpu_s: float  # of all programs that ran

    @property
    def complete(self) -> bool:
        """True if every goal and every axiom is proved."""
        return not self.open_goals and not self.open_axioms

    def __str__(self) -> str:
        proved = f"{self.goals - len(self.open_goals)} of {self.goals} goals proved by WP"
        if self.axioms:
            proved += f", {self.axioms - self.open_axioms} of {self.axioms} axioms by z3"
        return f"{proved}, {self.cpu_s:.1f} s of processor time"


def ensure_installed() -> None:
    """MissingToolError that names what is missing, and the line that installs it."""
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        what = f"contracts are proved by Frama-C, and not there: {', '.join(missing)}"
        raise MissingToolError(what, "--frama-c", f"install them: {INSTALL}")


def prove_contracts(build: Build, contracts: Contracts, steps: int = STEPS) -> Proven:
    """The answers about the header of a build. MissingToolError where a tool is missing or cannot read the files."""
    ensure_installed()
    header = build.text("h")
    assert header is not None, "no header to prove"
    before = os.times()
    with tempfile.TemporaryDirectory(prefix="maviper-contracts-") as scratch:
        folder = Path(scratch)
        (folder / f"{build.model.prefix}.h").write_text(header)
        for name, text in contracts.files.items():
            (folder / name).write_text(text)
        goals, open_goals = _goals(folder, contracts, steps)
        open_axioms = contracts.axioms - _axioms(folder, contracts)
    after = os.times()
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    return Proven(goals, open_goals, contracts.axioms, open_axioms, spent)


def _goals(folder: Path, contracts: Contracts, steps: int) -> tuple[int, tuple[str, ...]]:
    """Counts the goals that WP made, and names those that it left open."""
    config = folder / "why3.conf"  # of its own: nothing is written in the user's home
    run(["why3", "--config", str(config), "config", "detect"], folder)
    limits = ["-wp-steps", str(steps), "-wp-timeout", str(GOAL_S), "-wp-par", str(os.cpu_count() or 1)]
    *asked, source = contracts.command
    # by its whole path: Frama-C looks for a bare name where the shell says it is
    command = ["env", f"WHY3CONFIG={config}", *asked, *limits, str(folder / source)]
    ended = run(command, folder, limit_s=LIMIT_S)
    total = TOTAL.search(ended.stdout)
    if ended.returncode or total is None:
        said = [line for line in (ended.stdout + ended.stderr).splitlines() if line.strip()]
        raise MissingToolError("frama-c gave no answer", " ".join(said[-2:])[:300], f"is it whole? {INSTALL}")
    valid = {goal["name"]: goal["answer"] == "Valid" for goal in GOAL.finditer(ended.stdout)}
    still = tuple(sorted(name for name, proved in valid.items() if not proved))
    goals, proved = int(total["goals"]), int(total["proved"])
    assert len(still) == goals - proved, f"{len(still)} goals are named open, {goals - proved} counted: {ended.stdout}"
    return goals, still


def _axioms(folder: Path, contracts: Contracts) -> int:
    """Of how many axioms Z3 found that nothing contradicts them."""
    if not contracts.questions:
        return 0
    ended = run(["z3", contracts.questions], folder)
    return ended.stdout.split().count("unsat")


def record_of(proven: Proven, contracts: Contracts, build: Build, steps: int = STEPS) -> dict[str, str]:
    """The file that says what was proved, name -> text."""
    document = {
        "profile": build.model.content_hash,
        "style": build.model.style,
        "functions": list(contracts.functions),
        "leaves": contracts.leaves,
        "steps": steps,
        "goals": proven.goals,
        "open goals": list(proven.open_goals),
        "axioms": proven.axioms,
        "open axioms": proven.open_axioms,
    }
    return {f"{build.model.prefix}.contracts.json": layout(document) + "\n"}
