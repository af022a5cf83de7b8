"""A kind of claim has an entry in each of the tables by kind."""

from maviper.verification.run import PROCEDURES, procedure
from verify.claims.built_in import CLAIMS, OfEpisodes
from verify.claims.episodes import EPISODE_CLAIMS
from verify.kinds import Kind
from verify.reports.report import TELLINGS


def test_a_kind_of_claim_has_an_entry_in_each_table():
    assert set(PROCEDURES) == set(TELLINGS) == set(Kind)
    assert {name for name, kind in CLAIMS.items() if issubclass(kind, OfEpisodes)} == set(EPISODE_CLAIMS)
    assert procedure(EPISODE_CLAIMS["covers"]("team", 3)) is not PROCEDURES[Kind.DECISIONS]()
