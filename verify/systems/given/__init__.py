"""What agents give and the sums that they test, as proofs about systems read them.

Does: agents.py makes plain agents, played.py joins them with a world file, formulas.py reads what is said of outputs.
Assumes: a checked profile and a file that states its features.
Does not: decide.
"""
