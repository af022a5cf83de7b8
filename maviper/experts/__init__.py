"""Experts: what trees are extracted from.

Does: the numpy network that every shipped expert is, its file format, and the trainer that makes one.
Assumes: discrete actions, vector observations.
Does not: import torch unless training is asked for.
"""
