"""Importing ONNX: a model's one decision tree, and the operators before it.

Does: model.py follows the observation to the label, and makes a profile; columns.py knows the operators before the
  tree, tree.py the attributes of a tree.
Assumes: the package onnx.
Does not: run a model, but for the replay.
"""
