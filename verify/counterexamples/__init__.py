"""Counterexamples: a state or episode in which a claim fails, and why it fails there.

Does: finds states that replay, shrinks them, explains them.
Assumes: a violation found by an engine.
Does not: decide claims.
"""
