"""What an agent decides, asked in one place: actions and numbers of every arithmetic."""

import numpy as np
import pytest

from codegen import deciding, ir
from codegen.agreement import probes
from codegen.errors import InputError
from tests.support import summed

PROFILES = summed.every(5)


@pytest.mark.parametrize("name", PROFILES)
def test_decisions_are_those_of_the_reference_and_of_exact_arithmetic(name):
    for policy in PROFILES[name].agents:
        rows = probes.random(policy.features, 40, np.random.default_rng(1), policy.numbers)
        found = deciding.decide(policy, rows)
        assert found.shape == (40, *deciding.shape_decided(policy))
        assert np.array_equal(deciding.decide_at(policy, ir.apply(policy.tree, rows), rows), found)
        exact = [summed.exact_decision(policy, row) for row in rows.astype(float).tolist()]
        assert np.array_equal(found, np.array(exact, found.dtype))
        by_name = deciding.name_outputs(policy, rows)
        assert list(by_name) == ([f"{policy.agent}.{each.name}" for each in policy.outputs])
        assert all(np.array_equal(column, found[:, place]) for place, column in enumerate(by_name.values()))


@pytest.mark.parametrize("name", PROFILES)
def test_what_is_compared_is_named_and_computed_in_the_same_order(name):
    for policy in PROFILES[name].agents:
        tree, n = policy.tree, len(policy.features)
        row = probes.random(policy.features, 1, np.random.default_rng(2), policy.numbers)[0]
        operands, names = deciding.compute_operands(policy, row), deciding.list_operands(policy)
        assert len(operands) == len(names) == n + len(tree.sums)
        node = ir.ROOT
        while tree.feature[node] != ir.NO_FEATURE:
            left = operands[tree.feature[node]] <= tree.threshold[node]
            node = int(tree.left[node] if left else tree.right[node])
        assert node == ir.apply(tree, row[None])[0]
        for tested in tree.feature[tree.feature != ir.NO_FEATURE].tolist():
            read = deciding.read_by(tree, tested, n)
            assert read and all(0 <= place < n for _, place in read)
            assert all(policy.features[place].name in names[tested] for _, place in read)


def test_words_say_the_action_or_each_number():
    acting, giving = PROFILES["actions, float64"].agents[0], PROFILES["outputs, float64"].agents[0]
    row = [0.5] * len(acting.features)
    assert deciding.describe_decision(acting, row) in deciding.list_decided(acting) == ["left", "stay", "right"]
    (numbers,) = ir.outputs(giving, [row]).tolist()
    said = deciding.describe_decision(giving, row)
    assert said == ", ".join(f"u{place} = {value:.6g} N" for place, value in enumerate(numbers))
    leaf = int(ir.leaves(giving.tree)[0])
    assert deciding.describe_leaf(giving, leaf) == ", ".join(deciding.describe_given(giving, leaf))
    assert not list(deciding.describe_given(acting, int(ir.leaves(acting.tree)[0])))
    assert (deciding.kind_decided(acting), deciding.kind_decided(giving)) == ("actions", "outputs")


def test_whoever_reads_single_tests_only_refuses_both_kinds(profile):
    assert deciding.ensure_plain(profile, "it") is profile and not deciding.sums_in(profile)
    for name, where in (("actions, float64", "tests of sums"), ("outputs, float64", "numbers as outputs")):
        assert deciding.only_acts(PROFILES[name]) is (where == "tests of sums")
        with pytest.raises(InputError, match="it does not take sums yet") as caught:
            deciding.ensure_plain(PROFILES[name], "it")
        assert where in str(caught.value)
