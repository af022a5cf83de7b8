"""What texts of the language state in world files: expressions and half spaces.

Does: reads sums, products and functions of variables, with units.
Assumes: names are given with their units.
Does not: parse (verify.language), or run what it reads.
"""
