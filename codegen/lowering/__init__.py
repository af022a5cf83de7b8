"""Lowering: from a profile to the last level before text.

Does: deploys grown trees, simplifies trees, names everything, renders templates.
Assumes: a checked profile.
Does not: emit a language of its own.
"""
