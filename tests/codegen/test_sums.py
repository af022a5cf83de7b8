"""Trees with sums: the reference against exact fractions, the JSON form, and every rule that they must keep."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes
from codegen.errors import InputError, ProfileError
from codegen.policy_json import content_hash, dumps
from codegen.profiles import check, loads
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS, Sum
from codegen.wording import describe_sum
from tests.support import summed

KINDS = {**summed.every(1), **{f"{kind}, divided": it for kind, it in summed.every(7, inner=0.3, over=0.4).items()}}
DIFFERENCE = Sum(((1.0, 0), (-1.0, 1)))


@pytest.mark.parametrize("kind", KINDS)
def test_the_reference_is_the_exact_arithmetic(kind):
    for policy in KINDS[kind].agents:
        rows = np.concatenate(list(probes.telling(policy, np.random.default_rng(0))))[::17]
        wanted = [summed.exact_decision(policy, row) for row in rows.tolist()]
        if policy.outputs:
            given = ir.outputs(policy, rows)
            assert given.dtype == policy.tree.gives
            assert [summed.bits(row) for row in given.tolist()] == [summed.bits(row) for row in wanted]
            assert len({*map(tuple, given.tolist())}) > 20
        else:
            assert ir.act(policy, rows).tolist() == wanted and len({*wanted}) == 3


def one(tree, **given):
    """A profile of one agent with this tree over two features."""
    features = tuple(ir.FeatureSpec(name, "m", -1.0, 1.0, None) for name in ("a", "b"))
    actions = () if given.get("outputs") else tuple(ir.ActionSpec(name, None) for name in ("no", "yes"))
    return summed.profile(ir.AgentPolicy("agent_0", "team", features, actions, tree, **given))


def stump(each=DIFFERENCE, threshold=0.0, arithmetic=DOUBLE_SUMS, **given):
    numbers = summed.OBSERVED.get(arithmetic, "float32")
    arrays = ([2, -1, -1], [threshold, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])
    return ir.Tree(*arrays, **{"numbers": numbers, "arithmetic": arithmetic, "sums": (each,), **given})


def leaf(*vector, low=-1.0, high=1.0, **given):
    """A profile of one leaf that gives numbers."""
    given = {"arithmetic": DOUBLE_SUMS, **given}
    tree = ir.Tree([-1], [0], [-1], [-1], [0], vectors=(vector,), numbers=summed.OBSERVED[given["arithmetic"]], **given)
    return one(tree, outputs=tuple(ir.OutputSpec(f"u{place}", "N", low, high) for place in range(len(vector))))


def test_the_three_arithmetics_differ():
    """Weights and numbers that are exact in none of the steps."""
    each, x = Sum(((0.6369616985321045, 0), (0.2697867155075073, 1))), [[0.04097352549433708, 0.016527635976672173]]
    found = {name: float(each.value(np.array(x, summed.OBSERVED[name]), name)[0]) for name in summed.ARITHMETICS}
    exact = sum(Fraction(weight) * Fraction(x[0][place]) for weight, place in each.terms)
    assert found[DOUBLE_SUMS] == summed.rounded(exact, "float64"), "products are exact"
    assert found[FLOAT32_STEPS] != summed.rounded(exact, "float32"), "each product is rounded"
    each, x = Sum(((0.1, 0), (0.2, 1))), [[0.3, 0.7]]
    assert float(each.value(np.array(x), FLOAT64_SUMS)[0]) == 0.1 * 0.3 + 0.2 * 0.7


def test_nan_goes_right_and_zeros_keep_their_signs():
    policy = one(stump()).agents[0]
    assert ir.act(policy, [[np.nan, 0], [np.inf, np.inf], [-np.inf, np.inf], [0, 0]]).tolist() == [1, 1, 0, 0]
    gives = leaf(Sum(((1.0, 0), (1.0, 1))), low=0.0).agents[0]
    given = ir.outputs(gives, [[-0.0, -0.0], [0.0, -0.0], [-1, 0], [np.nan, 1], [5, 5]])[:, 0]
    assert np.signbit(given).tolist()[:3] == [True, False, False]
    assert given[2] == 0 and np.isnan(given[3]) and given[4] == 1


def test_who_gives_numbers_takes_no_action():
    with pytest.raises(InputError, match="gives numbers"):
        ir.act(leaf(Sum(((1.0, 0),))).agents[0], [[0, 0]])


def test_words():
    names = ["a", "b"]
    assert describe_sum(((1.0, 0), (-0.5, 1), (2.0, ir.CONSTANT)), names) == "a - 0.5 b + 2"
    assert describe_sum(((-1.0, 0),), names) == "-a" and describe_sum(((-0.0, ir.CONSTANT),), names) == "-0"
    assert describe_sum(((2.5, Sum(((1.0, ir.CONSTANT), (-1.0, 0)))), (-0.5, 1)), names) == "2.5 (1 - a) - 0.5 b"


# --- the JSON form


@pytest.mark.parametrize("kind", KINDS)
def test_profiles_come_back_from_their_json(kind):
    profile = KINDS[kind]
    text = dumps(profile)
    again = loads(text)
    divides = any(each.divides for policy in profile.agents for each in policy.tree.all_sums)
    version = 6 if divides else 5 if any(each.depth > 1 for each in profile.agents[0].tree.all_sums) else 2
    assert dumps(again) == text and json.loads(text)["schema_version"] == version
    assert check(profile) == () and content_hash(again) == content_hash(profile)
    for one_, other in zip(profile.agents, again.agents, strict=True):
        assert repr(one_.tree.sums) == repr(other.tree.sums) and repr(one_.tree.vectors) == repr(other.tree.vectors)


def document(profile):
    found = json.loads(dumps(profile))
    del found["content_hash"]
    return found


def changed(path, value):
    found = document(one(stump()))
    place = found
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return found


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (["schema_version"], 1, "schema_version"),
        (["agents", 0, "arithmetic"], "float16", "arithmetic"),
        (["agents", 0, "tree", 0, "sum"], [[1.0, "c"]], "unknown feature 'c'"),
        (["agents", 0, "tree", 0, "sum"], [[1.0]], "not a valid policy profile"),
        (["agents", 0, "tree", 0, "sum"], [], "1 to 1000 terms"),
        (["agents", 0, "tree", 0, "sum"], [["/3", "a"]], "another schema version"),
        (["agents", 0, "tree", 0, "feature"], "a", "a node has"),
        (["agents", 0, "tree", 1, "outputs"], [], "a node has"),
        (["semantics"], "something else", "other semantics"),
    ],
)
def test_damaged_profiles_are_refused_with_the_place(path, value, says):
    with pytest.raises(ProfileError, match=says):
        loads(json.dumps(changed(path, value)))


def test_a_threshold_between_two_float32_is_refused():
    found = document(one(stump(arithmetic=FLOAT32_STEPS)))
    found["agents"][0]["tree"][0]["threshold"] = 0.1
    with pytest.raises(ProfileError, match=r"tree\[0\].threshold: 0.1 is no float32"):
        loads(json.dumps(found))


# --- the rules


SMALL, TENTH = 1e-310, 0.1
BESIDE = ([2, 0, -1, -1, -1], [0, TENTH, 0, 0, 0], [1, 2, -1, -1, -1], [4, 3, -1, -1, -1], [-1, -1, 0, 1, 0])
SINGLE_BESIDE = ir.Tree(*BESIDE, arithmetic=DOUBLE_SUMS, sums=(DIFFERENCE,))  # a test of one feature beside a sum


@pytest.mark.parametrize(
    ("profile", "path", "says"),
    [
        (one(stump(Sum(((0.0, 0), (1.0, 1))))), "tree[0].sum", "a weight is 0"),
        (one(stump(Sum(((np.nan, 0), (1.0, 1))))), "tree[0].sum", "a weight must be finite"),
        (one(stump(Sum(((1e-40, 0), (1.0, 1))))), "tree[0].sum", "no float32"),
        (one(stump(Sum(((2.0**-140, 0), (1.0, 1))))), "tree[0].sum", "a weight is subnormal"),
        (one(stump(Sum(((TENTH, 0), (1.0, 1))))), "tree[0].sum", "a weight is no float32"),
        (one(stump(Sum(((SMALL, ir.CONSTANT), (1.0, 1))))), "tree[0].sum", "a constant is subnormal"),
        (one(stump(Sum(((1.0, 0), (1.0, 0))))), "tree[0].sum", "stands twice"),
        (one(stump(Sum(((1.0, 0), (1.0, 2))))), "tree[0].sum", "features are 0 to 1"),
        (one(stump(Sum(((1.0, 0),)))), "tree[0].sum", "more than one feature alone"),
        (one(stump(Sum(((1.0, ir.CONSTANT),)))), "tree[0].sum", "has a feature"),
        (one(stump(threshold=np.inf)), "tree[0].threshold", "finite"),
        (one(SINGLE_BESIDE), "tree[1].threshold", "is no float32, which the feature is"),
        (one(stump(sums=(DIFFERENCE, DIFFERENCE))), "tree", "each sum stands once"),
        (one(stump(arithmetic="double sums", numbers="float64")), "numbers", "must be float32"),
        (one(stump(arithmetic="float16")), "arithmetic", "must be double sums"),
        (one(stump(gives="float64")), "gives", "must be float32"),
        (one(stump(), grown=ir.GrownTree([-1], [0], [-1], [-1], [0])), "grown", "null"),
        (leaf(Sum(((1.0, 0),)), low=2.0), "outputs[0]", "low <= high"),
        (leaf(Sum(((1.0, 0),)), low=None), "outputs[0]", "needs both bounds"),
        (leaf(Sum(((1.0, 0),)), low=-1e-40), "outputs[0]", "a bound is no float32"),
        (leaf(Sum(((1.0, 0),)), low=-(2.0**-140)), "outputs[0]", "subnormal"),
        (leaf(Sum(((1.0, 0),)), arithmetic=FLOAT64_SUMS, gives="float32"), "gives", "must be float64"),
        (one(replace(leaf(DIFFERENCE).agents[0].tree)), "tree", "leaves give numbers where"),
        (one(ir.Tree([-1], [0], [-1], [-1], [0], arithmetic=DOUBLE_SUMS)), "arithmetic", "there are none"),
    ],
)
def test_broken_rules_are_found_with_their_place(profile, path, says):
    found = [str(each.path).removeprefix("$.agents[0].") + ": " + each.message for each in check(profile)]
    assert any(line.startswith(path) and says in line for line in found), found


def test_all_broken_rules_are_found_at_once():
    each = Sum(((0.0, 0), (np.nan, 1), (1e-40, ir.CONSTANT)))
    assert len(check(one(stump(each, arithmetic=FLOAT32_STEPS)))) == 3


def test_a_vector_has_a_sum_for_each_output():
    profile = leaf(DIFFERENCE, DIFFERENCE)
    policy = replace(profile.agents[0], outputs=profile.agents[0].outputs[:1])
    assert any("has 2 sums for 1 outputs" in each.message for each in check(summed.profile(policy)))


def test_plain_trees_cost_nothing():
    """A profile without sums says nothing of them, so that its bytes and its hash stay."""
    tree = ir.Tree([0, -1, -1], [0.5, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])
    text = dumps(one(tree))
    assert '"schema_version": 1' in text and not any(
        word in text for word in ("arithmetic", '"gives"', "outputs", '"sum"')
    )
