"""The preset `released`: the authors' published code, its accidents included.

Does: grows and selects trees as that code does.
Assumes: what algorithms.md states of it.
Does not: serve as anything but a comparison.
"""
