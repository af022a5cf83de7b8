"""Compilation: from a profile to code that was replayed against it.

Does: joins emitters, agreement, proofs and passes with on-policy episodes.
Assumes: a checked profile.
Does not: emit text itself.
"""
