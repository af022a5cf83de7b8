"""Who is asked about an arithmetic hands it on: no call of what takes `semantics`, the question first of all, leaves
it out.
"""

import ast
from functools import cache

from tests.support.sources import modules, parsed

MODULES = modules("verify", "maviper")
NAMED = {"semantics", "_semantics", "arithmetics", "MACHINE", "REAL"}  # what says which arithmetic a call is about
# functions of the deployed arithmetic: what they find, say or write is about that one alone
DEPLOYED = {
    "verify.states.shares._mistakes",
    "verify.solver.leaves.dead_leaves",  # what code may leave out
    "verify.states.episodes.play",
    "maviper.evaluation.comparison._exactly",
    "maviper.evaluation.comparison.differing",
    "maviper.verification.robust._question",
    "maviper.extraction.refitting._outcome",
    "maviper.verification.repair.repair_profile",
    "maviper.verification.repair._files",
}
OTHERWISE = {
    "verify.solver.encode.region_only",  # of no tree
}


def functions(tree):
    """(name, node) of every function of a module; methods by their own names, constructors by their classes'."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        if isinstance(node, ast.ClassDef):
            for inner in node.body:
                if isinstance(inner, ast.FunctionDef):
                    yield node.name if inner.name == "__init__" else f"{node.name}.{inner.name}", inner


def takes_semantics(node):
    arguments = node.args
    return any(argument.arg == "semantics" for argument in (*arguments.args, *arguments.kwonlyargs))


@cache
def asked():
    found = {
        f"{module}.{name}"
        for module, path in MODULES.items()
        for name, node in functions(parsed(path))
        if takes_semantics(node)
    }
    return found | {"verify.question.Question"}  # whose constructor is a dataclass's


def imported(module, tree):
    """Name in a module -> what it stands for, dotted."""
    found = {name: f"{module}.{name}" for name, _ in functions(tree)}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
    return found


def called(node, names):
    if isinstance(node.func, ast.Name):
        return names.get(node.func.id, "")
    if isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name):
        return f"{names.get(node.func.value.id, '')}.{node.func.attr}"
    return ""


def says(node):
    """Whether a call names the arithmetic."""
    parts = [part for given in (*node.args, *(one.value for one in node.keywords)) for part in ast.walk(given)]
    words = {part.id for part in parts if isinstance(part, ast.Name)}
    words |= {part.attr for part in parts if isinstance(part, ast.Attribute)}
    words |= {str(part.value) for part in parts if isinstance(part, ast.Constant)}  # options["semantics"]
    return bool(words & NAMED)


def silent_calls(module):
    tree = parsed(MODULES[module])
    names = imported(module, tree)
    for name, function in functions(tree):
        for node in ast.walk(function):
            if isinstance(node, ast.Call) and called(node, names) in asked() and not says(node):
                yield f"{module}.{name}", called(node, names)


def test_the_functions_are_found():
    assert {
        "verify.states.state.leaf_at",
        "verify.states.noise.reachable",
        "verify.solver.encode.reaching",
        "verify.question.from_start",
        "maviper.verification.bench.replay_state",
    } <= asked()


@cache
def silent():
    """All calls that say no arithmetic: (caller, callee)."""
    return [call for module in MODULES for call in silent_calls(module)]


def test_the_arithmetic_is_handed_on():
    unexpected = [(caller, callee) for caller, callee in silent() if caller not in DEPLOYED | OTHERWISE]
    assert not unexpected, unexpected


def test_what_is_of_the_deployed_arithmetic_alone_takes_no_other():
    assert not asked() & DEPLOYED
    assert {caller for caller, _ in silent()} == DEPLOYED | OTHERWISE
