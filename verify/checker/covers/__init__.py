"""The checker of covers: boxes and affine forms that hold every state of a stated system, step by step.

Does: sweeps the sets that a certificate names (sweep.py, invariants.py) by tests (boxes.py, trees.py, forms.py) and
  moves (images.py, forms.py), in float64 that is rounded outward (rounding.py).
Assumes: a profile and a system that are well formed.
Does not: find covers, or know how one was found.
"""
