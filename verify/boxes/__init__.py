"""Boxes: covers of what a stated system can reach, looked for in plain float64.

Does: finds how to cut the start, and in which cells to join boxes, so that a claim is shown (covering.py).
Assumes: systems and claims of `verify.systems`.
Does not: prove. What is found here is computed again, with bounds that hold, by verify/checker/covers.
"""
