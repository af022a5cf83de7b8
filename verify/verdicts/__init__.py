"""Verdicts: from a question to a verdict that carries its evidence.

Does: asks the engines, compares their answers, confirms counterexamples, runs the shuffled control.
Assumes: a checked profile; replays are handed in.
Does not: print or write files.
"""
