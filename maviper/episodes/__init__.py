"""Episodes: playing teams in batches, and what an episode measures.

Does: plays policies of any kind; measures success, returns and intervals.
Assumes: worlds of `maviper.worlds`.
Does not: learn.
"""
