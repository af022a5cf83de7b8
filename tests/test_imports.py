"""Imports: no circle of modules, hidden ones included; what is imported is declared."""

import ast
import re
import subprocess
import sys
import tomllib
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import metadata
from pathlib import Path

import grimp

from tests.support.heavy import ASIDE, HEAVY
from tests.support.sources import PACKAGES, functions_of, modules, nodes_of

ROOT = Path(__file__).parent.parent
# load what they do when they are called
VERBS = ("maviper", "maviper.__main__", "maviper.cli", "maviper.importing.verbs")
# asked for where they are missing
EXTRAS = {"dask", "distributed", "docutils", "matplotlib", "onnx", "onnxruntime", "sphinx", "torch", "vmas"}


@cache
def graph():
    """All imports, those for types and in functions too."""
    return grimp.build_graph(*PACKAGES, include_external_packages=True)


def imported(node):
    """The modules that a statement may import."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module:
        return [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return []


def circle(imports):
    """A circle in name -> names, or none."""
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return error.args[1]
    return None


def contracts_of_layers():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    return [each for each in contracts if each["type"] == "layers" and "containers" in each]


def test_the_floors_name_every_room():
    """A new package or module that no floor names fails: somebody decides what it may import."""
    contracts = contracts_of_layers()
    assert {name for each in contracts for name in each["containers"]} >= set(PACKAGES)
    for each in contracts:
        rooms = {room for layer in each["layers"] for room in layer.split(" | ")}
        (container,) = each["containers"]
        children = {name.rpartition(".")[2] for name in graph().find_children(container)}
        assert each.get("exhaustive") and rooms == children, container


def test_no_circle_of_modules():
    found = graph()
    # the verbs of the package itself lead everywhere
    names = {name for name in found.modules if name.split(".")[0] in PACKAGES} - {"maviper"}
    imports = {name: found.find_modules_directly_imported_by(name) & names for name in names}
    assert sum(map(len, imports.values())) > 500 and circle(imports) is None


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}}) and circle({"a": {"b"}, "b": {"c"}}) is None


@cache
def in_functions(path):
    """The imports that stand in functions of a file."""
    functions = [each for each in functions_of(path) if isinstance(each, ast.FunctionDef)]
    nodes = {node for each in functions for node in ast.walk(each)} if imports_of(path) else set()
    return [node for node in imports_of(path) if node in nodes]


@cache
def imports_of(path):
    return [node for node in nodes_of(path) if isinstance(node, ast.Import | ast.ImportFrom)]


@cache
def at_once():
    """What each module imports when it is imported itself, without what its functions import."""
    found = {}
    for name, path in modules().items():
        hidden = set(in_functions(path))
        nodes = [node for node in imports_of(path) if node not in hidden]
        found[name] = {target for node in nodes for target in imported(node)}
    return found


@cache
def loaded(name):
    """Everything that comes with a module."""
    found, open_ = set(), [name]
    while open_:
        new = at_once().get(open_.pop(), set()) - found
        found |= new
        open_ += new
    return found


def hidden_imports(name):
    """What the functions of a module import that is not heavy, and neither aside."""
    if name in VERBS or name.startswith("maviper.cli."):
        return
    for node in in_functions(modules()[name]):
        for target in set(imported(node)) & at_once().keys():
            if isinstance(node, ast.ImportFrom) and any(f"{target}.{each.name}" in at_once() for each in node.names):
                continue  # the package of what is imported
            if target not in ASIDE and not HEAVY & {each.split(".")[0] for each in loaded(target)}:
                yield target


def test_functions_import_only_what_is_heavy_or_aside():
    hidden = [f"{name} imports {target}" for name in modules() for target in hidden_imports(name)]
    assert not hidden, f"in a function, which hides it and saves nothing: {hidden}"


def test_an_extraction_loads_no_solver():
    code = "import sys, maviper.extraction.run; print({'z3', 'jinja2'} & set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert found.stdout == "set()\n"


def test_what_is_imported_is_declared():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = {re.split(r"[^\w.-]", line)[0].lower() for line in project["dependencies"]}
    distributions = metadata.packages_distributions()
    asked = {
        target.split(".")[0] for path in modules().values() for node in imports_of(path) for target in imported(node)
    }
    for module in asked - sys.stdlib_module_names - set(PACKAGES) - EXTRAS:
        assert declared & {name.lower() for name in distributions[module]}, f"{module} is imported and not declared"


def test_benchmarks_know_each_other_by_whole_names():
    """So that `python -m` finds them too."""
    paths = list((ROOT / "tests/benchmarks").glob("*.py"))
    asked = {target for path in paths for node in imports_of(path) for target in imported(node)}
    assert not asked & {path.stem for path in paths}
