"""Continuous time in world files.

Does: reads flows.
Assumes: a file's variables, constants and agents were read.
Does not: integrate.
"""
