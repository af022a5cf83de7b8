"""Reports: results as JSON, text and HTML.

Does: says what a result holds, in the words of the manual.
Assumes: results of `verify.verdicts`.
Does not: decide or measure anything.
"""
