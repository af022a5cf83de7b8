"""The answer to a question, whatever kind of claim it is about: verdict, reason, evidence and cost.

Does: the possible verdicts; what every kind of evidence has; the opinion of an engine, and how much room a proof has.
Assumes: whoever decides one kind of claim has a kind of evidence of its own (verdicts/).
Does not: decide, or say anything in words.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from codegen.rows import Shown
from verify.question import About, Question

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from verify.claims.region import Region
    from verify.claims.views import Viewed
    from verify.states.state import State


class Verdict(StrEnum):
    """The answer to a question; the values are the words that reports use.

    For example:

        maviper.verify(team).verdict == "PROVED"
    """

    PROVED = "PROVED"  #: holds in every world state of the region, by the arithmetic asked about
    VIOLATED = "VIOLATED"  #: fails in a world state that the referee confirmed by it
    VACUOUS = "VACUOUS"  #: no world state of the region meets the assumptions, or the left side of an implication
    UNKNOWN = "UNKNOWN"  #: the budget ended, or of the deployed arithmetic only a real-valued state was found
    SKIPPED = "SKIPPED"  #: not asked


SETTLED = (Verdict.PROVED, Verdict.VIOLATED)  # what a control is asked about


@dataclass(frozen=True)
class Opinion:
    """The verdict of one engine, and what it spent; SKIPPED where the question is beyond it."""

    engine: str
    verdict: Verdict
    spent: int
    unit: str

    def document(self) -> dict[str, str | int]:
        """The opinion as plain data."""
        return {"engine": self.engine, "verdict": self.verdict.value, "spent": self.spent, "unit": self.unit}


@dataclass(frozen=True)
class Margin:
    """Proved at `proved`; not at `failed`, or None where the widest margin that is asked about is proved too."""

    proved: Fraction
    failed: Fraction | None
    questions: int


@dataclass(frozen=True)
class Cost:
    """The amount that an answer took of its main budget, in a unit that does not depend on the machine.

    For example:

        maviper.verify(team).cost.spent
    """

    spent: int
    budget: int
    unit: str


@dataclass(frozen=True)
class Control:
    """The number of copies of the trees with their leaves shuffled that fulfil the claim, and that break it, of all
    asked.
    """

    fulfil: int = 0
    broken: int = 0
    asked: int = 0

    @staticmethod
    def of(verdicts: Iterable[Verdict]) -> Control:
        """Counts the verdicts on shuffled trees."""
        counts = Counter(verdicts)
        return Control(counts[Verdict.PROVED], counts[Verdict.VIOLATED], counts.total())

    @property
    def verdict(self) -> Verdict:
        """The verdict of more than half of them. It should be VIOLATED, else the claim says little about the trees."""
        if 2 * self.fulfil > self.asked:
            return Verdict.PROVED
        return Verdict.VIOLATED if 2 * self.broken > self.asked else Verdict.UNKNOWN if self.asked else Verdict.SKIPPED

    @property
    def words(self) -> str:
        """The same in words; "" where none was asked."""
        open_ = self.asked - self.fulfil - self.broken
        told = f"{self.fulfil} of {self.asked} fulfil the claim" + (f", {open_} without an answer" if open_ else "")
        return told if self.asked else ""


@dataclass(frozen=True, kw_only=True, repr=False)
class Evidence(Shown):
    """The evidence for a verdict of whatever kind. `certificate`: of a proof; the checker accepted it.

    For example:

        maviper.verify(team).evidence.certificate
    """

    control: Control = Control()  #: of shuffled leaves
    opinions: tuple[Opinion, ...] = ()  #: of the engines asked; where two have a verdict, it is the same
    certificate: Any = None
    counterexample: Any = None  #: of a claim about decisions: the state in which it fails, and who does what there
    branches: int = 0  #: that the certificate closes
    replays: tuple[str, ...] = ()  #: what replays a counterexample, beside the reference
    skipped: tuple[str, ...] = ()  #: replays that could not be had, with the reason
    left_out: str = ""  #: which states of the region the claim is not about, in words

    @property
    def told(self) -> list[str]:
        """Who does what where the claim fails, and in which state; else what the engines say."""
        views = getattr(self.counterexample, "agents", ())
        does = [f"{each.agent} {each.action}" for each in views if hasattr(each, "action")]
        state = self.failing_state
        placed = () if state is None else state.position.items()
        at = [f"{name} {float(value):.4g}" for name, value in placed]
        opinions = [f"{each.engine} {each.verdict}" for each in self.opinions]
        return [*does, *at] or opinions or ["no engine was asked"]

    @property
    def certificates(self) -> Iterator[tuple[str, Any]]:
        """Each certificate, and how the name of its file goes on after the name of the claim."""
        if self.certificate is not None:
            yield "", self.certificate

    @property
    def failing_state(self) -> State | None:
        """The world state of a counterexample: in which the claim fails, or the start of an episode that fails."""
        return None

    @property
    def plays_world(self) -> bool:
        """True if this version plays the world that the profile is about, so that meanings of features were checked."""
        return False


Found = TypeVar("Found", bound=Evidence, covariant=True)


@dataclass(frozen=True, repr=False)
class Result(Shown, Generic[About, Found]):
    """The answer to one question.

    For example:

        maviper.verify(team).proved
    """

    question: Question[About]  #: claim, region, arithmetic and budgets
    verdict: Verdict
    reason: str  #: why there is no answer; "" where there is one
    evidence: Found  #: what the verdict rests on, of a class by kind of claim
    cost: Cost  #: what the answer took of its budget

    @property
    def proved(self) -> bool:
        """True if the claim is proved."""
        return self.verdict is Verdict.PROVED

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One row: verdict, claim, team, region, arithmetic, cost."""
        claim: Any = self.claim
        asked = {"verdict": str(self.verdict), "claim": claim.shown, "team": getattr(claim, "team", "")}
        spent = {"spent": self.cost.spent, "budget": self.cost.budget, "unit": self.cost.unit}
        return [{**asked, "region": self.region.name, "semantics": self.semantics, "reason": self.reason, **spent}]

    @property
    def told(self) -> list[str]:
        """Four lines: verdict and claim; where; what it rests on; what it cost."""
        (row,) = self.rows
        of = f" of the {row['team']}" if row["team"] else ""
        rests = self.reason or ", ".join(self.evidence.told)
        return [
            f"{self.verdict}: {row['claim']}{of}",
            f"region {self.region.name}, {self.semantics} arithmetic",
            " ".join(rests.split()),
            f"{self.cost.spent:,} of {self.cost.budget:,} {self.cost.unit}",
        ]

    @property
    def claim(self) -> About:
        """The claim that was asked about."""
        return self.question.claim

    @property
    def region(self) -> Region:
        """Where it is claimed."""
        return self.question.region

    @property
    def semantics(self) -> str:
        """The arithmetic that was asked about."""
        return self.question.semantics

    @property
    def counterexample(self) -> Any:
        """The state in which a claim about decisions fails, or None; of episodes the evidence has start and actions."""
        return self.evidence.counterexample

    @property
    def certificate(self) -> Any:
        """The certificate that the checker accepts, or None."""
        return self.evidence.certificate

    @property
    def viewed(self) -> Viewed | None:
        """The view that the claim is about, of claims over observations."""
        return self.question.viewed


AnyResult = Result[Any, Evidence]
