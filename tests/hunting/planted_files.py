"""Ways in which the answer to a claim may depend on the others of its file, each of which the hunt must notice.

Does: patches what answers the claims of a world file.
Assumes: pytest's monkeypatch, or anything with its `setattr`.
Does not: look for them.
"""

from maviper.verification.stated import StatedWorld
from verify.reach import decide

Known = list[tuple[object, object]]  # of a system what its first claim left


def _equal(patch):
    """Claims that are equal but for labels and invariants have the answer of the first."""
    answer = StatedWorld.answer

    def of_first(self, question, beside=True):
        return answer(self, next(each for each in self._questions if each.claim == question.claim), beside)

    patch.setattr(StatedWorld, "answer", of_first)


def _witness(patch):
    """The start that shows that there is one is asked of the first claim about episodes."""
    inhabitant, made, known = decide.inhabitant, decide.ClaimSearch.__init__, Known()

    def noted(self, *given):
        made(self, *given)
        if not self.claim.about_decisions:
            _first(known, self.system, self.claim)

    patch.setattr(decide.ClaimSearch, "__init__", noted)
    patch.setattr(decide, "inhabitant", lambda system, claim: inhabitant(system, _first(known, system, claim)))


def _budget(patch):
    """All claims share one budget."""
    made, known = decide.ClaimSearch.__init__, Known()

    def shared(self, *given):
        made(self, *given)
        self.spending = _first(known, self.system, self.spending)

    patch.setattr(decide.ClaimSearch, "__init__", shared)


def _first(known, system, value):
    """The value that was first named with a system."""
    known.append((system, value))
    return next(kept for one, kept in known if one is system)


FAULTS = {"equal claims": _equal, "the first one's start": _witness, "one budget": _budget}
