"""Claims about games of teams that test sums, as world files: what the engine for stated systems decides.

Does: searching.py and playing.py find states and episodes of the game.
Assumes: features with meanings; agents that take actions.
Does not: decide.
"""
