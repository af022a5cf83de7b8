"""Importers: trees of others as profiles, exact or refused.

Does: reads if/else programs, scikit-learn estimators and ONNX models; replays each against where it comes from.
Assumes: files that nobody vouches for.
Does not: run a file, or open a pickle.
"""
