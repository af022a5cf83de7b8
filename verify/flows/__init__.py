"""Continuous time: looks for episodes that break a claim, and for how to cut and step so that the checker shows it.

Does: plays flows in numpy by a reading of its own; has the checker's sweep try plans; replays episodes in enclosures.
Assumes: a checked profile, system and claim.
Does not: prove. What shows a claim is the checker's sweep (verify/checker/flows), run again on the whole plan.
"""
