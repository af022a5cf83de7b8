"""Our own C, read back: in every style the trees decide as those that it was made from; other C is refused."""

from pathlib import Path

import numpy as np
import pytest

from codegen import ir, profiles
from codegen.errors import InputError
from codegen.importers.c.header import from_header
from codegen.importers.origin import Names, profile_of
from codegen.targets import emit
from tests.support.games import NAMES, random_profile

TEAM = Path(__file__).parent.parent.parent.parent.parent / "generated" / "physical_deception"


def same(profile, style):
    (header,) = emit(profile, ["c"], style=style).values()
    found = profile_of(from_header(header.encode(), "team.h"), Names())
    rng = np.random.default_rng(0)
    assert len(found.agents) == len(profile.agents)
    for ours, theirs in zip(found.agents, profile.agents, strict=True):
        assert [each.name for each in ours.actions] == [each.name.lower().replace("-", "_") for each in theirs.actions]
        rows = rng.choice(np.append(theirs.tree.threshold, rng.normal(size=9)), (2_000, len(theirs.features)))
        assert (ir.act(ours, rows) == ir.act(theirs, rows)).all()


@pytest.mark.parametrize("style", ["nested", "ordered", "freestanding", "walk"])
def test_the_shipped_team_comes_back(style):
    profile = profiles.loads((TEAM / "profile.json").read_bytes())
    same(profile, style)


@pytest.mark.parametrize("style", ["nested", "ordered", "freestanding", "walk"])
@pytest.mark.parametrize("seed", range(3))
def test_random_teams_come_back(style, seed):
    same(random_profile(NAMES[seed % len(NAMES)], seed), style)


@pytest.fixture(scope="module")
def header():
    return (TEAM / "physical_deception.h").read_text()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("#include <float.h>", "#include <float.h>\n#define x y"),
        ("#include <float.h>", '#include "other.h"'),
        ("_agent_0_act(const float *x)\n{", "_agent_0_act(const float *x)\n{\n    x++;"),
        ("_PROFILE \"", "_PROFIL \""),
        ("return PHYSICAL_DECEPTION_AGENT_0_LEFT;", "return 5;"),
        ("return PHYSICAL_DECEPTION_AGENT_0_LEFT;", "return -1;"),
        ("return PHYSICAL_DECEPTION_AGENT_0_LEFT;", "return 0.0;"),
        ("] <= ", "] < "),
        ("#endif", "#endif }"),
        ("-0x1.a5ff24p-8f", "-0.1f"),  # decimal, which would be read as hexadecimal
        ("_agent_0_act(const float *x)\n{", "_agent_0_act(const float *x)\n{\n    (void)(x++);"),
        ("_agent_0_act(const float *x)\n{", "_agent_0_act(const int *x)\n{"),
        ("_AGENT_0_STAY = 0,", "_AGENT_0_STAY = 1,"),
        ("_AGENT_0_X_GOAL_DX = 0", "_AGENT_0_X_GOAL_DX = 1"),
        ("_AGENT_0_N_ACTIONS = 5", "_AGENT_0_N_ACTIONS = 4"),
        ("if (x[PHYSICAL_DECEPTION_ADVERSARY", "if (y[PHYSICAL_DECEPTION_ADVERSARY"),
    ],
)  # fmt: skip
def test_c_that_is_not_ours_is_refused(header, before, after):
    assert before in header
    with pytest.raises(InputError):
        from_header(header.replace(before, after).encode(), "team.h")


def test_what_is_no_header_is_refused():
    for content in (b"", b"int f(void) { return 0; }", b"\xff\x00", b"{" * 10_000):
        with pytest.raises(InputError):
            from_header(content, "team.h")
