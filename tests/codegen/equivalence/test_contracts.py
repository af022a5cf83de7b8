"""Contracts in ACSL: each table says what the tree does, and everything else in the file is what it should be."""

import re

import numpy as np
import pytest
from hypothesis import given, settings

from codegen import ir
from codegen.equivalence.contracts import OPTIONS, contracts_of, frama_c, table_of
from codegen.errors import InputError
from codegen.lowering.lower import lower
from codegen.numbers import neighbour
from codegen.sums import DOUBLE_SUMS
from tests.support import summed
from tests.support.games import random_profile
from tests.support.observations import blind, doubled
from tests.support.strategies import profiles
from tests.support.teams import tree

TEST = re.compile(r"(!?)\\le_(float|double)\(x\[(\d+)\], \((?:float|double)\)(\S+)\)")
LINE = re.compile(r"      \((?:(.*) ==> )?\\result == (\d+)\)( &&|;) // leaf (\d+)")


def contracts(profile, style="nested"):
    model = lower(profile, style=style)
    return contracts_of(profile, model), model


def near(tree, n_features, rng):
    """Observations at each threshold, beside it, and where nothing is finite."""
    pool = [np.nan, np.inf, -np.inf, 0.0, -0.0]
    for threshold in tree.threshold[tree.feature >= 0]:
        pool += [threshold, *(neighbour(threshold, towards, tree.numbers) for towards in (np.inf, -np.inf))]
    return rng.choice(np.array(pool, dtype=tree.numbers), (200, n_features))


def answers(lines, x):
    """The action of each observation by a table as text; a table that gives none, or two, is wrong."""
    given = np.full(len(x), -1)
    for path, action, _, _ in lines:
        reached = np.ones(len(x), dtype=bool)
        for no, kind, feature, threshold in TEST.findall(path):
            number = {"float": np.float32, "double": np.float64}[kind](float.fromhex(threshold))
            reached &= (x[:, int(feature)] <= number) != bool(no)
        assert (given[reached] == -1).all()
        given[reached] = int(action)
    assert (given >= 0).all()
    return given


@settings(max_examples=10)
@given(profile=profiles())
def test_a_table_decides_as_its_tree(profile):
    made, _ = contracts(profile)
    tables = made.files[made.source].split("ensures table:")[1:]
    assert len(tables) == len(profile.agents)
    rng = np.random.default_rng(0)
    for text, policy in zip(tables, profile.agents, strict=True):
        lines = LINE.findall(text)
        assert [int(line[3]) for line in lines] == ir.leaves(policy.tree).tolist()
        assert [line[2] for line in lines] == [" &&"] * (len(lines) - 1) + [";"]
        x = near(policy.tree, len(policy.features), rng)
        assert (answers(lines, x) == ir.act(policy, x)).all()


def test_a_table_of_doubles_has_doubles():
    rng = np.random.default_rng(4)
    single = tree((0, -0.5, 1, 2), 0, (1, 1.5, 3, 6), (2, 0.25, 4, 5), 1, 2, 0)
    policy = blind({"a": doubled(single, rng)}).agents[0]
    lines = [(" && ".join(leaf.tests), leaf.action, "", leaf.id) for leaf in table_of(policy.tree)]
    assert "double" in lines[0][0]
    x = near(policy.tree, len(policy.features), rng)
    assert (answers(lines, x) == ir.act(policy, x)).all()


def test_a_tree_that_always_does_the_same_has_one_line():
    made, _ = contracts(blind({"a": tree(2)}))
    assert "      (\\result == 2); // leaf 0\n" in made.files[made.source]


@pytest.mark.parametrize("style", ["nested", "ordered"])
def test_every_agent_is_read_within_bounds_and_nothing_is_written(style):
    profile = random_profile("cooperative-navigation")
    made, model = contracts(profile, style)
    text = made.files[made.source]
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        contract = text[: text.index(f"{agent.names.act}(const float *x);")].rsplit("/*@", 1)[1]
        assert f"requires \\valid_read(x + (0 .. {len(policy.features) - 1}));" in contract
        assert "terminates \\true;" in contract and "assigns \\nothing;" in contract
        # NaN is left out by the style that takes none, where it is tested, and by no other
        asked = [
            f"    requires !\\is_NaN(x[{at}]);" for at in sorted({*policy.tree.feature.tolist()} - {ir.NO_FEATURE})
        ]
        found = [line for line in contract.splitlines() if "is_NaN(x[" in line]
        assert found == (asked if style == "ordered" else []) and len(asked) < len(policy.features)
    assert made.functions == tuple(agent.names.act for agent in model.agents)
    assert text.endswith(f'#include "{model.prefix}.h"\n')  # the header itself, not a copy


def test_axioms_are_questions_too():
    """One for each threshold, by its bits; in nested code only where it says `<` for the last number below zero."""
    profile = blind({"a": tree((0, -0.5, 1, 2), 0, (1, 1.5, 3, 4), 1, 2)})
    made, model = contracts(profile, "ordered")
    text, asked = made.files[made.source], made.files[made.questions]
    assert made.axioms == text.count(" axiom ") == asked.count("(check-sat)") == 2
    assert f"(uint32_t){model.names.bits}_of(x) >= 0xbf000000 <==> \\le_float(x, (float)-0x1p-1)" in text
    assert f"{model.names.bits}_of(x) <= 0x3fc00000 <==> \\le_float(x, (float)0x1.8p+0)" in text
    assert "(bvuge b #xbf000000)" in asked and "(bvsle b #x3fc00000)" in asked
    assert contracts(profile)[0].axioms == 0

    strict = contracts(blind({"a": tree((0, -1e-45, 1, 2), 0, 1)}))[0]
    assert strict.axioms == 1 and "(float)-0x1p-149" in strict.files[strict.source]


def test_what_is_asked_of_the_solver_is_true():
    from verify.solver.solve import ask_bits

    profile = blind({"a": tree((0, -0.5, 1, 2), 0, (1, 0.0, 3, 4), 1, (0, 3e38, 5, 6), 2, (1, -1e-45, 7, 8), 0, 1)})
    for style, count in (("ordered", 4), ("nested", 1)):
        made, _ = contracts(profile, style)
        questions = re.findall(r"\(push 1\).*\n((?:.+\n)+?)\(check-sat\)", made.files[made.questions])
        assert [ask_bits(text, ("b",)).holds for text in questions] == [False] * count


def test_the_command_is_in_the_file():
    made, _ = contracts(blind({"a": tree((0, 0.5, 1, 2), 0, 1)}))
    assert made.command == ("frama-c", *OPTIONS, "-wp-fct", "imported_a_act", "imported_contracts.c")
    assert " ".join(frama_c(made.source, made.functions)) in made.files[made.source]


def test_walks_and_sums_have_no_contracts():
    with pytest.raises(InputError, match="nested and ordered") as caught:
        contracts(blind({"a": tree((0, 0.5, 1, 2), 0, 1)}), "walk")
    assert "--style nested" in caught.value.next_step
    with pytest.raises(InputError, match="a contract in ACSL does not take sums"):
        contracts(summed.profile(summed.policy(0, DOUBLE_SUMS)))
