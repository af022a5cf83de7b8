"""Random C programs of the subset that importing.md states, as people write firmware.

Does: draws functions of arrays, structs and parameters of declared types, with enumerators, macros, constants, helpers,
  tables, switches and loops with constant bounds. Names of the file end with the seed, so that many stand in one
  translation unit.
Assumes: what importing.md says is refused is avoided: numbers that may not fit, unsigned ones that may wrap around,
  products of features, sums of products that a compiler may join.
Does not: compile them, or know how they are read.
"""

from tests.hunting.sources.drafts import DECIMAL, INDENT, NAMES, TEXTS, WHOLE, Draft, Feature, Program, Step
from tests.hunting.sources.observing import WHOLE as RANGES

FORMS = ("array", "array", "pointer", "pointer", "value", "columns", "columns", "columns")
FLOATS = ("float", "float", "double")
WHOLES = ("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "bool")
SHARES = (3, 4, 6, 0, 5, 4, 3, 0, 4)  # numbers of 64 bits are refused: large ones are no doubles
ORDERS = ("<", "<=", ">", ">=")
PLACE = "; /* a place for a step */"
CODES = {
    "int8": ("100", "-128", "127", "-7", "0x1F"),
    "int16": ("1000", "-32768", "300", "12345"),
    "int32": ("100000001", "16777217", "-2147483647", "123456789", "1 << 20", "40000"),
    "int64": ("100000001", "4294967297", "-5000000001LL", "9007199254740991LL"),
    "uint8": ("200", "255", "128", "0x80"),
    "uint16": ("65535", "40000", "1000u"),
    "uint32": ("4000000000u", "100000001u", "16777217u", "2147483648u"),
    "uint64": ("10000000000ull", "4294967296ull", "16777217u"),
    "bool": ("0", "1"),
}


class CDraft(Draft):
    """The C program of a seed."""

    leaving, idle = "return {};", PLACE
    statements = ("branches", "guard", "loop", "switch", "ternary", "variable", "counted", "assigned")
    shares = (28, 26, 9, 11, 9, 9, 6, 8)

    def __init__(self, seed: int, step: Step | None = None, place: int = -1) -> None:
        super().__init__(seed, "c", step, place)
        rng = self.rng
        self.form = rng.choice(FORMS)
        self.end = f"_{seed}"
        self.agent = rng.choice(("steer", "decide", "control", "gate", "policy")) + self.end
        self.given = rng.choice(("in", "x", "obs", "s"))
        self.shared = ""  # the type of an array's numbers
        names = rng.sample(NAMES, rng.randint(1, 5))
        self.features = tuple(self._feature(place, name) for place, name in enumerate(names))
        self.includes = {"#include <stdint.h>", "#include <stdbool.h>"}
        self.top: list[str] = []
        self.numbers: dict[str, list[str]] = {"float": [], "double": [], "whole": []}
        self.helping: dict[str, list[str]] = {}
        self.helpers: list[tuple[str, str, str]] = []  # name, "number" or "test", type
        self._actions()
        self._constants()
        self._helpers()

    def _feature(self, place: int, name: str) -> Feature:
        if self.form == "array":
            self.shared = self.shared or self._type()
            return Feature(f"x{place}", self.shared, f"{self.given}[{place}]")
        joint = {"pointer": "->", "value": "."}.get(self.form)
        return Feature(name, self._type(), name if joint is None else f"{self.given}{joint}{name}")

    def _type(self) -> str:
        rng = self.rng
        return rng.choice(FLOATS) if rng.random() < 0.6 else rng.choices(WHOLES, SHARES)[0]

    @staticmethod
    def typed(kind: str) -> str:
        """A type as C has it."""
        return kind if kind in ("float", "double", "bool") else f"{kind}_t"

    # --- numbers

    def literal(self, kind: str = "double") -> str:
        """A number of a type as people write it."""
        rng = self.rng
        if kind in RANGES:
            if self.chance(0.35):
                return rng.choice(CODES[kind])
            low, high = RANGES[kind]
            value = rng.choice([each for each in WHOLE if each <= high])
            return f"-{value}" if low < 0 and rng.random() < 0.3 and value else str(value)
        value = rng.choice((*DECIMAL, *WHOLE))
        text = str(float(value)) if self.chance(0.85) else str(value)
        text = (
            rng.choice((text, text, text, "1.0 / 3", "16777217.0", "0.1 + 0.2", "1e3", "0x1p-3"))
            if self.chance(0.1)
            else text
        )
        if kind == "float" and self.chance(0.8) and " " not in text and not text.isdigit():
            text += "f"
        return f"-{text}" if rng.random() < 0.3 and " " not in text else text

    def constant(self, kind: str) -> str:
        """A literal or a named one."""
        text = self.literal(kind)
        named = self.numbers["whole" if kind in RANGES else kind]
        if named and self.chance(0.35) and kind not in ("bool", "uint8", "uint16", "uint32", "uint64"):
            text = self.rng.choice(named)
        return self.spot("constant", f"({text})" if " " in text else text)

    # --- what a feature becomes

    def feature(self) -> tuple[str, str]:
        """A feature, or what is computed of one, and its type."""
        rng = self.rng
        each = rng.choice(self.features)
        text, kind = each.text, each.type
        if kind in ("float", "double"):
            for _ in range(rng.choices((0, 1, 2), (62, 30, 8))[0]):
                text = self._computed(text, kind)
        elif kind in ("int8", "int16", "uint8", "uint16") and self.chance(0.35):
            number = rng.choice([each for each in WHOLE if each])
            text = rng.choice(
                (f"({text} + {number})", f"({text} - {number})", f"{text} * {number}", f"{text} / {number}", f"-{text}")
            )
            kind = "int32"
        return text, kind

    def _computed(self, base: str, kind: str) -> str:
        rng = self.rng
        end = "f" if kind == "float" and self.chance(0.8) else ""
        number = f"{float(rng.choice(DECIMAL))}{end}"
        low, high = (f"{float(each)}{end}" for each in sorted(rng.sample((*DECIMAL, *WHOLE), 2)))
        letter = "f" if kind == "float" and end else ""
        helpers = [name for name, what, of in self.helpers if what == "number" and of == kind]
        texts = [
            f"({base} - {number})",
            f"({base} + {number})",
            f"{base} * {number}" if "*" not in base and "+" not in base and "-" not in base else base,
            f"{base} / {number}",
            f"-{base}" if not base.startswith("-") else base,
            f"fabs{letter}({base})",
            f"fmin{letter}({base}, {high})",
            f"fmax{letter}({base}, {low})",
            f"({base} < {low} ? {low} : {base})",
            f"({kind}) ({base})",
        ]
        if helpers and self.chance(0.3):
            return f"{rng.choice(helpers)}({base})"
        text = rng.choice(texts)
        if "fab" in text or "fm" in text:
            self.includes.add("#include <math.h>")
        return text

    # --- conditions

    def compare(self) -> str:
        """A comparison."""
        rng = self.rng
        kind = rng.choices(("order", "flipped", "between", "equal", "helper", "pair"), (55, 8, 12, 8, 10, 7))[0]
        left, of = self.feature()
        if of == "bool":
            return rng.choice((left, f"!{left}", f"{left} == true", f"{left} == 0"))
        order = rng.choice(ORDERS)
        if kind == "flipped":
            return f"{self.constant(of)} {order} {left}"
        if kind == "between":
            return f"{left} > {self.constant(of)} && {left} <= {self.constant(of)}"
        if kind == "equal":
            return f"{left} {rng.choice(('==', '!='))} {self.constant(of)}"
        helpers = [name for name, what, kept in self.helpers if what == "test" and kept == of]
        if kind == "helper" and helpers:
            return f"{rng.choice(helpers)}({left})"
        if kind == "pair":
            alike = [each for each in self.features if each.type in ("float", "double")]
            if len(alike) > 1:
                one, other = rng.sample(alike, 2)
                return f"{one.text} {order} {other.text}"
        return f"{left} {order} {self.constant(of)}"

    def condition(self, levels: int = 2) -> str:
        """A comparison, or several joined."""
        rng = self.rng
        kind = rng.choices(("one", "&&", "||", "!", "variable"), (58, 14, 14, 6, 8))[0] if levels else "one"
        if kind == "variable" and self.conditions:
            return self.spot("condition", rng.choice(self.conditions))
        if kind in ("&&", "||"):
            parts = [f"({self.condition(levels - 1)})" for _ in range(2)]
            return self.spot("condition", f" {kind} ".join(parts))
        if kind == "!":
            return self.spot("condition", f"!({self.condition(levels - 1)})")
        return self.spot("condition", self.compare())

    # --- the file's own names

    def _constants(self) -> None:
        rng = self.rng
        for stem in rng.sample(("LIMIT", "NEAR", "FAR", "MARGIN"), rng.randint(0, 3)):
            kind = rng.choice(("float", "double", "whole"))
            name = f"{stem}{self.end}"
            text = str(rng.choice(WHOLE)) if kind == "whole" else self.literal(kind)
            if self.chance(0.5):
                self.top.append(
                    f"#define {name} " + (f"({text})" if self.chance(0.7) or "-" in text or " " in text else text)
                )
            else:
                self.top.append(f"static const {'int' if kind == 'whole' else kind} {name} = {text};")
            self.numbers[kind].append(name)
        if self.chance(0.25):
            kind = rng.choice(("float", "double"))
            values = [self.literal(kind) for _ in range(3)]
            self.top.append(f"static const {kind} BANDS{self.end}[3] = {{{', '.join(values)}}};")
            self.numbers[kind] += [f"BANDS{self.end}[{place}]" for place in range(3)]

    def _actions(self) -> None:
        rng = self.rng
        kind, count = (
            rng.choice(("enum", "enum", "enum", "whole", "whole", "defines", "bool", "odd", "valued")),
            rng.randint(2, 5),
        )
        names = [f"{text.upper()}{self.end}" for text in rng.sample(TEXTS, count)]
        self.labels: tuple[str, ...] = ()
        self.answer = "int"
        if kind in ("enum", "valued"):
            values = sorted(rng.sample(range(9), count)) if kind == "valued" else None
            if values and self.chance(0.3):
                rng.shuffle(values)
            inside = ", ".join(
                name if values is None else f"{name} = {value}"
                for name, value in zip(names, values or names, strict=True)
            )
            self.answer = f"action{self.end}_t"
            text = f"typedef enum {{ {inside} }} {self.answer};"
            if self.chance(0.3):
                self.answer = f"enum action{self.end}"
                text = f"{self.answer} {{ {inside} }};"
            self.top.append(text)
            self.actions = names
            self.labels = tuple(names)
            if self.chance(0.15):
                self.answer = rng.choice(("int", "uint8_t"))
        elif kind == "whole":
            self.actions, self.answer = (
                [str(each) for each in range(count)],
                rng.choice(("int", "uint8_t", "int32_t", "unsigned")),
            )
        elif kind == "defines":
            self.top += [f"#define {name} {value}" for value, name in enumerate(names)]
            self.actions, self.labels = names, tuple(names)
        elif kind == "bool":
            self.actions, self.answer = rng.choice((["true", "false"], ["1", "0"])), "bool"
        else:
            self.actions, self.answer = rng.choice(
                ((["-1", "0", "1"], "int"), (["-2", "4", "7"], "int8_t"), (["100", "300"], "int"))
            )

    def action(self) -> str:
        """What a path returns."""
        return self.another(self.actions)

    def _helpers(self) -> None:
        rng = self.rng
        for number in range(rng.choices((0, 1, 2), (50, 35, 15))[0]):
            what = rng.choice(("number", "test"))
            kind = rng.choice((*FLOATS, *sorted({each.type for each in self.features} - {"bool"})))
            if what == "number" and kind not in FLOATS:
                continue
            name = rng.choice(("scale", "limit", "is_far", "close_to")) + f"{number}{self.end}"
            typed, low, high = self.typed(kind), self.literal(kind), self.literal(kind)
            if what == "number":
                body = rng.choice(
                    (
                        f"return v < {low} ? {low} : v;",
                        f"if (v > {high}) return {high};\n{INDENT}return v;",
                        "return v * 2;",
                    )
                )
                head = f"static {typed} {name}({typed} v)"
            else:
                body = rng.choice((f"return v > {low};", f"return v >= {low} && v < {high};", f"return !(v < {low});"))
                head = f"static {rng.choice(('bool', 'bool', 'int'))} {name}({typed} v)"
            self.helping[name] = [
                f"{rng.choice(('', '', 'inline '))}{head}".replace("inline static", "static inline"),
                "{",
                f"{INDENT}{body}",
                "}",
                "",
            ]
            self.helpers.append((name, what, kind))

    # --- statements

    def _branches(self, depth: int) -> list[str]:
        lines = [f"if ({self.condition()}) {{", *self.within(depth - 1)]
        for _ in range(self.rng.choice((0, 0, 1, 2))):
            lines += [f"}} else if ({self.condition()}) {{", *self.within(depth - 2)]
        return [*lines, "} else {", *self.within(depth - 1), "}"]

    def _guard(self, depth: int) -> list[str]:
        if self.chance(0.4):
            return [f"if ({self.condition()}) return {self.action()};", *self.returning(depth - 1)]
        return [f"if ({self.condition()}) {{", *self.within(depth - 2), "}", *self.returning(depth - 1)]

    def _ternary(self, depth: int) -> list[str]:
        last = self.action()
        if self.chance(0.3):
            last = f"({self.condition()} ? {self.action()} : {last})"
        return [f"return {self.condition()} ? {self.action()} : {last};"]

    def _variable(self, depth: int) -> list[str]:
        name = self.fresh("near")
        line = f"{self.rng.choice(('bool', 'const bool', 'int'))} {name} = {self.condition(1)};"
        self.conditions.append(name)
        return [line, *self.returning(depth)]

    def _floats(self) -> list[Feature]:
        return [each for each in self.features if each.type in ("float", "double")]

    def _loop(self, depth: int) -> list[str]:
        rng, name = self.rng, self.fresh("i")
        floats = self._floats()
        if not floats:
            return self._guard(depth)
        feature = rng.choice(floats)
        count = rng.randint(2, 4)
        values = ", ".join(self.literal(feature.type) for _ in range(count))
        table = self.fresh("table")
        actions = ", ".join(self.action() for _ in range(count))
        lines = [f"static const {feature.type} {table}[{count}] = {{{values}}};"]
        given = self.action()
        if self.chance(0.5):
            kind = self.answer if self.answer != "bool" else "int"
            lines.append(f"static const {kind} {table}a[] = {{{actions}}};")
            given = f"{table}a[{name}]"
        head = rng.choice(
            (
                f"for (int {name} = 0; {name} < {count}; {name}++)",
                f"for (int {name} = {count - 1}; {name} >= 0; --{name})",
            )
        )
        lines += [
            f"{head} {{",
            f"{INDENT}if ({feature.text} {rng.choice(ORDERS)} {table}[{name}]) return {given};",
            "}",
        ]
        return [*lines, *self.returning(depth - 1)]

    def _counted(self, depth: int) -> list[str]:
        rng, name = self.rng, self.fresh("count")
        lines = [f"{rng.choice(('int', 'unsigned', 'uint8_t'))} {name} = 0;"]
        for _ in range(rng.randint(2, 3)):
            lines.append(
                rng.choice((f"if ({self.condition(1)}) {name}++;", f"{name} += ({self.condition(1)}) ? 1 : 0;"))
            )
        lines += [f"if ({name} {rng.choice(('>=', '==', '<'))} {rng.randint(1, 2)}) {{", *self.within(depth - 2), "}"]
        return [*lines, *self.returning(depth - 1)]

    def _assigned(self, depth: int) -> list[str]:
        name = self.fresh("chosen")
        kind = self.answer if self.answer != "bool" else "bool"
        lines = [f"{kind} {name} = {self.action()};"]
        for _ in range(self.rng.randint(1, 3)):
            lines.append(f"if ({self.condition()}) {name} = {self.action()};")
        return [*lines, f"return {name};"]

    def _switch(self, depth: int) -> list[str]:
        rng = self.rng
        wholes = [
            each for each in self.features if each.type in RANGES and each.type not in ("bool", "int64", "uint64")
        ]
        before: list[str] = []
        if wholes and self.chance(0.7):
            feature = rng.choice(wholes)
            subject, pool = feature.text, [str(each) for each in WHOLE if each <= RANGES[feature.type][1]]
            pool += [each for each in CODES[feature.type] if " " not in each]
            cases = rng.sample(pool, 3)
            if len({int(each.rstrip("uUlL"), 0) for each in cases}) < 3:
                cases = ["0", "1", "2"]
        else:
            subject = self.fresh("mode")
            before = [
                f"int {subject} = 0;",
                f"if ({self.condition()}) {subject} = 1;",
                f"else if ({self.condition()}) {subject} = 2;",
            ]
            cases = ["0", "1", "7"]
        lines = [*before, f"switch ({subject}) {{", f"case {cases[0]}: {{", *self.within(depth - 2), "}"]
        if self.chance(0.4):
            lines += [f"case {cases[1]}:", f"case {cases[2]}: {{", *self.within(depth - 2), "}"]
        else:
            lines += (
                [f"case {cases[1]}:", f"{INDENT}break;"] if self.chance(0.3) else [f"case {cases[1]}:", *self.within(0)]
            )
        if self.chance(0.6):
            lines += ["default: {", *self.within(depth - 2), "}"]
        return [*lines, "}", *self.returning(depth - 1)]

    # --- the file

    def text(self) -> str:
        """The whole source."""
        rng = self.rng
        lines = self.spot("statement", PLACE).split("\n")
        if self.chance(0.1):
            wholes = [each for each in self.features if each.type not in ("bool",)]
            if wholes:
                self.includes.add("#include <assert.h>")
                each = rng.choice(wholes)
                low = "0" if each.type.startswith("u") else "-100"
                lines.append(f"assert({each.text} >= {low} && {each.text} <= 120);")
        lines += self.returning(rng.randint(1, 4))
        head, self.parameters = self._head()
        function = [*head, "{", *(INDENT + line for line in lines), "}"]
        text = "\n".join(function)
        helpers = [line for name, lines in self.helping.items() if f"{name}(" in text for line in lines]
        step = self.step if self.taken and self.step is not None else None
        if step is not None and step.before.startswith("#include"):
            self.includes.add(step.before.split("\n")[0])
        before = [self.fill(step.before, self.replaced), ""] if step and step.before else []
        after = ["", self.fill(step.after, self.replaced)] if step and step.after else []
        every = [*sorted(self.includes), "", *self.top, "", *self.struct, *before, *helpers, *function, *after]
        every = [line for part in every for line in part.split("\n") if line.strip() != PLACE]
        return "\n".join(every) + "\n"

    def _head(self) -> tuple[list[str], str]:
        rng = self.rng
        self.struct: list[str] = []
        if self.form == "array":
            typed = self.typed(self.features[0].type)
            given = rng.choice(
                (
                    f"const {typed} *{self.given}",
                    f"const {typed} {self.given}[{len(self.features)}]",
                    f"{typed} {self.given}[]",
                )
            )
        elif self.form == "columns":
            given = ", ".join(f"{self.typed(each.type)} {each.text}" for each in self.features)
        else:
            name = f"input{self.end}_t"
            members = [f"{INDENT}{self.typed(each.type)} {each.name};" for each in self.features]
            self.struct = ["typedef struct {", *members, f"}} {name};", ""]
            given = f"const {name} *{self.given}" if self.form == "pointer" else f"{name} {self.given}"
        return [f"{self.answer} {self.agent}({given})"], given


def make(seed: int, step: Step | None = None, place: int = -1) -> tuple[CDraft, Program]:
    """The program of a seed, and its draft."""
    draft = CDraft(seed, step, place)
    source, name = draft.source(), "" if step is None else step.name
    return draft, Program(seed, source, draft.agent, "", draft.form, draft.features, {}, name, draft.labels)
