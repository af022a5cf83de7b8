"""Tests of what a tool of others proves: left out, with the reason, where it is not installed."""

import shutil

import pytest

from maviper.compilation import frama_c

installed = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in frama_c.TOOLS), reason=f"no Frama-C here: {frama_c.INSTALL}"
)
