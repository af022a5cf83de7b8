"""Continuous time for the checker: enclosures of all states of a flow, period by period.

Does: reads certificates of claims about flows, and shows each claim again by interval Taylor steps of its own.
Assumes: a profile and a system that were read and checked.
Does not: look for how to cut or integrate; it knows no engine and trusts no integrator.
"""
