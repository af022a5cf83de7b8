"""The house in figures: how large it is, and what in it a reader may stumble over. A report, no test.

    python -m tests.house [--all]      every line of the lists, not the first ten of each

Does: counts lines, modules, packages, templates and tests; lists what is long or crowded, functions that are no verbs,
  docstrings that do not begin as a sentence, and phrases that readers stumbled over.
Assumes: a person reads it. What must hold is a test (test_house.py, test_imports.py).
Does not: fail.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import click

from maviper.cli.main import cli
from tests.support.sources import functions_of, nodes_of, parsed

ROOT = Path(__file__).parent.parent
PACKAGES = ("codegen", "maviper", "verify")
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
LONG_MODULE, LONG_FUNCTION, LONG_TEMPLATE, MANY_MODULES, MANY_PARAMETERS = 500, 60, 150, 15, 7  # more is listed
SHOWN = 10
# participles that do not end in -ed; those spelt like their verb (bound, cut, put, read, run, set, split) are verbs
IRREGULAR = re.compile(
    "bent|borne|bought|broken|brought|built|caught|chosen|dealt|drawn|driven|fed|felt|found|frozen|given|gone|grown|held|"
    "hidden|kept|known|laid|led|lent|lost|made|meant|met|paid|rebuilt|redrawn|retold|rewritten|said|seen|sent|shaken|shown|"
    "shrunk|sold|spent|spoken|spun|stolen|struck|swept|taken|taught|thought|told|torn|understood|undone|withdrawn|won|worn|"
    "wound|woven|written"
)
VERBS_IN_ED = {"embed", "exceed", "feed", "need", "proceed", "seed"}
NO_SENTENCE = re.compile(r"(As|What|Whether|How|Which|Who)\b")
SUMS = re.compile(r"\.arithmetic\b|\.outputs\b|\.sums\b|summed")
PHRASES = (
    *("ended before the proof did", "start box", "no state is claimed anything of", "could have been seen"),
    *("are against it", "of somebody's own"),
)
PLAIN_S = re.compile(r"len\([a-z_.]+\)(?::,)?\} (?:agents|branches|claims|guards|cells|leaves)\b")  # "1 leaves"


def count_lines(paths: list[Path]) -> int:
    """The lines of files together."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in paths)


def measure() -> dict[str, int]:
    """The sizes of the house."""
    tests = sorted((ROOT / "tests").rglob("*.py"))
    benchmarks = [path for path in tests if "benchmarks" in path.parts]
    pages = [path for path in (ROOT / "templates").rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    docstrings = [text for path in MODULES for text in docstrings_of(path)]
    manual = (ROOT / "maviper" / "manual").glob("*.md")
    commands = [command for chapter in cli.chapters.values() for command in walk(chapter)]
    return {
        "lines of Python in codegen, maviper and verify": count_lines(MODULES),
        "modules": len(MODULES),
        "packages": sum(path.name == "__init__.py" for path in MODULES),
        "lines of templates and of the page's scripts": count_lines(pages),
        "lines of tests": count_lines(tests),
        "lines of benchmarks among them": count_lines(benchmarks),
        "modules that ask about numbers or sums": sum(bool(SUMS.search(path.read_text())) for path in MODULES),
        "docstrings that begin As, What, Whether, How, Which, Who": sum(
            bool(NO_SENTENCE.match(text)) for text in docstrings
        ),
        "words of the manual": sum(len(path.read_text().split()) for path in manual),
        "commands on the first screen": sum(map(len, cli.chapters.values())),
        "options of the command line, deprecated ones apart": sum(map(count_options, (cli, *commands))),
    }


def walk(names: Iterable[str], group: click.Group = cli) -> Iterator[click.Command]:
    """The named commands of a group, and those below them."""
    for command in map(group.commands.__getitem__, names):
        yield command
        yield from walk(command.commands, command) if isinstance(command, click.Group) else ()


def count_options(command: click.Command) -> int:
    """The options that the help of a command shows, --help apart."""
    return sum(isinstance(each, click.Option) and not each.hidden for each in command.params)


def docstrings_of(path: Path) -> Iterator[str]:
    """Those of functions and classes."""
    for node in nodes_of(path):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield ast.get_docstring(node) or ""


def parameters(function: ast.FunctionDef) -> int:
    """How many parameters a function has, without the one that it is bound to."""
    given = function.args
    names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


def is_participle(name: str) -> bool:
    """Whether a function is called by what was done, not by what it does."""
    first = name.strip("_").split("_")[0]
    return bool(IRREGULAR.fullmatch(first)) or (first.endswith("ed") and first not in VERBS_IN_ED)


def lists() -> dict[str, list[str]]:
    """What a reader may stumble over, the worst first."""
    named = [(path.relative_to(ROOT).as_posix(), path) for path in MODULES]
    functions = [(name, node) for name, path in named for node in functions_of(path)]
    lengths = {f"{name}: {node.name}": (node.end_lineno or 0) - node.lineno + 1 for name, node in functions}
    many = {f"{name}: {node.name}": parameters(node) for name, node in functions}
    folders = Counter(str(path.parent.relative_to(ROOT)) for path in MODULES if path.name != "__init__.py")
    templates = {path.relative_to(ROOT).as_posix(): count_lines([path]) for path in (ROOT / "templates").rglob("*.j2")}
    texts = [(name, path.read_text(encoding="utf-8")) for name, path in named]
    return {
        f"modules of more than {LONG_MODULE} lines": rank({n: count_lines([p]) for n, p in named}, LONG_MODULE),
        f"functions of more than {LONG_FUNCTION} lines": rank(lengths, LONG_FUNCTION),
        f"templates of more than {LONG_TEMPLATE} lines": rank(templates, LONG_TEMPLATE),
        f"folders of more than {MANY_MODULES} modules": rank(dict(folders), MANY_MODULES),
        f"functions of {MANY_PARAMETERS} parameters or more": rank(many, MANY_PARAMETERS - 1),
        "modules whose header does not say what they do": [n for n, p in named if not says_what(p)],
        "functions named by a participle": [f"{n}: {each.name}" for n, each in functions if is_called(each)],
        "locals called `found`": [n for n, text in texts if re.search(r"\bfound(: \S+)? = ", text)],
        "phrases that readers stumbled over": [f"{n}: {each}" for n, text in texts for each in PHRASES if each in text],
        "plurals beside a count, without format_count": [n for n, text in texts if PLAIN_S.search(text)],
    }


def rank(sizes: dict[str, int], most: int) -> list[str]:
    """What is larger than `most`, the largest first."""
    return [f"{size:>5}  {name}" for name, size in Counter(sizes).most_common() if size > most]


def says_what(path: Path) -> bool:
    """Whether a module's header says what it does, assumes and does not do."""
    header = ast.get_docstring(parsed(path)) or ""
    return all(f"\n{part}" in header for part in ("Does:", "Assumes:", "Does not:"))


def is_called(function: ast.FunctionDef) -> bool:
    """Whether a participle names a function that is no property."""
    decorators = " ".join(ast.unparse(each) for each in function.decorator_list)
    return is_participle(function.name) and not re.search(r"property|setter", decorators)


def main() -> None:
    """Prints the report."""
    for what, size in measure().items():
        print(f"{size:>9,}  {what}")
    for title, entries in lists().items():
        print(f"\n{title}: {len(entries)}")
        shown = entries if "--all" in sys.argv else entries[:SHOWN]
        print("\n".join(f"  {each}" for each in shown))


if __name__ == "__main__":
    main()
