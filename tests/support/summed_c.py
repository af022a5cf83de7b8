"""Programs in C that compare what a header gives with bits that stand in them, for compilers and machines."""

import numpy as np

from codegen.deciding import decide
from codegen.lowering.lower import lower

COUNT = """
static int same(const void *a, const void *b, unsigned long n)
{{
    return memcmp(a, b, n) == 0;
}}

int main(void)
{{
    long wrong = 0;
    long i;
{checks}
    printf("%ld wrong\\n", wrong);
    return wrong == 0 ? 0 : 1;
}}
"""


def _bits(values):
    """Rows as a list of unsigned numbers in C."""
    held = np.ascontiguousarray(values)
    return ", ".join(f"0x{value:x}u" + "ll" * (held.itemsize == 8) for value in held.view(f"u{held.itemsize}").ravel())


def program(profile, rows):
    """The text of a program that asks for these rows, by agent, and counts answers whose bits are others. A NaN that is
    given may be any NaN: rows that give one are left out.
    """
    model = lower(profile)
    parts = [f'#include "{model.prefix}.h"', "#include <stdio.h>", "#include <stdint.h>", "#include <string.h>"]
    checks = []
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        wanted = decide(policy, rows[policy.agent])
        if policy.outputs:
            kept = ~np.isnan(wanted).any(axis=1)
            given, wanted = rows[policy.agent][kept], wanted[kept]
        else:
            given, wanted = rows[policy.agent], wanted.astype(np.int32)
        uint = f"uint{8 * given.itemsize}_t"
        answer = agent.summed.kind if policy.outputs else "int"
        width = len(policy.outputs) or 1
        parts.append(f"static const {uint} rows_{agent.lower}[] = {{{_bits(given)}}};")
        parts.append(f"static const uint{8 * wanted.itemsize}_t wanted_{agent.lower}[] = {{{_bits(wanted)}}};")
        call = f"{agent.names.act}(x, y);" if policy.outputs else f"y[0] = {agent.names.act}(x);"
        n = len(policy.features)
        checks.append(f"""
    for (i = 0; i < {len(given)}; i++) {{
        {agent.kind} x[{n}];
        {answer} y[{width}];
        memcpy(x, rows_{agent.lower} + i * {n}, sizeof x);
        {call}
        wrong += same(y, wanted_{agent.lower} + i * {width}, sizeof y) ? 0 : 1;
    }}""")
    return "\n".join(parts) + COUNT.format(checks="".join(checks))
