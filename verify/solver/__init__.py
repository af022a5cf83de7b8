"""Z3: the only importers of the solver.

Does: encodes queries, asks them, decides claims about single decisions, finds dead leaves.
Assumes: claims and exact thresholds.
Does not: use zones.
"""
