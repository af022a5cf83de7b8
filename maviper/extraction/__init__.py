"""Extraction: from an expert to a policy profile.

Does: the algorithms of the paper, each a short module in the shape of its pseudocode.
Assumes: an expert whose critics answer for any joint action.
Does not: train experts, generate code or prove anything.
"""
