"""The process that runs a source: it reads a request, then observations, and writes what the source answers to them.

Does: has the gate make a tree, limits itself, runs the tree with the gate's tables for names, and asks its entry.
Assumes: Python's isolated mode; requests as asking.py writes them.
Does not: import anything of ours but the gate, or open a file once the source runs.

Whatever the gate may have missed ends here: after the imports, an event of Python's audit that reaches out of the
process ends it at once.
"""

# pyright: basic
# the values of a program may be anything
import ast
import builtins
import gc
import json
import operator
import os
import sys
from importlib import import_module
from struct import iter_unpack
from types import SimpleNamespace
from typing import Any, NamedTuple

MAX_PARTS = 1 << 12  # of an answer
MAX_TEXT = 1 << 14
MAX_NUMBERS = 1 << 15  # of a source
MAX_BITS = 1 << 10
HARMLESS = ("object", "code", "compile", "exec", "sys", "builtins", "cpython", "marshal", "time")  # events
FOUND = 77  # the exit status of a source that reached out
OPERATORS = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.USub: operator.neg, ast.UAdd: operator.pos,
    ast.Pow: lambda one, other: one**other if abs(other) < MAX_BITS else None,
}  # fmt: skip
FOLDED = (ast.Name, ast.BinOp, ast.UnaryOp, ast.Call)


class Raised(NamedTuple):
    """An error in place of an answer."""

    error: str
    text: str


class Names(dict):
    """An observation whose numbers have names: obs["speed"] and obs.speed."""

    def __init__(self, pairs: Any) -> None:
        super().__init__(pairs)
        self.__dict__.update(self)


def limit_process(asked: dict[str, Any]) -> None:
    """No files written, no processes, so much time and memory."""
    import resource

    size, seconds = asked["bytes"], asked["seconds"]
    wanted = {"FSIZE": 0, "CORE": 0, "NPROC": 0, "CPU": seconds, "AS": size, "DATA": size}
    for name, value in wanted.items():
        try:
            resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (value, value))
        except (AttributeError, ValueError, OSError):
            continue  # of a system that has no such limit; the parent's clock remains


def watch_process() -> None:
    """An end at the first event that reaches out."""

    def end_process(event: str, _: Any) -> None:
        if event.partition(".")[0] not in HARMLESS:
            os._exit(FOUND)

    sys.addaudithook(end_process)


def build_namespace(imports: dict[str, tuple[str, str]], gate: Any) -> dict[str, Any]:
    """Returns the names that the source may use: tables of functions, never a module."""

    def ignore_call(*given: Any, **named: Any) -> Any:
        return silent

    silent = SimpleNamespace(**dict.fromkeys(gate.LEVELS.split(), ignore_call))
    held: dict[str, Any] = {}
    for module in {module for module, _ in imports.values()}:
        if module == "logging":
            held[module] = SimpleNamespace(**dict.fromkeys(gate.MEMBERS[module], ignore_call))
        else:
            real = import_module(module)
            known = {each: getattr(real, each) for each in gate.MEMBERS[module] if hasattr(real, each)}
            held[module] = SimpleNamespace(**known)
    table = {name: getattr(builtins, name) for name in gate.NAMES}
    table |= {"print": lambda *given, **named: None, "__build_class__": builtins.__build_class__}
    names = {name: getattr(held[module], of) if of else held[module] for name, (module, of) in imports.items()}
    return {"__builtins__": table, "__name__": "policy", **names}


PLAIN = (ast.FunctionDef, ast.arguments, ast.arg, ast.If, ast.IfExp, ast.Return, ast.Pass, ast.BoolOp)
ORDERS = {ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq}
EXACT = 1 << 53  # a whole number up to which arrays have all


def only_compares(nodes: list[ast.AST], shapes: list[Any]) -> bool:
    """Returns True if a source compares single numbers of what it is given with constants or one another, returns
    constants, and does nothing else: arrays are then answered as lists of floats.
    """
    numbers, whole = {*map(type, shapes)} == {int}, set[int]()  # nodes that may be all of what is given
    given = {each.arg for each in nodes if isinstance(each, ast.arg)}
    for node in nodes:  # what is a part of another one stands behind it
        plain = isinstance(node, PLAIN)
        if isinstance(node, ast.Name):
            plain = numbers or node.id not in given or id(node) in whole
        elif isinstance(node, ast.Constant):
            plain = type(node.value) is not int or abs(node.value) <= EXACT
        elif isinstance(node, ast.UnaryOp):
            plain = isinstance(node.op, ast.Not) or isinstance(node.operand, ast.Constant)
        elif isinstance(node, ast.Compare):
            sides = node.left, *node.comparators
            plain = {*map(type, node.ops)} <= ORDERS and not any(isinstance(each, ast.Tuple) for each in sides)
        elif isinstance(node, ast.Subscript):
            plain = isinstance(node.value, ast.Name) and type(getattr(node.slice, "value", None)) in (int, str)
            whole.add(id(node.value))
        elif isinstance(node, ast.Assign):
            unpacked = len(node.targets) == 1 and isinstance(node.targets[0], ast.Tuple)
            names = getattr(node.targets[0], "elts", []) if unpacked else node.targets
            plain = all(isinstance(each, ast.Name) for each in names)
            whole |= {id(node.value), id(node.targets[0])} if unpacked else set()
        elif isinstance(node, ast.Tuple):
            plain = id(node) in whole  # names for all numbers
        if not plain:
            return False
    return True


# --- numbers of the source


def collect_numbers(nodes: list[ast.AST], space: dict[str, Any]) -> list[Any]:
    """All numbers that stand in the source, that its constant expressions give, or that its constants hold. `nodes`:
    what is a part of another one stands behind it.
    """
    numbers, held = dict[Any, None](), list[Any]([value for name, value in space.items() if name != "__builtins__"])
    seen = set[int]()
    value: Any
    while held and len(seen) < MAX_NUMBERS:
        value = held.pop()
        if id(value) in seen or isinstance(value, SimpleNamespace):
            continue
        seen.add(id(value))
        _keep_number(value, numbers)
        if isinstance(value, list | tuple | set | frozenset):
            held += value
        elif isinstance(value, dict):
            held += [*value, *value.values()]
        elif hasattr(value, "__dict__"):
            held += vars(value).values()
        array: Any = value
        if hasattr(array, "tolist"):
            held.append(array.tolist())
    known: dict[int, Any] = {}
    for node in reversed(nodes):  # parts before what they are part of
        value = node.value if isinstance(node, ast.Constant) else _fold_node(node, known, space)
        if value is not None:
            known[id(node)] = value
            _keep_number(value, numbers)
    return list(numbers)[:MAX_NUMBERS]


def _keep_number(value: Any, numbers: dict[Any, None]) -> None:
    value = value.item() if hasattr(value, "item") and hasattr(value, "ndim") and not value.ndim else value
    if (type(value) is int and value.bit_length() <= MAX_BITS) or (type(value) is float and value - value == 0):
        numbers[value] = None


def _fold_node(node: ast.AST, known: dict[int, Any], space: dict[str, Any]) -> Any:
    """The number that an expression of constants gives; None for all others."""
    value: Any
    if not isinstance(node, FOLDED):
        return None
    parts = [known.get(id(each)) for each in ast.iter_child_nodes(node) if isinstance(each, ast.expr)]
    try:
        if isinstance(node, ast.Name):
            value = space.get(node.id)
        elif not isinstance(node, ast.Call) and None not in parts:
            value = OPERATORS[type(node.op)](*parts)
        elif isinstance(node, ast.Call) and None not in parts[1:] and isinstance(node.func, ast.Attribute):
            owner: Any = node.func.value
            value = getattr(space[owner.id], node.func.attr)(*parts[1:]) if not node.keywords else None
        else:
            return None
        return value if isinstance(value, int | float) or (hasattr(value, "dtype") and not value.ndim) else None
    except Exception:
        return None


# --- answers


def find_entry(space: dict[str, Any], asked: dict[str, Any]) -> Any:
    """The function, or the method of an object, that decides."""
    entry = space[asked["entry"]]
    if not asked["method"]:
        return entry
    made = entry() if isinstance(entry, type) and asked["made"] else entry
    return getattr(made, asked["method"])


def encode_answer(value: Any, depth: int = 0) -> Any:
    """An answer as JSON; of what is no number, text, list or member, the type alone."""
    kind = type(value)
    if value is None or kind in (bool, float) or (kind is int and value.bit_length() <= 4 * MAX_BITS):
        return value
    if kind is str and len(value) <= MAX_TEXT:
        return value
    if kind is Raised:
        return {"raised": value.error, "said": value.text}
    if isinstance(value, ENUM) and depth < 3:
        return {"member": value._name_, "value": encode_answer(value._value_, depth + 1)}
    if kind.__module__ == "numpy" and hasattr(value, "tolist"):
        return encode_answer(value.tolist(), depth + 1)
    if isinstance(value, list | tuple) and len(value) <= MAX_PARTS and depth < 4:
        return [encode_answer(each, depth + 1) for each in value]
    return {"strange": kind.__name__}


def make_value(shape: Any, row: Any) -> Any:
    """Returns what a parameter is given: a number, the whole observation, or numbers by name."""
    if isinstance(shape, dict):
        return Names({key: row[place] for key, place in shape.items()})
    return row if shape == "row" else row[shape]


def ask_rows(entry: Any, asked: dict[str, Any], rows: Any) -> tuple[list[Any], list[int]]:
    """The answers that are different, and the place of each row's among them."""
    given, named, answers = asked["given"], asked["named"], list[Any]()

    def call_entry(row: Any) -> Any:
        parts = {name: make_value(each, row) for name, each in named.items()}
        return entry(*[make_value(each, row) for each in given], **parts)

    call = entry if given == ["row"] and not named else call_entry
    call = keep_calls(call, entry.__self__, asked) if asked["kept"] else call
    for row in rows:
        try:
            answers.append(call(row))
        except Exception as error:
            answers.append(Raised(type(error).__name__, str(error)[:200]))
    kinds = {*map(type, answers)}
    plain = kinds <= {int, str} or kinds == {bool}  # most are: no text is made of each
    texts = answers if plain else [json.dumps(encode_answer(each)) for each in answers]
    places = {text: place for place, text in enumerate(dict.fromkeys(texts))}
    return [encode_answer(each) if plain else json.loads(each) for each in places], [places[each] for each in texts]


def keep_calls(call: Any, owner: Any, asked: dict[str, Any]) -> Any:
    """A call that sets what is remembered, where the row has it, and answers with what is remembered then."""
    names, count = [name for name, _ in asked["kept"]], len(asked["kept"])
    values = [listed and [asked["find"](each) for each in listed] for _, listed in asked["kept"]]

    def read(name: str, listed: Any) -> Any:
        value = getattr(owner, name)
        value = value.item() if type(value).__module__ == "numpy" and value.ndim == 0 else value
        if listed is None:
            return value if type(value) is int else None
        return next((at for at, each in enumerate(listed) if type(each) is type(value) and each == value), None)

    def call_kept(row: Any) -> Any:
        for name, listed, given in zip(names, values, row[-count:], strict=True):
            if given == given:
                setattr(owner, name, int(given) if listed is None else listed[int(given)])
        return [call(row[:-count]), *map(read, names, values)]

    return call_kept


def answer_form(entry: Any, asked: dict[str, Any], form: str, content: bytes) -> tuple[list[Any], list[int]]:
    """The answers to observations as lists of Python's floats, or as arrays."""
    for name, value in asked["begun"]:
        setattr(entry.__self__, name, value)
    if form == "floats":
        return ask_rows(entry, asked, map(list, iter_unpack(f"{asked['width']}d", content)))
    import numpy as np

    with np.errstate(all="ignore"):
        matrix = np.frombuffer(content, np.float64).reshape(asked["rows"], asked["width"])
        return ask_rows(entry, asked, matrix.astype(form))


def main() -> None:
    """Two lines are read and two written; the observations, doubles row by row, stand behind the second."""
    gc.disable()  # of a syntax tree nothing is garbage
    read, to = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)

    def say(content: Any) -> None:
        to.write(json.dumps(content).encode() + b"\n")
        to.flush()

    asked = json.loads(read.readline())
    limit_process(asked)
    sys.path.append(os.path.dirname(__file__))  # noqa: PTH120 - to load pathlib takes as long as to walk 1,000 ifs
    sys.path.append(asked["library"])
    content = asked["source"].encode("latin-1")
    gate = import_module("gate")
    try:
        tree, imports, nodes = gate.gate_source(content, asked["entry"], asked["method"])
        space = build_namespace(imports, gate)
        shapes = [*asked["given"], *asked["named"].values()]
        if asked["forms"] == ["floats", "float64"] and only_compares(nodes, shapes):
            asked["forms"] = ["floats"]
        import_module("math" if asked["forms"] == ["floats"] else "numpy")  # later, nothing is imported
        code = compile(tree, "source", "exec", dont_inherit=True)
        watch_process()
        exec(code, space)
        entry = find_entry(space, asked)
        say({"numbers": collect_numbers(nodes, space)})
    except SyntaxError as error:
        return say({"refused": error.msg, "line": error.lineno or 0})
    except (RecursionError, MemoryError, ValueError) as error:
        return say({"refused": f"{type(error).__name__}: {error}"[:200], "line": 0})
    except Exception as error:
        return say({"refused": f"it raises {type(error).__name__}: {error}"[:200], "line": 0})
    gc.freeze()
    gc.enable()
    asked |= json.loads(read.readline())
    begun = [(name, getattr(entry.__self__, name)) for name, _ in asked["kept"]]
    asked["begun"] = begun
    asked["find"] = lambda each: getattr(space[each[0]], each[1]) if each[0] else each[1]
    content = read.read(8 * asked["rows"] * asked["width"])
    return say([answer_form(entry, asked, form, content) for form in asked["forms"]])


ENUM = import_module("enum").Enum

if __name__ == "__main__":
    main()
    os._exit(0)  # nothing that the source left behind is run
