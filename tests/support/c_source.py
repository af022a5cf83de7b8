"""What several tests use of `codegen.importers.c.test_source`."""

import ctypes
import shutil
import subprocess

import numpy as np

COMPILER = shutil.which("cc") or shutil.which("gcc")


def compiled(text, folder):
    """The functions of a text of C."""
    (folder / "tree.c").write_text(text)
    library = folder / "tree.so"
    subprocess.run([COMPILER, "-std=c99", "-O1", "-shared", "-fPIC", "-o", library, folder / "tree.c"], check=True)
    return ctypes.CDLL(str(library))


def scores(function, rows, n_scores):
    """The places of the largest scores that a function copies to its output for each row."""
    taken = np.zeros(n_scores)
    found = []
    for row in np.ascontiguousarray(rows, dtype=np.float64):
        function(*(each.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for each in (row, taken)))
        found.append(int(taken.argmax()))
    return found
