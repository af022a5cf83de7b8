"""Our games: batched simulators that reproduce the reference environments, one file per game.

Does: holds the games, what they share (particle.py, features.py), and their form for tools of others (exported.py).
Assumes: a game is a class whose constructor's parameters are its options.
Does not: find games by name (maviper.worlds does).
"""
