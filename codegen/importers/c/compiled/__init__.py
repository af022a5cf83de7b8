"""The second reading of C, by the C compiler itself.

Does: tokens.py compares the preprocessors; unit.py writes what was accepted; builds.py compiles and runs it, and hands
  its answers to the replay.
Assumes: a C compiler; where there is none, nothing is compared, and the profile says so.
Does not: share anything with the reader but the syntax tree.
"""
