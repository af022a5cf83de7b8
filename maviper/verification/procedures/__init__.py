"""Procedures: what each kind of claim needs beside its verdict.

Does: one module for each kind, and the table of them.
Assumes: verdicts of `verify`.
Does not: decide.
"""
