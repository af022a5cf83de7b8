"""Experts that ship with the package, as safetensors files; each carries its card.

Does: holds the files.
Assumes: `maviper.experts.network` reads them.
Does not: contain code.
"""
