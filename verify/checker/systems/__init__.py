"""The checker of proofs about stated systems.

Does: reads the certificate (certificates.py), reads system and trees (reading.py, rows.py, trees.py), walks the proof
  (walk.py), and shows enclosures again (enclosures.py).
Assumes: a profile and a system that are well formed.
Does not: find proofs.
"""
