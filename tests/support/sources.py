"""The modules of this repository, each read, parsed and walked once in a process."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("codegen", "maviper", "verify")


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a file; who asks does not change it."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a file's syntax tree, as `ast.walk` gives them."""
    return tuple(ast.walk(parsed(path)))


@cache
def functions_of(path: Path) -> tuple[ast.FunctionDef | ast.AsyncFunctionDef, ...]:
    """The functions among them, methods and inner ones included."""
    return tuple(node for node in nodes_of(path) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


@cache
def modules(*packages: str) -> dict[str, Path]:
    """Name -> file, of all packages where none is named."""
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for package in packages or PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }
