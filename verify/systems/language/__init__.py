"""The language of world's files: units, expressions, and the text that states them.

Does: reads sums, products, sin, cos and clip of variables, with units.
Assumes: names are given with their units.
Does not: run what it reads.
"""
