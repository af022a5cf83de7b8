"""Importing if/else Python: files written by hand.

Does: source.py reads functions, file.py what stands around them; meaning.py follows them as Python would.
Assumes: Python's own grammar (the module ast).
Does not: run anything of a file.
"""
