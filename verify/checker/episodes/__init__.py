"""The checker of proofs about whole episodes.

Does: reads certificates and walks their proofs (certificates.py); reads the question (reading.py, contacts.py); asks
  what edges need (unbounded.py).
Assumes: a profile that is well formed.
Does not: find proofs.
"""
