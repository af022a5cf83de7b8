"""Importing Python: files written by hand.

Does: source.py evaluates what stands around functions, finds those that decide, and makes trees of them; machine.py
  interprets them; library.py computes, and makes tests of features.
Assumes: Python's own grammar (the module ast).
Does not: run anything of a file.
"""
