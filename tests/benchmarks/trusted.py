"""How many lines must be right for a certificate, today and at the commit of the review that asked for 500 fewer.

    python -m tests.benchmarks.trusted [--then COMMIT] [--json]

Lines are counted as in the table of `verify/checker/README.md`: all lines of the modules that reports list. Beside the
whole stands what is left without the kinds that the review did not know: sums and outputs, claims for ever, some claims
over observations. Of these only whole modules and whole definitions are taken away; the lines that they need elsewhere
stay. With --then, the command asks git whether none of them was there, and counts that
commit's base again.
"""

import argparse
import ast
import json
import re
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

from verify.reports import trusted

ROOT = Path(__file__).parents[2]
REVIEWED = {"decisions": 4_294, "episodes": 5_733}  # at 2679a87f
FEWER = 500  # that the review asked for
BASES: Mapping[str, Mapping[str, tuple[str, ...]]] = {"decisions": trusted.DECISIONS, "episodes": trusted.EPISODES}
WHOLE = ("",)  # the module itself
NEW: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "sums and outputs": {
        "codegen.sums": WHOLE,
        "codegen.sum_rules": WHOLE,
        "codegen.form": ("_dump_sum", "_Known", "_sum", "OutputJson"),
        "codegen.ir": ("OutputSpec", "outputs"),
        "codegen.policy_json": ("_summing",),
    },
    "claims for ever": {
        "verify.checker.episodes.forever": WHOLE,
        "verify.claims.episodes": ("StaysIn", "by_edges", "resolve_steps", "describe_broken"),
    },
    "claims over observations": {
        "verify.claims.relations": ("Differ", "Ignores", "Symmetric"),
        "verify.claims.observed": ("Mirrored", "_opposite"),
    },
}


def read_source(module: str, commit: str = "") -> str:
    """The text of a module, as it lies or at a commit."""
    path = f"{module.replace('.', '/')}.py"
    if not commit:
        return (ROOT / path).read_text()
    return subprocess.run(
        ["git", "show", f"{commit}:{path}"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout


def measure_definitions(source: str, names: tuple[str, ...]) -> int:
    """The lines of the definitions of these names, decorators included; one within another counts once."""
    taken = set[int]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name in names:
            assert node.end_lineno is not None
            first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
            taken |= {*range(first, node.end_lineno + 1)}
    return len(taken)


def measure_new(module: str) -> Iterator[tuple[str, int]]:
    """The lines of a module that belong to each new kind."""
    for kind, modules in NEW.items():
        if module in modules:
            source = read_source(module)
            whole = modules[module] == WHOLE
            yield kind, len(source.splitlines()) if whole else measure_definitions(source, modules[module])


def count_then(commit: str) -> dict[str, int]:
    """The bases at a commit. AssertionError where a new definition was there already."""
    lists: dict[str, object] = {}
    exec(read_source("verify.reports.trusted", commit), lists)  # our own file, as it was
    sizes: dict[str, int] = {}
    for base in BASES:
        listed = trusted.modules(lists[base.upper()])  # type: ignore[arg-type]
        sources = {module: read_source(module, commit) for module in listed}
        sizes[base] = sum(len(source.splitlines()) for source in sources.values())
        for modules in NEW.values():
            for module, names in modules.items():
                assert names != WHOLE or module not in sources, module
                package = module.partition(".")[0]
                text = "\n".join(source for each, source in sources.items() if each.startswith(package))
                there = [name for name in names if name and re.search(rf"^\s*(class|def) {name}\b", text, re.MULTILINE)]
                assert not there, (module, there)
    return sizes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--then", metavar="COMMIT", help="count this commit's base, and ask that new kinds are new")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    then = count_then(options.then) if options.then else REVIEWED
    figures: list[dict[str, object]] = []
    for base, rooms in BASES.items():
        modules = trusted.modules(rooms)
        total = sum(len(read_source(module).splitlines()) for module in modules)
        kinds = dict.fromkeys(NEW, 0)
        for module in modules:
            for kind, lines in measure_new(module):
                kinds[kind] += lines
        alike = total - sum(kinds.values())
        figures.append(
            {
                "name": f"trusted lines, {base}, kinds of the review",
                "value": alike,
                "reach": then[base] - FEWER,
                "better": "lower",
            }
        )
        if not options.json:
            fewer = f"{then[base] - alike:,} fewer than {then[base]:,}"
            print(f"{base}: {total:,} lines; {alike:,} without new kinds, {fewer}")
            print("".join(f"  {lines:>5,}  {kind}\n" for kind, lines in kinds.items() if lines), end="")
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
