"""What several tests use of `maviper.verification.test_unstated`."""

from dataclasses import replace

from codegen import ir
from codegen.profiles import ensure
from tests.support.observations import blind
from tests.support.teams import tree
from verify.claims.observed import View, over


def far(threshold, action):
    """A profile that speaks of two variables without a range."""
    whole = over(blind({"car": tree((0, threshold, 1, 2), 0, action)}, {"car": ["gap"]}, ir.MAX_LENGTH), View())
    return ensure(replace(whole, world=replace(whole.world, options={})))
