"""Importing C: our own header, and C of others.

Does: header.py reads what `maviper compile` writes. text.py expands macros; source.py chooses the functions that decide
  and follows each: machine.py and objects.py interpret, arithmetic.py computes with features.
Assumes: what pcpp and pycparser read is what a compiler reads.
Does not: run anything of a file; compiled/ does, to compare.
"""
