"""C files as libraries that a test calls."""

import ctypes
import subprocess

import pytest

from codegen.agreement.compiled import find_compiler


def library(text, folder):
    compiler = find_compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    (folder / "tree.c").write_text(text)
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-w"]
    subprocess.run([*compiler, *flags, "tree.c", "-o", "tree.so", "-lm"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "tree.so"))
