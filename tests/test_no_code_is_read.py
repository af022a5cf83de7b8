"""Nothing that we read can run code: what loads or runs code stands in a table, each place with its reason."""

import ast
from pathlib import Path

import pytest

from tests.support.sources import nodes_of

ROOT = Path(__file__).parent.parent
PACKAGES = ("codegen", "maviper", "verify")
MODULES = ("pickle", "cPickle", "dill", "cloudpickle", "marshal", "shelve", "runpy", "code", "yaml", "imp")
NAMES = ("eval", "exec", "compile", "__import__")  # the built-in functions
METHODS = ("exec_module", "load_module", "run_path", "run_module", "load_pickle", "read_pickle")
LOADERS = {"np.load", "numpy.load", "joblib.load", "torch.load", "torch.jit.load", "torch.hub.load"}
ALLOWED: dict[tuple[str, str], str] = {
    ("codegen/importers/python/source.py", "compile"): "checks the grammar; what it gives is thrown away, never run",
    ("codegen/importers/running/child.py", "compile"): "if/else Python that passed the gate, in a process of its own",
    ("codegen/importers/running/child.py", "exec"): "the same; SECURITY.md says under which limits",
    ("codegen/importers/running/child.py", "import_module"): "modules of the gate's table, by name; numpy; the gate",
    ("codegen/agreement/readback.py", "import_module"): "jax or torch, by its name in the sources",
    ("codegen/agreement/readback.py", "runpy"): "code that this very run has generated, to compare it with the trees",
    ("codegen/agreement/readback.py", "runpy.run_path"): "the same",
    ("codegen/importers/reading.py", "import_module"): "a reader of this package, by its name in the sources",
    ("verify/reports/report.py", "import_module"): "the report of a kind of claims, by its name in the sources",
    ("maviper/__init__.py", "import_module"): "modules of this package, by their names in the sources",
    ("maviper/worlds/outside/making.py", "import_module"): "user code that the user names on the command line",
}

STARTERS = ("subprocess", "multiprocessing", "codegen.agreement.programs")
STARTS: dict[str, str] = {
    "codegen/agreement/programs.py": "what others name, with a limit of time",
    "codegen/agreement/compiled.py": "a compiler, of code that this very run has generated",
    "codegen/agreement/readback.py": "interpreters, of code that this very run has generated",
    "codegen/importers/c/compiled.py": "the C preprocessor on an imported file, and C that was accepted, with limits",
    "codegen/importers/running/asking.py": "Python, of a source that passed the gate",
    "maviper/compilation/proofs.py": "Frama-C, of code that this very run has generated",
    "maviper/verification/bench.py": "none itself: it asks whether there is a compiler",
    "maviper/worlds/outside/processes.py": "copies of an environment that the user names on the command line",
}


def dotted(node):
    """`a.b.c` of an expression; nothing of any other."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def safe_load(called, call):
    """Arrays are read by np.load, which refuses objects unless it is asked."""
    given = {one.arg: one.value for one in call.keywords}
    allow = given.get("allow_pickle")
    return (
        called in ("np.load", "numpy.load")
        and None not in given
        and (len(call.args) <= 2 and (allow is None or (isinstance(allow, ast.Constant) and allow.value is False)))
    )


def running(nodes):
    """What in a source can run code that is read: names, each as often as it stands there. `nodes`: of its syntax."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (one.name for one in node.names if one.name.split(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom):
            yield from ([node.module] if (node.module or "").split(".")[0] in MODULES else [])
            yield from (one.name for one in node.names if f"{node.module}.{one.name}" in LOADERS)
        elif isinstance(node, ast.Call):
            called = dotted(node.func)
            last = called.rpartition(".")[2]
            if called in NAMES or last in METHODS or (called in LOADERS and not safe_load(called, node)):
                yield called
            elif last == "import_module" and not all(isinstance(one, ast.Constant) for one in node.args):
                yield last


def test_nothing_that_we_read_can_run_code():
    found = set()
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            found |= {(path.relative_to(ROOT).as_posix(), name) for name in running(nodes_of(path))}
    assert found == set(ALLOWED), sorted(found ^ set(ALLOWED))


def test_what_starts_programs_stands_in_a_table():
    found = set()
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            for node in nodes_of(path):
                names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
                names += [f"{node.module}.{one.name}" for one in node.names] if isinstance(node, ast.ImportFrom) else []
                found |= {path.relative_to(ROOT).as_posix() for name in names if name.startswith(STARTERS)}
    assert found == set(STARTS), sorted(found ^ set(STARTS))


@pytest.mark.parametrize(
    "source",
    [
        *("import pickle", "from pickle import loads", "import yaml", "from numpy import load", "eval(text)"),
        *("exec(text)", "np.load(path, allow_pickle=True)", "np.load(path, allow_pickle=asked)"),
        *("np.load(path, None, True)", "np.load(path, **given)", "torch.load(path)", "joblib.load(path)"),
        *("torch.load(path, weights_only=True)", "spec.loader.exec_module(made)", "importlib.import_module(name)"),
    ],
)
def test_what_runs_code_is_seen(source):
    assert list(running(ast.walk(ast.parse(source))))


@pytest.mark.parametrize("source", ["np.load(path)", "re.compile(text)", "import_module('onnx')"])
def test_what_runs_none_is_left_alone(source):
    assert not list(running(ast.walk(ast.parse(source))))
