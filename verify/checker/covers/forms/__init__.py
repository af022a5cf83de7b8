"""Covers by affine forms: sets of states that depend on the start.

Does: the same as the boxes of covers/ (sweep.py), with sets (arrays.py) that do not widen where boxes do, by their own
  tests (cuts.py) and moves (moves.py).
Assumes: a profile and a system that are well formed.
Does not: read certificates.
"""
