"""A source asked itself: what Python answers where an importer has read it.

Does: gates a source, runs what passes in a process of its own, and asks it at observations.
Assumes: a source that an importer has read.
Does not: share code with the reader whose tree is compared.
"""
