"""The checker of proofs about whole episodes.

Does: reads the certificate (certificates.py), reads the question (reading.py, contact_reading.py), and walks the proof
  (walk.py).
Assumes: a profile that is well formed.
Does not: find proofs.
"""
