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

NODES = frozenset((
    ast.Module, ast.FunctionDef, ast.ClassDef, ast.Return, ast.Assign, ast.AugAssign, ast.AnnAssign, ast.For, ast.While,
    ast.If, ast.Match, ast.Raise, ast.Assert, ast.Expr, ast.Pass, ast.Break, ast.Continue, ast.BoolOp, ast.NamedExpr,
    ast.BinOp, ast.UnaryOp, ast.Lambda, ast.IfExp, ast.Dict, ast.Set, ast.ListComp, ast.SetComp, ast.DictComp,
    ast.GeneratorExp, ast.Compare, ast.Call, ast.FormattedValue, ast.JoinedStr, ast.Constant, ast.Attribute,
    ast.Subscript, ast.Starred, ast.Name, ast.List, ast.Tuple, ast.Slice, ast.comprehension, ast.arguments, ast.arg,
    ast.keyword, ast.match_case, ast.MatchValue, ast.MatchSingleton, ast.MatchSequence, ast.MatchMapping, ast.MatchStar,
    ast.MatchAs, ast.MatchOr,
))  # fmt: skip
SIGNS = (ast.expr_context, ast.boolop, ast.operator, ast.unaryop, ast.cmpop)  # of which every kind is let through
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
CONSTANTS = (bool, bytes, int, float, str, types.NoneType)
BASES = NAMES - {"dict", "frozenset", "list", "map", "property", "range", "set", "slice", "super", "tuple", "zip"}
COMPUTED = (ast.Lambda, ast.NamedExpr, ast.GeneratorExp, ast.ListComp, ast.DictComp, ast.SetComp)  # no default


def _refuse(node: ast.AST, what: str) -> SyntaxError:
    """Returns an error for a source that may do something else than compute."""
    return SyntaxError(what, ("source", getattr(node, "lineno", 0), 0, ""))


def gate_source(text: bytes | str, entry: str, method: str = "") -> tuple[ast.Module, dict[str, tuple[str, str]]]:
    """Lists what a source needs for `entry`, a name of the file, and its imports: name -> module and member, or "".

    `method`: of the entry, which is what decides. SyntaxError for all that is not on the lists.
    """
    tree = ast.parse(text)
    imports, used, nodes = dict[str, tuple[str, str]](), {method}, list(ast.walk(tree))
    for node in nodes:
        used |= {node.attr} if isinstance(node, ast.Attribute) else set()
        for each in node.names if isinstance(node, ast.Import | ast.ImportFrom) else ():
            held = (node.module or "", each.name) if isinstance(node, ast.ImportFrom) else (each.name, "")
            if imports.setdefault(each.asname or each.name, held) != held:
                raise _refuse(node, f"{each.asname or each.name} is imported twice")
    imports = {name: held for name, held in imports.items() if _is_member(*held)}
    for node in nodes:
        _clean_node(node, used)
    tree.body = _reach_entry(tree.body, entry)
    nodes = list(ast.walk(tree))
    bound = NAMES.union(("__name__",), imports, _bind_names(nodes))
    for node in nodes:
        _check_node(node, bound, imports)
    return tree, imports


def _is_member(module: str, member: str) -> bool:
    return module in MEMBERS and (not member or member in MEMBERS[module])


def _clean_node(node: ast.AST, used: set[str]) -> None:
    """Removes imports, docstrings, annotations, the main block, and methods that nothing names."""
    for field in ("body", "orelse"):
        block: list[ast.stmt] = getattr(node, field, [])
        if field in node._fields and type(block) is list:
            kept = [part for each in block for part in _clean_statement(each, node, used)]
            empty = field == "body" and not kept and not isinstance(node, ast.Module)
            setattr(node, field, [ast.copy_location(ast.Pass(), block[0])] if empty else kept)
    if isinstance(node, ast.arg):
        node.annotation = None
    if isinstance(node, ast.FunctionDef):
        node.returns = None


def _clean_statement(node: ast.stmt, parent: ast.AST, used: set[str]) -> list[ast.stmt]:
    """Returns what is left of a statement; of a method that nothing names, nothing."""
    of_class, told = (
        isinstance(parent, ast.ClassDef),
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant),
    )
    if told or isinstance(node, ast.Import | ast.ImportFrom):
        return []
    if of_class and isinstance(node, ast.FunctionDef) and not node.decorator_list and not node.name.endswith("_"):
        return [node] if node.name in used else []
    if isinstance(node, ast.AnnAssign):
        if of_class and "ClassVar" not in ast.unparse(node.annotation):
            node.annotation = ast.copy_location(ast.Constant(None), node)  # fields of dataclasses need one
            return [node]
        return [] if node.value is None else [ast.copy_location(ast.Assign([node.target], node.value), node)]
    if isinstance(node, ast.If) and ast.unparse(node.test) == "__name__ == '__main__'":
        return node.orelse
    return [node]


def _reach_entry(body: list[ast.stmt], entry: str) -> list[ast.stmt]:
    """The statements that the entry may depend on: what names it, what it names, and so on; all that call functions."""
    names = [{each.id for each in ast.walk(node) if isinstance(each, ast.Name)} for node in body]
    defined = [getattr(node, "name", "") for node in body]
    kept, known, count = set[int](), {entry}, -1
    while count < len(kept):
        count = len(kept)
        for place, node in enumerate(body):
            calls = isinstance(node, ast.Expr) and names[place].intersection(filter(None, defined))
            if calls or known.intersection([defined[place]] if defined[place] else names[place]):
                kept.add(place)
                known |= names[place]
    return [node for place, node in enumerate(body) if place in kept]


def _bind_names(nodes: list[ast.AST]) -> Iterator[str]:
    for node in nodes:
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        held = getattr(node, "name", None) or getattr(node, "arg", None) or getattr(node, "rest", None)
        if isinstance(held, str) and not isinstance(node, ast.keyword):
            yield held


def _check_node(node: ast.AST, bound: frozenset[str], imports: dict[str, tuple[str, str]]) -> None:
    """SyntaxError for a node that is not on the lists."""
    if type(node) not in NODES:
        if isinstance(node, SIGNS):
            return
        raise _refuse(node, f"{type(node).__name__} is not among what is run")
    for name in (getattr(node, field, None) for field in ("id", "name", "arg", "rest")):
        if isinstance(name, str) and name.startswith("__") and name not in (*OWN, "__name__"):
            raise _refuse(node, f"the name {name}")
    if isinstance(node, ast.Name) and node.id not in bound:
        raise _refuse(node, f"the name {node.id} is not defined in the file")
    if isinstance(node, ast.Attribute):
        module, member = imports.get(node.value.id, ("", "-")) if isinstance(node.value, ast.Name) else ("", "-")
        known = node.attr in ATTRIBUTES or (node.attr not in BUILT_IN and not node.attr.startswith("__"))
        if not (known if member else _is_member(module, node.attr)) and ast.unparse(node) != "super().__init__":
            raise _refuse(node, f"the attribute {node.attr}")
    if isinstance(node, ast.Constant) and type(node.value) not in CONSTANTS:
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
