"""The structural proof of emitted C: its syntax tree, walked against the policy tree.

Does: parses the header (pycparser) and finds every difference between a function and the tree that it should be: tests,
  thresholds bit by bit, sides, actions, the loops around tables.
Assumes: what pycparser reads is what a compiler reads; comments and preprocessor lines carry no decision.
Does not: run anything, or use what the emitter made on the way.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from pycparser import CParser, c_ast, c_generator
from pycparser.c_parser import ParseError

from codegen import ir
from codegen.deciding import sums_in
from codegen.floats import FLOAT32, WHOLE, below_zero
from codegen.ir import NO_FEATURE, ROOT, Tree
from codegen.lowering.model import Model
from codegen.lowering.names import TABLES

NOT_PROVED = (AttributeError, LookupError, TypeError, ValueError)
MEANT = re.compile(
    r'#(include <(float|stdint)\.h>|ifdef FLT_RADIX|endif|error .*|define \w+_H|define \w+_PROFILE "[0-9a-f]{64}")'
)
# a sum whose parts no compiler may fuse with what the caller makes of them; read as the sum that it is
UNFUSED = re.compile(
    r"""#if defined\(__FMA__\) && defined\(__GNUC__\) && defined\(__x86_64__\)
 *__asm__\("" : "\+x"\(a\), "\+x"\(b\)\);
 *double total = a \+ b;
#elif defined\(__FP_FAST_FMA\) \|\| defined\(__FMA__\) \|\| defined\(__AVX2__\) \|\| defined\(__aarch64__\)
 *const volatile double first = a;
 *const volatile double second = b;
 *double total = first \+ second;
#else
( *double total = a \+ b;)
#endif"""
)
# tables, once in a unit or once in a program; read as this unit's own
SHARED = re.compile(
    r"""#ifdef (\w+)_SHARED_TABLES
((?:extern const \w[\w ]* \w+\[\d+\];\n)+)#define \1_TABLE const
#else
#define \1_TABLE static const
#endif
#if !defined\(\1_SHARED_TABLES\) \|\| defined\(\1_OWN_TABLES\)
((?:\1_TABLE \w[\w ]* \w+\[\d+\] = \{[^\n{}]*\};\n)+)#endif
"""
)
CONSTANT = re.compile(r"#define (\w+_(DT|DAMPING|FORCE)) -?[0-9.e+-]+")  # a number that the code does not use
TYPES = " ".join(f"typedef {'unsigned' * (each[0] == 'u')} int {each}_t;" for each in WHOLE) + "\n"
# a table of plain numbers; such are most of a large header, and are read apart in a tenth of the parser's time
NUMBER = r"-?(?:0x[0-9a-f]+(?:\.[0-9a-f]+)?p[-+]?[0-9]+f?|[0-9]+)"
TABLE = re.compile(rf"(?<=\] = \{{){NUMBER}(?:, {NUMBER}){{15,}}(?=\}};)")
STANDS_IN = "table_apart_"  # the name that stands in a table's place while the rest is parsed
# what stands around the tables; {next} is the step to the child
STEP = {
    True: "i = ((2 * i) + 1) + ((x[feature[i]] <= threshold[i]) ? (0) : (1));",
    False: "i = (int) child[(2 * i) + ((x[feature[i]] <= threshold[i]) ? (0) : (1))];",
}
WALK = "int i = 0; int level; for (level = 0; level < {levels}; level++) {{ {step} }} return (int) action[{place}];"

# of observations and thresholds
KINDS: dict[str, Any] = {"float": np.float32, "double": np.float64}
KINDS |= {f"{each}_t": np.dtype(each).type for each in WHOLE}
LEAST = "(-2147483647) - 1;"  # the least int32, which is no constant of C
COUNT = ["const long left = n - first;", "const long count = (left < 256) ? (left) : (256);"]
LOOPS = ["first = 0;", "first < n;", "first += 256;", "row = 0;", "row < count;", "row++;"]
COPIED = re.compile(r"for \(row = 0; row < count; row\+\+\) \{ actions\[first \+ row\] = \([a-z ]+\) chosen\[row\]; \}")


def faults(header: str, profile: ir.PolicyProfile, model: Model) -> dict[str, list[str]]:
    """Per agent, how its `act` and `act_columns` in the header differ from its tree; nothing where they do not.

    There is no agent where one has sums, which this proof does not read.
    """
    if sums_in(profile):
        return {}
    try:
        parsed = syntax(header)
    except ParseError as error:
        return {policy.agent: [f"not C as it should be: {error}"] for policy in profile.agents}
    odd = odd_lines(header)
    if odd:
        return {policy.agent: [f"a line that may change the rest: {odd[0][:80]}"] for policy in profile.agents}
    functions = functions_in(parsed)
    numbers = enumerators(parsed)
    by_agent: dict[str, list[str]] = {}
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        name = f"{model.prefix}_{agent.lower}"
        # the constants for features and actions are their counts and places
        upper = name.upper()
        wanted = {f"{upper}_N_FEATURES": len(policy.features), f"{upper}_N_ACTIONS": len(policy.actions)}
        for kind, items in (("X_", policy.features), ("", policy.actions)):
            for place, item in enumerate(items):
                wanted[f"{upper}_{kind}{item.name.upper().replace('-', '_')}"] = place
        wrong = ((constant, value) for constant, value in wanted.items() if numbers.get(constant) != value)
        problems = [f"{constant} is {numbers.get(constant)}, not {value}" for constant, value in wrong]
        for suffix, check in (("act", act_faults), *(() if model.bare else (("act_columns", _columns),))):
            function = resolve_function(functions, f"{name}_{suffix}")
            if function is None:
                problems.append(f"there is no function {name}_{suffix}")
                continue
            try:
                tree = replace(policy.tree, numbers=policy.whole) if policy.whole else policy.tree
                problems += [f"{suffix}: {each}" for each in check(function, tree, numbers)]
            except NOT_PROVED as error:
                problems.append(f"{suffix}: not of the form that is proved ({error})")
        by_agent[policy.agent] = problems
    return by_agent


@lru_cache(maxsize=2)
def syntax(header: str) -> Any:
    """The header's syntax tree, to be read only: proofs about one header parse it once. ParseError if it is not C."""
    text = plain(header)
    apart: dict[str, str] = {}

    def set_apart(table: re.Match[str]) -> str:
        apart[f"{STANDS_IN}{len(apart)}"] = table[0]
        return f"{STANDS_IN}{len(apart) - 1}"

    parsed = CParser().parse(TYPES + (text if STANDS_IN in text else TABLE.sub(set_apart, text)))
    for declared in parsed.ext:
        for item in (declared.body.block_items or []) if isinstance(declared, c_ast.FuncDef) else [declared]:
            first = item.init.exprs[0] if is_table(item) else None
            if isinstance(first, c_ast.ID) and first.name in apart:
                item.init.exprs = [_constant(each) for each in apart.pop(first.name).split(", ")]
    return CParser().parse(TYPES + text) if apart else parsed  # where tables stand elsewhere, by the parser alone


def _constant(text: str) -> Any:
    """A number as the parser gives it: a constant, under a minus if it has one."""
    kind = "int" if "p" not in text else "float" if text.endswith("f") else "double"
    constant = c_ast.Constant(kind, text.removeprefix("-"))
    return c_ast.UnaryOp("-", constant) if text.startswith("-") else constant


def resolve_function(functions: Mapping[str, Any], name: str) -> Any:
    """The function of that name, or the one that it does nothing but call, with its own parameters in their order: how
    agents that share a tree share its code. None where there is no such function.
    """
    passed: set[str] = set()
    while name in functions and name not in passed:
        passed.add(name)
        items = [item for item in functions[name].body.block_items or [] if not is_void(item)]
        call = getattr(items[0], "expr", items[0]) if len(items) == 1 else None
        if not isinstance(call, c_ast.FuncCall) or not isinstance(call.name, c_ast.ID):
            return functions[name]
        declared, name = functions[name].decl.type, call.name.name
        given = [item.name if isinstance(item, c_ast.ID) else "" for item in call.args.exprs]
        alike = name in functions and _signature(functions[name].decl.type) == _signature(declared)
        if given != [each.name for each in declared.args.params] or not alike:
            return None
    return None


def _signature(declared: Any) -> list[str]:
    return [_text(declared.args), " ".join(declared.type.type.names)]


def _strip_comments(header: str) -> str:
    """The header without comments, and with its sums as they are read."""
    text = re.sub(r" *\n", "\n", re.sub(r"/\*.*?\*/", " ", header, flags=re.S))
    return SHARED.sub(_own_tables, UNFUSED.sub(r"\1", text, count=1), count=1)


def _own_tables(tables: re.Match[str]) -> str:
    """The tables of a header as if no unit shared them; all lines where it declares others than it defines."""
    own = tables[3].replace(f"{tables[1]}_TABLE ", "static const ")
    return own if tables[2] == re.sub("^static(.*) = .*;", r"extern\1;", own, flags=re.M) else tables[0]


def functions_in(parsed: c_ast.FileAST) -> dict[str, Any]:
    """The functions by name, each with the tables of the file that it names, as if they stood in it."""
    functions: dict[str, Any] = {}
    for function in (node for node in parsed.ext if isinstance(node, c_ast.FuncDef)):
        named, left = set[str](), [function.body]
        while left:
            node = left.pop()
            if isinstance(node, c_ast.ArrayRef) and isinstance(node.name, c_ast.ID):
                named.add(node.name.name)
            left += [child for _, child in node.children()]
        tables = [item for item in parsed.ext if is_table(item) and item.name in named]
        body = c_ast.Compound([*tables, *(function.body.block_items or [])])
        functions[function.decl.name] = c_ast.FuncDef(function.decl, None, body)
    return functions


def name_table(function: c_ast.FuncDef, text: str) -> str:
    """A text without the function's own name before those of tables."""
    return re.sub(rf"\b{re.sub('act(_columns)?$', '', function.decl.name)}({'|'.join(TABLES)})\b", r"\1", text)


def plain(header: str) -> str:
    """The header without comments and preprocessor lines."""
    text = _strip_comments(header)
    return "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))


def odd_lines(header: str) -> list[str]:
    """Preprocessor lines that could change what the rest means: others than those that a header needs."""
    lines = [line.strip() for line in _strip_comments(header).splitlines() if line.strip()]
    odd = []
    for line, after in zip(lines, [*lines[1:], ""], strict=True):
        if not line.startswith("#"):
            continue
        refuses = re.match(r"#\s*(if|ifdef)\b", line) and after.startswith("#error")
        guards, names = re.fullmatch(r"#ifndef (\w+)", line), CONSTANT.fullmatch(line)
        unused = names and sum(len(re.findall(rf"\b{names[1]}\b", each)) for each in lines) == 1
        if not (refuses or MEANT.fullmatch(line) or unused or (guards and after == f"#define {guards[1]}")):
            odd.append(line)
    return odd


def enumerators(parsed: c_ast.FileAST) -> dict[str, int]:
    """The numbers of all enumerators."""
    numbers: dict[str, int] = {}
    for declaration in parsed.ext:
        enum = getattr(declaration, "type", None)
        if isinstance(enum, c_ast.Enum):
            numbers |= {each.name: int(each.value.value) for each in enum.values.enumerators}
    return numbers


def _kinds(function: c_ast.FuncDef, numbers: str) -> Iterator[str]:
    """Yields the observations and tables of thresholds that are not of the type that the agent compares."""
    given = function.decl.type.args.params[0].type
    declared = [("observations", given)]
    declared += [
        (item.name, item.type) for item in function.body.block_items or [] if _declares(function, item, "threshold")
    ]
    for name, kind in declared:
        while not isinstance(kind, c_ast.TypeDecl):
            kind = kind.type
        type_names = kind.type.names
        if len(type_names) != 1 or KINDS.get(type_names[0]) != np.dtype(numbers).type:
            yield f"{name} are of {' '.join(type_names)}, not of {numbers}"


def act_faults(function: c_ast.FuncDef, tree: Tree, numbers: Mapping[str, int]) -> Iterator[str]:
    """Yields the differences of an `..._act` from a tree; a form that is not proved raises one of NOT_PROVED."""
    items = [item for item in function.body.block_items or [] if not is_void(item)]
    if takes_bits(function) and tree.numbers == FLOAT32:
        yield from _check_nested(items, tree, numbers, parse_bits)
        return
    yield from _kinds(function, tree.numbers)
    if any(isinstance(item, c_ast.For) or _declares(function, item, "action") for item in items):
        yield from _walk(function, items, tree)
    else:
        yield from _check_nested(items, tree, numbers, parse_test)


Test = tuple[int, np.floating]  # feature and threshold
Parser = Callable[[c_ast.BinaryOp, Mapping[str, int]], Test]


def _check_nested(items: list[Any], tree: Tree, numbers: Mapping[str, int], parse: Parser) -> Iterator[str]:
    stack = [(items, ROOT)]
    while stack:
        (item,), node = stack.pop()
        if tree.feature[node] == NO_FEATURE:
            action = read_place(item.expr, numbers)
            if action != tree.action[node]:
                yield f"leaf {node} takes action {action}, not {tree.action[node]}"
            continue
        feature, threshold = parse(item.cond, numbers)
        yield from _differences(tree, node, feature, threshold)
        stack += [(item.iffalse.block_items, int(tree.right[node])), (item.iftrue.block_items, int(tree.left[node]))]


def read_place(item: Any, numbers: Mapping[str, int]) -> int:
    """A feature or an action, by its name or, in vast trees, by its number."""
    return int(item.value) if isinstance(item, c_ast.Constant) else numbers[item.name]


def _differences(tree: Tree, node: int, feature: int, threshold: np.floating) -> Iterator[str]:
    if feature != tree.feature[node]:
        yield f"node {node} tests feature {feature}, not {tree.feature[node]}"
    wanted = tree.threshold[node]
    if tree.numbers in WHOLE and threshold.dtype.kind == "i":
        threshold = threshold.astype(wanted.dtype) if threshold == wanted else threshold
    if threshold.dtype != wanted.dtype or threshold.tobytes() != wanted.tobytes():
        yield f"node {node} has the threshold {float(threshold).hex()}, not {float(tree.threshold[node]).hex()}"


def parse_test(condition: c_ast.BinaryOp, numbers: Mapping[str, int]) -> Test:
    """Feature and threshold of `x[F] <= t`, of `x[F] < 0`, or of a test by bits: signed for t >= 0, unsigned and turned
    below.
    """
    left, right = condition.left, condition.right
    if condition.op in ("<=", "<") and isinstance(left, c_ast.ArrayRef) and left.name.name == "x":
        return read_place(left.subscript, numbers), _threshold(condition)
    turned = isinstance(left, c_ast.Cast)
    call: Any = left.expr if turned else left
    if isinstance(left, c_ast.Cast) and left.to_type.type.type.names != ["uint32_t"]:
        raise ValueError("a cast to another type")
    if not call.name.name.endswith("_bits"):
        raise ValueError("a call of another function")
    bits = int(right.args.exprs[0].value, 16)
    if (condition.op, right.name.name, bits >> 31) != ((">=", "UINT32_C", 1) if turned else ("<=", "INT32_C", 0)):
        raise ValueError("bits compared in another way")
    return read_place(call.args.exprs[0].subscript, numbers), np.uint32(bits).view(np.float32)


def takes_bits(function: c_ast.FuncDef) -> bool:
    """Returns True if a function takes the bits of an observation, as those of the style `freestanding` do."""
    return _text(function.decl.type.args) == "const int *x;"


def parse_bits(condition: c_ast.BinaryOp, numbers: Mapping[str, int]) -> Test:
    """Feature and threshold of a test by bits in such a function."""
    left, right = condition.left, condition.right
    turned = isinstance(left, c_ast.Cast)
    seen: Any = left.expr if turned else left
    bits = int(right.value.removesuffix("U"), 16)
    cast = _text(left.to_type) if isinstance(left, c_ast.Cast) else ""
    form = (condition.op, cast, right.type, bits >> 31, seen.name.name)
    if form != ((">=", "unsigned int;", "unsigned int", 1, "x") if turned else ("<=", "", "int", 0, "x")):
        raise ValueError("bits compared in another way")
    return read_place(seen.subscript, numbers), np.uint32(bits).view(np.float32)


def _threshold(condition: c_ast.BinaryOp) -> np.floating:
    """The t of `<= t`, and of `< 0` the last number below 0."""
    threshold = number(condition.right)
    if condition.op == "<=":
        return threshold
    if condition.op != "<" or bool(threshold):
        raise ValueError(f"compared by {condition.op} with {threshold}")
    return threshold.dtype.type(below_zero(threshold.dtype.name))


def number(item: Any) -> Any:
    """A constant of float or double, or a whole number, with its sign."""
    if isinstance(item, c_ast.UnaryOp) and item.op == "-":
        return -number(item.expr)
    if isinstance(item, c_ast.BinaryOp) and item.op == "-" and _text(item) == LEAST:
        return np.int64(-(2**31))
    if isinstance(item, c_ast.Constant) and item.type in ("int", "unsigned int"):
        return np.int64(item.value.rstrip("U"))
    if not isinstance(item, c_ast.Constant) or item.type not in KINDS:
        raise ValueError("a threshold that is no constant of float or double")
    if not item.value.lower().startswith("0x"):
        raise ValueError("a threshold that is not hexadecimal")
    return KINDS[item.type](float.fromhex(item.value.rstrip("f")))


# --- tables


def _declares(function: c_ast.FuncDef, item: Any, name: str) -> bool:
    return isinstance(item, c_ast.Decl) and name_table(function, item.name) == name


def is_table(item: Any) -> bool:
    """Returns True if a statement declares an array with its numbers."""
    return isinstance(item, c_ast.Decl) and isinstance(item.init, c_ast.InitList)


def is_void(item: Any) -> bool:
    """Returns True if a statement is (void)x;"""
    return isinstance(item, c_ast.Cast) and isinstance(item.expr, c_ast.ID)


def _walk(function: c_ast.FuncDef, items: list[Any], tree: Tree) -> Iterator[str]:
    tables = {name_table(function, item.name): item.init.exprs for item in items if is_table(item)}
    code = name_table(function, " ".join(_text(item) for item in items if not is_table(item)))
    actions = [int(item.value) for item in tables["action"]]
    if "threshold" not in tables:
        if code != "return (int) action[0];":
            yield f"another way through the tables: {code[:80]}"
        if tree.feature[ROOT] != NO_FEATURE or actions != [int(tree.action[ROOT])]:
            yield "the only action is another"
        return
    thresholds = [number(item) for item in tables["threshold"]]
    features = [int(item.value) for item in tables["feature"]]
    complete = "child" not in tables
    n = len(thresholds)
    levels = int(ir.depth(tree).max())
    place = f"i - {n}" if complete else "i"
    if code != WALK.format(levels=levels, step=STEP[complete], place=place):
        yield f"another way through the tables: {code}"
    if complete and n != 2**levels - 1:
        yield f"tables of {n} nodes for {levels} levels"
        return
    child = [] if complete else [int(item.value) for item in tables["child"]]
    stack = [(ROOT, ROOT)]
    while stack:
        node, at = stack.pop()
        if tree.feature[node] != NO_FEATURE:
            yield from _differences(tree, node, features[at], thresholds[at])
            pair = (2 * at + 1, 2 * at + 2) if complete else (child[2 * at], child[2 * at + 1])
            stack += [(int(tree.left[node]), pair[0]), (int(tree.right[node]), pair[1])]
        elif not complete:
            if actions[at] != tree.action[node] or child[2 * at : 2 * at + 2] != [at, at]:
                yield f"leaf {node} takes action {actions[at]}, not {tree.action[node]}, or is not the end"
        elif at >= n:
            if actions[at - n] != tree.action[node]:
                yield f"leaf {node} takes action {actions[at - n]}, not {tree.action[node]}"
        else:
            stack += [(node, 2 * at + 1), (node, 2 * at + 2)]


def _text(item: Any) -> str:
    text = c_generator.CGenerator().visit(item).strip()
    text = text if text.endswith(("}", ";")) else f"{text};"
    return re.sub(r"\s+", " ", text)


# --- batches over columns


def _columns(function: c_ast.FuncDef, tree: Tree, numbers: Mapping[str, int]) -> Iterator[str]:
    """The form with a select a split. A batch that walks is of the same tables as `act_rows`, and is replayed; so is
    one that asks `act` for each row.
    """
    yield from _kinds(function, tree.numbers)
    items = list(function.body.block_items or [])
    inner = [each for item in items if isinstance(item, c_ast.For) for each in item.stmt.block_items]
    if any(_declares(function, item, "action") for item in items) or any(
        _declares(function, item, "seen") for item in inner
    ):
        return
    pointers = [item for item in items if isinstance(item, c_ast.Decl) and item.init is not None]
    columns = {item.name: numbers[item.init.subscript.name] for item in pointers}
    blocks = next(item for item in items if isinstance(item, c_ast.For))
    _, *counts, loop, copied = blocks.stmt.block_items
    *selects, last = loop.stmt.block_items
    around = [_text(each) for each in (blocks.init, blocks.cond, blocks.next, loop.init, loop.cond, loop.next, copied)]
    if [_text(each) for each in counts] != COUNT or around[:6] != LOOPS or not COPIED.fullmatch(around[6]):
        yield "the loop over rows is another"
    splits = {select.name: select.init for select in selects}
    wanted = {f"n{node}" for node in ir.splits(tree)}
    if set(splits) != wanted:
        yield f"selects for {sorted(set(splits) ^ wanted)[:3]} too many or too few"
    for name, select in splits.items():
        node = int(name[1:])
        if _text(select.cond.left.subscript) != "first + row;":
            yield f"node {node} is compared in another way"
        yield from _differences(tree, node, columns[select.cond.left.name.name], _threshold(select.cond))
        for side, child in ((select.iftrue, tree.left[node]), (select.iffalse, tree.right[node])):
            target = side.name if isinstance(side, c_ast.ID) else float(side.value.rstrip("f"))
            if target != (f"n{child}" if tree.feature[child] != NO_FEATURE else float(tree.action[child])):
                yield f"node {node} leads to {target}"
    target = last.rvalue.name if isinstance(last.rvalue, c_ast.ID) else float(last.rvalue.value.rstrip("f"))
    if target != ("n0" if tree.feature[ROOT] != NO_FEATURE else float(tree.action[ROOT])):
        yield f"the answer is {target}"
    if _text(last.lvalue) != "chosen[row];":
        yield "the answer goes elsewhere"
