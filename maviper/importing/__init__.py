"""Importing: trees of other programs, as profiles of their own or of a game's agents.

Does: reads files through `codegen.importers`; ties features and actions to those of a world.
Assumes: nothing about the files.
Does not: run anything that a file holds, but if/else Python and C, to compare them with what was read.
"""
