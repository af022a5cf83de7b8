"""The yardsticks of tests/benchmarks/verifier.py: they answer as the zones do, and nothing is kept between them."""

from tests.benchmarks import direct, verifier
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.region_files import start_region
from verify.question import Question
from verify.result import Verdict
from verify.subjects import Game
from verify.verdicts.opinions import by_zones


def test_a_direct_query_answers_as_the_zones_do_and_nothing_is_kept_between_them():
    game = verifier.Played("physical-deception")
    region = start_region(game.world.spec)
    verdicts = set()
    for profile in (verifier.deception_team(game, "roles", 6), verifier.held_roles(game, 3)):
        found = by_zones(Question(Game(profile), DistinctTargets("defenders"), region)).opinion.verdict
        assert (found is Verdict.PROVED) == direct.decided(profile, "defenders")
        verdicts.add(found)
        assert formula.cache_info().currsize
        verifier.forget()
        assert not formula.cache_info().currsize
    assert verdicts == {Verdict.PROVED, Verdict.VIOLATED}
