"""House rule: a function is a verb with an object; no parameter is called `found`, and no local that lives longer."""

import ast
import re
from pathlib import Path

from tests.support.sources import functions_of, nodes_of

ROOT = Path(__file__).parent.parent
MODULES = sorted(path for package in ("codegen", "maviper", "verify") for path in (ROOT / package).rglob("*.py"))
# participles that do not end in -ed; those spelt like their verb (bound, cut, put, read, run, set, split) are verbs
IRREGULAR = re.compile(
    "bent|borne|bought|broken|brought|built|caught|chosen|dealt|drawn|driven|fed|felt|found|frozen|given|gone|grown|held|"
    "hidden|kept|known|laid|led|lent|lost|made|meant|met|paid|rebuilt|redrawn|retold|rewritten|said|seen|sent|shaken|shown|"
    "shrunk|sold|spent|spoken|spun|stolen|struck|swept|taken|taught|thought|told|torn|understood|undone|withdrawn|won|worn|"
    "wound|woven|written"
)
VERBS_IN_ED = {"embed", "exceed", "feed", "need", "proceed", "seed"}
PROPERTIES = {"property", "cached_property", "setter"}  # which say what something is
# adjectives of what is returned, a term of Gymnasium, and a name that users hold
KEPT = {"_named_tuple", "deployed_facts", "fitted_q", "printed", "released_code", "squared_distances", "terminated"}
LONG = 5


def named_by_a_participle(name):
    first = name.strip("_").split("_")[0]
    return bool(IRREGULAR.fullmatch(first)) or (first.endswith("ed") and first not in VERBS_IN_ED)


def decorators(node):
    return {ast.unparse(each).split("(")[0].split(".")[-1] for each in node.decorator_list}


def test_the_rule_reads_names():
    assert named_by_a_participle("_checked") and named_by_a_participle("told_apart")
    assert not named_by_a_participle("check_cover") and not named_by_a_participle("seed_all")


def test_a_function_is_a_verb():
    participles = [
        f"{path.relative_to(ROOT)}: {each.name}"
        for path in MODULES
        for each in functions_of(path)
        if named_by_a_participle(each.name) and not decorators(each) & PROPERTIES and each.name not in KEPT
    ]
    assert len(MODULES) > 400 and not participles, "name these by what they do"


def test_locals_have_names_of_the_domain():
    long = [
        f"{path.relative_to(ROOT)}: {each.name}, line {min(lines)}"
        for path in MODULES
        if any(isinstance(each, ast.Name) and each.id == "found" for each in nodes_of(path))
        for each in functions_of(path)
        if (lines := lines_of_found(each)) and max(lines) - min(lines) > LONG
    ]
    assert not long


def test_parameters_have_names_of_the_domain():
    taken = [
        f"{path.relative_to(ROOT)}, line {each.lineno}"
        for path in MODULES
        for each in nodes_of(path)
        if isinstance(each, ast.arg) and each.arg == "found"
    ]
    assert not taken


def lines_of_found(function):
    """Where a function names a local `found`."""
    names = [name for name in ast.walk(function) if isinstance(name, ast.Name) and name.id == "found"]
    return [name.lineno for name in names] if any(isinstance(name.ctx, ast.Store) for name in names) else []
