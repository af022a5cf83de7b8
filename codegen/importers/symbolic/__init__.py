"""A program followed along all of its paths, whatever language it is written in: the core of the importers of code.

Does: feature.py says where a test of one number turns, and what a sum of several is; paths.py follows a program for its
  tree and makes an origin of it.
Assumes: a front end that evaluates statements and asks `Growth.holds` wherever a test of a feature decides.
Does not: know a language, run anything, or answer for a source: Python and the compiler do.
"""
