"""Systems: what a user states about a world of their own, as exact data.

Does: variables, what features measure, and how the state moves in one step.
Assumes: numbers are exact; a decimal means what is written.
Does not: read files, decide or play.
"""
