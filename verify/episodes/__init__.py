"""The engine for claims about episodes: all starts of a region are followed as zones.

Does: unrolls trees and dynamics, splits zones by decisions, closes the branches in which a claim holds.
Assumes: agents start at rest.
Does not: import Z3 or play episodes.
"""
