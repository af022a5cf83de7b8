"""Importing C: our own header, and C of others.

Does: header.py reads what `maviper compile` writes. text.py expands macros; source.py chooses the functions that decide
  and follows each: machine.py interprets, arithmetic.py computes with features. compiled.py compares.
Assumes: what pcpp and pycparser read is what a compiler reads, which compiled.py asks.
Does not: run anything of a file elsewhere.
"""
