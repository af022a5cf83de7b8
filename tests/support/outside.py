"""Tests of what a tool of others proves: left out, with the reason, where it is not installed."""

import shutil

import pytest

from maviper.compilation import proofs

installed = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in proofs.TOOLS), reason=f"no Frama-C here: {proofs.INSTALL}"
)
