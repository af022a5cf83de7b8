"""Bounds of outputs beside what is sampled: most are proved 2 % above the sampled extreme, none is 2 % below it."""

from fractions import Fraction

import numpy as np
import pytest

import maviper
from codegen import ir
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS
from tests.support import summed
from tests.support.giving import VARIABLES, tree, world
from verify.result import Verdict
from verify.systems.files import statement_of
from verify.systems.observing import observe_state

FEW, MANY, SAMPLES = 1, 12, 400
NEAR = 0.02  # of the span, from the sampled extreme to a bound


def sampled(policy, seed):
    """What the agent gives in states of the ranges, half of their numbers at an end, [n, outputs]."""
    system = statement_of(world(len(policy.outputs)), "w.toml").system
    rng = np.random.default_rng(seed)
    rows = rng.uniform(-3, 3, (SAMPLES, len(VARIABLES)))
    rows = np.where(rng.random(rows.shape) < 0.5, np.sign(rows) * 3, rows)
    return np.concatenate(
        [
            ir.outputs(
                policy,
                observe_state(
                    system, policy, {name: Fraction(value) for name, value in zip(VARIABLES, row.tolist(), strict=True)}
                ),
            )
            for row in rows
        ]
    )


def asked(policy, seed, folder):
    """Verdicts on bounds just above and just below the extremes of each output: (sound bound, verdict)."""
    given = sampled(policy, seed)
    claims, above = [], []
    for place, output in enumerate(policy.outputs):
        low, high = float(given[:, place].min()), float(given[:, place].max())
        near = NEAR * max(high - low, 0.1)
        for sign, end, outward in (("<=", high, near), (">=", low, -near)):
            for times in (1, -1):
                claims.append(
                    f'[[property]]\nformula = "out(agent_0).{output.name} {sign} {end + times * outward!r}"\n'
                )
                above.append(times > 0)
    file = folder / f"{seed}.toml"
    file.write_text(world(len(policy.outputs), more="".join(claims)))
    found = maviper.verify_system(summed.profile(policy), file)
    return list(zip(above, [result.verdict for result in found.results], strict=True))


def hunted(arithmetic, seeds, folder):
    found = [pair for seed in seeds for pair in asked(tree(seed, arithmetic, 2), seed, folder)]
    assert all(verdict is not Verdict.PROVED for sound, verdict in found if not sound)  # a sampled state breaks it
    decided = sum(verdict in (Verdict.PROVED, Verdict.VIOLATED) for _, verdict in found)
    assert decided >= 0.9 * len(found)
    return found


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
@pytest.mark.parametrize("arithmetic", [DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS])
def test_bounds_are_tight_and_sound(arithmetic, count, tmp_path):
    found = hunted(arithmetic, range(count), tmp_path)
    proved = sum(verdict is Verdict.PROVED for sound, verdict in found if sound)
    assert len(found) == 8 * count and (count == FEW or proved >= 0.6 * sum(sound for sound, _ in found))
