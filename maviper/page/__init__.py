"""The page: one HTML file in which a reader plays a profile.

Does: puts world, trees, claims and generated code into a page.
Assumes: a checked profile.
Does not: decide or extract.
"""
