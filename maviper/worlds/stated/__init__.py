"""Systems that a world file states, in play.

Does: plays a statement as an environment (systems.py), and measures how far it is from the one that it is about.
Assumes: `verify.systems` reads the files.
Does not: decide claims.
"""
