"""Repair: trees changed until a claim is proved.

Does: guards the leaves that violate a claim.
Assumes: claims that give each agent a landmark.
Does not: measure what a repair costs in play.
"""
