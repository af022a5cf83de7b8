"""Reachability: deciding claims about stated systems.

Does: proofs with certificates, and exact counterexamples.
Assumes: systems and claims of `verify.systems`.
Does not: measure how far a statement is from a simulator.
"""
