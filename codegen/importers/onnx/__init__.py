"""Importing ONNX: a model's one decision tree, and the operators before it.

Does: model.py makes a profile; graph.py follows the observation to the label; columns.py knows the operators before the
  tree, tree.py and ensemble.py the attributes of either operator.
Assumes: the package onnx.
Does not: run a model, but for the replay.
"""
