"""Boxes: of observations that reach a node of a tree, of world states that a region lets pass.

Does: finds and checks them.
Assumes: checked profiles.
Does not: belong to what proofs rest on.
"""
