"""Importing Python: files written by hand.

Does: file.py evaluates what stands around functions and finds those that decide; machine.py and its handlers interpret
  them (expressions.py, statements.py, library.py); arithmetic.py makes tests of features; source.py makes trees.
Assumes: Python's own grammar (the module ast).
Does not: run anything of a file.
"""
