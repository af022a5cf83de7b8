"""Verification: the verifier joined with simulator, compiled code and environment.

Does: turns options into questions, replays counterexamples, writes certificates and reports, repairs.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: decide verdicts.
"""
