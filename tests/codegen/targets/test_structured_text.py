"""Structured Text by outside means: parsers of other people read it, and it decides alike in their virtual machine."""

import operator
import os
import re
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import entries, selfcheck
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from codegen.memory import initial_memory, step_memory
from codegen.targets import emit
from codegen.targets.st import literal
from maviper import manual
from tests.support import crates, summed
from tests.support.games import NAMES, random_profile
from tests.support.remembering import SOURCES

PARSED = 'iec61131 = "=0.7.0"'
COMPARED = {"<=": operator.le, "<": operator.lt, ">=": operator.ge, "=": operator.eq, "AND": operator.and_}
COMPARED |= {"+": operator.add, "-": operator.sub}
NEXT = re.compile(r"(<= )(-?\d+\.\d+(?:E[-+]?\d+)?)( THEN)")
# PROGRAM ROWS INPUTS OUTPUTS ANSWERS: a scan for each row of numbers, given by their bits
SCANS = """\
use ironplc_codegen::{compile, CodegenOptions, EmptyLookup};
use ironplc_container::VarIndex;
use ironplc_dsl::core::FileId;
use ironplc_parser::{options::CompilerOptions, parse_program};
use ironplc_vm::{Vm, VmBuffers};
use std::{env, fs};

fn main() {
    let given: Vec<String> = env::args().collect();
    let text = fs::read_to_string(&given[1]).expect("the program");
    let rows = fs::read(&given[2]).expect("the rows");
    let counts: Vec<u16> = given[3..5].iter().map(|each| each.parse().expect("a count")).collect();
    let options = CompilerOptions::default();
    let parsed = parse_program(&text, &FileId::default(), &options).expect("Structured Text");
    let (library, context) = ironplc_analyzer::stages::resolve_types(&[&parsed], &options).expect("types");
    let how = CodegenOptions { system_uptime_global: false };
    let made = compile(&library, &context, &how, &EmptyLookup).expect("a program");
    let mut buffers = VmBuffers::from_container(&made);
    let mut machine = Vm::new().load(&made, &mut buffers).start().map_err(|_| "a fault").expect("a start");
    let mut answers = Vec::new();
    for (scan, row) in rows.chunks_exact(4 * usize::from(counts[0])).enumerate() {
        for (at, number) in row.chunks_exact(4).enumerate() {
            let bits = i32::from_le_bytes(number.try_into().expect("four bytes"));
            machine.write_variable(VarIndex::new(at as u16), bits).expect("an input");
        }
        machine.run_round(100_000 * scan as u64).map_err(|_| "a fault").expect("a scan");
        for at in counts[0]..counts[0] + counts[1] {
            answers.extend(machine.read_variable(VarIndex::new(at)).expect("an output").to_le_bytes());
        }
    }
    fs::write(&given[5], answers).expect("a place for the answers");
}
"""


def blocks(profile):
    """Each agent's policy with its text."""
    return list(zip(profile.agents, emit(profile, ["st"], prefix="plc").values(), strict=True))


def one_float_lower(text):
    """The text whose first threshold is one float lower."""

    def lower(found):
        return found[1] + literal(repr(float(np.nextafter(np.float32(found[2]), np.float32(-np.inf))))) + found[3]

    return NEXT.sub(lower, text, count=1)


def observed(policy, random):
    """Observations without what a controller's inputs cannot be."""
    rows = selfcheck.observations(policy, random)
    return rows[np.isfinite(rows).all(axis=1)]


@pytest.mark.parametrize("name", NAMES[::3])
@pytest.mark.usefixtures("few_completions")
def test_blocks_agree_and_a_threshold_one_float_lower_is_noticed(name):
    profile = random_profile(name)
    files = emit(profile, ["st"])
    report = selfcheck.check_files(profile, files, random=1_000).ensure()
    assert [item.target for item in report.agreements] == ["st"] * len(profile.agents)
    for change in (one_float_lower, lambda text: re.sub("act := [12];", "act := 3;", text, count=1)):
        changed = {file: change(text) for file, text in files.items()}
        assert any(each.differences for each in selfcheck.check_files(profile, changed, random=1_000).agreements)


# --- another parser's tree, run statement by statement


@cache
def parsed(text):
    """The block of a text, as blark reads it."""
    return pytest.importorskip("blark.parse").parse_source_code(text).transform().items[0]


def run(text, rows, known=None):
    """All variables of a block by name after a scan of each row; `known`: others, before the scan."""
    transform = pytest.importorskip("blark.transform")
    block = parsed(text)
    inputs = [str(each) for each in re.findall(r"^    (x_\w+) : \w+;", str(block), re.MULTILINE)]
    state = {name: rows[:, at] for at, name in enumerate(inputs)}
    state |= {
        name: np.zeros(len(rows), np.int32)
        for name in re.findall(r"^    (?!x_)(\w+) : (?:INT|BOOL);", str(block), re.MULTILINE)
    }
    begun = re.findall(r"^    (\w+) : DINT := (-?\d+);", str(block), re.MULTILINE)
    state |= {name: np.full(len(rows), int(value)) for name, value in begun} | (known or {})

    def value(item):
        if isinstance(item, transform.ParenthesizedExpression):
            return value(item.expr)
        if isinstance(item, transform.UnaryOperation):
            assert item.op == "-"
            return -value(item.expr)
        if isinstance(item, transform.BinaryOperation):
            return COMPARED[str(item.op)](value(item.left), value(item.right))
        if isinstance(item, transform.Real):
            return np.float32(str(item))
        if isinstance(item, transform.Integer):
            return int(str(item))
        if isinstance(item, transform.Boolean):
            return np.full(len(rows), str(item) == "TRUE")
        return state[str(item)]

    def execute(statements, reached):
        for each in statements:
            if isinstance(each, transform.IfStatement):
                assert not each.else_ifs
                holds = value(each.if_expression)
                execute(each.statements.statements, reached & holds)
                execute(each.else_clause.statements.statements if each.else_clause else (), reached & ~holds)
            else:
                assert isinstance(each, transform.AssignmentStatement)
                name = str(each.variables[0])
                state[name] = np.where(reached, value(each.expression), state[name])

    execute(block.body.statements, np.ones(len(rows), bool))
    return state


def ensure_alike(policy, rows, outputs):
    """All outputs are what they are meant to be."""
    wanted = ir.act(policy, rows)
    assert (outputs["act"] == wanted).all()
    assert (outputs["valid"] == entries.checks(policy, rows) // 2).all()
    flags = np.array([outputs[name] for name in outputs if name.startswith("act_")])
    assert (flags == (wanted == np.arange(len(flags))[:, None])).all()


def test_a_parser_of_other_people_reads_blocks_that_decide_alike(profile):
    for policy, text in blocks(profile):
        rows = observed(policy, 10_000)
        ensure_alike(policy, rows, run(text, rows))
        assert (run(one_float_lower(text), rows)["act"] != ir.act(policy, rows)).any()


@pytest.mark.parametrize("name", SOURCES)
def test_blocks_that_remember_decide_alike_in_100_000_scans_of_another_parsers_tree(name):
    profile = profile_of(from_c(SOURCES[name].encode(), "act.c", Said(run=False)), Names())
    ((policy, text),), rng = blocks(profile), np.random.default_rng(0)
    inputs = np.array([*observed(policy, 0)[:, 0], *rng.uniform(-1, 25, 20)], np.float32)
    names, memory = (
        re.findall(r"^    (m_\w+) : DINT", text, re.MULTILINE),
        initial_memory(policy)[None].repeat(500, axis=0),
    )
    held, known, seen = rng.random(500), None, rng.choice(inputs, (500, 1))
    for _ in range(200):
        seen = np.where(rng.random(500) < held, seen[:, 0], rng.choice(inputs, 500))[:, None]
        reset = rng.random(500) < 0.01
        memory[reset] = initial_memory(policy)
        wanted, memory = step_memory(policy, memory, seen)
        known = run(text, seen, {**({each: known[each] for each in names} if known else {}), "reset": reset})
        assert (known["act"] == wanted).all()
        assert (np.stack([known[each] for each in names], axis=1) == memory).all()


WHOLE = """#include <stdint.h>
int act(LEVEL level, FLOW flow) {
    static int count = 0;
    if (level == LEAST) return 3;
    if (level < -100) { count = 0; return 1; }
    if (level > 120 && flow == 1) { if (count < 5) count++; return 2; }
    return flow >= 7 && count >= 3 ? 2 : flow > MOST ? 1 : 0;
}"""


@pytest.mark.compile
@pytest.mark.parametrize(
    ("level", "flow", "kind", "least", "most"),
    [("int8_t", "int8_t", "SINT", "-128", "126"), ("int16_t", "uint8_t", "INT", "INT16_MIN", "250"),
     ("int32_t", "int32_t", "DINT", "INT32_MIN", "16777217")],
)  # fmt: skip
def test_whole_numbers_are_inputs_of_their_type_and_decide_alike(level, flow, kind, least, most):
    words = {"LEVEL": level, "FLOW": flow, "LEAST": least, "MOST": most}
    source = re.sub(r"\b(?:LEVEL|FLOW|LEAST|MOST)\b", lambda found: words[found[0]], WHOLE)
    profile = profile_of(from_c(source.encode(), "act.c", Said(run=False)), Names())
    ((policy, text),), rng = blocks(profile), np.random.default_rng(0)
    assert re.findall(r" : (\w+);", text)[:2] == [kind, kind] and "." not in text.split("VAR_INPUT")[1]
    assert str(np.iinfo(policy.whole).min) not in text.split("END_VAR")[-1]  # which is no literal of its type
    threshold = np.concatenate([policy.tree.threshold[policy.tree.feature == each] for each in (0, 1)])
    near = np.unique(np.add.outer(threshold, [-1, 0, 1]))
    info = np.iinfo(policy.whole)
    near = near[(near >= info.min) & (near <= info.max)]
    seen = np.stack([rng.choice([*near, info.min, info.max], 100_000) for _ in range(2)], axis=1)
    seen[:, 1] = np.clip(seen[:, 1], policy.features[1].low, policy.features[1].high)
    memory = rng.integers(0, 6, (len(seen), 1))
    wanted, after = step_memory(policy, memory, seen)
    answered = run(text, seen, {"m_count": memory[:, 0], "reset": np.zeros(len(seen), bool)})
    assert (answered["act"] == wanted).all() and (answered["m_count"] == after[:, 0]).all()
    assert answered["valid"].all()
    report = selfcheck.check_files(profile, emit(profile, ["st"]), random=1_000).ensure()
    assert report.agreements


def test_the_program_of_the_manual_is_read_with_its_block(profile):
    (program,) = re.findall(r"```text\n(PROGRAM.*?)```", manual.page("plc"), re.DOTALL)
    text = dict(emit(profile, ["st"]))["physical_deception_agent_0.st"]
    parse = pytest.importorskip("blark.parse").parse_source_code
    block, called = parse(text + program).transform().items
    assert re.findall(r": (physical\w+);", program) == [str(block.name)] and str(called.name) == "main"
    used = re.findall(r"robot\.(\w+)", program) + re.findall(r"(x_\w+) :=", program)
    assert len(used) == 3 and all(f"    {name} : " in text for name in used)


@pytest.mark.nightly
def test_the_crate_iec61131_reads_all_of_a_block(profile, tmp_path):
    source = (
        "fn main() {\n    for path in std::env::args().skip(1) {\n"
        '        let text = std::fs::read_to_string(path).expect("a file");\n'
        '        iec61131::Parser::new(&text).parse().expect("Structured Text");\n    }\n}\n'
    )
    (tmp_path / "parser").mkdir()
    parser = crates.program(tmp_path / "parser", source, PARSED)
    for number, (_, text) in enumerate(blocks(profile)):
        (tmp_path / f"{number}.st").write_text(text)
        subprocess.run([parser, tmp_path / f"{number}.st"], check=True)
        (tmp_path / "broken.st").write_text(text.replace("END_IF;", "END_IF", 1).replace("ELSE", "ELSEIF", 1))
        assert subprocess.run([parser, tmp_path / "broken.st"], capture_output=True, check=False).returncode != 0


# --- a virtual machine


def scanned(machine, folder, policy, text, rows):
    """The outputs of a block in a program of IronPLC, a scan for each row."""
    name = re.search(r"^FUNCTION_BLOCK (\w+)", text, re.MULTILINE)[1]
    inputs = re.findall(r"^    x_(\w+) : REAL;", text, re.MULTILINE)
    outputs = re.findall(r"^    (\w+) : (INT|BOOL);", text, re.MULTILINE)
    declared = [f"in_{each} : REAL;" for each in inputs] + [f"out_{each} : {kind};" for each, kind in outputs]
    given = ", ".join(f"x_{each} := in_{each}" for each in inputs)
    lines = ["PROGRAM main", "VAR", *declared, f"policy : {name};", "END_VAR", f"policy({given});"]
    lines += [f"out_{each} := policy.{each};" for each, _ in outputs]
    lines += ["END_PROGRAM", "CONFIGURATION config", "RESOURCE resource1 ON PLC"]
    lines += ["TASK task1(INTERVAL := T#100ms, PRIORITY := 1);", "PROGRAM main1 WITH task1 : main;"]
    lines += ["END_RESOURCE", "END_CONFIGURATION", ""]
    (folder / "program.st").write_text(text + "\n".join(lines))
    rows.astype("<f4").tofile(folder / "rows")
    command = [machine, "program.st", "rows", str(len(inputs)), str(len(outputs)), "answers"]
    subprocess.run(command, cwd=folder, check=True)
    answers = np.fromfile(folder / "answers", "<i4").reshape(len(rows), len(outputs))
    return {name: answers[:, at] for at, (name, _) in enumerate(outputs)}


@pytest.mark.nightly
def test_ironplc_decides_alike_in_100_000_scans(profile, tmp_path):
    """IronPLC's virtual machine is in no registry: IRONPLC names a clone of its repository."""
    if "IRONPLC" not in os.environ:
        pytest.skip("IRONPLC names no clone of IronPLC's repository")
    folder = Path(os.environ["IRONPLC"]) / "compiler"
    needed = [
        f'ironplc-{each} = {{ path = "{folder / each}" }}'
        for each in ("analyzer", "codegen", "container", "dsl", "parser", "vm")
    ]
    (tmp_path / "machine").mkdir()
    machine = crates.program(tmp_path / "machine", SCANS, *needed)
    for policy, text in blocks(profile):
        rows = observed(policy, 100_000)
        assert len(rows) > 100_000
        ensure_alike(policy, rows, scanned(machine, tmp_path, policy, text, rows))
        near = observed(policy, 0)
        assert (scanned(machine, tmp_path, policy, one_float_lower(text), near)["act"] != ir.act(policy, near)).any()


# --- what is refused, and how numbers and names are written


def test_sums_which_a_controller_may_round_are_refused():
    with pytest.raises(InputError, match="the target st does not take sums yet"):
        emit(summed.profile(summed.policy(0, "double sums")), ["st"])


def test_names_that_a_controller_takes_for_one_are_refused(profile):
    first, second, *others = profile.agents[0].features
    features = (replace(first, name="level_1"), replace(second, name="level__1"), *others)
    with pytest.raises(InputError, match="two names that are x_level_1 in Structured Text"):
        emit(replace(profile, agents=(replace(profile.agents[0], features=features), *profile.agents[1:])), ["st"])


@pytest.mark.parametrize(
    ("decimal", "written"), [("0.1", "0.1"), ("-1e-38", "-1.0E-38"), ("1.5e+30", "1.5E+30"), ("3", "3.0")]
)
def test_literals_have_a_point(decimal, written):
    assert literal(decimal) == written
