"""Questions in the languages of other people's tools.

Does: writes VNN-LIB (vnnlib.py).
Assumes: questions are about decisions.
Does not: answer them.
"""
