"""A program followed along all of its paths, whatever language it is written in: the core of the importers of code.

Does: line.py orders floats; feature.py says where a test of one number turns; paths.py follows a program, once for its
  tree and once more for the replay; labels.py orders what it returns; program.py makes an origin of it.
Assumes: a front end that evaluates statements and asks `Paths.holds` wherever a test of a feature decides.
Does not: know a language, or run anything.
"""
