"""States in which real agents break a formula about what they give and do, drawn anywhere in a claim's regions.

Does: draws states in float64, many at a time; asks `codegen.ir` what the agents give and do there.
Assumes: a statement and a profile as `as_played` reads them, and the formula of the claim as it was written.
Does not: decide: each state is judged in exact numbers by whoever asked for it.

A state that breaks a claim by a rounding alone says nothing of states far from it, in which the agents may break it.
"""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from codegen.ir import Int32, PolicyProfile, act, outputs
from verify.claims.formula import Formula
from verify.claims.uncertified.values import Batch
from verify.reach.play.samples import Planes, Starts, observe_planes, random_starts, value
from verify.systems.claims import SystemClaim
from verify.systems.observing import list_settings
from verify.systems.statement import Statement
from verify.systems.system import State

DRAWN, TRIED, SEED = 16_384, 8, 0  # states; of those that seem to break the claim, the ones that are told


def iterate_failing(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, written: Formula
) -> Iterator[State]:
    """Some states of a claim's regions in which the formula seems to fail; roundings are as they are drawn."""
    system = statement.system
    drawn = random_starts(system, claim, Starts(DRAWN), np.random.default_rng(SEED))
    if drawn is None:
        return
    point: Planes = dict(drawn)
    actions: dict[str, Int32] = {}
    for policy in profile.agents:
        read = statement.acting.get(policy.agent)
        real = policy if read is None else read.real
        rows = observe_planes(system, real, drawn)
        if real.outputs:
            given = outputs(real, rows).astype(np.float64)
            point |= {f"{real.agent}.{each.name}": given[:, place] for place, each in enumerate(real.outputs)}
        else:
            actions[real.agent] = taken = act(real, rows)
            for number, action in enumerate(real.actions):
                for name, form in list_settings(statement, real.agent, action.name).items():
                    point[name] = np.where(taken == number, value(form, drawn), point.get(name, 0.0))
    asked = Batch(point, len(next(iter(drawn.values()))))
    broken = ~asked.holds(written, actions)
    if claim.regions:
        broken &= asked.holds(claim.inside, {})
    for row in np.flatnonzero(broken)[:TRIED]:
        yield {name: Fraction(float(values[row])) for name, values in drawn.items()}
