"""Questions to a solver: is there an observation for which emitted code and tree take different actions?

Does: writes them as SMT-LIB: the code from its text (C: symbolic.py; Python: its syntax tree), the tree from its
  arrays.
Assumes: IEEE arithmetic; doubles are rounded once, to nearest, ties to even.
Does not: ask (maviper hands the text to verify), or use what the emitter made on the way.

Floats are given by their bits, so that an answer covers every NaN, both zeros, infinities and subnormals.
"""

import ast
import re
import struct
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from codegen import ir
from codegen.equivalence.symbolic import Definitions, Header, Unreadable
from codegen.lowering.model import Model
from codegen.lowering.render import render

SINGLE, DOUBLE = 32, 64  # bits of a number of an observation
C, PYTHON = "c float proof", "python double proof"


@dataclass(frozen=True)
class Obligation:
    """`text`: SMT-LIB, unsatisfiable iff code and tree decide alike for all observations that `covers` names."""

    target: str
    agent: str
    width: int  # bits of each number
    names: tuple[str, ...]  # the text's constants, the bits of each number
    covers: str
    text: str

    def observation(self, bits: Mapping[str, int]) -> tuple[float, ...]:
        """The observation with these bits."""
        codes = ("<I", "<f") if self.width == SINGLE else ("<Q", "<d")
        return tuple(struct.unpack(codes[1], struct.pack(codes[0], bits[name]))[0] for name in self.names)


def about_c(header: str, profile: ir.PolicyProfile, model: Model) -> list[Obligation]:
    """A question for each agent's `..._act`. Unreadable when the header is not of the C that is read."""
    read = Header(header)
    obligations: list[Obligation] = []
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        n = len(policy.features)
        inputs, code = [f"f{i}" for i in range(n)], Definitions("c")
        bits = {f"f{i}": f"x{i}" for i in range(n)}
        answer = read.decide(f"{model.prefix}_{agent.lower}_act", inputs, bits, code)
        assumed = [f"(not (fp.isNaN {each}))" for each in inputs] if model.by_bits else []
        obligations.append(_question(C, policy, model, SINGLE, (code, answer), assumed))
    return obligations


def about_python(module: str, profile: ir.PolicyProfile, model: Model) -> list[Obligation]:
    """A question for each agent's `act_...`, about lists of doubles: the code takes them as they are, the tree their
    float32 values. `_act_...`, which decides for arrays, gets one of its own if its tests are others. Unreadable when
    a function is not of the Python that is read.
    """
    body = ast.parse(module).body
    functions = {node.name: node for node in body if isinstance(node, ast.FunctionDef)}
    taken = functions.keys() | BUILT_IN.keys()
    for node in body:
        _ensure_idle(node, taken)
    obligations: list[Obligation] = []
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        code, names = Definitions("p"), (f"_act_{agent.lower}", f"act_{agent.lower}")
        answers = dict.fromkeys(_python_of(functions, name, len(policy.features), code) for name in names)
        obligations += [_question(PYTHON, policy, model, DOUBLE, (code, answer), []) for answer in answers]
    return obligations


def _python_of(functions: Mapping[str, ast.FunctionDef], name: str, n: int, into: Definitions) -> str:
    """The term of what a function returns for a list of n doubles."""
    function = functions.get(name)
    if function is None:
        raise Unreadable(f"there is no function {name}")
    parameters = function.args.args
    given = parameters[0].arg if parameters else ""
    only = ast.arguments([], parameters[:1], None, [], [], None, [])  # one parameter, and nothing else
    if ast.unparse(function.args) != ast.unparse(only) or given in BUILT_IN:
        raise Unreadable(f"{name} does not take one observation")
    return _python(function.body, given, n, into)


def _ensure_idle(node: ast.stmt, taken: Collection[str]) -> None:
    """Unreadable for a statement of the module that may change what a function does. `taken`: names that must stay."""
    match node:
        case ast.Expr(value=ast.Constant()):
            return
        case ast.FunctionDef(decorator_list=[]) if node.name not in BUILT_IN:
            return
        case ast.Assign(targets=targets) if all(
            isinstance(each, ast.Name) and each.id not in taken for each in targets
        ):
            return
        case ast.AnnAssign(target=ast.Name(id=name)) if name not in taken:
            return
        case ast.ImportFrom(module=module, names=names, level=0) if module in TYPING:
            if not any(each.asname or each.name == "*" or each.name in taken for each in names):
                return
        case ast.ClassDef(bases=[ast.Name(id="IntEnum")], keywords=[], decorator_list=[]) if node.name not in taken:
            for each in node.body:
                _ensure_idle(each, taken)
            return
        case ast.If(test=ast.Name(id="TYPE_CHECKING"), orelse=[]):
            for each in node.body:
                _ensure_idle(each, taken)
            return
        case _:
            pass
    raise Unreadable(f"a statement of the module: {ast.unparse(node)[:60]}")


def _question(
    target: str,
    policy: ir.AgentPolicy,
    model: Model,
    width: int,
    code: tuple[Definitions, str],
    assumed: Sequence[str],
) -> Obligation:
    tree, wanted = policy.tree, Definitions("t")
    terms: dict[int, str] = {}  # of the action below each node
    for node in reversed(range(len(tree.feature))):  # preorder: children come after their parents
        if tree.feature[node] == ir.NO_FEATURE:
            terms[node] = wanted.action(int(tree.action[node]))
            continue
        bits = int(tree.threshold[node].view(np.uint32))
        below = f"(fp.leq f{tree.feature[node]} ((_ to_fp 8 24) #x{bits:08x}))"
        terms[node] = wanted.choice(below, terms.pop(int(tree.left[node])), terms.pop(int(tree.right[node])))
    covers = f"2^{width * len(policy.features)} observations{' but those with NaN' if assumed else ''}"
    names = tuple(f"x{index}" for index in range(len(policy.features)))
    text = render(
        "smt/equal.smt2.j2",
        target=target,
        covers=covers,
        policy=policy,
        model=model,
        width=width,
        assumed=assumed,
        code=code[0].lines,
        tree=wanted.lines,
        answers=(code[1], terms[ir.ROOT]),
    )
    return Obligation(target, policy.agent, width, names, covers, text)


TYPING = ("__future__", "array", "enum", "math", "numpy.typing", "typing")  # what a module may import from
BUILT_IN = dict.fromkeys(("float", "len", "list", "tuple", "type"))  # what a function asks about its observation
OTHERWISE = "(kind := type({x})) is not list and kind is not tuple", "len({x}) != {n}"  # no list, or of another length
PLAIN = re.compile(r"(\w+)\[(\d+)\]")
NUMBER = re.compile(
    rf"(\w+) if type\(\((\w+) := {PLAIN.pattern}\)\) is float else _double\((\w+)\)"
)  # itself, if a double
_COMPARE: dict[type[ast.cmpop], str] = {ast.LtE: "fp.leq", ast.Lt: "fp.lt", ast.Gt: "fp.gt", ast.GtE: "fp.geq"}


def _python(body: Sequence[ast.stmt], given: str, n: int, into: Definitions) -> str:
    """The term of what statements return for a list of n doubles: `if` and `return` only."""
    rest = [item for item in body if not (isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant))]
    match rest:
        case [ast.Return(value=ast.Constant(value=int(number))), *_]:
            return into.action(number)
        case [ast.If(test=first, orelse=[ast.If(test=second, orelse=[])]), *after] if tuple(
            map(ast.unparse, (first, second))
        ) == tuple(each.format(x=given, n=n) for each in OTHERWISE):
            return _python(after, given, n, into)
        case [ast.If(test=test, body=yes, orelse=no), *after]:
            sides = (_python([*side, *after], given, n, into) for side in (yes, no))
            return into.choice(_test(test, given, n), *sides)
        case _:
            raise Unreadable(f"a statement of Python: {ast.unparse(rest[0])[:60] if rest else 'none'}")


def _test(test: ast.expr, given: str, n: int) -> str:
    """The comparison of a number of the observation, which is read as PLAIN or NUMBER says, with a constant."""
    match test:
        case ast.Compare(left=ast.IfExp() | ast.Subscript() as left, ops=[sign], comparators=[to]) if (
            type(sign) in _COMPARE
        ):
            text = ast.unparse(left)
            plain, read = PLAIN.fullmatch(text), NUMBER.fullmatch(text)
            whole, place = plain.groups() if plain else read.groups()[2:4] if read else ("", "")
            names = set(read.group(1, 2, 5)) if read else {"v"}
            if whole != given or len(names) > 1 or names & {given, *BUILT_IN}:
                raise Unreadable(f"a number of Python: {text[:60]}")
            if int(place) < n:
                (bits,) = struct.unpack("<Q", struct.pack("<d", _double(to)))
                return f"({_COMPARE[type(sign)]} d{int(place)} ((_ to_fp 11 53) #x{bits:016x}))"
        case _:
            pass
    raise Unreadable(f"a test of Python: {ast.unparse(test)[:60]}")


def _double(item: ast.expr) -> float:
    """A float constant, with its sign."""
    match item:
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=float(number))):
            return -number
        case ast.Constant(value=float(number)):
            return number
        case _:
            raise Unreadable(f"a threshold of Python: {ast.unparse(item)[:60]}")
