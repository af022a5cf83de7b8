"""Selection: which trees are kept.

Does: plays many trees at once, races iterates, refines the winner by return.
Assumes: trees in the world's order of agents.
Does not: grow trees from data.
"""
