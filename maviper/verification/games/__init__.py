"""Claims about games of teams that test sums, as world files: what the engine for stated systems decides.

Does: observing.py states what agents observe, decisions.py the claims, searching.py finds states of the game.
Assumes: features with meanings; agents that take actions.
Does not: decide.
"""
