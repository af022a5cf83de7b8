"""The command line: one file for commands that belong together.

Does: parses, calls the library, prints.
Assumes: every command is also a function of `maviper`.
Does not: compute anything.
"""
