"""Reproduction: the paper's experiments as cells, and what they say about its claims.

Does: plans, makes and keeps cells; writes their table, and a report with verdicts on the paper's claims.
Assumes: experts, extraction and evaluation as they stand; nothing is done here in another way than a user would.
Does not: print (cli/start.py does).
"""
