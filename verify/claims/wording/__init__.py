"""What engines, files, reports and the referee read of claims, and no certificate needs.

Does: claims that no certificate names, the start region, profiles with their views, values of formulas.
Assumes: the modules beside this folder, which say what claims mean.
Does not: belong to what proofs rest on. A contract of imports keeps the checker from it.
"""
