"""Settings of an extraction that mean nothing are refused, with the reason."""

import pytest

from codegen.errors import InputError
from maviper.extraction.settings import BEST_RESPONSE, FITTED_Q, RGMDT, TEAM, Settings

RELEASED = {"preset": "released"}
REPLIES = {"algorithm": BEST_RESPONSE}
GREEDY = {"algorithm": RGMDT}
SHARED = {"share": TEAM}
REFUSED = [
    ({"max_depth": 0}, "at least 1"), ({"max_depth": 65}, "at most 64"), ({"iterations": 0}, "iterations"),
    ({"rollouts": -1}, "rollouts"), ({"seed": -1}, "seed"),
    ({"iterations": 10_000, "rollouts": 100}, "100000 episodes in all"),
    *(({"enough": wrong}, "enough is a ratio") for wrong in (-0.1, 101.0, float("nan"))),
    *(({"max_seconds": wrong}, "max_seconds is a number of seconds") for wrong in (-1.0, float("inf"), float("nan"))),
    *(({"least_right": wrong}, "no number of right predictions")
      for wrong in ("", "n", "-1", "1.5", "N+1", "2 of 3", "N-", "9" * 9)),
    *(({"budget": wrong}, f"--max-episodes must be from 1 to [0-9]+, not {wrong}") for wrong in (-1, 0)),
    ({"budget": 1_000, "iterations": 3, "refinement": 0}, "already determines --iterations, --refinement-episodes"),
    ({"max_leaves": 5}, "vote"),
    ({**RELEASED, "least_right": "N"}, "preset released"),
    ({**RELEASED, "rollouts_by": "team"}, "preset released"),
    ({**RELEASED, "algorithm": "iviper", "weights": "averaged"}, "preset released"),
    ({**RELEASED, "selection_by": "agent"}, "preset released"),
    ({**RELEASED, "algorithm": FITTED_Q}, "always stands still"),
    ({"undo": "leaves", "preset": "paper"}, "only the authors' code"),
    ({**RELEASED, "undo": "leaves"}, "accident of the released maviper 'leaves'"),
    ({**RELEASED, "undo": "leavs", "algorithm": "iviper"}, "did you mean 'leaves'"),
    ({**RELEASED, "undo": "restarts", "algorithm": "iviper"}, "restarts"),
    ({**RELEASED, "undo": "warm-up+"}, "accident"),
    ({"algorithm": "viper", "rollouts_by": "all"}, "viper extracts one agent"),
    ({"algorithm": "viper", "selection_by": "team"}, "viper extracts one agent"),
    ({"algorithm": FITTED_Q, "rollouts_by": "all"}, "rewards of expert episodes"),
    ({"algorithm": FITTED_Q, "weights": "own"}, "rewards of expert episodes"),
    ({"selection": "race", "selection_by": "all"}, "one agent or of one team"),
    ({"selection": "return", "selection_by": "all"}, "one agent or of one team"),
    ({**REPLIES, "least_right": "N"}, "votes count predictions"),
    ({**REPLIES, "rollouts_by": "agent"}, "extracted in the same rounds"),
    ({**REPLIES, "weights": "averaged"}, "not averaged over"),
    ({**REPLIES, "selection_by": "member", "selection": "uniform"}, "are raced"),
    ({**REPLIES, **RELEASED}, "is ours"),
    ({**GREEDY, "max_leaves": 1}, "max_leaves"),
    ({"max_leaves": 8, "algorithm": "maviper"}, "level by level"),
    ({"max_leaves": 8, "algorithm": FITTED_Q}, "fitted-q"),
    ({**GREEDY, **RELEASED}, "after its description"),
    ({**GREEDY, "weights": "own"}, "expert's Q"),
    ({**SHARED, "algorithm": "viper"}, "viper grows a tree for each agent alone"),
    ({**SHARED, "algorithm": FITTED_Q}, "fitted-q grows"),
    ({**SHARED, **RELEASED, "algorithm": "maviper"}, "authors' code grows"),
    ({**SHARED, "algorithm": "iviper", "rollouts_by": "agent"}, "play and choose together"),
    ({**SHARED, "algorithm": "maviper", "refinement": 300_000}, "refinement changes the trees"),
    ({"algorithm": "maviper", "share": "all"}, "unknown share 'all'"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "said"), REFUSED)
def test_what_means_nothing_is_refused(given, said):
    with pytest.raises(InputError, match=said):
        Settings.of(given).complete()
