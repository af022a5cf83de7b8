"""Agreement: generated code decides as the profile, shown by replay.

Does: compiles, reads back and replays every target at every boundary; writes test vectors.
Assumes: emitted files.
Does not: prove anything for all observations.
"""
