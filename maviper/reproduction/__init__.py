"""Grids of cells: comparisons on a user's own expert, and the paper's experiments with what they say about its claims.

Does: plans, makes and keeps cells (grid.py); writes the table of a comparison (compare.py, compared.py), and a report
  with verdicts on the paper's claims (run.py, report.py).
Assumes: experts, extraction and evaluation as they stand; nothing is done here in another way than a user would.
Does not: print (cli/start.py does).
"""
