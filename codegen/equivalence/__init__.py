"""Equivalence: generated code decides as the tree for all observations.

Does: reads C and Python from their text, walks them against the tree, states proof obligations for a solver.
Assumes: emitted files.
Does not: run code or call a solver.
"""
