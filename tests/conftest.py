"""Fixtures that many tests share: the shipped expert and a small profile extracted from it."""

import pytest
from hypothesis import settings

from codegen import ir
from codegen.selfcheck import find_compiler

settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=40)
settings.load_profile("repeatable")


def pytest_runtest_setup(item):
    if item.get_closest_marker("compile") and find_compiler() is None:
        pytest.skip("no C compiler (cc, gcc, clang or $CC)")
    if item.get_closest_marker("train"):
        pytest.importorskip("torch", reason="the extra maviper[train] is not installed")


@pytest.fixture(scope="session")
def world():
    from maviper.worlds import find

    return find("physical-deception")


@pytest.fixture(scope="session")
def expert():
    from maviper.experts import store

    return store.load("physical-deception")[0]


@pytest.fixture(scope="session")
def profile(world, expert) -> ir.PolicyProfile:
    """A real profile, extracted quickly: few iterations, depth 3."""
    from maviper.extract.maviper import Settings, extract

    return extract(world, expert, Settings(max_depth=3, iterations=4, rollouts=30, selection_episodes=30))
