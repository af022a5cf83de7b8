"""Importing C: our own header, and if/else C of others.

Does: header.py reads what `maviper compile` writes; source.py reads functions of ifs, from the text that text.py leaves
  of a file, with the numbers of numbers.py; meaning.py follows the same syntax tree for the replay.
Assumes: what pycparser reads is what a compiler reads.
Does not: run a compiler or a preprocessor.
"""
