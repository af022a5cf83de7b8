"""Play: episodes that may break claims, many at a time, and counterexamples made smaller.

Does: plays starts in float64 (samples.py); rounds what was found (shrinking.py); follows episodes of rules that are
  not affine in narrow ranges (written.py).
Assumes: systems and claims of `verify.systems`.
Does not: believe what it finds before it is replayed in exact numbers, or in such ranges.
"""
