"""Proofs about games: the seconds of CPU to find one, to check it, and of all that `verify` does for the claim.

    python -m tests.benchmarks.since [--rounds 3] [--whole] [--json]

Claims are those of generated/verdicts with a certificate. Whatever `--since` kept of an earlier proof would have to be
checked against the changed team, so the check of the whole is what a team that did not change would take. Finding and
checking take turns, and the least of all rounds counts. --whole adds `verify`, which plays episodes, asks the solver
and shuffles leaves beside the proof, once.
"""

from functools import partial
from pathlib import Path

from maviper import load
from maviper.verification.ask import VerifyOptions, questions
from maviper.verification.run import verify_claims
from tests.benchmarks.common import figure, interleave, reader, seconds, tell
from verify.checker import decisions as checked_decisions
from verify.checker.episodes import certificates as checked_episodes
from verify.episodes import composition
from verify.episodes.certificates import build_certificate
from verify.kinds import Kind
from verify.result import Verdict
from verify.verdicts.decisions import by_zones
from verify.zones import engine

RECORD = Path(__file__).parents[2] / "generated" / "verdicts"


def ways_of(question):
    """How a claim's proof is found and how it is checked; None where it has none."""
    profile = question.profile
    if question.claim.kind is Kind.DECISIONS:
        certificate = by_zones(question).certificate
        find, check = lambda: engine.decide(question), checked_decisions.check_certificate
    elif question.claim.kind is Kind.EPISODES:
        decided = composition.decide(question)
        if decided.verdict is not Verdict.PROVED:
            return None
        certificate, check = build_certificate(question, decided.parts), checked_episodes.check_certificate

        def find():
            build_certificate(question, composition.decide(question).parts)
    else:
        return None
    return None if certificate is None else {"find": find, "check": lambda: check(certificate, profile)}


def main():
    """Prints the figures of all claims that are proved."""
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--whole", action="store_true")
    given = parser.parse_args()

    def measure():
        for folder in sorted(path.parent for path in RECORD.glob("*/profile.json")):
            numbers = sorted(int(path.name.split("-")[1]) for path in folder.glob("certificate-*"))
            asked = questions(load(folder / "profile.json"), "", VerifyOptions(file=folder / "properties.toml"))
            for number, one in ((number, asked[number - 1]) for number in numbers):
                ways = ways_of(one.question)
                if ways is None:
                    continue
                name = f"{folder.name} {number} {one.claim.name}"
                least = {way: min(times) for way, times in interleave(ways, given.rounds).items()}
                yield from (figure(f"{name}, {way}, s", taken) for way, taken in least.items())
                yield figure(f"{name}, check over find", least["check"] / least["find"])
                if given.whole:
                    yield figure(f"{name}, verify, s", seconds(partial(verify_claims, [one.question]))[0])

    tell(measure(), given.json)


if __name__ == "__main__":
    main()
