"""The standing hunt for false words of the verifier: see tests/hunt.py."""
