"""Environments of other people: found by name, made, and fitted to what a world is made of.

Does: names and makes environments (sources.py); fits them to one form (wrappers.py, spaces.py).
Assumes: a user who names an environment means its code to run.
Does not: play.
"""
