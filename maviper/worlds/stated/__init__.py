"""Systems that a world file states, in play.

Does: plays a statement as an environment (systems.py) or as it is written (written.py), and measures how far it is from
  the environment that it is about.
Assumes: `verify.systems` reads the files.
Does not: decide claims.
"""
