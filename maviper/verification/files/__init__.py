"""What verification writes beside its report, and reads again.

Does: writes, checks and replays certificates, counterexamples, failing states and places.
Assumes: answers are there.
Does not: ask questions, or write reports.
"""
