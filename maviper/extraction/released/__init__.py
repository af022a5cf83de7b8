"""The preset `released`: the authors' published code, its accidents included.

Does: grows and selects trees as that code does.
Assumes: its accidents are as the manual lists them (`maviper guide extraction`).
Does not: serve as anything but a comparison.
"""
