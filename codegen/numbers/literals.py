"""Literals of generated code: texts that every reader decodes to the same float.

Does: exact literals of C, of decimals and of SMT-LIB.
Assumes: finite numbers, but for SMT-LIB.
Does not: round.
"""

import numpy as np

from codegen.floats import short_hex


def hex_literal(threshold: np.float32 | np.float64) -> str:
    """The exact value as a C99 hexadecimal literal of its type: `0x1.99999ap-4f` of float, `0x1.8p-4` of double."""
    return short_hex(float(threshold)) + ("f" if threshold.dtype == np.float32 else "")


def decimal_literal(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    return repr(float(value))


def smt_literal(bits: int) -> str:
    """A Float32 of SMT-LIB by its bits; every NaN is the same one to a solver."""
    if bits & 0x7FFFFFFF > 0x7F800000:
        return "(_ NaN 8 24)"
    return f"(fp #b{bits >> 31:b} #b{bits >> 23 & 0xFF:08b} #b{bits & 0x7FFFFF:023b})"
