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
import sys
import types
from collections.abc import Iterator
from typing import Any, cast

NODES = frozenset((
    ast.Module, ast.FunctionDef, ast.ClassDef, ast.Return, ast.Assign, ast.AugAssign, ast.AnnAssign, ast.For, ast.While,
    ast.If, ast.Match, ast.Raise, ast.Assert, ast.Expr, ast.Pass, ast.Break, ast.Continue, ast.BoolOp, ast.NamedExpr,
    ast.BinOp, ast.UnaryOp, ast.Lambda, ast.IfExp, ast.Dict, ast.Set, ast.ListComp, ast.SetComp, ast.DictComp,
    ast.GeneratorExp, ast.Compare, ast.Call, ast.FormattedValue, ast.JoinedStr, ast.Constant, ast.Attribute,
    ast.Subscript, ast.Starred, ast.Name, ast.List, ast.Tuple, ast.Slice, ast.comprehension, ast.arguments, ast.arg,
    ast.keyword, ast.match_case, ast.MatchValue, ast.MatchSingleton, ast.MatchSequence, ast.MatchMapping, ast.MatchStar,
    ast.MatchAs, ast.MatchOr,
    *ast.expr_context.__subclasses__(), *ast.boolop.__subclasses__(), *ast.operator.__subclasses__(),
    *ast.unaryop.__subclasses__(), *ast.cmpop.__subclasses__(),
))  # fmt: skip
NAMES = frozenset(
    """abs all any bool callable dict divmod enumerate filter float frozenset int isinstance iter len list map max min
    next object pow print range reversed round set slice sorted str sum super tuple zip property staticmethod
    classmethod Exception ArithmeticError AssertionError IndexError KeyError LookupError NotImplementedError
    RuntimeError TypeError ValueError ZeroDivisionError""".split()  # noqa: SIM905
)
LEVELS = "critical debug error exception info log warning"
MEMBERS = {
    module: frozenset(members.split())
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
HELD = [each for held in (builtins, types) for each in vars(held).values() if isinstance(each, type)]
ARRAYS = [getattr(sys.modules.get("numpy"), each, object) for each in ("ndarray", "generic", "dtype", "ufunc")]
BUILT_IN = frozenset(name for each in (*HELD, *ARRAYS) for name in dir(each))
OWN = ("__init__", "__call__", "__post_init__")
BASES = NAMES - {"dict", "frozenset", "list", "map", "property", "range", "set", "slice", "super", "tuple", "zip"}
BINDING: dict[type[ast.AST], str] = {  # the field that gives a name something
    ast.FunctionDef: "name", ast.ClassDef: "name", ast.MatchAs: "name", ast.MatchStar: "name", ast.arg: "arg",
    ast.MatchMapping: "rest",
}  # fmt: skip
NAMED: dict[type[ast.AST], str] = {**BINDING, ast.Name: "id", ast.keyword: "arg"}
UNCHECKED = (ast.If, ast.Compare, ast.Subscript, ast.Return, ast.Expr, ast.Assign, ast.BinOp, ast.UnaryOp, ast.BoolOp)
Imports = dict[str, tuple[str, str]]  # name -> module and member, or ""
CLEANED = (ast.stmt, ast.mod, ast.match_case, ast.arg)
COMPUTED = (ast.Lambda, ast.NamedExpr, ast.GeneratorExp, ast.ListComp, ast.DictComp, ast.SetComp)  # no default


def _refuse(node: ast.AST, what: str) -> SyntaxError:
    return SyntaxError(what, ("source", getattr(node, "lineno", 0), 0, ""))


def gate_source(text: bytes | str, entry: str, method: str = "") -> tuple[ast.Module, Imports, list[ast.AST]]:
    """Lists what a source needs for `entry`, a name of the file (`method`: of it, what decides): tree, imports, nodes.
    SyntaxError for all that is not on the lists.
    """
    tree = ast.parse(text)
    imports, used, nodes = Imports(), {method}, walk_nodes(tree)
    for node in nodes:
        if type(node) is ast.Attribute:
            used.add(node.attr)
        for each in node.names if isinstance(node, ast.Import | ast.ImportFrom) else ():
            held = (node.module or "", each.name) if isinstance(node, ast.ImportFrom) else (each.name, "")
            if imports.setdefault(each.asname or each.name, held) != held:
                raise _refuse(node, f"{each.asname or each.name} is imported twice")
    for node in (each for each in nodes if isinstance(each, CLEANED)):
        _clean_node(node, used)
    imports, nodes = {name: held for name, held in imports.items() if _is_member(*held)}, _reach_entry(tree, entry)
    _check_nodes(nodes, NAMES.union(("__name__",), imports, _bind_names(nodes)), imports)
    return tree, imports, nodes


def walk_nodes(node: ast.AST) -> list[ast.AST]:
    """A node and all below it. Contexts and most operators are left out: each of them is on the list."""
    nodes: list[Any] = [node]
    for each in nodes:
        for field in each._fields if type(each) not in (ast.Name, ast.Constant) else ():
            value: Any = getattr(each, field, None)
            if type(value) is list:
                nodes += [one for one in cast("list[Any]", value) if isinstance(one, ast.AST)]
            elif isinstance(value, ast.AST) and value._fields:
                nodes.append(value)
    return nodes


def _is_member(module: str, member: str) -> bool:
    return module in MEMBERS and member in ("", *MEMBERS[module])


def _clean_node(node: ast.AST, used: set[str]) -> None:
    """Removes imports, docstrings, annotations, the main block, and methods that nothing names."""
    for field in {"body", "orelse"}.intersection(node._fields):
        block: list[ast.stmt] = getattr(node, field)
        kept = [part for each in block for part in _clean_statement(each, node, used)]
        if field == "body" and not kept and not isinstance(node, ast.Module):
            kept = [ast.copy_location(ast.Pass(), block[0])]
        setattr(node, field, kept)
    if type(node) in (ast.arg, ast.FunctionDef):
        setattr(node, "annotation" if isinstance(node, ast.arg) else "returns", None)


def _clean_statement(node: ast.stmt, parent: ast.AST, used: set[str]) -> list[ast.stmt]:
    """Returns what is left of a statement; of a method that nothing names, nothing."""
    of_class = isinstance(parent, ast.ClassDef)
    told = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    if isinstance(node, ast.Import | ast.ImportFrom) or told:
        return []
    if of_class and isinstance(node, ast.FunctionDef) and not node.decorator_list and not node.name.endswith("_"):
        return [node] if node.name in used else []
    if isinstance(node, ast.AnnAssign):
        if of_class and "ClassVar" not in ast.unparse(node.annotation):
            node.annotation = ast.copy_location(ast.Constant(None), node)  # fields of dataclasses need one
            return [node]
        return [] if node.value is None else [ast.copy_location(ast.Assign([node.target], node.value), node)]
    if not isinstance(node, ast.If) or getattr(getattr(node.test, "left", None), "id", "") != "__name__":
        return [node]
    return node.orelse if ast.unparse(node.test) == "__name__ == '__main__'" else [node]


def _reach_entry(tree: ast.Module, entry: str) -> list[ast.AST]:
    """Keeps what names the entry, what it names, and so on, and calls of functions; returns the nodes of these."""
    body, walked = tree.body, [walk_nodes(node) for node in tree.body]
    names = [{each.id for each in nodes if type(each) is ast.Name} for nodes in walked]
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
            known = node.attr in ATTRIBUTES or (node.attr not in BUILT_IN and not node.attr.startswith("__"))
            if not (known if member else _is_member(module, node.attr)) and ast.unparse(node) != "super().__init__":
                raise _refuse(node, f"the attribute {node.attr}")
        if isinstance(node, ast.Constant) and type(node.value) not in (bool, bytes, int, float, str, types.NoneType):
            raise _refuse(node, f"a constant of the type {type(node.value).__name__}")
        spec = node.format_spec if isinstance(node, ast.FormattedValue) else None
        if isinstance(spec, ast.JoinedStr) and not all(isinstance(each, ast.Constant) for each in spec.values):
            raise _refuse(node, "a format that is computed")
        if isinstance(node, ast.ClassDef):
            bases = {each.id for each in node.bases if isinstance(each, ast.Name)}
            if node.keywords or bases & (NAMES - BASES):
                raise _refuse(node, "a keyword or a base of a class")
        if isinstance(node, ast.arguments):
            for default in (*node.defaults, *filter(None, node.kw_defaults)):
                if any(isinstance(each, COMPUTED) for each in ast.walk(default)):
                    raise _refuse(default, "a default that is computed")
