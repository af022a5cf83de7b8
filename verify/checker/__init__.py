"""The checker: accepts a certificate or refuses it, independently of the engines.

Does: derives every constraint again from profile, region and claim, and adds exact numbers.
Assumes: what its README lists is right: the trusted base.
Does not: search, call a solver or import an engine.
"""
