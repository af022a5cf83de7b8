"""The language of formulas, conditions, rules and features: text in, a tree out, and what its sums and units are.

Does: one grammar for claims over world states, over observations and about stated systems, and for world files.
Assumes: whoever reads a tree knows the names in it.
Does not: run what it reads.
"""
