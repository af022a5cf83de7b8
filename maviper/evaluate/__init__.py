"""Evaluation: episodes and what they are worth.

Does: plays policies of any kind in batches of games and measures their success.
Assumes: worlds of `maviper.worlds`.
Does not: learn.
"""
