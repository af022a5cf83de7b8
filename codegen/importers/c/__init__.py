"""Importing C: our own header, and C of others.

Does: header.py reads what `maviper compile` writes. text.py expands macros; source.py chooses the functions that decide
  and follows each: statements.py, expressions.py and objects.py interpret, arithmetic.py computes with features.
Assumes: what pcpp and pycparser read is what a compiler reads.
Does not: run a compiler, or anything of a file.
"""
