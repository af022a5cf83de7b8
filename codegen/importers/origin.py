"""A tree of others, read in full, and the profile that is made of one such tree for each agent.

Does: says what every reader hands over; names features and actions; replays each tree before it returns a profile.
Assumes: the reader understood all of its source.
Does not: read any source.

What is kept: the decision for every observation of the numbers that the origin compares, without NaN; `Origin.nan` says
whether also with NaN. Tests are read as doubles, exactly as the origin compares. Where it compares doubles, the agent
does so too. Else, or where float32 is asked for, the doubles are kept in the grown tree, and `lowering/deploy.py`
rounds them down to float32, which changes no decision for a float32 observation.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codegen import ir
from codegen.check import ensure
from codegen.dynamics import motionless
from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers import names, replay
from codegen.ir import MAX_LENGTH, Bool, Floats, GrownTree, Int32
from codegen.lowering.deploy import deployed
from codegen.lowering.render import comment

AGENT, TEAM = "agent_0", "team"
NAN_KEPT, NAN_RIGHT = "decided as in the origin", "goes right, whatever the origin does"


@dataclass(frozen=True)
class Origin:
    """What an agent's tree comes from: its tests, its labels, and how it decides by itself."""

    kind: str  # in words, such as "if/else Python"
    grown: GrownTree  # a leaf's action is the place of its label
    labels: tuple[Any, ...]  # of the actions, in their order
    act: Callable[[Floats], Int32]  # rows [n, n_features] -> the places of the origin's own labels [n]
    replayed_by: str  # who decides in `act`, in words
    features: tuple[str, ...] = ()  # names; (): the origin gives none
    n_features: int = 0  # 0: the origin does not say; then as many as are tested or named
    nan: bool = False  # whether a NaN is decided as in the origin
    finite: bool = False  # whether the origin takes finite numbers only
    takes: Callable[[Floats], Bool] | None = None  # which observations it takes, where not all finite ones
    numbers: str = FLOAT32  # that it compares; what is given to it becomes one of these first
    n_read: int = 0  # features up to the last one that the origin looks at, also in a test that decides nothing


@dataclass(frozen=True)
class Names:
    """Names that the user gives for every agent, instead of the origin's own."""

    features: Sequence[str] | None = None
    actions: Sequence[str] | None = None
    world: str = "imported"


def profile_of(origins: Mapping[str, Origin], given: Names, numbers: str | None = None) -> ir.PolicyProfile:
    """A profile with an agent for each origin, replayed. `numbers`: what agents compare; None: what their origins do.

    InputError for names that do not fit, and for float64 of an origin that compares float32; DisagreementError where a
    tree decides otherwise than its origin.
    """
    agents = names.cleaned(list(origins), "agent")
    policies = [_policy(agent, origin, given, numbers) for agent, origin in zip(agents, origins.values(), strict=True)]
    compared = ", ".join(dict.fromkeys(policy.numbers for policy in policies))
    facts: dict[str, float | int | str] = {"observations": compared}
    for policy, origin in zip(policies, origins.values(), strict=True):
        rows = replay.observations(policy, nan=origin.nan, finite=origin.finite)
        count = replay.replayed(policy, origin.act, rows if origin.takes is None else rows[origin.takes(rows)])
        facts |= {f"{policy.agent} from": comment(origin.kind), f"{policy.agent} replayed": count}
        facts[f"{policy.agent} replayed by"] = comment(origin.replayed_by)
        facts[f"{policy.agent} NaN"] = NAN_KEPT if origin.nan else NAN_RIGHT
    kinds = ", ".join(dict.fromkeys(origin.kind for origin in origins.values()))
    provenance = ir.Provenance("imported", "none", 0, "", comment(kinds), facts)
    world = motionless(names.cleaned([given.world], "imported")[0], "", agents)
    return ensure(ir.PolicyProfile(world, tuple(policies), provenance))


def _policy(agent: str, origin: Origin, given: Names, numbers: str | None) -> ir.AgentPolicy:
    n_tested = max(int(origin.grown.feature.max()) + 1, origin.n_read)
    called = given.features if given.features is not None else origin.features or None
    width = origin.n_features or max(n_tested, len(called or ()), 1)
    features = [f"x{index}" for index in range(width)] if called is None else list(called)
    if len(features) != width:
        raise InputError(f"{len(features)} feature names for {width} features", agent, "name each feature once")
    if int(ir.depth(origin.grown).max()) > ir.MAX_DEPTH:
        raise InputError(f"the tree is deeper than {ir.MAX_DEPTH} splits", agent, "simplify it first")
    numbers = numbers or origin.numbers
    if (numbers, origin.numbers) == (FLOAT64, FLOAT32):
        raise InputError(f"{origin.kind} compares float32, not float64", agent, "leave --numbers out")
    tree = deployed(origin.grown, numbers)
    if not replay.representable(tree):
        raise InputError(f"a threshold lies below every {numbers} number", agent, "rescale that feature")
    return ir.AgentPolicy(
        agent,
        TEAM,
        tuple(ir.FeatureSpec(each, "none", -MAX_LENGTH, MAX_LENGTH, None) for each in names.cleaned(features, "x")),
        tuple(ir.ActionSpec(each, None) for each in names.action_names(origin.labels, given.actions)),
        tree,
        origin.grown if numbers == FLOAT32 else None,
    )
