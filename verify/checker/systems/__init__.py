"""The checker of proofs about stated systems.

Does: reads the certificate (proofs.py), reads system and trees (reading.py, cases.py), follows the branches of a proof
  (branch_proofs.py), and shows enclosures again (enclosures.py).
Assumes: a profile and a system that are well formed.
Does not: find proofs.
"""
