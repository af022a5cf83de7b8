"""Evaluation: how good a team is, beside its expert and against others.

Does: cross-play, fidelity, comparison of two profiles, players by name.
Assumes: episodes of `maviper.episodes`.
Does not: learn.
"""
