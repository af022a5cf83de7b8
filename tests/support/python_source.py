"""What several tests of the import of Python use: imports compared with Python's own run, and large programs."""

import numpy as np

from codegen import ir, policy_json, profiles
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from codegen.numbers import neighbour
from tests.codegen.importers.origins import label_of

SAID = Said()
NUMBERS = (0.1, -0.3, 0.5, 2, 0, 1e-3, 16777217, 0.30000001192092896, -1e30, 9007199254740993)


def imported(text, said=SAID, **given):
    return profile_of(from_python(text.encode(), "policy.py", said), Names(**given))


def called(text, name):
    """The function as Python itself makes it; only tests run what they wrote."""
    space = {}
    exec(text, space)
    return space[name]


def around(numbers, width, count=3_000):
    """Observations with every feature at a number, beside it, or anywhere, [count, width] float32."""
    rng = np.random.default_rng(0)
    with np.errstate(over="ignore"):
        at = np.array([float(each) for each in numbers]).astype(np.float32)
    values = np.concatenate([at, neighbour(at, -np.inf), neighbour(at, np.inf), [np.inf, -np.inf]])
    rows = rng.choice(values.astype(np.float32), (count, width))
    rows[::2] = np.where(rng.random((len(rows[::2]), width)) < 0.5, rows[::2], rng.normal(size=rows[::2].shape))
    return rows


def same(text, numbers=NUMBERS, label=str, spread=False, said=SAID, **given):
    """The profile, after each function was compared with Python's own."""
    profile = imported(text, said, **given)
    origins = from_python(text.encode(), "policy.py", said)
    for policy, (name, origin) in zip(profile.agents, origins.items(), strict=True):
        function, rows = called(text, name), around(numbers, len(policy.features))
        said = [function(*row) if spread else function(row) for row in rows.astype(np.float64).tolist()]
        found = [label(label_of(policy, origin, action)) for action in ir.act(policy, rows).tolist()]
        assert found == [label(each) for each in said]
    assert policy_json.dumps(profiles.loads(policy_json.dumps(profile))) == policy_json.dumps(profile)
    return profile


def nested(depth, bounds, indent, rng):
    """A full tree of tests, each within what the tests above it leave, as lines."""
    if depth == 0:
        yield f"{indent}return {rng.integers(5)}\n"
        return
    feature = depth % len(bounds)
    low, high = bounds[feature]
    at = low + (high - low) * rng.uniform(0.3, 0.7)
    yield f"{indent}if x[{feature}] <= {at!r}:\n"
    yield from nested(depth - 1, {**bounds, feature: (low, at)}, indent + " ", rng)
    yield f"{indent}else:\n"
    yield from nested(depth - 1, {**bounds, feature: (at, high)}, indent + " ", rng)
