"""The verifier: claims about a team of tree policies over world states, decided for the deployed arithmetic.

Does: properties, regions, exact encodings, verdicts, counterexamples and reports.
Assumes: a checked profile of `codegen.ir` whose features have meanings.
Does not: import `maviper`; simulators and compiled code are handed in as functions.
"""
