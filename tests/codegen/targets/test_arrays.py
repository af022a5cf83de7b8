"""The modules for JAX and PyTorch: any leading shape, subnormal numbers, jit, vmap, scan and torch.compile."""

import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes, readback, selfcheck
from codegen.floats import FLOAT32
from codegen.lowering.lower import lower
from codegen.targets import emit
from tests.support.strategies import with_trees
from tests.support.teams import towards, tree

LIBRARIES = ["jax", "torch"]
TINY = float(np.float32(1e-45))
THRESHOLDS = [0.0, TINY, -TINY, 1e-39, 0.1, -0.3, 3.4028234663852886e38, -3.4028234663852886e38]


def module_of(profile, library):
    pytest.importorskip(library, reason=f"{library} is not installed")
    return readback.load_python(emit(profile, [library])[f"physical_deception_{library}.py"])


def given(library, rows):
    if library == "jax":
        return rows
    return pytest.importorskip("torch").tensor(rows)


@pytest.mark.interop
@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_subnormal_numbers_are_not_zero(library, threshold, profile):
    """XLA on a CPU takes them for zero where floats are compared."""
    made = with_trees({"agent_0": tree((0, threshold, 1, 2), 1, 2)}, profile)
    act, policy = module_of(made, library)["act_agent_0"], made.policy("agent_0")
    tiny = [-np.float32(np.nan), np.float32(TINY), -np.float32(TINY)]
    around = [*probes.neighbours(threshold, FLOAT32), *probes.SPECIAL[FLOAT32], *tiny]
    rows = np.zeros((len(around), len(policy.features)), dtype=np.float32)
    rows[:, 0] = around
    assert np.asarray(act(given(library, rows))).tolist() == ir.act(policy, rows).tolist()


@pytest.mark.interop
@pytest.mark.parametrize("library", LIBRARIES)
def test_any_leading_shape(library, profile):
    made = with_trees({"adversary_0": tree(3), "agent_0": towards(0, 0)}, profile)
    module, rng = module_of(made, library), np.random.default_rng(0)
    for policy in made.agents:
        act, n = module["ACT"][policy.agent], len(policy.features)
        for shape in ((), (1,), (0,), (7,), (2, 3), (2, 1, 4)):
            rows = rng.uniform(-1, 1, (*shape, n)).astype(np.float32)
            found = np.asarray(act(given(library, rows)))
            assert found.shape == shape and found.dtype == (np.int32 if library == "jax" else np.int64)
            assert found.ravel().tolist() == ir.act(policy, rows.reshape(-1, n)).tolist()
        for wrong in (np.zeros((2, n + 1), np.float32), np.zeros((n, 1), np.float32), np.zeros((), np.float32)):
            with pytest.raises(ValueError, match=f"{policy.agent} observes {n} numbers, given a"):
                act(given(library, wrong))
        with pytest.raises(TypeError, match=f"{policy.agent} observes {n} numbers, given a"):
            act(given(library, np.zeros((2, n), np.complex64)))
    seen = {policy.agent: given(library, np.zeros((4, len(policy.features)), np.float32)) for policy in made.agents}
    assert {name: found.shape[0] for name, found in module["act_all"](seen).items()} == dict.fromkeys(seen, 4)


@pytest.mark.interop
def test_jax_scans_over_decisions(profile):
    module, jax = module_of(profile, "jax"), pytest.importorskip("jax")
    policy = profile.policy("agent_0")
    rows = probes.random(policy.features, 50, np.random.default_rng(0))
    found = jax.jit(lambda x: jax.lax.scan(lambda _, row: (None, module["act_agent_0"](row)), None, x)[1])(rows)
    assert np.asarray(found).tolist() == ir.act(policy, rows).tolist()


@pytest.mark.interop
@pytest.mark.parametrize("given", [[0.0] * 10, (0.0,) * 10, np.zeros(10, np.float32), np.zeros((2, 10)), None, 0.0])
def test_torch_takes_tensors_only(given, profile):
    """As the Python module: a TypeError that says what was given, not whatever breaks further on."""
    module = module_of(profile, "torch")
    kind = type(given).__name__
    with pytest.raises(TypeError, match=rf"agent_0 observes a tensor of 10 numbers, given {kind}: torch\.as_tensor"):
        module["act_agent_0"](given)


@pytest.mark.slow
@pytest.mark.train
def test_torch_compile_takes_the_functions(profile):
    torch = pytest.importorskip("torch")
    if shutil.which("g++") is None or sys.platform != "linux":
        pytest.skip("torch.compile needs g++")
    policy = profile.policy("agent_0")
    rows = np.concatenate(
        [probes.random(policy.features, 500, np.random.default_rng(0)), selfcheck.observations(policy, random=0)]
    )
    compiled = torch.compile(module_of(profile, "torch")["act_agent_0"], fullgraph=True)
    assert compiled(torch.tensor(rows)).tolist() == ir.act(policy, rows).tolist()


@pytest.mark.parametrize("library", LIBRARIES)
def test_a_missing_library_is_said(library, profile, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    report = selfcheck.check_files(profile, emit(profile, [library]), random=100)
    assert report.skipped == (f"py: {library} is not installed",) and not report.agreements


def test_thresholds_in_the_order_of_integers(profile):
    """As C reads bits: the order of finite floats is that of these integers, and both zeros are one threshold."""
    values = sorted([*THRESHOLDS, 1.0, -1.0, 2.0, -2.5])
    found = []
    for value in (*values, -0.0):
        stump = tree((0, value, 1, 2), 1, 2)
        stump = replace(stump, threshold=np.array([value, 0, 0], dtype=np.float32))
        found.append(lower(with_trees({"agent_0": stump}, profile)).agents[1].nodes[0].ordered)
    assert found[:-1] == sorted(set(found[:-1])) and found[-1] == 0 == found[values.index(0.0)]
