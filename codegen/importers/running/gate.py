"""The gate before Python runs a source: a syntax tree that can compute and do nothing else, or a refusal with its line.

Does: removes imports, annotations, docstrings and what the decision does not name; lets a closed list of nodes, names
  and attributes through.
Assumes: a process that runs the tree with nothing but `NAMES` and `MEMBERS`, under limits of time, memory and files.
Does not: know what the source decides, or share anything with the reader that made a tree of it.

No value that a program can have leads out of this list by an attribute: an attribute is one of `ATTRIBUTES`, a member
that `MEMBERS` names, or a name that no built-in type has and that does not begin with two underscores.
"""

import ast
import builtins
import math
import types
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import Any, cast

NODES: frozenset[type[ast.AST]] = frozenset((
    ast.Module, ast.FunctionDef, ast.ClassDef, ast.Return, ast.Assign, ast.AugAssign, ast.AnnAssign, ast.For, ast.While,
    ast.If, ast.Match, ast.Raise, ast.Assert, ast.Expr, ast.Pass, ast.Break, ast.Continue, ast.BoolOp, ast.NamedExpr,
    ast.BinOp, ast.UnaryOp, ast.Lambda, ast.IfExp, ast.Dict, ast.Set, ast.ListComp, ast.GeneratorExp, ast.Compare,
    ast.Call, ast.FormattedValue, ast.JoinedStr, ast.Constant, ast.Attribute, ast.Subscript, ast.Name, ast.List,
    ast.Tuple, ast.Slice, ast.comprehension, ast.arguments, ast.arg, ast.keyword, ast.match_case, ast.MatchValue,
    ast.MatchSingleton, ast.MatchSequence, ast.MatchAs, ast.MatchOr,
    *ast.expr_context.__subclasses__(), *ast.boolop.__subclasses__(), *ast.operator.__subclasses__(),
    *ast.unaryop.__subclasses__(), *ast.cmpop.__subclasses__(),
))  # fmt: skip
NAMES = frozenset(
    """abs all any bool dict enumerate float frozenset int isinstance len list max min object print range reversed round
    set sorted str sum tuple zip property staticmethod classmethod Exception ArithmeticError AssertionError IndexError
    KeyError LookupError NotImplementedError RuntimeError TypeError ValueError ZeroDivisionError""".split()  # noqa: SIM905
)
LEVELS = "critical debug error exception info log warning"
MEMBERS = {
    module: frozenset(("", *members.split()))
    for module, members in {
        "dataclasses": "dataclass field",
        "enum": "Enum IntEnum auto unique",
        "logging": f"basicConfig getLogger DEBUG INFO WARNING ERROR {LEVELS}",
        "math": " ".join(each for each in dir(math) if not each.startswith("_")),
        "numpy": """abs array asarray clip deg2rad dot e float32 float64 inf matmul maximum minimum nan ndarray pi
            rad2deg""",
        "typing": "NamedTuple Protocol TypedDict",
    }.items()
}
ATTRIBUTES = frozenset(
    f"""add all any append args argmax argmin astype bit_count bit_length capitalize clear clip close code copy count
    cumsum difference discard dot dtype end endswith errno extend find flatten get imag index insert intersection
    is_integer isdigit issubset issuperset item items join keys kind lower lstrip max mean min msg name ndim numerator
    denominator obj offset path pop prod ravel real reason remove repeat replace reshape reverse round rstrip setdefault
    shape size sort split squeeze start startswith std step stop strip sum symmetric_difference text tile title tolist
    type union update upper value values var T {LEVELS}""".split()
)
OWN = ("__init__", "__call__", "__post_init__")
NO_BASES = {"dict", "frozenset", "list", "property", "range", "set", "tuple", "zip"}
BINDING: dict[type[ast.AST], str] = {  # the field that gives a name something
    ast.FunctionDef: "name", ast.ClassDef: "name", ast.MatchAs: "name", ast.arg: "arg",
}  # fmt: skip
NAMED: dict[type[ast.AST], str] = {**BINDING, ast.Name: "id", ast.keyword: "arg"}
UNCHECKED = (ast.If, ast.Compare, ast.Subscript, ast.Return, ast.Expr, ast.Assign, ast.BinOp, ast.UnaryOp, ast.BoolOp)
Imports = dict[str, tuple[str, str]]  # name -> module and member, or ""
FIELDS = {kind: [each for each in kind._fields if each not in ("ctx", "op", "ops")] for kind in NODES} | {
    ast.Name: [], ast.Constant: [],
}  # fmt: skip
COMPUTED = (ast.Lambda, ast.NamedExpr, ast.GeneratorExp, ast.ListComp, ast.DictComp, ast.SetComp)  # no default


def _refuse(node: ast.AST, what: str) -> SyntaxError:
    return SyntaxError(what, ("source", getattr(node, "lineno", 0), 0, ""))


def gate_source(text: bytes | str, entry: str, method: str = "") -> tuple[ast.Module, Imports, list[ast.AST]]:
    """Lists what a source needs for `entry`, a name of the file (`method`: of it, what decides): tree, imports, nodes.
    SyntaxError for all that is not on the lists.
    """
    tree, imports, used = ast.parse(text), Imports(), {method}
    if any(isinstance(node, ast.ClassDef) for node in tree.body):
        used |= {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    tree.body = _clean_block(tree.body, tree, used, imports)
    nodes = _reach_entry(tree, [walk_nodes(node, used, imports) for node in tree.body], entry)
    imports = {name: (module, of) for name, (module, of) in imports.items() if of in MEMBERS.get(module, ())}
    _check_nodes(nodes, NAMES.union(("__name__",), imports, _bind_names(nodes)), imports)
    return tree, imports, nodes


def walk_nodes(node: ast.AST, used: set[str], imports: Imports) -> list[ast.AST]:
    """A node and all below it, cleaned of imports (which `imports` has then), annotations, docstrings, and methods that
    nothing names. Contexts and operators are left out: each of them is on the list.
    """
    nodes: list[ast.AST] = [node]
    for each in nodes:
        kind: type[ast.AST] = type(each)
        if isinstance(each, ast.arg | ast.FunctionDef):
            setattr(each, "annotation" if isinstance(each, ast.arg) else "returns", None)
        for field in FIELDS.get(kind, each._fields):
            value: Any = getattr(each, field, None)
            parts = cast("list[Any]", value) if isinstance(value, list) else [value]
            if parts is value and field in ("body", "orelse"):
                empty = [ast.copy_location(ast.Pass(), one) for one in parts[: field == "body"]]
                parts = _clean_block(parts, each, used, imports) or empty
                setattr(each, field, parts)
            nodes += [one for one in parts if isinstance(one, ast.AST)]
    return nodes


@cache
def list_built_in() -> frozenset[str]:
    """The attributes of Python's own types, and of NumPy's."""
    numpy: Any = import_module("numpy")
    kinds = [each for held in (builtins, types) for each in vars(held).values() if isinstance(each, type)]
    kinds += [numpy.ndarray, numpy.generic, numpy.dtype, numpy.ufunc]
    return frozenset(name for each in kinds for name in dir(each))


def _clean_block(block: list[ast.stmt], parent: ast.AST, used: set[str], imports: Imports) -> list[ast.stmt]:
    kept, of_class = list[ast.stmt](), isinstance(parent, ast.ClassDef)
    for node in block:
        if isinstance(node, ast.Import | ast.ImportFrom):
            for each in node.names:
                held = (node.module or "", each.name) if isinstance(node, ast.ImportFrom) else (each.name, "")
                if imports.setdefault(each.asname or each.name, held) != held:
                    raise _refuse(node, f"{each.asname or each.name} is imported twice")
        elif isinstance(node, ast.AnnAssign):
            if of_class and "ClassVar" not in ast.unparse(node.annotation):
                node.annotation = ast.copy_location(ast.Constant(None), node)  # fields of dataclasses need one
                kept.append(node)
            elif node.value is not None:
                kept.append(ast.copy_location(ast.Assign([node.target], node.value), node))
        elif isinstance(node, ast.If) and getattr(getattr(node.test, "left", None), "id", "") == "__name__":
            main = ast.unparse(node.test) == "__name__ == '__main__'"
            kept += _clean_block(node.orelse, parent, used, imports) if main else [node]
        elif of_class and isinstance(node, ast.FunctionDef) and not node.decorator_list and not node.name.endswith("_"):
            kept += [node] if node.name in used else []
        elif not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant):
            kept.append(node)
    return kept


def _reach_entry(tree: ast.Module, walked: list[list[ast.AST]], entry: str) -> list[ast.AST]:
    """Keeps what names the entry, what it names, and so on, and calls of functions; returns the nodes of these.
    `walked`: those of each statement.
    """
    body = tree.body
    names = [{each.id for each in nodes if isinstance(each, ast.Name)} for nodes in walked]
    defined = [getattr(node, "name", "") for node in body]
    kept, known, count = set[int](), {entry}, -1
    while count < len(kept):
        count = len(kept)
        for place, node in enumerate(body):
            calls = isinstance(node, ast.Expr) and names[place].intersection(filter(None, defined))
            if calls or known.intersection([defined[place]] if defined[place] else names[place]):
                kept.add(place)
                known |= names[place]
    tree.body = [node for place, node in enumerate(body) if place in kept]
    return [node for place in sorted(kept) for node in walked[place]]


def _bind_names(nodes: list[ast.AST]) -> Iterator[str]:
    for node in nodes:
        if type(node) is ast.Name and isinstance(node.ctx, ast.Store):
            yield node.id
        elif type(node) in BINDING and getattr(node, BINDING[type(node)]):
            yield getattr(node, BINDING[type(node)])


def _check_nodes(nodes: list[ast.AST], bound: frozenset[str], imports: Imports) -> None:
    """SyntaxError for a node that is not on the lists."""
    for node in nodes:
        kind = type(node)
        if kind not in NODES:
            raise _refuse(node, f"{kind.__name__} is not among what is run")
        if kind in UNCHECKED:
            continue
        name = (getattr(node, NAMED[kind]) if kind in NAMED else "") or ""
        if name.startswith("__") and name not in (*OWN, "__name__"):
            raise _refuse(node, f"the name {name}")
        if kind is ast.Name and name not in bound:
            raise _refuse(node, f"the name {name} is not defined in the file")
        if isinstance(node, ast.Attribute):
            module, member = imports.get(node.value.id, ("", "-")) if isinstance(node.value, ast.Name) else ("", "-")
            own = node.attr in ATTRIBUTES if member else node.attr in MEMBERS.get(module, ())
            if not own and (not member or node.attr.startswith("__") or node.attr in list_built_in()):
                raise _refuse(node, f"the attribute {node.attr}")
        if isinstance(node, ast.Constant) and type(node.value) not in (bool, bytes, int, float, str, types.NoneType):
            raise _refuse(node, f"a constant of the type {type(node.value).__name__}")
        spec = node.format_spec if isinstance(node, ast.FormattedValue) else None
        if isinstance(spec, ast.JoinedStr) and not all(isinstance(each, ast.Constant) for each in spec.values):
            raise _refuse(node, "a format that is computed")
        if isinstance(node, ast.ClassDef):
            bases = {each.id for each in node.bases if isinstance(each, ast.Name)}
            if node.keywords or bases & NO_BASES:
                raise _refuse(node, "a keyword or a base of a class")
        if isinstance(node, ast.arguments):
            for default in (*node.defaults, *filter(None, node.kw_defaults)):
                if any(isinstance(each, COMPUTED) for each in ast.walk(default)):
                    raise _refuse(default, "a default that is computed")
