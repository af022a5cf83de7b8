"""What is done with claims about whole episodes.

Does: joins their verdicts with rollouts; certificates and counterexamples as text.
Assumes: a bench for the profile that is asked about. Such claims are of the deployed arithmetic.
Does not: decide. No files: the report has the share of starts that fail, and zones decide without a solver.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from codegen.ir import PolicyProfile
from maviper.verification.bench import Bench
from maviper.verification.files import episodes as episode_files
from maviper.verification.procedures.procedure import Procedure
from maviper.verification.replays import rollouts
from verify.certificates.episodes import to_json
from verify.extent.starts import start_share
from verify.question import EpisodeQuestion
from verify.result import Verdict
from verify.semantics import MACHINE
from verify.verdicts import episodes
from verify.verdicts.episodes import EpisodeResult


def _answer(question: EpisodeQuestion, bench: Bench, region_file: str | None) -> EpisodeResult:
    asked = question.by(MACHINE)
    result = episodes.verify_episodes(asked, rollouts(bench.made, bench.world), bench.skipped)
    if region_file is None:
        return result
    return replace(result, evidence=replace(result.evidence, starts=start_share(asked, result.verdict)))


def _verdict(question: EpisodeQuestion, bench: object) -> tuple[Verdict, str]:
    return episodes.verdict(question.by(MACHINE))


def _counterexample(profile: PolicyProfile, result: EpisodeResult) -> tuple[dict[str, Any], str] | None:
    return None if result.evidence.state is None else (episode_files.document(profile, result), "from its start")


PROCEDURE = Procedure(_answer, _verdict, to_json, _counterexample)
