"""Numbers: floats beside a number, and literals of generated code.

Does: rounds downwards, to the nearest and to neighbours; writes exact literals.
Assumes: floats.py, which says what agents compare.
Does not: belong to what proofs rest on.
"""
