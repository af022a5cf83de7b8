"""Extent: where a violated claim fails and where it holds.

Does: lists the failing cells, their exact share, and the largest region found in which the claim is proved.
Assumes: claims about single decisions.
Does not: write reports.
"""
