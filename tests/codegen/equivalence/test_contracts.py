"""Contracts in ACSL: each table says what the tree does, and everything else in the file is what it should be."""

import re

import numpy as np
import pytest
from hypothesis import given, settings

import maviper
from codegen import ir
from codegen.equivalence.contracts import OPTIONS, contracts_of, frama_c, table_of
from codegen.errors import InputError
from codegen.lowering.lower import lower
from codegen.memory import step_memory
from codegen.numbers import neighbour
from codegen.sums import DOUBLE_SUMS
from tests.support import summed
from tests.support.games import random_profile
from tests.support.observations import blind, doubled
from tests.support.remembering import GIVING, PUMP, SOURCES, SUMMING, WHOLE, adding
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


def passing(path, x):
    """Marks the observations that pass the tests of features on a path."""
    reached = np.ones(len(x), dtype=bool)
    for no, kind, feature, threshold in TEST.findall(path):
        number = {"float": np.float32, "double": np.float64}[kind](float.fromhex(threshold))
        reached &= (x[:, int(feature)] <= number) != bool(no)
    return reached


def answers(lines, x):
    """The action of each observation by a table as text; a table that gives none, or two, is wrong."""
    given = np.full(len(x), -1)
    for path, action, _, _ in lines:
        reached = passing(path, x)
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
    lines = [(" && ".join(leaf.tests), leaf.action, "", leaf.id) for leaf in table_of(policy)]
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


def test_what_is_asked_of_the_solver_is_true(tmp_path):
    from verify.solver.solve import ask_bits

    profile = blind({"a": tree((0, -0.5, 1, 2), 0, (1, 0.0, 3, 4), 1, (0, 3e38, 5, 6), 2, (1, -1e-45, 7, 8), 0, 1)})
    heater = remembering("debounce", tmp_path)
    for about, style, count in (
        (profile, "ordered", 4),
        (profile, "nested", 1),
        (heater, "nested", 2),
        (heater, "ordered", 6),
    ):
        made, _ = contracts(about, style)
        questions = re.findall(r"\(push 1\).*\n((?:.+\n)+?)\(check-sat\)", made.files[made.questions])
        assert [ask_bits(text, ("b",)).holds for text in questions] == [False] * count


def test_the_command_is_in_the_file():
    made, _ = contracts(blind({"a": tree((0, 0.5, 1, 2), 0, 1)}))
    assert made.command == ("frama-c", *OPTIONS, "-wp-fct", "imported_a_act", "imported_contracts.c")
    assert " ".join(frama_c(made.source, made.functions)) in made.files[made.source]


def remembering(name, folder):
    """A controller in C that remembers, as it comes in."""
    (folder / f"{name}.c").write_text(SOURCES[name])
    return maviper.from_file(folder / f"{name}.c")


BEHAVIOR = re.compile(r"behavior leaf_\d+:\n +assumes (.*);\n +ensures \\result == (\d+) && (.*);\n +ensures (.*);\n")
MEMORY_TEST = re.compile(r"state->(\w+) (<=|>) (-?\d+)")
AFTER = re.compile(r"state->(\w+) == (?:(-?\d+)|\\old\(state->\w+\)(?: \+ (-?\d+))?)(?: &&|$)")


@pytest.mark.parametrize("style", ["nested", "ordered"])
@pytest.mark.parametrize("name", ["heater", "debounce", "light"])
def test_what_is_remembered_becomes_what_the_policy_says(name, style, tmp_path):
    """Each observation and memory passes one behavior's tests, which says what `step_memory` gives."""
    profile = remembering(name, tmp_path)
    made, model = contracts(profile, style)
    (policy,), (agent,), rng = profile.agents, model.agents, np.random.default_rng(5)
    machine = agent.machine
    names = [each.name for each in machine.memory]
    behaviors = BEHAVIOR.findall(made.files[made.source])
    assert len(behaviors) == made.leaves == len(ir.leaves(policy.tree))
    bounds = " && ".join(f"{each.low} <= state->{each.name} <= {each.high}" for each in machine.memory)
    assert {each[3] for each in behaviors} == {bounds}
    x = near(policy.tree, len(policy.features), rng)[:, : machine.observed]
    memory = np.stack([rng.integers(each.low, each.high + 1, len(x)) for each in machine.memory], axis=1)
    actions, after = step_memory(policy, memory, x)
    reached = np.zeros(len(x), int)
    for path, action, becomes, _ in behaviors:
        of = passing(path, x)
        for memory_name, sign, number in MEMORY_TEST.findall(path):
            of &= (memory[:, names.index(memory_name)] <= int(number)) == (sign == "<=")
        said = AFTER.findall(becomes)
        assert [each for each, *_ in said] == names
        for place, (_, fixed, added) in enumerate(said):
            now = int(fixed) if fixed else memory[of, place] + int(added or 0)
            assert (after[of, place] == now).all()
        assert (actions[of] == int(action)).all()
        reached += of
    assert (reached == 1).all()
    assert made.functions == (agent.names.act, agent.names.init, agent.names.step)
    initial = " && ".join(f"state->{each.name} == {each.initial}" for each in machine.memory)
    assert f"ensures initial: {initial};" in made.files[made.source]
    assert made.command[made.command.index("-ulevel") + 1] == str(machine.observed + 1)


def test_whole_numbers_are_compared_as_they_are(tmp_path):
    (tmp_path / "whole.c").write_text(WHOLE)
    made, _ = contracts(maviper.from_file(tmp_path / "whole.c"))
    text = made.files[made.source]
    assert "(x[0] <= -21 ==> \\result == 1)" in text and "(const int16_t *x);" in text
    assert "float" not in text.replace("Typed+Float", "").replace("-warn-special-float", "") and made.axioms == 0


def test_memory_is_no_nan_in_order_of_bits(tmp_path):
    """What is observed is asked not to be NaN; of what is remembered a float says so that it is at most its end."""
    profile = remembering("debounce", tmp_path)
    made, _ = contracts(profile, "ordered")
    step = made.files[made.source].split("#include")[-1]
    assert re.findall(r"requires !\\is_NaN\(x\[(\d+)\]\)", step) == ["0"]
    for name, high in (("count", "0x1.88p+5"), ("stable", "0x1p+0")):
        end = int(float.fromhex(high))
        assert f"state->{name} <= {end} <==> \\le_float((float)state->{name}, (float){high});" in step
        assert end == next(each.high for each in profile.agents[0].memory if each.name == name)


def test_of_sums_it_is_said_which_actions_there_are_and_which_bounds(tmp_path):
    profile = summed.profile(summed.policy(0, DOUBLE_SUMS))
    made, model = contracts(profile)
    text, tree = made.files[made.source], profile.agents[0].tree
    said = re.findall(r"\\result == (\d+)", text[text.index("ensures actions:") :].split(";")[0])
    assert [*map(int, said)] == sorted({*tree.action[ir.leaves(tree)].tolist()}) and "table" not in text
    (tmp_path / "act.c").write_text(GIVING)
    giving, model = contracts(maviper.from_file(tmp_path / "act.c"))
    text = giving.files[giving.source]
    assert "assigns y[0 .. 0];" in text and "requires \\valid(y + (0 .. 0));" in text
    bounds = r"\is_NaN(y[0]) || (\le_double((double)-0x1p+1, y[0]) && \le_double(y[0], (double)0x1.8p+1))"
    assert f"ensures bounds: {bounds};" in text
    assert giving.functions == (model.agents[0].names.act, model.names.at_least, model.names.at_most)


TAKEN = re.compile(r"ensures taken_(\d+): \\result == \d+ ==>\n((?: +\(.*\)(?: \|\||;)\n)+)")
WAY = re.compile(r"^ +\((?:\\old\((.*?)\) && )?(state->\w+ == .*)\)(?: \|\||;)$", re.MULTILINE)
ONLY = re.compile(r"ensures only_(\d+): \\result == \d+ ==> (.*);")


def within(path, memory, names):
    """Marks the memories that pass the tests of memory on a path."""
    reached = np.ones(len(memory), dtype=bool)
    for name, sign, number in MEMORY_TEST.findall(path):
        reached &= (memory[:, names.index(name)] <= int(number)) == (sign == "<=")
    return reached


def told_after(becomes, memory):
    """What memory is after a step, from what is said of it."""
    columns = zip(memory.T, AFTER.findall(becomes), strict=True)
    return np.column_stack(
        [0 * now + int(fixed) if fixed else now + int(added or 0) for now, (_, fixed, added) in columns]
    )


@pytest.mark.parametrize("name", ["heater", "debounce", *SUMMING])
def test_beside_sums_it_is_said_what_is_remembered_with_each_action(name, tmp_path):
    """What `step_memory` gives is one of the ways that are said of the action, whose tests hold, and no way is idle; an
    action comes about only where the tests of features on a path to it hold.
    """
    (tmp_path / "act.c").write_text((SOURCES | SUMMING)[name])
    profile = maviper.from_file(tmp_path / "act.c")
    profile = profile if name in SUMMING else adding(profile)
    made, _ = contracts(profile)
    (policy,), text, rng = profile.agents, made.files[made.source], np.random.default_rng(5)
    names, width = [each.name for each in policy.memory], len(policy.features) - len(policy.memory)
    memory = np.stack([rng.integers(each.low, each.high + 1, 40_000) for each in policy.memory], axis=1)
    x = rng.choice([-4.0, -0.5, 0.25, 1.5, 3.0, 10.0, 18.0, 20.0, 22.0], (len(memory), width))
    actions, after = step_memory(policy, memory, x)
    said = {int(action): WAY.findall(ways) for action, ways in TAKEN.findall(text)}
    assert sorted(said) == sorted({*actions.tolist()}) and "ensures table" not in text and "behavior" not in text
    for action, ways in said.items():
        keeps = np.zeros(len(x), dtype=bool)
        for path, becomes in ways:
            fits = passing(path, x) & within(path, memory, names) & (after == told_after(becomes, memory)).all(axis=1)
            assert (fits & (actions == action)).any()
            keeps |= fits
        assert keeps[actions == action].all()
    seen = np.column_stack([x, memory]).astype(policy.numbers)
    chosen, only = ir.act(policy, seen), dict(ONLY.findall(text))
    assert only
    for action, paths in only.items():
        held = np.any([passing(path, seen) for path in paths[1:-1].split(") || (")], axis=0)
        assert held[chosen == int(action)].all() and not held.all()


def test_what_is_observed_and_remembered_may_be_read_one_by_one(tmp_path):
    """Among facts of floats no solver finds it for two numbers and more."""
    (tmp_path / "act.c").write_text(PUMP)
    made, _ = contracts(maviper.from_file(tmp_path / "act.c"))
    asked = r"requires \valid(&state->held) && \valid(&state->on) && \valid_read(x + 0) && \valid_read(x + 1);"
    assert asked in made.files[made.source]


def test_sums_stand_in_order_of_bits_beside_plain_trees():
    """Of sums it is said what every style says, as none changes them; of plain trees what their bits are."""
    plain = blind({"plain": tree((0, -0.5, 1, 2), 0, (1, 1.5, 3, 4), 1, 2)}).agents
    made, model = contracts(summed.profile(summed.policy(0, DOUBLE_SUMS), *plain), "ordered")
    text = made.files[made.source]
    of_sums, of_bits = text.split(f"{model.agents[0].names.act}(const float *x);")
    assert made.axioms == 2 and "ensures actions:" in of_sums and "!\\is_NaN(x[" not in of_sums
    assert of_bits.count("!\\is_NaN(x[") == 2 and "ensures table:" in of_bits


def test_walks_have_no_contracts():
    with pytest.raises(InputError, match="nested and ordered") as caught:
        contracts(blind({"a": tree((0, 0.5, 1, 2), 0, 1)}), "walk")
    assert "--style nested" in caught.value.next_step
