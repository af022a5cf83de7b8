"""The compiler: the policy IR, its JSON form, and the code generators.

Does: owns the one central noun (`codegen.ir`) that everything else produces or reads.
Assumes: nothing of the packages above it.
Does not: import `verify` or `maviper`.
"""
