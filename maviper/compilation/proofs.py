"""Proofs of emitted code for all inputs: by verify's solver, and by Frama-C's WP, whose axioms Z3 proves.

Does: a question for each agent about the C and about the Python, its answer, and a file of both for others to check;
  runs frama-c on the header as it is written, and z3 on the axioms of contracts; counts what is proved, names the other
  goals.
Assumes: the files were replayed already; a budget of solver resources or steps, not of time; frama-c, why3 and z3 on
  the PATH for contracts.
Does not: emit code, write contracts (codegen/equivalence/contracts.py), or trust an answer that is not there.
"""

import os
import re
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from codegen import ir
from codegen.agreement.compiled import Build
from codegen.agreement.programs import run
from codegen.agreement.selfcheck import MAX_PARSED
from codegen.equivalence import obligations
from codegen.equivalence.contracts import Contracts
from codegen.equivalence.obligations import Obligation
from codegen.equivalence.symbolic import Unreadable
from codegen.errors import DisagreementError, InputError, MissingToolError
from codegen.form import layout
from codegen.lowering.model import Model
from verify.question import Budgets
from verify.solver.solve import BitsAnswer, ask_bits, solver_name

ENDINGS = {obligations.C: "c.smt2", obligations.PYTHON: "python.smt2"}


@dataclass(frozen=True)
class Proof:
    """A question and its answer: proved where `answer.holds` is False, open where it is None."""

    question: Obligation
    answer: BitsAnswer

    def __str__(self) -> str:
        asked, spent = self.question, f"{self.answer.resources:,} resource units"
        if self.answer.holds is None:
            return f"{asked.target}: {asked.agent} not decided for all {asked.covers} ({self.answer.reason}), {spent}"
        return f"{asked.target}: {asked.agent} equal for all {asked.covers}, {spent}"


@dataclass(frozen=True)
class Proofs:
    """The questions that were asked, with answers, and those that could not be asked."""

    proofs: tuple[Proof, ...]
    skipped: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """True if every question was asked and answered."""
        return not self.skipped and all(proof.answer.holds is False for proof in self.proofs)


def ensure_askable(targets: Sequence[str], budget: int | None) -> None:
    """InputError when nothing can be proved about any of the targets, or with a budget that is no number of units."""
    if not {"c", "python"} & set(targets):
        raise InputError("there is nothing to prove", "--prove", "it needs the target c or python")
    if budget is not None and budget < 1:
        raise InputError(f"the solver units must be positive, not {budget}", "solver_units", "leave it out")


def prove(build: Build, budget: int | None = None, effort: str = "normal") -> Proofs:
    """Asks whether the C and the Python of a build decide as the trees for every observation.

    DisagreementError, with the observation, when they do not.
    """
    profile, model = build.profile, build.model
    asked: list[Obligation] = []
    skipped: list[str] = []
    writers = {obligations.C: ("h", obligations.about_c), obligations.PYTHON: ("py", obligations.about_python)}
    texts = {target: build.text(ending) for target, (ending, _) in writers.items()}
    nodes = sum(len(policy.tree.feature) for policy in profile.agents)
    for target, text in texts.items():
        if text is None:
            continue
        if not model.single:
            skipped.append(f"{target}: it is about float32 agents, and {model.doubled} compares float64")
            continue
        if nodes > MAX_PARSED:
            skipped.append(f"{target}: more than {MAX_PARSED} nodes")
            continue
        try:
            asked += writers[target][1](text, profile, model)
        except Unreadable as error:
            skipped.append(f"{target}: {error}")
    answered: list[Proof] = []
    for question in asked:
        answer = ask_bits(question.text, question.names, budget or Budgets.of_effort(effort).solver_units)
        if answer.model is not None:
            x, policy = question.observation(answer.model), profile.policy(question.agent)
            wanted = policy.actions[int(ir.act(policy, [x])[0])].name
            values = ", ".join(repr(value) for value in x)
            where = f"{question.agent}: for x = ({values}) the profile says {wanted}, the code another action"
            raise DisagreementError(f"{question.target}: code and profile differ", where, "nothing was written")
        answered.append(Proof(question, answer))
    return Proofs(tuple(answered), tuple(skipped))


def files_of(proofs: Proofs, model: Model) -> dict[str, str]:
    """The questions, which any solver of SMT-LIB can be asked again, and the answers, name -> text."""
    lowered = {agent.name: agent.lower for agent in model.agents}
    files: dict[str, str] = {}
    rows: list[dict[str, str | int | bool]] = []
    for proof in proofs.proofs:
        asked, answer = proof.question, proof.answer
        name = f"{model.prefix}_{lowered[asked.agent]}.{ENDINGS[asked.target]}"
        files[name] = asked.text
        row = {"target": asked.target, "agent": asked.agent, "covers": asked.covers, "question": name}
        rows.append(row | {"proved": answer.holds is False, "resources": answer.resources})
    document = {"profile": model.content_hash, "solver": solver_name(), "style": model.style}
    text = layout(document | {"proofs": rows, "skipped": list(proofs.skipped)}) + "\n"
    return files | {f"{model.prefix}.proofs.json": text}


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
        # nothing contradicts an axiom of which Z3 says so
        asked = run(["z3", contracts.questions], folder).stdout if contracts.questions else ""
        open_axioms = contracts.axioms - asked.split().count("unsat")
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
