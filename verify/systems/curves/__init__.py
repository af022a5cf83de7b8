"""Curves in claims: products, functions and next states of variables, where an enclosure decides them.

Does: formulas without curves that are stronger and weaker than one that has some.
Assumes: a checked statement.
Does not: decide.
"""
