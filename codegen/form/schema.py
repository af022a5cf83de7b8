"""The shape of a policy profile's JSON form.

Does: states every object and field as a struct; the published JSON schema is made from them.
Assumes: the meaning of each field is that of its namesake in ir.py.
Does not: check invariants that need more than one field (check.py).
"""

from typing import Literal

import msgspec

SCHEMA_VERSION = 1
SUMS_VERSION = 2  # of profiles in which any agent has sums or outputs, and of no others
Number = float | int | str
SumJson = list[tuple[float, str | None]]  # [weight, feature], or [constant, null], in the order of the additions


class _Strict(msgspec.Struct, forbid_unknown_fields=True):
    pass


class SplitJson(_Strict):
    """`x[feature] <= threshold` goes to node `left`, everything else to node `right`.

    An agent that compares float64 has no `float32`: `threshold` is what it compares.
    """

    feature: str
    threshold: float
    float32: str
    left: int
    right: int


class NodeJson(_Strict, omit_defaults=True):
    """Either a split (feature, threshold, left, right, and float32 where that is compared) or a leaf (action; visits:
    its decisions in held-out episodes, of all leaves or of none). A split may have a sum in place of feature and
    float32, a leaf outputs in place of action: a sum for each output of the agent.
    """

    feature: str | None = None
    sum: SumJson | None = None
    threshold: float | None = None
    float32: str | None = None
    left: int | None = None
    right: int | None = None
    action: str | None = None
    outputs: list[SumJson] | None = None
    visits: int | None = None


class GrownJson(_Strict):
    """The tree as it was learned, in arrays: float64 thresholds, -1 for what a node does not have."""

    feature: list[int]
    threshold: list[float]
    left: list[int]
    right: list[int]
    action: list[int]


class FeatureJson(_Strict):
    """`seen`: least, 1st and 99th percentile and most in episodes, of all features of an agent or of none."""

    name: str
    unit: str
    range: tuple[float, float]
    meaning: str | None
    seen: tuple[float, float, float, float] | None = None


class ActionJson(_Strict):
    name: str
    effect: tuple[float, float] | None
    legal_if: str = ""
    label: int | float | str | None = None


class OutputJson(_Strict):
    """A number that an agent gives, clipped to low and high; null: no bound."""

    name: str
    unit: str
    low: float | None
    high: float | None


class EntityJson(_Strict):
    name: str
    size: float
    force: float
    max_speed: float | None
    collides: bool
    start_box: tuple[float, float] | None


class VariableJson(_Strict):
    """A coordinate that belongs to no entity."""

    name: str
    unit: str
    range: tuple[float, float]


class WorldJson(_Strict):
    name: str
    reference: str
    agents: list[EntityJson]
    landmarks: list[EntityJson]
    goals: list[str]
    dt: float
    damping: float
    start_box: tuple[float, float]
    episode_steps: int
    contact_force: float
    contact_margin: float
    options: dict[str, int | str]
    variables: list[VariableJson] = []


class AgentJson(_Strict):
    """`numbers`: what the agent observes and compares. Of agents with sums or outputs also `arithmetic`, which sums are
    computed in, and of those that give numbers `outputs`, rounded to what the agent `gives`; these have no actions.
    """

    agent: str
    team: str
    features: list[FeatureJson]
    actions: list[ActionJson]
    tree: list[NodeJson]
    grown: GrownJson | None
    numbers: Literal["float32", "float64"] = "float32"
    arithmetic: Literal["double sums", "float32 steps", "float64"] | None = None
    gives: Literal["float32", "float64"] = "float32"
    outputs: list[OutputJson] = []


class ProvenanceJson(_Strict):
    algorithm: str
    preset: str
    seed: int
    expert: str
    tool: str
    training: dict[str, Number]
    evaluation: dict[str, Number]


class RegionJson(_Strict):
    """World states: bounds of coordinates and of differences `a - b`, pairs kept apart; numbers are exact text."""

    goals: list[str]
    box: dict[str, tuple[str, str]]
    difference: dict[str, tuple[str, str]]
    apart: dict[str, str]


class ProfileJson(_Strict):
    """A policy profile. `content_hash` covers everything else; leave it out after an edit made on purpose.
    `region`: the world states that the trees are meant for; without it, all.
    """

    schema_version: int
    semantics: str
    world: WorldJson
    agents: list[AgentJson]
    provenance: ProvenanceJson
    region: RegionJson | None = None
    content_hash: str | None = None
