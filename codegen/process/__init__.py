"""What belongs to the whole process: floating-point flags and filters of warnings, stated or held aside for a call.

Does: flags.py states what NumPy does at an underflow or a NaN; unwarned.py keeps warnings off the screen.
Assumes: callers that others run beside.
Does not: change anything for good.
"""
