"""The style `freestanding` by outside means: it has no floats, and decides alike in the kernel's virtual machine."""

import re
import shutil
import subprocess
from dataclasses import replace
from graphlib import TopologicalSorter
from itertools import pairwise

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes, selfcheck
from codegen.errors import InputError
from codegen.targets import emit
from maviper.compilation.compile import compile_and_prove
from tests.support import crates, summed
from tests.support.games import NAMES, doubled, random_profile

STYLE = "freestanding"
BPF = "clang -target bpf -ffreestanding -nostdlib -O2 -Wall -Wextra -Werror -c policy.c -o policy.o"
X86 = "gcc -mgeneral-regs-only -std=c99 -O2 -Wall -Wextra -Werror -ffreestanding -c policy.c -o policy.o"
ARM = "arm-none-eabi-gcc -mcpu=cortex-m0 -mthumb -mfloat-abi=soft -std=c99 -Os -ffreestanding -c policy.c -o policy.o"
MAX_INSTRUCTIONS, MAX_JUMP = 1_000_000, 2**15  # that the kernel's verifier follows; that an instruction holds
LEAVES = {4: 16, 10: 1_024}


def build(command, folder, profile, style=STYLE):
    """Compiles a function for each agent that calls its header; skips where the compiler is missing."""
    if shutil.which(command.split()[0]) is None:
        pytest.skip(f"{command.split()[0]} is not installed")
    (folder / "policy.h").write_text(emit(profile, ["c"], prefix="policy", style=style)["policy.h"])
    heads = [f"int {each.agent}(const {'int' if style == STYLE else 'float'} *x)" for each in profile.agents]
    names = [each.agent for each in profile.agents]
    lines = [f"{head};\n{head} {{ return policy_{name}_act(x); }}" for head, name in zip(heads, names, strict=True)]
    (folder / "policy.c").write_text('#include "policy.h"\n' + "\n".join(lines) + "\n")
    return subprocess.run(command.split(), cwd=folder, capture_output=True, text=True, check=False)


def tool(command, folder):
    if shutil.which(command.split()[0]) is None:
        pytest.skip(f"{command.split()[0]} is not installed")
    return subprocess.run(command.split(), cwd=folder, capture_output=True, text=True, check=True).stdout


def instructions(folder):
    """The instructions of each function by place, in the words of the disassembler."""
    shown = tool("llvm-objdump -d --no-show-raw-insn policy.o", folder)
    parts = re.split(r"^[0-9a-f]+ <(?!LBB)(\w+)>:\n", shown, flags=re.MULTILINE)[1:]
    return {
        name: {int(at): said for at, said in re.findall(r"^ *(\d+):\s+(.*)$", text, re.MULTILINE)}
        for name, text in zip(parts[::2], parts[1::2], strict=True)
    }


@pytest.mark.compile
@pytest.mark.parametrize("name", NAMES[::3])
@pytest.mark.usefixtures("unoptimised", "few_completions")
def test_the_code_agrees_and_has_the_structure_of_the_trees(name):
    profile = random_profile(name)
    files = emit(profile, ["c"], style=STYLE)
    (header,) = files.values()
    assert not re.search(r"float|double|#include", re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL))
    report = selfcheck.check_files(profile, files, random=1_000, style=STYLE).ensure()
    asked = {item.target for item in report.agreements}
    assert asked == {"c structure", "c", "c input check", "c all agents", "c range input check"}


@pytest.mark.compile
@pytest.mark.parametrize("depth", LEAVES)
def test_the_kernels_machine_takes_it_without_calls_loops_and_floats(depth, tmp_path):
    """Its instructions know no floats, so that each would be a call; its limits hold for 1,024 leaves."""
    profile = random_profile(NAMES[0], depth=depth)
    assert all(len(ir.leaves(each.tree)) == LEAVES[depth] for each in profile.agents)
    built = build(BPF, tmp_path, profile)
    assert built.returncode == 0, built.stderr
    by_function = instructions(tmp_path)
    assert set(by_function) == {each.agent for each in profile.agents}
    for name, listed in by_function.items():
        jumps = {at: int(found[1]) for at, said in listed.items() if (found := re.search(r"goto ([+-]\d+)", said))}
        print(f"{name}: {LEAVES[depth]} leaves, {len(listed)} instructions, jumps of at most {max(jumps.values())}")
        assert not any("call" in said or "r10" in said for said in listed.values()), "a call, or the stack"
        assert max(map(abs, jumps.values())) < MAX_JUMP and max(listed) - min(listed) < MAX_INSTRUCTIONS
        after = {at: [at + 1 + jump] for at, jump in jumps.items()}
        for at, following in pairwise(listed):
            if not listed[at].startswith(("goto", "exit")):
                after.setdefault(at, []).append(following)
        assert len(list(TopologicalSorter(after).static_order())) == len(listed), "a loop would be a CycleError"
    assert "R_BPF" not in tool("llvm-objdump -r policy.o", tmp_path)


@pytest.mark.compile
@pytest.mark.parametrize("style", ["nested", "walk"])
def test_the_kernels_machine_calls_what_it_lacks_in_styles_with_floats(style, profile, tmp_path):
    built = build(BPF, tmp_path, profile, style)
    assert built.returncode != 0 or "call" in str(instructions(tmp_path))


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    """The virtual machine of the crate rbpf."""
    return crates.program(tmp_path_factory.mktemp("machine"), crates.VIRTUAL_MACHINE, 'rbpf = "=0.4.1"')


@pytest.mark.compile
@pytest.mark.parametrize(
    "random", [pytest.param(10_000, marks=pytest.mark.slow), pytest.param(1_000_000, marks=pytest.mark.nightly)]
)
def test_a_virtual_machine_decides_as_the_trees(random, machine, profile, tmp_path):
    assert build(BPF, tmp_path, profile).returncode == 0
    for policy in profile.agents:
        drawn = probes.random(policy.features, random, np.random.default_rng(0))
        rows = np.concatenate([selfcheck.observations(policy, random=0), drawn])
        rows = rows[~np.isnan(rows).any(axis=1)]
        assert len(rows) >= random
        assert not np.count_nonzero(decided(machine, tmp_path, policy, rows) != ir.act(policy, rows))
    header = tmp_path / "policy.h"
    header.write_text(re.sub(r"<= (0x\w+)\)", lambda found: f"<= {int(found[1], 16) + 1:#x})", header.read_text()))
    subprocess.run(BPF.split(), cwd=tmp_path, check=True)
    noticed = []
    for policy in profile.agents:
        rows = np.nan_to_num(selfcheck.observations(policy, random=0))
        noticed.append((decided(machine, tmp_path, policy, rows) != ir.act(policy, rows)).any())
    assert any(noticed), "the next integer as a threshold"


def decided(machine, folder, policy, rows):
    """The actions of a program's function in the virtual machine."""
    tool("llvm-objcopy -O binary --only-section=.text policy.o all.bin", folder)
    table = tool("llvm-objdump -t policy.o", folder)
    (found,) = re.findall(rf"^(\w+) g +F \.text\s+(\w+) {policy.agent}$", table, re.MULTILINE)
    at, size = (int(each, 16) for each in found)
    (folder / "code").write_bytes((folder / "all.bin").read_bytes()[at : at + size])
    rows.astype("<f4").tofile(folder / "rows")
    subprocess.run([machine, "code", "rows", str(rows.shape[1]), "actions"], cwd=folder, check=True)
    return np.fromfile(folder / "actions", "<i4")


@pytest.mark.compile
@pytest.mark.parametrize("command", [X86, ARM], ids=["x86", "arm"])
def test_compilers_that_may_not_use_floats_build_it_and_call_nothing(command, profile, tmp_path):
    built = build(command, tmp_path, profile)
    assert built.returncode == 0, built.stderr
    symbols = tool("nm -u policy.o", tmp_path)
    assert symbols == "", symbols
    (tmp_path / "policy.o").unlink()
    refused = build(command, tmp_path, profile, "nested")
    assert refused.returncode != 0 or tool("nm -u policy.o", tmp_path), "what compares floats calls the library"


def remembering(profile):
    """The profile, whose first agent remembers its last feature."""
    first, *others = profile.agents
    features = (*first.features[:-1], replace(first.features[-1], initial=0))
    return replace(profile, agents=(replace(first, features=features), *others))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (lambda profile: doubled(profile), "compares the bits of float32, and adversary_0 compares float64"),
        (
            lambda profile: summed.profile(summed.policy(0, "double sums")),
            "has neither floats nor state, and agent_0 adds floats",
        ),
        (lambda profile: remembering(profile), "has neither floats nor state, and adversary_0 remembers"),
    ],
    ids=["float64", "sums", "memory"],
)
def test_what_needs_floats_is_refused(changed, said, profile):
    with pytest.raises(InputError, match=said):
        emit(changed(profile), ["c"], style=STYLE)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"region": "start", "passes": ["drop"]}, "the check of the profile's region adds them"),
        ({"contracts": True}, "contracts are for the styles nested and ordered, not for freestanding"),
    ],
)
def test_options_that_need_floats_are_refused(options, said, profile):
    with pytest.raises(InputError, match=said):
        compile_and_prove(profile, ["c"], style=STYLE, **options)
