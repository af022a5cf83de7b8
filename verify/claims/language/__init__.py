"""The language of formulas: its words, its sums, and the formulas that a text states.

Does: reads formulas of property files.
Assumes: a vocabulary of coordinates, agents and entities.
Does not: run what it reads.
"""
