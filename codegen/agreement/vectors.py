"""Test vectors: observations with their answers, and a short test of them in a target's language.

Does: picks boundary, special and ordinary observations that any wrong generator would fail; writes them and the tests.
Assumes: files side by side.
Does not: run the tests.
"""

from collections.abc import Iterable

import numpy as np

from codegen import ir
from codegen.agreement import probes
from codegen.agreement.compiled import Build
from codegen.agreement.selfcheck import SEED
from codegen.lowering.model import Model
from codegen.lowering.render import render

SPECIALS, ORDINARY, EACH = 60, 40, 3  # special and ordinary observations per agent; completions per boundary value
TESTS = {"c": "c", "python": "py", "javascript": "mjs", "rust": "rs"}


def vectors(profile: ir.PolicyProfile, model: Model) -> str:
    """A line for each observation: the agent's place, the action's number, and the bits of every number in hex."""
    kind = "float32" if model.single else "number"
    lines = [f"# profile {model.content_hash}: agent's place, action's number, bits of each {kind} in hex"]
    for place, policy in enumerate(profile.agents):
        rows = _choose_rows(policy)
        bits = rows.view(f"u{rows.itemsize}")
        for row, action in zip(bits, ir.act(policy, rows), strict=True):
            lines.append(" ".join([str(place), str(action), *(f"{value:0{2 * rows.itemsize}x}" for value in row)]))
    return "\n".join(lines) + "\n"


def _choose_rows(policy: ir.AgentPolicy) -> ir.Floats:
    """Observations of an agent, [n, n_features]."""
    rng = np.random.default_rng(SEED)
    boundary = probes.boundary(policy.tree, policy.features, rng)
    kept = np.arange(len(boundary)) % probes.FILLINGS < EACH
    special = probes.special(policy.features, rng, policy.numbers)
    chosen = rng.permutation(len(special))[:SPECIALS]
    ordinary = probes.random(policy.features, ORDINARY, rng, policy.numbers)
    return np.ascontiguousarray(probes.in_type(np.concatenate([boundary[kept], special[chosen], ordinary]), policy))


def write_arrays(profile: ir.PolicyProfile, model: Model) -> str:
    """The same as constants of C, for machines without files: whole numbers as they are, of floats the bits; without
    NaN where the style takes none.
    """
    name = f"{model.prefix}_vectors".upper()
    lines = [
        f"/* Test vectors of profile {model.content_hash}: of each agent observations, and the action of each.",
        " * Bits of floats: memcpy a row into an observation. */",
        f"#ifndef {name}_H",
        f"#define {name}_H",
        "#include <stdint.h>",
    ]
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        rows = _choose_rows(policy)
        rows = rows[~np.isnan(rows).any(axis=1)] if model.by_bits else rows
        size = 8 * rows.itemsize
        bits = rows.astype(np.int64).tolist() if policy.whole else rows.view(f"u{rows.itemsize}").tolist()
        written = [", ".join(str(each) if policy.whole else f"0x{each:x}u" for each in row) for row in bits]
        called, kind = f"{model.prefix}_{agent.lower}", agent.kind if policy.whole else f"uint{size}_t"
        lines += [
            f"static const {kind} {called}_vectors[{len(rows)}][{len(policy.features)}] = {{",
            *(f"    {{{each}}}," for each in written),
            "};",
            f"static const uint16_t {called}_answers[{len(rows)}] = {{{', '.join(map(str, ir.act(policy, rows)))}}};",
        ]
    return "\n".join([*lines, "#endif", ""])


def files(build: Build, targets: Iterable[str]) -> dict[str, str]:
    """The vectors, and a test for each of the targets that can run one."""
    model = build.model
    texts = {f"{model.prefix}.vectors.txt": vectors(build.profile, model)}
    for target in targets:
        if target == "c":
            texts[f"{model.prefix}_vectors.h"] = write_arrays(build.profile, model)
        if target in TESTS:
            texts[f"{model.prefix}_test.{TESTS[target]}"] = render(f"tests/test.{TESTS[target]}.j2", model=model)
    return texts
