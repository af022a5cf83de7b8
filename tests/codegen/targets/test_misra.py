"""The walk style holds to MISRA C:2012 as far as cppcheck's checker goes, and that checker is awake."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen.importers import scikit
from codegen.targets import emit
from tests.benchmarks.misra import checker, findings
from tests.support.games import NAMES, random_profile
from tests.support.tiers import first_of


@pytest.fixture(autouse=True)
def needs_the_checker():
    if checker() is None:
        pytest.skip("cppcheck with its add-on misra.py is not installed")


def header(profile, style):
    return next(iter(emit(profile, ["c"], style=style).values()))


def uneven():
    """A classifier's tree, deep on one side only, whose table is not the complete one."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(100, 3)).astype(np.float32) ** 3
    return scikit.from_sklearn(DecisionTreeClassifier(random_state=0).fit(x, np.arange(100) % 4))


@pytest.mark.parametrize("style", first_of(1, ["walk", "nested", "ordered"]))
def test_the_checker_sees_what_is_planted_into_a_header(style, profile):
    """And nothing else in a team that walks."""
    text = header(profile, style)
    clean = findings(text)
    assert style != "walk" or clean == {}
    planted = (
        "static inline int planted(int a)\n{\n    if (a & 1) {\n        return 0;\n    }\n    return a;\n}\n\n#endif"
    )
    found = findings(text.replace("#endif /*", f"{planted} /*"))
    assert len(found["15.5"]) == len(clean.get("15.5", [])) + 1
    assert "if (a & 1) {" in found["14.4"][-1] and "14.4" not in clean


def test_a_header_that_the_checker_cannot_read_is_no_clean_header(profile):
    text = header(profile, "walk").replace("#ifdef FLT_RADIX", "#ifndef FLT_RADIX")
    with pytest.raises(RuntimeError, match="cppcheck did not read"):
        findings(text)


@pytest.mark.parametrize("name", first_of(1, NAMES[::2]))
def test_random_teams_of_every_game_walk_without_findings(name):
    assert findings(header(random_profile(name), "walk")) == {}


def test_a_deep_tree_walks_without_findings():
    assert findings(header(uneven(), "walk")) == {}
