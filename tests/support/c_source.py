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
    rows, taken = np.ascontiguousarray(rows, dtype=np.float64), np.zeros(n_scores)
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    first, step, output = rows.ctypes.data, rows.strides[0], taken.ctypes.data
    found = []
    for place in range(len(rows)):
        function(first + place * step, output)
        found.append(int(taken.argmax()))
    return found
