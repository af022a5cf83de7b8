"""Claims for ever, answered; invariants given to the checker; a room with a heater."""

from fractions import Fraction as F

from codegen.policy_json import content_hash
from tests.support.altered import of_hashes
from tests.support.system_cases import box, decided, form, policy, team
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Invariant
from verify.question import Budgets
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, Piece, System, Variable


def always(steps=60, **bounds):
    return SystemClaim(Pattern.ALWAYS, (box(**bounds),), steps)


def thermostat():
    """A room loses a tenth of its warmth beyond 10 degrees a step, and a heater gives 2 degrees below 19."""
    warm = Variable("warm", "1", (F(0), F(40)))
    move, heat = {"warm": form(1, warm=F(9, 10))}, {("heater", "on"): {"warm": form(2)}}
    error = {"warm": (F(-1, 10), F(1, 10))}
    features = {"heater": {"t": Feature(form(warm=1))}}
    system = System("room", (warm,), features, box(warm=(15, 25)), (Piece({}, move, heat, error),), 60)
    return system, team(policy("heater", ["t"], ["on", "off"], ((0, 19.0), 0, 1)))


def answered(asked, claim, **budgets):
    system, profile = asked
    (found,) = decided(profile, system, [claim], Budgets(**budgets))
    return found


def any_taken(asked, claim, state, lists):
    """Whether the checker takes one of several lists of parts for an invariant that shows the claim."""
    system, profile = asked
    hashes = content_hash(profile), documents.content_hash(system)
    taken = []
    for parts in lists:
        try:
            taken.append(accept(of_hashes(*hashes, claim, state, Invariant(parts)), profile, system) > 0)
        except RejectedError:
            taken.append(False)
    return any(taken)
