"""Generated text: legal, exact, identical each time, and checked against planted faults."""

import ctypes
import itertools
import re
import shutil
import subprocess
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings

from codegen import ir
from codegen.agreement import compiled, probes, readback, selfcheck
from codegen.agreement.compiled import Build
from codegen.errors import DisagreementError, InputError, UnknownNameError
from codegen.lowering import lower as lower_module
from codegen.lowering.deploy import deploy_tree
from codegen.lowering.lower import AUTO, lower
from codegen.lowering.render import comment
from codegen.numbers import neighbour
from codegen.profiles import check, ensure
from codegen.targets import TARGETS, USUAL, emit, emit_model
from tests.support.chains import chain
from tests.support.games import NAMES, random_profile, random_tree
from tests.support.strategies import profiles
from tests.support.tiers import first_of

TEXTS = [target for target in TARGETS if not target.startswith("onnx")]
FEW = 1_000  # random observations; the boundary ones are what counts


def test_no_machine_facts_in_text(profile):
    for text in emit(profile).values():
        assert not re.search(r"/tmp|/home|/root|20\d\d-\d\d-\d\d", text)


@pytest.mark.compile
def test_a_shared_library_exports_the_decisions(profile, tmp_path):
    for name, text in emit(profile, ["shared"], "mine").items():
        (tmp_path / name).write_text(text)
    command = [*compiled.find_compiler(), "-std=c99", "-shared", "-fPIC", "mine_shared.c", "-o", "mine.so"]
    subprocess.run(command, check=True, cwd=tmp_path)
    code = ctypes.CDLL(str(tmp_path / "mine.so"))
    for policy in profile.agents:
        rows = selfcheck.observations(policy, FEW).astype(policy.numbers)
        given = np.empty((2, len(rows)), np.int32)
        places = [ctypes.c_void_p(each.ctypes.data) for each in (rows, *given)]
        code[f"mine_{policy.agent}_decide"](places[0], ctypes.c_long(len(rows)), *places[1:])
        assert given[0].tolist() == ir.act(policy, rows).tolist()
        assert (given[1] % 2 == np.isfinite(rows).all(axis=1)).all()


def agreement_of(profile, targets=USUAL, style=AUTO):
    """The report on a random profile; each second one of a style is compiled without an optimiser, in a third of the
    time.
    """
    optimised = next(EXAMPLES.setdefault((tuple(targets), style), itertools.cycle((True, False))))
    model = lower(profile, style=style)
    with Build(profile, model, emit_model(model, profile, targets), optimised) as made:
        return selfcheck.check(made, FEW).ensure()


EXAMPLES: dict[tuple, itertools.cycle] = {}


@pytest.mark.compile
@settings(max_examples=4)
@given(profiles())
def test_random_profiles_agree_everywhere(profile):
    report = agreement_of(profile)
    assert {item.target for item in report.agreements} >= {"c", "c input check", "python", "python batch", "json"}


@pytest.mark.compile
@pytest.mark.parametrize("style", ["nested", "ordered", "walk"])
@settings(max_examples=4)
@given(profile=profiles())
def test_every_style_agrees(style, profile):
    report = agreement_of(profile, ["c"], style)
    assert {item.target for item in report.agreements} >= {"c", "c rows", "c columns", "c input check"}


@pytest.mark.compile
@pytest.mark.parametrize("style", ["nested", "ordered"])
@pytest.mark.usefixtures("few_completions")
def test_vast_trees_are_short_text_that_agrees(style, monkeypatch):
    """Nobody reads a hundred thousand lines: they stand without names, comments, indentation and tables."""
    profile = random_profile(NAMES[0])
    read = len(emit(profile, ["c"], style=style)[f"{lower(profile).prefix}.h"])
    monkeypatch.setattr(lower_module, "NESTED_SPLITS", 3)
    monkeypatch.setattr(lower_module, "SELECTS", 3)
    report = agreement_of(profile, ["c"], style)
    assert {item.target for item in report.agreements} >= {"c", "c rows", "c columns", "c input check"}
    header = emit(profile, ["c"], style=style)[f"{lower(profile, style=style).prefix}.h"]
    assert "leaf 2" not in header and len(header) < 0.9 * read


@pytest.mark.compile
@pytest.mark.parametrize(  # nested: every game agrees everywhere
    ("name", "style"), first_of(2, itertools.product(NAMES[::2], ("ordered", "walk")))
)
@pytest.mark.usefixtures("unoptimised", "few_completions")
def test_every_game_decides_from_world_states(name, style):
    profile = random_profile(name)
    report = selfcheck.check_files(profile, emit(profile, ["c"], style=style), random=FEW, style=style).ensure()
    ensure_team(profile, report)


def ensure_team(profile, report):
    """Every agent was asked in world states."""
    teams = [item for item in report.agreements if item.target == selfcheck.TEAM]
    assert {item.agent for item in teams} == {policy.agent for policy in profile.agents}
    assert all(item.observations > 100 for item in teams)


def test_without_meanings_there_is_no_world_to_decide_from(profile):
    policy = profile.agents[0]
    features = (replace(policy.features[0], meaning=None), *policy.features[1:])
    header = emit(replace(profile, agents=(replace(policy, features=features), *profile.agents[1:])), ["c"])
    assert "act_world" not in next(iter(header.values()))


def test_the_automatic_style_is_nested_until_compilers_give_up(profile):
    assert lower(profile).style == "nested"
    for deep in (chain(lower_module.NESTED_LEVELS + 1), chain(lower_module.NESTED_LEVELS)):
        policies = tuple(replace(policy, tree=deep, grown=None) for policy in profile.agents)
        found = lower(replace(profile, agents=policies))
        assert found.style == ("walk" if ir.depth(deep).max() > lower_module.NESTED_LEVELS else "nested")
        assert not found.agents[0].tables.complete
    with pytest.raises(UnknownNameError, match="did you mean 'ordered'"):
        emit(profile, ["c"], style="orderd")


@pytest.mark.compile
@pytest.mark.usefixtures("few_completions")
def test_a_chain_of_three_hundred_splits_walks(profile):
    """Deeper than a profile may be, so lowered without the checker: tables without end to nest."""
    first, *others = profile.agents
    deep = replace(profile, agents=(replace(first, tree=chain(300), grown=None), *others))
    selfcheck.check_files(deep, emit(deep, ["c"]), random=FEW).ensure()


@pytest.mark.compile
@pytest.mark.parametrize("name", first_of(2, [*NAMES[::6], *NAMES[1:6]]))
def test_every_game_agrees_everywhere(name, request):
    """Signs, 0 or 1, and features that are always 0 are numbers like any other; their meanings stand in the text."""
    if name != NAMES[0]:  # one game is enough for an optimiser, and for all completions
        request.getfixturevalue("unoptimised")
        request.getfixturevalue("few_completions")
    profile = random_profile(name)
    files = emit(profile)
    report = selfcheck.check_files(profile, files, random=FEW).ensure()
    assert {item.agent for item in report.agreements} == {"all", *(policy.agent for policy in profile.agents)}
    assert lower(profile).style == "nested"
    ensure_team(profile, report)
    header = next(text for file, text in files.items() if file.endswith(".h"))
    for policy in profile.agents:
        tested = policy.tree.feature[policy.tree.feature != ir.NO_FEATURE]
        assert all(str(policy.features[feature].meaning) in header for feature in tested)


@pytest.mark.compile
def test_a_profile_of_single_leaves_compiles(profile):
    leaf = ir.Tree([-1], [0], [-1], [-1], [3])
    alone = replace(profile, agents=tuple(replace(policy, tree=leaf, grown=None) for policy in profile.agents))
    selfcheck.check_files(alone, emit(alone), random=FEW).ensure()


@pytest.mark.slow
@pytest.mark.compile
def test_the_deepest_trees_compile(profile):
    tree = chain(ir.MAX_DEPTH)
    deep = replace(profile, agents=tuple(replace(policy, tree=tree, grown=None) for policy in profile.agents))
    assert check(deep) == ()
    selfcheck.check_files(deep, emit(deep), random=FEW).ensure()


@pytest.mark.slow
@pytest.mark.compile
def test_a_tree_of_more_than_a_hundred_thousand_nodes_compiles(profile):
    tree = deploy_tree(random_tree(profile.agents[1].features, 5, np.random.default_rng(0), 16))
    large = replace(profile, agents=(replace(profile.agents[1], tree=tree, grown=None),))
    assert len(ensure(large).agents[0].tree.feature) == 131_071
    report = selfcheck.check_files(large, emit(large, ["c"]), random=FEW).ensure()
    assert report.observations > 1_000_000
    assert report.skipped == ("the structural proof of the C: more than 20000 nodes",)


@pytest.mark.compile
@pytest.mark.parametrize("compiler", ["gcc -std=c99", "g++ -x c++ -std=c++17", "clang -std=c99"])
def test_the_header_is_read_twice_and_refuses_fast_math(profile, compiler, tmp_path):
    command = compiler.split()
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed")
    (tmp_path / "use.h").write_text(emit(profile, ["c"])["physical_deception.h"])
    (tmp_path / "use.c").write_text('#include "use.h"\n#include "use.h"\nint main(void)\n{\n    return 0;\n}\n')
    subprocess.run([*command, *compiled.STRICT[1:], "-c", "use.c"], cwd=tmp_path, check=True)
    # clang names no macro for the last one; what it links is found by the function that tries a tiny number
    unsafe = [] if command[0] == "clang" else ["-funsafe-math-optimizations"]
    for flag in ("-ffast-math", "-ffinite-math-only", *unsafe):
        refused = subprocess.run([*command, flag, "-c", "use.c"], cwd=tmp_path, capture_output=True, check=False)
        assert refused.returncode != 0 and b"fast-math" in refused.stderr


@pytest.mark.compile
@pytest.mark.parametrize(("standard", "says"), [("c++11", True), ("c++14", True), ("gnu++11", False), ("c++17", False)])
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_cpp_that_knows_no_hexadecimal_floats_is_told_what_to_do(profile, compiler, standard, says, tmp_path):
    """clang++ knows them in every standard."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    (tmp_path / "use.cpp").write_text(emit(profile)["physical_deception.h"])
    command = [compiler, f"-std={standard}", "-fsyntax-only", "use.cpp"]
    read = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    refused = says and compiler == "g++"
    assert (read.returncode != 0) == refused and ("compile with -std=c++17" in read.stderr) == refused, read.stderr


def test_an_unknown_target_gets_its_closest_match(profile):
    with pytest.raises(UnknownNameError, match="did you mean 'python'"):
        emit(profile, ["pyton"])


@pytest.mark.parametrize("prefix", ["2fast", "rotorCtl", "Rotor", "_rotor", "rotor-1", "rotör", "r" * 42, ""])
def test_a_prefix_that_is_refused_is_answered_with_what_one_may_be(profile, prefix):
    """Not every identifier of C is one: `rotorCtl` has a letter that is not lower-case."""
    with pytest.raises(InputError, match="not a usable prefix") as refused:
        emit(profile, ["c"], prefix=prefix)
    assert refused.value.next_step == "a lower-case letter, then up to 40 lower-case letters, digits or _"


@pytest.mark.compile
@pytest.mark.parametrize("style", ["nested", "ordered", "walk"])
@pytest.mark.usefixtures("unoptimised", "few_completions")
def test_every_public_name_of_a_header_begins_with_the_prefix(profile, style):
    files = emit(profile, ["c"], "rotor", style)
    assert list(files) == ["rotor.h"]
    functions = re.findall(r"^static inline .*?(\w+)\(", files["rotor.h"], re.MULTILINE)
    constants = re.findall(r"^(?:#define |    )([A-Z]\w*)(?: =.*| \S+)$", files["rotor.h"], re.MULTILINE)
    assert len(functions) > 20 and all(re.fullmatch(r"rotor_[a-z0-9_]+", name) for name in functions)
    assert len(constants) > 50 and all(re.fullmatch(r"ROTOR_[A-Z0-9_]+", name) for name in constants)
    report = selfcheck.check_files(profile, files, "rotor", FEW, style).ensure()
    assert {item.target for item in report.agreements} >= {"c", "c structure"}


@pytest.mark.parametrize("name", ["x_goal_dx", "N_ACTIONS"])
def test_names_that_collide_in_code_are_refused(profile, name):
    first, *others = profile.agents[1].actions
    actions = (replace(first, name=name), *others)
    agents = (profile.agents[0], replace(profile.agents[1], actions=actions), profile.agents[2])
    with pytest.raises(InputError, match="same name"):
        lower(replace(profile, agents=agents))


def test_hostile_texts_stay_inside_the_comments_of_every_target(profile):
    hostile = ('x */ int main; /* """ \\ ??/\n#error', '"""+evil+"""\\', "-->\r</svg>\u2028; |x|")
    texts = dict(zip(("tool", "algorithm", "preset"), hostile, strict=True))
    features = tuple(replace(each, unit="".join(hostile)) for each in profile.agents[0].features)
    agents = (replace(profile.agents[0], features=features), *profile.agents[1:])
    plain = emit(profile, TEXTS)
    files = emit(replace(profile, agents=agents, provenance=replace(profile.provenance, **texts)), TEXTS)
    assert set(files) == set(plain)
    for name, text in files.items():
        if name.endswith((".json", "_reader.py")):
            continue
        assert len(text.splitlines()) == len(plain[name].splitlines()), name
        assert "*/ int" not in text and '"""+evil' not in text
        assert not re.search(r"[^\n -~]", text.replace("\N{NO-BREAK SPACE}", "")), name
        if name.endswith(".svg"):
            ElementTree.fromstring(text)
    readback.load_python(files["physical_deception.py"])


def test_the_comment_filter_by_example():
    assert comment('a*/ b\n"c"\\ /* ??/') == "a_/ b__c__ _* _?/"


def test_c_that_does_not_compile_is_reported(profile):
    if compiled.find_compiler() is None:
        pytest.skip("no C compiler")
    with pytest.raises(DisagreementError, match="does not compile"):
        selfcheck.check_files(profile, {"physical_deception.h": "int x = ;"}, random=FEW)


def test_without_a_compiler_c_is_skipped_and_said(profile, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    report = selfcheck.check_files(profile, emit(profile), random=FEW)
    assert report.skipped == ("C: no compiler found (cc, gcc, clang or $CC)",)
    assert {item.target for item in report.agreements if item.target.startswith("c")} == {selfcheck.STRUCTURE}


# --- the probes themselves


@given(profiles())
def test_boundary_probes_reach_their_split(profile):
    policy = profile.agents[1]
    tree = policy.tree
    for node, low, high in probes.paths(tree, len(policy.features)):
        x = np.minimum(neighbour(low, np.inf), high)
        assert ((low < x) & (x <= high)).all()
        here = 0
        while here != node:
            assert tree.feature[here] != ir.NO_FEATURE
            here = int(tree.left[here] if x[tree.feature[here]] <= tree.threshold[here] else tree.right[here])


def test_boundary_probes_hold_every_threshold_and_both_neighbours(profile):
    policy = profile.agents[1]
    rows = probes.boundary(policy.tree, policy.features, np.random.default_rng(0))
    for node, _, _ in probes.paths(policy.tree, len(policy.features)):
        column = rows[:, policy.tree.feature[node]]
        threshold = policy.tree.threshold[node]
        for value in (threshold, np.nextafter(threshold, np.float32(9)), np.nextafter(threshold, np.float32(-9))):
            assert value in column


ROWS = """#include "team.h"
#include <stdio.h>
void second(const float *x, int *actions);
void third(const float *x, unsigned char *actions);
static const float rows[] = {{{rows}}};
int main(void)
{{
    long row;
    for (row = 0; row < {n}; row++) {{
        const float *const x = &rows[row * TEAM_AGENT_0_N_FEATURES];
        const float *const each[3] = {{x, x, x}};
        int actions[3];
        unsigned char one = 0;
        team_act_all(each, actions);
        second(x, &actions[0]);
        third(x, &one);
        if (actions[0] != actions[1] || actions[0] != one || actions[0] != team_agent_0_act(x)) {{
            return 1;
        }}
        printf("%d", actions[1]);
    }}
    return 0;
}}
"""
UNITS = {
    "second": "void second(const float *x, int *actions) { *actions = team_agent_0_act(x); }",
    "third": "void third(const float *x, unsigned char *actions) { team_agent_0_act_rows(x, 1, actions); }",
}


@pytest.mark.compile
@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("compiler", ["gcc -std=c99", "clang -std=c99", "g++ -x c++"])
def test_tables_are_in_a_unit_once_and_where_asked_for_in_a_program_once(compiler, shared, profile, tmp_path):
    if shutil.which(compiler.split()[0]) is None:
        pytest.skip(f"{compiler.split()[0]} is not installed")
    (header,) = emit(profile, ["c"], prefix="team", style="walk").values()
    policy = profile.policy("agent_0")
    x = np.random.default_rng(0).choice(policy.tree.threshold, (200, len(policy.features))).astype(np.float32)
    numbers = ", ".join(f"{value!r}F" for value in x.ravel().tolist())
    (tmp_path / "team.h").write_text(header)
    (tmp_path / "main.c").write_text("#define TEAM_OWN_TABLES\n" * shared + ROWS.format(rows=numbers, n=len(x)))
    for name, text in UNITS.items():
        (tmp_path / f"{name}.c").write_text(f'#include "team.h"\n{text.split(" {")[0]};\n{text}\n')
    options = ["-O1", "-Wall", "-Wextra", "-Werror", "-I.", *(["-DTEAM_SHARED_TABLES"] * shared)]
    for unit in ("main", *UNITS):
        built = [*compiler.split(), *options, "-c", f"{unit}.c", "-o", f"{unit}.o"]
        subprocess.run(built, cwd=tmp_path, check=True)
    linked = [compiler.split()[0], "main.o", "second.o", "third.o", "-o", "program"]
    subprocess.run(linked, cwd=tmp_path, check=True)
    told = subprocess.run(["./program"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert [*map(int, told)] == ir.act(policy, x).tolist()

    def count(file):
        names = subprocess.run(["nm", file], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
        return len(re.findall(r"(?i) r \w*team_agent_0_threshold", names))

    assert [count(f"{unit}.o") for unit in ("main", *UNITS)] == [1, not shared, not shared]
    assert count("program") == (1 if shared else 3)
