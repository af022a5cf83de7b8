"""The texts of certificates, and proofs as bytes.

Does: writes what the checker reads.
Assumes: nothing; what is written is believed once the checker has read it.
Does not: belong to what must be right for a certificate to mean something.
"""
