"""What is done with claims about whole episodes.

Does: joins their verdicts with rollouts; certificates and counterexamples as text.
Assumes: a bench for the profile that is asked about. Such claims are of the deployed arithmetic.
Does not: decide. Files of regions and queries: such claims have none.
"""

from __future__ import annotations

from typing import Any

from codegen.ir import PolicyProfile
from maviper.verification.bench import Bench
from maviper.verification.files import episodes as episode_files
from maviper.verification.procedures.procedure import Procedure
from maviper.verification.replays import rollouts
from verify.certificates.games import to_json
from verify.kinds import MACHINE
from verify.question import EpisodeQuestion
from verify.result import Verdict
from verify.verdicts import episodes
from verify.verdicts.episodes import EpisodeResult


def _answer(question: EpisodeQuestion, bench: Bench, region_file: str | None) -> EpisodeResult:
    return episodes.verify_episodes(question.by(MACHINE), rollouts(bench.made, bench.world), bench.skipped)


def _verdict(question: EpisodeQuestion, bench: object) -> tuple[Verdict, str]:
    return episodes.verdict(question.by(MACHINE))


def _counterexample(profile: PolicyProfile, result: EpisodeResult) -> tuple[dict[str, Any], str] | None:
    return None if result.evidence.state is None else (episode_files.document(profile, result), "from its start")


PROCEDURE = Procedure(_answer, _verdict, to_json, _counterexample)
