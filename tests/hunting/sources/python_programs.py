"""Random Python programs of the subset that importing.md states, as people write controllers.

Does: draws functions, classes and data classes that decide by one to five features, with helpers, constants, tables,
  loops, matches; some give numbers or scores.
Assumes: what importing.md says is refused is avoided: a feature twice in a sum, products of features, remainders.
Does not: run them, or know how they are read.
"""

import re
from collections.abc import Sequence

from tests.hunting.sources.drafts import AGENTS, DECIMAL, INDENT, NAMES, TEXTS, WHOLE, Draft, Feature, Program, Step

PLACE = "pass  # a place for a step"
FORMS = ("row", "row", "row", "unpacked", "unpacked", "columns", "columns", "names", "attributes")
LABELS = ("whole", "whole", "texts", "texts", "members", "members", "constants", "list", "bools", "table", "odd")
ROWS = ("x", "obs", "state", "observation", "s")
ORDERS = ("<", "<=", ">", ">=")


class PythonDraft(Draft):
    """The Python program of a seed."""

    joint, leaving, idle = "_", "return {}", PLACE
    statements = ("branches", "guard", "loop", "match", "ternary", "variable", "counted", "assigned", "steps")
    shares = (26, 24, 9, 7, 8, 12, 5, 6, 3)

    def __init__(self, seed: int, step: Step | None = None, place: int = -1) -> None:
        super().__init__(seed, "python", step, place)
        rng = self.rng
        self.kind = rng.choice(("function", "function", "function", "class", "dataclass"))
        self.form = rng.choice(FORMS)
        self.gives = rng.choices(("label", "numbers", "scores"), (88, 8, 4))[0]
        self.cut = self.bounds() if rng.random() < 0.3 else None  # bounds of a number that is given
        self.agent = rng.choice(AGENTS)
        self.given = rng.choice(ROWS)
        names = rng.sample(NAMES, rng.randint(1, 5))
        self.features = tuple(Feature(name, "float", self._text(place, name)) for place, name in enumerate(names))
        self.imports: set[str] = set()
        self.top: list[str] = []
        self.numbers: list[str] = []  # constants by name
        self.helpers: list[tuple[str, str]] = []  # name and "number" or "test"
        self.helping: dict[str, list[str]] = {}  # their text: what nothing calls would be an agent
        self._constants()
        self._actions()
        self._helpers()

    def _text(self, place: int, name: str) -> str:
        return {
            "row": f"{self.given}[{place}]",
            "unpacked": name,
            "columns": name,
            "names": f'{self.given}["{name}"]',
            "attributes": f"{self.given}.{name}",
        }[self.form]

    # --- numbers

    def literal(self) -> str:
        """A number as people write it."""
        rng = self.rng
        kind = rng.choices(("whole", "decimal", "power", "odd", "near"), (30, 50, 6, 10, 4))[0]
        if kind == "power":
            return rng.choice(("2**20", "2 ** 10", "1e3", "1_000", "0x1F", "2**24 + 1", "1e-9", "1e10"))
        if kind == "odd":
            return rng.choice(
                ("1 / 3", "0.1 + 0.2", "0.2 * 3", "-0.0", "7 // 2", "-7 // 2", ".5", "5.", "3 * 0.7", "7 % 4")
            )
        if kind == "near":
            return repr(rng.choice((0.30000000000000004, 0.1 + 2**-54, 16777217, 33554433.0, 0.49999999999999994)))
        value = rng.choice(WHOLE) if kind == "whole" else rng.choice(DECIMAL)
        return f"-{value}" if rng.random() < 0.3 else str(value)

    def constant(self) -> str:
        """A literal, a named one, or arithmetic on them."""
        rng = self.rng
        text = self.literal()
        if self.numbers and self.chance(0.35):
            text = rng.choice(self.numbers)
        if self.chance(0.12):
            text = rng.choice(
                (f"{text} * 2", f"({text}) / 2", f"-({text})", f"({text}) + 0.5", f"abs({text})", f"max({text}, 0.1)")
            )
        return self.spot("constant", f"({text})" if " " in text else text)

    def bounds(self) -> tuple[str, str]:
        """Two literals in order."""
        low, high = sorted(self.rng.sample((*DECIMAL, *WHOLE), 2))
        return (f"-{high}", f"-{low}") if self.chance(0.2) else (str(low), str(high))

    # --- what a feature becomes

    def feature(self) -> str:
        """A feature, or what is computed of one."""
        rng = self.rng
        base = rng.choice(self.scaled) if self.scaled and self.chance(0.2) else rng.choice(self.features).text
        for _ in range(rng.choices((0, 1, 2), (60, 32, 8))[0]):
            base = self._computed(base)
        return base

    def _computed(self, base: str) -> str:
        rng = self.rng
        number = str(rng.choice(DECIMAL))
        low, high = self.bounds()
        helpers = [name for name, kind in self.helpers if kind == "number"]
        texts = [
            f"({base} + {number})",
            f"({base} - {number})",
            f"({number} - {base})",
            f"{base} * {number}",
            f"{base} / {number}",
            f"-{base}",
            f"abs({base})",
            f"abs({base} - {number})",
            f"min({base}, {high})",
            f"max({base}, {low})",
            f"min(max({base}, {low}), {high})",
            f"float({base})",
            f"({base} if {base} > {low} else {low})",
            f"({base}) * ({base})" if "[" not in base and " " not in base else f"({base} * 3)",
            f"-({base}) * 2.0",
        ]
        if self.chance(0.15):
            self.imports.add("import numpy as np")
            texts = [f"np.clip({base}, {low}, {high})", f"np.abs({base})", f"np.minimum({base}, {high})"]
        elif helpers and self.chance(0.3):
            texts = [f"{rng.choice(helpers)}({base})"]
        elif self.chance(0.06):
            texts = [f"int({base})", f"round({base})"]
        return rng.choice(texts)

    # --- conditions

    def compare(self) -> str:
        """A comparison."""
        rng = self.rng
        kind = rng.choices(
            ("order", "flipped", "chain", "equal", "in", "pair", "apart", "helper"), (50, 8, 12, 5, 4, 8, 5, 8)
        )[0]
        left, order = self.feature(), rng.choice(ORDERS)
        if kind == "flipped":
            return f"{self.constant()} {order} {left}"
        if kind == "chain":
            low, high = self.bounds()
            return f"{low} {rng.choice(ORDERS[:2])} {left} {rng.choice(ORDERS[:2])} {high}"
        if kind == "equal":
            return f"{left} {rng.choice(('==', '!='))} {self.constant()}"
        if kind == "in":
            places = ", ".join(str(each) for each in rng.sample(WHOLE, rng.randint(2, 4)))
            return f"{rng.choice(self.features).text} {rng.choice(('in', 'in', 'not in'))} ({places})"
        if kind in ("pair", "apart") and len(self.features) > 1:
            one, other = (each.text for each in rng.sample(self.features, 2))
            if kind == "pair":
                return f"{one} {order} {other}"
            return f"{one} - {other} {order} {self.constant()}"
        helpers = [name for name, of in self.helpers if of == "test"]
        if kind == "helper" and helpers:
            return f"{rng.choice(helpers)}({left})"
        return f"{left} {order} {self.constant()}"

    def condition(self, levels: int = 2) -> str:
        """A comparison, or several joined."""
        rng = self.rng
        kind = rng.choices(("one", "and", "or", "not", "variable"), (58, 14, 14, 6, 8))[0] if levels else "one"
        if kind == "variable" and self.conditions:
            return self.spot("condition", rng.choice(self.conditions))
        if kind in ("and", "or"):
            parts = [self.condition(levels - 1) for _ in range(rng.choice((2, 2, 3)))]
            return self.spot("condition", f" {kind} ".join(f"({part})" if " or " in part else part for part in parts))
        if kind == "not":
            return self.spot("condition", f"not ({self.condition(levels - 1)})")
        return self.spot("condition", self.compare())

    # --- the file's own names

    def _constants(self) -> None:
        rng = self.rng
        for stem in rng.sample(("LIMIT", "NEAR", "FAR", "MARGIN", "K"), rng.randint(0, 3)):
            self.top.append(f"{stem} = {self._plain()}")
            self.numbers.append(stem)
        if self.chance(0.3):
            values = sorted(rng.sample(DECIMAL, 3))
            opening, closing = rng.choice(("()", "[]"))
            self.top.append(f"BANDS = {opening}{', '.join(map(str, values))}{closing}")
            self.numbers += [f"BANDS[{place}]" for place in (0, 1, -1)]
        if self.chance(0.2):
            self.top.append(f'GAINS = {{"low": {rng.choice(DECIMAL)}, "high": {rng.choice(WHOLE)}}}')
            self.numbers += ['GAINS["low"]', 'GAINS["high"]']
        self.own: list[tuple[str, str]] = []
        if self.kind != "function":
            self.own = [(name, self._plain()) for name in rng.sample(("margin", "limit", "gain"), rng.randint(1, 3))]
            self.named = list(self.numbers)  # what stands outside the class
            self.numbers += [f"self.{name}" for name, _ in self.own]

    def _plain(self) -> str:
        before = [each for each in self.numbers if not each.startswith("self.")]
        if before and self.chance(0.3):
            return f"{self.rng.choice(before)} * {self.rng.choice(DECIMAL)}"
        return self.literal()

    def _actions(self) -> None:
        rng = self.rng
        kind, count = rng.choice(LABELS), rng.randint(2, 5)
        texts = rng.sample(TEXTS, count)
        if kind == "whole":
            self.actions = [str(each) for each in range(count)]
        elif kind == "texts":
            self.actions = [repr(each) if self.chance(0.5) else f'"{each}"' for each in texts]
        elif kind == "bools":
            self.actions = ["True", "False"]
        elif kind == "odd":
            self.actions = rng.choice(
                (["-1", "0", "1"], ["0.5", "-0.5", "2"], ["-2", "4", "7"], ['"go left"', '"go-right"'])
            )
        elif kind == "members":
            base = rng.choice(("Enum", "IntEnum"))
            self.imports.add(f"from enum import {base}" + (", auto" if self.chance(0.2) else ""))
            auto = any("auto" in each for each in self.imports)
            values = ["auto()"] * count if auto else [str(each) for each in rng.sample(range(8), count)]
            lines = [f"{INDENT}{text.upper()} = {value}" for text, value in zip(texts, values, strict=True)]
            self.top += ["", "", f"class Action({base}):", *lines, "", ""]
            self.actions = [f"Action.{text.upper()}" for text in texts]
        elif kind == "constants":
            values = rng.choice((range(count), [f'"{text}"' for text in texts]))
            self.top += [f"{text.upper()} = {value}" for text, value in zip(texts, values, strict=True)]
            self.actions = [text.upper() for text in texts]
        elif kind == "list":
            self.top.append(f"ACTIONS = {texts!r}")
            self.actions = [f'ACTIONS.index("{text}")' if self.chance(0.5) else str(n) for n, text in enumerate(texts)]
            if self.chance(0.5):
                self.actions = [f"ACTIONS[{place}]" for place in range(count)]
        else:
            self.top.append("CODES = {" + ", ".join(f'"{text}": {n}' for n, text in enumerate(texts)) + "}")
            self.actions = [f'CODES["{text}"]' for text in texts]

    def action(self) -> str:
        """What a path returns."""
        rng = self.rng
        if self.gives == "label":
            return self.another(self.actions)
        low, high = map(float, self.cut or (-1e9, 1e9))
        numbers = [str(min(max(rng.choice((0.0, 1.0, -1.0, *DECIMAL)), low), high)) for _ in range(2)]
        if self.gives == "numbers" and self.chance(0.6):
            feature = rng.choice(self.features).text
            numbers[0] = rng.choice(
                (
                    feature,
                    f"{feature} * {rng.choice(DECIMAL)}",
                    f"-{rng.choice(DECIMAL)} * {feature}",
                    f"{feature} + 0.5",
                )
            )
            if self.cut:  # alike on all paths
                numbers[0] = f"min(max({numbers[0]}, {low}), {high})"
        return f"[{', '.join(numbers)}]" if self.chance(0.8) else f"({', '.join(numbers)})"

    def _helpers(self) -> None:
        rng = self.rng
        for _ in range(rng.choices((0, 1, 2), (55, 30, 15))[0]):
            kind = rng.choice(("number", "test"))
            name = rng.choice(("scale", "limit_to", "is_close", "too_far", "smooth")) + f"_{len(self.helpers)}"
            low, high = self.bounds()
            if kind == "number":
                body = rng.choice(
                    (
                        f"return v * {rng.choice(DECIMAL)}",
                        f"return min(max(v, {low}), {high})",
                        f"if v < {low}:\n{INDENT * 2}return {low}\n{INDENT}return v",
                        f"return v - {rng.choice(DECIMAL)} if v > {high} else v",
                    )
                )
                head = f"def {name}(v):"
            else:
                body = rng.choice((f"return v > {low}", f"return {low} < v <= {high}", "return abs(v) < tol"))
                head = f"def {name}(v, tol={rng.choice(DECIMAL)}):" if "tol" in body else f"def {name}(v):"
            self.helping[name] = ["", "", head, f"{INDENT}{body}"]
            self.helpers.append((name, kind))

    # --- statements

    def _branches(self, depth: int) -> list[str]:
        lines = [f"if {self.condition()}:", *self.within(depth - 1)]
        for _ in range(self.rng.choice((0, 0, 1, 2))):
            lines += [f"elif {self.condition()}:", *self.within(depth - 2)]
        return [*lines, "else:", *self.within(depth - 1)]

    def _guard(self, depth: int) -> list[str]:
        return [f"if {self.condition()}:", *self.within(depth - 2), *self.returning(depth - 1)]

    def _ternary(self, depth: int) -> list[str]:
        text = f"{self.action()} if {self.condition()} else {self.action()}"
        if self.chance(0.3):
            text = f"{self.action()} if {self.condition()} else ({text})"
        return [f"return {text}"]

    def _variable(self, depth: int) -> list[str]:
        if self.chance(0.5):
            name = self.fresh("near")
            line = f"{name} = {self.condition(1)}"
            self.conditions.append(name)
        else:
            name = self.fresh("v")
            line = f"{name} = {self.feature()}"
            if self.chance(0.3):
                line = f"{name} = {self.feature()} if {self.condition(1)} else {self.constant()}"
            self.scaled.append(name)
        return [line, *self.returning(depth)]

    def _loop(self, depth: int) -> list[str]:
        rng, name = self.rng, self.fresh("t")
        feature = rng.choice(self.features).text
        values = sorted(rng.sample(DECIMAL, rng.randint(2, 4)))
        if self.gives == "label" and self.chance(0.5):
            pairs = ", ".join(f"({value}, {self.action()})" for value in values)
            other = self.fresh("a")
            lines = [f"for {name}, {other} in ({pairs}):", f"{INDENT}if {feature} < {name}:"]
            return [*lines, f"{INDENT * 2}return {other}", *self.returning(depth - 1)]
        literal = ", ".join(map(str, values))
        line = rng.choice(
            (f"for {name} in ({literal}):", f"for {name} in [{literal}]:", f"for {name} in range({len(values)}):")
        )
        lines = [line, f"{INDENT}if {feature} {rng.choice(ORDERS)} {name} and {self.condition(1)}:"]
        return [*lines, *(INDENT + each for each in self.within(0)), *self.returning(depth - 1)]

    def _counted(self, depth: int) -> list[str]:
        """Counts conditions, in a loop over limits or one by one."""
        rng, name = self.rng, self.fresh("count")
        lines = [f"{name} = 0"]
        if self.form == "row" and self.chance(0.5):
            limits = ", ".join(str(rng.choice(DECIMAL)) for _ in self.features)
            place = self.fresh("i")
            lines += [f"for {place} in range({len(self.features)}):"]
            lines += [f"{INDENT}if {self.given}[{place}] > ({limits},)[{place}]:", f"{INDENT * 2}{name} += 1"]
        else:
            for _ in range(rng.randint(2, 3)):
                lines += [f"if {self.condition(1)}:", f"{INDENT}{name} += 1"]
        lines += [f"if {name} {rng.choice(('>=', '==', '<'))} {rng.randint(1, 2)}:", *self.within(depth - 2)]
        return [*lines, *self.returning(depth - 1)]

    def _assigned(self, depth: int) -> list[str]:
        name = self.fresh("chosen")
        lines = [f"{name} = {self.action()}"]
        for _ in range(self.rng.randint(1, 3)):
            lines += [f"if {self.condition()}:", f"{INDENT}{name} = {self.action()}"]
        return [*lines, f"return {name}"]

    def _steps(self, depth: int) -> list[str]:
        """A loop that is left, with an `else`."""
        rng, name, level = self.rng, self.fresh("t"), self.fresh("level")
        feature = rng.choice(self.features).text
        values = ", ".join(map(str, sorted(rng.sample(DECIMAL, 3))))
        lines = [f"{level} = 0", f"for {name} in ({values}):", f"{INDENT}if {feature} <= {name}:", f"{INDENT * 2}break"]
        lines += (
            [f"{INDENT}{level} += 1", "else:", f"{INDENT}{level} = 9"]
            if self.chance(0.5)
            else [f"{INDENT}{level} += 1"]
        )
        return [*lines, f"if {level} > {rng.randint(0, 2)}:", *self.within(depth - 2), *self.returning(depth - 1)]

    def _match(self, depth: int) -> list[str]:
        rng, mode = self.rng, self.fresh("mode")
        values: Sequence[str] = rng.choice((('"low"', '"mid"', '"high"'), ("0", "1", "2")))
        lines = [f"if {self.condition()}:", f"{INDENT}{mode} = {values[0]}"]
        lines += [
            f"elif {self.condition()}:",
            f"{INDENT}{mode} = {values[1]}",
            "else:",
            f"{INDENT}{mode} = {values[2]}",
        ]
        subject, cases = mode, [values[0], f"{values[1]} | {values[2]}" if self.chance(0.3) else values[1]]
        if self.chance(0.3):
            other = self.fresh("side")
            lines.append(f'{other} = "in" if {self.condition(1)} else "out"')
            subject, cases = f"({mode}, {other})", [f'({values[0]}, "in")', f"({values[1]}, _)", '(_, "out")']
        lines.append(f"match {subject}:")
        for case in cases:
            guard = f" if {self.condition(1)}" if self.chance(0.1) else ""
            lines += [f"{INDENT}case {case}{guard}:", *(INDENT + line for line in self.within(depth - 2))]
        return [*lines, f"{INDENT}case _:", *(INDENT + line for line in self.within(depth - 2))]

    # --- the file

    def body(self) -> list[str]:
        """The function that decides."""
        rng, lines = self.rng, []
        if self.form == "unpacked":
            names = ", ".join(feature.name for feature in self.features)
            given = self.given
            if self.chance(0.2):
                self.imports.add("import numpy as np")
                given = f"np.asarray({given})"
            lines.append(f"{names}{',' * (len(self.features) == 1)} = {given}")
        if self.chance(0.1):
            lines.append('"""Decides."""')
            lines.reverse()
        lines += self.spot("statement", PLACE).split("\n")
        return [*lines, *self.returning(rng.randint(1, 4))]

    def text(self) -> str:
        """The whole source."""
        rng, self_ = self.rng, "self, " if self.kind != "function" else ""
        body = self.body()
        given = ", ".join(each.name for each in self.features) if self.form == "columns" else self.given
        if self.chance(0.15) and self.form == "columns":
            given = ", ".join(f"{each.name}: float" for each in self.features)
        name = self.agent if self.kind == "function" else rng.choice((self.agent, "__call__"))
        self.entry, head = self.agent, [f"def {name}({self_}{given}):"]
        function = [*head, *(INDENT + line for line in body)]
        text = "\n".join(function)
        helpers = [line for name, lines in self.helping.items() if f"{name}(" in text for line in lines]
        if self.kind != "function":
            function, self.agent = self._classed(function, name)
        step = self.step if self.taken and self.step is not None else None
        before = ["", "", self.fill(step.before, self.replaced)] if step and step.before else []
        after = ["", "", self.fill(step.after, self.replaced)] if step and step.after else []
        lines = [*sorted(self.imports), "", *self.top, *helpers, *before, "", "", *function, *after]
        lines = [line for part in lines for line in part.split("\n") if line.strip() != PLACE]
        return re.sub(r"\n{4,}", "\n\n\n", "\n".join(lines)).lstrip("\n") + "\n"

    def _classed(self, function: list[str], name: str) -> tuple[list[str], str]:
        owner = self.rng.choice(("Driver", "Controller", "Policy"))
        if self.kind == "dataclass":
            self.imports.add("from dataclasses import dataclass")
            fields = [f"{INDENT}{each}: float = {value}" for each, value in self.own]
            head = ["@dataclass", f"class {owner}:", *fields]
        else:
            given = "".join(f", {each}={value}" for each, value in self.own) if self.chance(0.4) else ""
            sets = [f"{INDENT * 2}self.{each} = {each if given else value}" for each, value in self.own]
            head = [f"class {owner}:", f"{INDENT}def __init__(self{given}):", *sets]
        lines = [*head, "", *(INDENT + line for line in function)]
        call = "" if name == "__call__" else f".{name}"
        if self.chance(0.3):
            self.entry = f"unit{call}"
            return [*lines, "", "", f"unit = {owner}()"], "unit"
        self.entry = f"{owner}(){call}"
        return lines, owner


def make(seed: int, step: Step | None = None, place: int = -1) -> tuple[PythonDraft, Program]:
    """The program of a seed, and its draft."""
    draft = PythonDraft(seed, step, place)
    form = "row" if draft.form == "unpacked" else draft.form
    options: dict[str, object] = {"numbers": {"output_names": ("u", "w")}, "scores": {"scores": True}}.get(
        draft.gives, {}
    )
    source, name = draft.source(), "" if step is None else step.name
    return draft, Program(seed, source, draft.agent, draft.entry, form, draft.features, options, name)
