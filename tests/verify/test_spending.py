"""What long searches tell, and to whom."""

from fractions import Fraction

from tests.support.episode_cases import arriving
from tests.support.teams import team
from verify.claims.episodes import Reaches
from verify.question import from_start
from verify.spending import listening, tell
from verify.verdicts.episodes import verdict


def test_nobody_need_listen_and_the_last_listener_hears():
    heard = []
    tell(1, 2, "nobody")
    with listening(lambda *said: heard.append(said)):
        tell(1, 2, "first")
        with listening(lambda *said: heard.append(("inner", *said))):
            tell(2, 2, "second")
        tell(2, 2, "third")
    tell(3, 3, "nobody again")
    assert heard == [(1, 2, "first"), ("inner", 2, 2, "second"), (2, 2, "third")]


def test_a_proof_about_episodes_tells_its_zones_and_answers(profile):
    roles = team(profile, arriving(0), arriving(1))
    claim = Reaches("defenders", 40, Fraction(2, 5), ("landmark_0", "landmark_1"))
    heard = []
    with listening(lambda *said: heard.append(said)):
        verdict(from_start(roles, claim))
    kinds = {words.split(" ")[0] for _, _, words in heard}
    assert kinds == {"zones", "answers"} and all(0 <= done <= most for done, most, _ in heard)
