"""A program followed along all of its paths, whatever language it is written in: the core of the importers of code.

Does: feature.py says where a test of one number turns; paths.py follows a program for its tree; program.py makes an
  origin of it; replay.py asks the program once more.
Assumes: a front end that evaluates statements and asks `Paths.holds` wherever a test of a feature decides.
Does not: know a language, or run anything.
"""
