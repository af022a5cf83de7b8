"""The checker of proofs about single decisions.

Does: reads the certificate (certificates.py), and walks the proof (walk.py).
Assumes: a profile that is well formed.
Does not: find proofs.
"""
