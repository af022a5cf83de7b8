"""Proofs of emitted code for all inputs: codegen asks the questions, verify's solver answers them.

Does: a question for each agent about the C and about the Python, its answer, and a file of both for others to check.
Assumes: the files were replayed already; a budget of solver resources, not of time.
Does not: emit code.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from codegen import ir
from codegen.agreement.compiled import Build
from codegen.agreement.selfcheck import MAX_PARSED
from codegen.equivalence import obligations
from codegen.equivalence.obligations import Obligation
from codegen.equivalence.symbolic import Unreadable
from codegen.errors import DisagreementError, InputError
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
        raise InputError(f"the solver units must be positive, not {budget}", "--solver-units", "leave it out")


def prove(build: Build, budget: int | None = None) -> Proofs:
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
    return Proofs(
        tuple(_answer_question(profile, question, budget or Budgets().solver_units) for question in asked),
        tuple(skipped),
    )


def _answer_question(profile: ir.PolicyProfile, question: Obligation, budget: int) -> Proof:
    answer = ask_bits(question.text, question.names, budget)
    if answer.model is not None:
        x = question.observation(answer.model)
        policy = profile.policy(question.agent)
        wanted = policy.actions[int(ir.act(policy, [x])[0])].name
        values = ", ".join(repr(value) for value in x)
        where = f"{question.agent}: for x = ({values}) the profile says {wanted}, the code another action"
        raise DisagreementError(f"{question.target}: code and profile differ", where, "nothing was written")
    return Proof(question, answer)


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
