"""The checker of covers: boxes that hold every state of a stated system, step by step.

Does: reads the certificate (certificates.py) and sweeps boxes (sweep.py) by tests (cuts.py) and moves (images.py), in
  float64 that is rounded outward (rounding.py).
Assumes: a profile and a system that are well formed.
Does not: find covers, or know how one was found.
"""
