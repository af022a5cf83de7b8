"""Claims for ever: invariants are looked for as cells that grow from the start, and as regions.

Does: nothing itself.
Assumes: nothing.
Does not: import, so that a module loads alone.
"""
