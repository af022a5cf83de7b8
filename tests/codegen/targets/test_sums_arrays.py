"""Trees with sums under JAX and PyTorch: float64 sums of float32 numbers, whatever XLA simplifies or takes for zero."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes, readback, selfcheck
from codegen.agreement.compiled import Build
from codegen.lowering.lower import lower
from codegen.sums import FLOAT64_SUMS
from codegen.targets import emit
from tests.support import summed

pytestmark = pytest.mark.interop
LIBRARIES = ["jax", "torch"]
RANDOM = 200
TINY = "jnp.where(bits & 0x7F800000 == 0, jnp.where(bits < 0, -tiny, tiny), wide)"
STEP = "jnp.where(jnp.abs(value) < 2.0**-126, jnp.round(value * 2.0**149) * 2.0**-149, near)"
SINGLE = "jnp.where(tiny, jax.lax.bitcast_convert_type(bits, jnp.float32), value.astype(jnp.float32))"
FAULTS = [
    ("jax", "jnp.where(value == 0, 0.0, value)", "value + 0.0"),  # which XLA takes for value
    ("jax", TINY, "wide"),
    ("jax", STEP, "near"),
    ("jax", SINGLE, "value.astype(jnp.float32)"),
    ("jax", "(value > high, high", "(value > high, low"),
    ("torch", "near = value.to(torch.float32).to(torch.float64)", "near = value"),
    ("torch", "(value < low, low", "(value <= low, high"),
]


@cache
def team():
    """Agents that observe float32: what acts, what gives in either arithmetic, what is rounded at the end."""
    kinds = summed.every(1, levels=2)
    names = ("actions, double sums", "outputs, double sums", "outputs, float32 steps", "double sums given as float32")
    agents = (kinds[name].agents[0] for name in names)
    return summed.profile(*(replace(each, agent=f"agent_{place}") for place, each in enumerate(agents)))


@cache
def files(library):
    pytest.importorskip(library, reason=f"{library} is not installed")
    return emit(team(), [library])


def replayed(made):
    with Build(team(), lower(team()), made) as build:
        return selfcheck.check(build, random=RANDOM)


@pytest.mark.parametrize("library", LIBRARIES)
def test_the_bits_of_the_reference(library):
    report = replayed(files(library)).ensure()
    assert len({each.target for each in report.agreements}) == 2 and report.observations > 10_000


@pytest.mark.parametrize(("library", "right", "wrong"), FAULTS)
def test_what_a_library_would_compute_otherwise_is_found(library, right, wrong):
    (text,) = files(library).values()
    assert text.count(right) == 1
    policies = [policy for policy in team().agents if policy.outputs]
    module = readback.load_python(text.replace(right, wrong))
    assert any(differs(module, library, policy) for policy in policies)


def differs(module, library, policy):
    """Whether a compiled or mapped call gives other bits than the reference."""
    rng = np.random.default_rng(0)
    rows = np.concatenate(list(probes.telling(policy, rng)))
    act, wanted = module["ACT"][policy.agent], ir.outputs(policy, rows)
    if library == "jax":
        jax = pytest.importorskip("jax")
        with readback.with_doubles(module):
            found = np.asarray(jax.jit(act)(rows))
    else:
        found = act(pytest.importorskip("torch").tensor(rows)).numpy()
    return found.dtype != wanted.dtype or not (bits(found) == bits(wanted)).all()


def bits(values):
    return np.where(np.isnan(values), np.nan, values).astype(np.float64).view(np.uint64)


@pytest.mark.parametrize("library", [pytest.param("jax", marks=pytest.mark.slow), "torch"])
def test_any_leading_shape(library):
    (text,) = files(library).values()
    module = readback.load_python(text)
    policy = next(each for each in team().agents if each.outputs)
    for shape in ((), (0,), (2, 3)):
        rows = np.random.default_rng(1).uniform(-3, 3, (*shape, 5)).astype(np.float32)
        with readback.with_doubles(module):
            given = rows if library == "jax" else pytest.importorskip("torch").tensor(rows)
            found = np.asarray(module["ACT"][policy.agent](given))
        wanted = ir.outputs(policy, rows.reshape(-1, 5)).reshape(*shape, len(policy.outputs))
        assert found.shape == wanted.shape and (bits(found) == bits(wanted)).all()


def test_without_float64_jax_says_so():
    (text,) = files("jax").values()
    with pytest.raises(RuntimeError, match="sums of agent_0 are added as float64, which JAX has not yet"):
        readback.load_python(text)["act_agent_0"](np.zeros(5, np.float32))


@pytest.mark.slow
@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("seed", range(2, 6))
def test_other_trees(library, seed):
    pytest.importorskip(library, reason=f"{library} is not installed")
    agents = [each for each in summed.together(seed).agents if each.tree.arithmetic != FLOAT64_SUMS]
    profile = summed.profile(*(replace(each, agent=f"agent_{place}") for place, each in enumerate(agents)))
    report = selfcheck.check_files(profile, emit(profile, [library]), random=RANDOM).ensure()
    assert report.observations > 10_000
