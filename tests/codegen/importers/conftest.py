"""Libraries whose trees are imported; a test that asks for one that is not installed is skipped."""

import pytest


@pytest.fixture(scope="session")
def xgboost():
    return pytest.importorskip("xgboost", reason="xgboost is not installed")


@pytest.fixture(scope="session")
def lightgbm():
    return pytest.importorskip("lightgbm", reason="lightgbm is not installed")
