"""Glances: what tells of nearly all states, by few numbers, that they are in a list of a monitor.

Does: makes them of turned boxes and of lists of boxes.
Assumes: lists of which something is proved.
Does not: refuse a state: of whoever does not pass, the list itself is asked.
"""
