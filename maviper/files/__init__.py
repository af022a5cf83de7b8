"""Files: run folders, profiles and regions on disk.

Does: reads and writes atomically, with clear errors.
Assumes: paths from the caller.
Does not: know what a file means beyond its form.
"""
