"""Claims: what can be said about a team, as formulas over world states and actions.

Does: states, finds, parses and writes claims; states the regions that they are about.
Assumes: a checked profile of `codegen.ir`.
Does not: decide claims, sample states or know an engine.
"""
