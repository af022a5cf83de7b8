"""Training of experts: everything that needs torch.

Does: MAPPO, MADDPG, VDN, imitation and critics; keeps the best checkpoint.
Assumes: the extra `maviper[train]`.
Does not: play or measure by itself.
"""
