"""Repair in a stated system: guards above trees, until each claim of a world file is proved.

Does: has the claims asked after each counterexample; renders the team, its certificates, the report and what changed.
Assumes: claims about regions in which episodes stay.
Does not: choose guards (verify/reach/guards.py), decide verdicts, measure play, print or write files.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from codegen.deciding import VERIFIER, ensure_plain
from codegen.errors import InputError
from codegen.form import layout
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from codegen.profiles import ensure
from codegen.rows import Shown
from maviper.compilation.compile import BEFORE_REPAIR
from maviper.evaluation.comparison import sizes_document
from maviper.files import runs
from maviper.options import RepairOptions, complete_options
from maviper.verification.ask import VerifyOptions
from maviper.verification.repair import COST_FILE
from maviper.verification.run import Verified
from maviper.verification.stated import StatedWorld
from verify.question import Question
from verify.reach.guards import Answer, Guard, hold, insert
from verify.result import AnyResult, Verdict
from verify.systems.claims import SystemClaim
from verify.systems.system import ensure_in_steps

SAMPLES = 16  # random episodes that may refute a claim before it is proved


@dataclass(frozen=True, repr=False)
class Guarded(Shown):
    """A repair in a stated system: guards, and, where all claims are proved, the team with them and its files.

    For example:

        maviper.repair(team, "world.toml").after
    """

    before: PolicyProfile
    guards: tuple[Guard, ...]
    reason: str  #: why no repair was found; "": one was
    after: PolicyProfile | None = None  #: None: no repair was found
    results: tuple[AnyResult, ...] = ()
    files: Mapping[str, str | bytes] = field(default_factory=dict[str, str | bytes])  #: name -> text
    certificates: Mapping[str, str] = field(default_factory=dict[str, str])  #: those among the files

    @property
    def guarded(self) -> list[str]:
        """The agents that got guards."""
        return list(dict.fromkeys(guard.agent for guard in self.guards))

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each claim that was proved."""
        return [row for result in self.results for row in result.rows]

    @property
    def told(self) -> list[str]:
        """The guards as rules, or why there is no repair."""
        return [f"Guarded: {self.reason or 'each claim is proved'}", *(guard.words for guard in self.guards)]


class _Asking:
    """Asks the claims of a world file; `results`: of the claims proved since the team last changed, by number."""

    def __init__(self, before: PolicyProfile, options: VerifyOptions) -> None:
        self.options, self.stated = options, StatedWorld.of(before, options)
        self.results, self.first = dict[int, AnyResult](), -1
        self._origin, self._marked = self.stated.origin, _mark(before)

    def __call__(self, after: PolicyProfile) -> Answer | None:
        """The first claim that is not proved, the one that failed last before others."""
        changed = after.agents != self._origin.agents
        self.stated = StatedWorld.of(replace(after, provenance=self._marked) if changed else after, self.options)
        self.results = dict[int, AnyResult]()
        asked = self.stated.asked
        last_ones_first = reversed(range(len(asked)))  # files tend to begin with what any tree keeps
        for place in sorted(last_ones_first, key=lambda place: place != self.first):
            question = asked[place].question
            sparing = cast("Question[SystemClaim]", question.spending(samples=SAMPLES))
            result = self.stated.answer(sparing, beside=False)
            if result.verdict is not Verdict.PROVED:
                self.first = place
                return Answer(result.claim, result.evidence.counterexample, result.reason)
            self.results[place] = replace(result, question=question)
        return None


def _mark(before: PolicyProfile) -> Any:
    """The provenance of what is repaired: the same after each repair of a team, so that certificates stay valid."""
    first = before.provenance.training.get(BEFORE_REPAIR, content_hash(before))
    training = {**before.provenance.training, "repair": "guards in stated systems", BEFORE_REPAIR: first}
    return replace(before.provenance, training=training, evaluation={})


def ensure_unasked(region: str | Path, options: Mapping[str, Any]) -> None:
    """InputError for a region, or an option of `maviper repair`, that a repair by a world file does not read."""
    usual = {"region": "start", **complete_options(RepairOptions, {})}
    for name, value in {"region": str(region), **options}.items():
        if value is not None and value != usual[name]:
            flag = f"--{name.replace('_', '-')}"
            raise InputError(f"{flag} has no effect with a world file", flag, "leave it out; the file states regions")


def repair_stated(before: PolicyProfile, world: Path, name: str = runs.PROFILE_FILE) -> Guarded:
    """The repair of a team, which a user calls `name`, by the claims of a world file. InputError for a team that tests
    sums, a file that cannot be used, and a system in continuous time.
    """
    ensure_plain(before, VERIFIER)
    asking = _Asking(before, VerifyOptions(world=world))
    system = asking.stated.statement.system
    ensure_in_steps(system, "a repair")
    held = hold(asking.stated.origin, system, asking)
    if held.reason:
        return Guarded(before, held.guards, held.reason)
    marked = replace(before, provenance=_mark(before)) if held.guards else before
    after = ensure(insert(marked, held.guards))
    results = tuple(result for _, result in sorted(asking.results.items()))
    verified = Verified(after, tuple(asking.stated.asked), results, None, asking.stated)
    made = shlex.join(["maviper", "repair", name, "--claim", world.name])
    told = {
        "command": made,
        "profile_before": content_hash(before),
        "profile": content_hash(after),
        "counterexamples": held.rounds,
        "guards": [guard._asdict() for guard in held.guards],
        "trees": sizes_document(before, after, list(dict.fromkeys(guard.agent for guard in held.guards))),
    }
    files = {**verified.files, COST_FILE: layout(told) + "\n"}
    return Guarded(before, held.guards, "", after, results, files, verified.certificates)
