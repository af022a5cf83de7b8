"""Zones: the engine for claims about single decisions.

Does: searches the product of the trees for states that violate a claim, by bounds on differences of coordinates.
Assumes: claims whose atoms bound such differences.
Does not: import Z3.
"""
