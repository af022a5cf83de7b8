"""What several tests use of `codegen.importers.test_python_source`."""


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
