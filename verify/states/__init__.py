"""States: world states, episodes, and shares of sampled states.

Does: observes, samples and plays; evaluates claims at given states: the referee.
Assumes: claims of `verify.claims`.
Does not: decide claims over all states.
"""
