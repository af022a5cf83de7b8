"""Comparing agents that test sums or give numbers: how far apart what they do can be, and where.

Does: cells.py meets the leaves of two trees, extremes.py finds the largest difference in each, compared.py says it.
Assumes: features with ranges.
Does not: prove that two different trees act alike, or make certificates.
"""
