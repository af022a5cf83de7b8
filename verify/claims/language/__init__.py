"""What texts of the language state as claims: formulas over coordinates, observations or stated variables.

Does: gives the formula of a text.
Assumes: a vocabulary of coordinates, agents and entities.
Does not: parse (verify.language), or run what it reads.
"""
