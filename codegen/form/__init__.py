"""The JSON form: the shape of profiles, their nodes, how texts are laid out, and where a damaged one breaks off.

Does: states the schema, encodes and decodes nodes, writes plain data as text.
Assumes: JSON as RFC 8259 says.
Does not: read a whole profile (policy_json.py).
"""
