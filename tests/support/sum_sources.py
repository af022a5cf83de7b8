"""Random programs in Python and C that test sums of features and return numbers, as people write them."""

import numpy as np

from codegen import ir
from codegen.agreement import probes
from codegen.sums import among

N = 5  # features


class Writer:
    """A random program. `kind`: "labels" or "numbers"; its forms are those that Python and C share."""

    def __init__(self, seed, kind="numbers", outputs=2, levels=3, c=False, short=False):
        self.rng, self.kind, self.outputs, self.levels, self.c = np.random.default_rng(seed), kind, outputs, levels, c
        self.short = short  # whether returned constants are float32

    def number(self):
        return self.suffix(
            repr(float(self.rng.choice([0.1, 0.25, -0.5, 1.5, 2.0, 0.3, 7.0, 1e-3, float(self.rng.normal())])))
        )

    def suffix(self, text):
        """A number as the language writes one of its type."""
        return f"{text}f" if self.c and self.short else text

    def term(self, place):
        read = f"x[{place}]"
        form = int(self.rng.integers(5))
        if form == 0:
            return f"{self.number()} * {read}"
        if form == 1:
            return f"{read} * {self.number()}"
        return f"{read} / {self.divisor()}" if form == 2 else read

    def divisor(self):
        return self.suffix(str(self.rng.choice(["2.0", "3.0", "0.3", "10.0", "7.5"])))

    def total(self, least=1, inner=0.3):
        """A sum of terms, some with parentheses: `inner` of them, and fewer within."""
        text = self.plain(least)
        if self.rng.random() >= inner:
            return text
        other = f"({self.total(1, inner / 2)})"
        return [
            f"{self.number()} * ({text})",
            f"-({text})",
            f"({text}) / {self.divisor()}",
            f"{text} {self.rng.choice(['+', '-'])} {other}",
            f"{other} - {text.lstrip('-')}",
            f"{text} {self.rng.choice(['+', '-'])} {self.positive()} * {other}",
        ][int(self.rng.integers(6))]

    def plain(self, least):
        count = int(self.rng.integers(least, 4))
        places = self.rng.permutation(N)[:count].tolist()
        text = self.term(places[0])
        if self.rng.random() < 0.2:
            text = f"-{text}" if text.startswith("x") else text
        for place in places[1:]:
            text += f" {self.rng.choice(['+', '-'])} {self.term(place)}"
        constant = self.rng.random()
        if constant < 0.3:
            text += f" {self.rng.choice(['+', '-'])} {self.positive()}"
        elif constant < 0.4:
            text = f"{self.number()} + {text}" if not text.startswith("-") else text
        return text

    def test(self):
        sign = self.rng.choice(["<", "<=", ">", ">="])
        form = self.rng.random()
        if form < 0.15:
            return f"x[{int(self.rng.integers(N))}] {sign} {self.number()}"
        if form < 0.3:
            a, b = self.rng.permutation(N)[:2].tolist()
            return f"x[{a}] {sign} x[{b}]"
        if form < 0.4:
            return (
                f"{('fabsf' if self.short else 'fabs') if self.c else 'abs'}({self.total(2)}) {sign} {self.positive()}"
            )
        if form < 0.5:
            return f"{self.number()} {sign} {self.total(2)}"
        return f"{self.total(2)} {sign} {self.number()}"

    def values(self):
        return [self.constant() if self.rng.random() < 0.3 else self.total() for _ in range(self.outputs)]

    def constant(self):
        return self.suffix(repr(float(self.rng.integers(-8, 9)) / 4)) if self.short else self.number()

    def positive(self):
        return self.number().lstrip("-")

    def python(self, level=1):
        pad = "    " * level
        if level > self.levels or (level > 1 and self.rng.random() < 0.15):
            if self.kind == "labels":
                return [f"{pad}return {int(self.rng.integers(3))}"]
            said = ", ".join(self.values())
            shape = self.rng.choice(["[{}]", "({})", "np.array([{}])"]) if self.outputs > 1 else "{}"
            return [f"{pad}return {shape.format(said)}"]
        lines = [f"{pad}if {self.test()}:", *self.python(level + 1)]
        return [*lines, f"{pad}else:", *self.python(level + 1)]

    def python_file(self):
        return "\n".join(["import numpy as np", "", "", "def act(x):", *self.python()]) + "\n"

    def c_function(self, name):
        """A function of C that writes its numbers, or returns its label."""
        kind = "float" if self.short else "double"
        head = f"int {name}(const {kind} *x)" if self.kind == "labels" else f"void {name}(const {kind} *x, {kind} *y)"
        return "\n".join([head, "{", *self._c_lines(), "}", ""])

    def _c_lines(self, level=1):
        pad = "    " * level
        if level > self.levels or (level > 1 and self.rng.random() < 0.15):
            if self.kind == "labels":
                return [f"{pad}return {int(self.rng.integers(3))};"]
            return [f"{pad}y[{place}] = {said};" for place, said in enumerate(self.values())]
        lines = [f"{pad}if ({self.test()}) {{", *self._c_lines(level + 1)]
        return [*lines, f"{pad}}} else {{", *self._c_lines(level + 1), f"{pad}}}"]


def c_file(seeds, kind, *, short):
    """A file of C with a function for each seed. Products and sums are not joined, which it says."""
    writers = {seed: Writer(seed, kind, 1 + seed % 3, c=True, short=short) for seed in seeds}
    lines = [writer.c_function(f"act_{seed}") for seed, writer in writers.items()]
    return "\n".join(["#include <math.h>", "#pragma STDC FP_CONTRACT OFF", "", *lines])


def rows_of(policy):
    """Observations for which the policy is to give the bits of its source: no sum in a test is NaN, which goes right
    here, whatever the source does.
    """
    spans = tuple(ir.FeatureSpec(each.name, "none", -3.0, 3.0, None) for each in policy.features)
    about = ir.AgentPolicy(policy.agent, policy.team, spans, policy.actions, policy.tree, outputs=policy.outputs)
    rng = np.random.default_rng(0)
    rows = np.concatenate(list(probes.telling(about, rng)))
    rows = rows[np.isfinite(rows).all(axis=1)]
    rows = rows[~np.isnan(among(rows, policy.tree.sums, policy.tree.arithmetic)).any(axis=1)]
    return rows[rng.permutation(len(rows))[:600]]
