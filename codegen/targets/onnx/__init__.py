"""ONNX: a model for each agent, for runtimes that load files.

Does: model.py makes the files; ensembles.py writes trees as either operator of ai.onnx.ml, sums.py the nodes that add.
Assumes: the package onnx; a runtime with ai.onnx.ml that keeps subnormal numbers (onnxruntime does, unless told to set
  denormals to zero).
Does not: import onnx before a file is asked for.
"""
