"""The paper's experiments as one command: cells that are played, a table of them, and the report of its claims.

Does: holds the package.
Assumes: nothing.
Does not: import anything, so that help stays fast.
"""
