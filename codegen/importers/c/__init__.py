"""Importing C: our own header, and if/else C of others.

Does: header.py reads what `maviper compile` writes; source.py reads functions of ifs, numbers.py their numbers;
  meaning.py follows the same syntax tree for the replay.
Assumes: what pycparser reads is what a compiler reads.
Does not: run a compiler or a preprocessor.
"""
