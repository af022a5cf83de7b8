"""Growth: from weighted states to trees.

Does: grows single trees and joint teams, by exact splits or histograms; weighs states.
Assumes: labelled states of `dataset.Dataset`.
Does not: choose among trees.
"""
