"""What is told of a profile whose JSON form cannot be decoded.

Does: makes the error, with the path of the fault.
Assumes: a text from outside in the message was escaped.
Does not: find where a text breaks off (breaks.py).
"""

from codegen.errors import ProfileError

INVALID = "not a valid policy profile"
ADVICE = "extract it again, or undo the edit"


def make_fault(where: str, advice: str = ADVICE) -> ProfileError:
    """The error for a damaged profile; `where`: the path, and what is wrong there."""
    return ProfileError(INVALID, where, advice)
