"""Cells: planned, made, kept in folders, and put into one table.

Does: everything from what is asked for to cells.csv.
Assumes: a folder that all processes see.
Does not: say which processes make cells (reproduction/run.py), or judge claims (reproduction/report.py).
"""
