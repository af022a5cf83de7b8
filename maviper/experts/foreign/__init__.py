"""Experts of other libraries, from files of weights: stable-baselines3, CleanRL, plain torch.

Does: reads weights (weights.py), recognises what they are (libraries.py), plays them in numpy (layers.py).
Assumes: fully connected networks over an agent's own observation, one number for each action.
Does not: open pickled parts of a file, or need the library that wrote it.
"""
