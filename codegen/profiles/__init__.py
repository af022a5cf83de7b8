"""Profiles as others hand them in: read from a text, and judged by all rules.

Does: reads a text, and says where it is damaged; asks of a profile what its meaning does not rest on, too.
Assumes: `check` and `policy_json`, on which it rests what a profile means.
Does not: belong to what proofs rest on.
"""
