"""The part of a report that says where a claim holds, and the file of its violating zones.

Does: counts zones and leaves, puts the most important ones into words, writes every zone with its exact bounds.
Assumes: a result of `decisions.verify` with its `where`.
Does not: contain times, paths or facts about the machine.

In the file of zones an interval has a square bracket at an end that belongs to it and a round one at an end that does
not. A zone's box is the least around it, without the intervals that are the region's; of the differences those are
stated that the box does not imply.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import Any, TypeAlias

from codegen.floats import rational_literal
from codegen.form import layout
from codegen.ir import AgentPolicy, PolicyProfile
from codegen.policy_json import content_hash
from verify.claims.region import Region, goal_text
from verify.claims.wording import region_document, spell_decisions
from verify.decimals import plain
from verify.decimals import text as decimal
from verify.extent.largest import Where
from verify.extent.violations import Failing
from verify.verdicts.decisions import DecisionResult, of_states
from verify.zones.search import Branch

FORM = "maviper-zones-1"
FIRST = 1_000  # zones that are written of those that are not all: the others would say no more
SHOWN = 3  # combinations of leaves that are put into words
LONGEST = 1 << 13  # bits of a volume beyond which shares of cells are written rounded: reducing each takes too long
SMALLEST = Fraction(1, 2**149)  # float32 above 0; what is smaller is written as 0
OVERLAPPING = "each cell is where some errors lead to its leaves, so cells overlap and their shares count states again"
Ranked: TypeAlias = tuple[Failing, Branch, int | None]  # a zone with its goal's data and its volume, if known
Bounds = Mapping[tuple[str, str], tuple[Fraction, bool]]  # (a, b) -> most of a - b, whether it stays below


def where_facts(profile: PolicyProfile, result: DecisionResult) -> dict[str, Any]:
    """Returns what is known of where the claim holds, as plain data."""
    extent = result.evidence.where
    assert extent is not None
    share = extent.share
    between = {} if share is None or share.exact else {"between": [float(share.value), float(share.upper)]}
    return {
        "reason": of_states(result.question, extent.reason),
        "everywhere": extent.everywhere,
        "zones": extent.count,
        "goals": len(result.region.goals),
        "complete": extent.complete,
        "exact": _exact(share.value) if share is not None and share.exact else None,
        "exact_reason": extent.share_reason,
        **between,
        **({"overlapping": OVERLAPPING} if result.claim.eps and extent.count else {}),
        "leaves": _leaves(profile, extent),
        "most": _most(profile, result),
        "region": None if extent.part is None else _part(result),
        "region_reason": extent.part_reason,
    }


def _exact(share: Fraction) -> dict[str, Any]:
    return {"fraction": rational_literal(share), "share": float(share)}


def _rank_zones(where: Where) -> list[Ranked]:
    """All zones with their volumes, the largest first; in the order of the search where these are equal or unknown."""
    rows: list[Ranked] = []
    for place, failing in enumerate(where.failing):
        for number, zone in enumerate(failing.zones):
            rows.append((failing, zone, None if where.share is None else where.share.zones[place][number]))
    return sorted(rows, key=lambda row: -(row[2] or 0))


def _leaves(profile: PolicyProfile, where: Where) -> dict[str, list[dict[str, Any]]]:
    """Agent -> the leaves that it is in somewhere where the claim fails: action, zones, share of the region."""
    counts: dict[str, dict[int, int]] = {}
    volumes: dict[str, dict[int, int]] = {}
    for failing, zone, volume in _rank_zones(where):
        for agent, leaf in zip(failing.agents, zone[0], strict=True):
            own, sums = counts.setdefault(agent, {}), volumes.setdefault(agent, {})
            own[leaf] = own.get(leaf, 0) + 1
            sums[leaf] = sums.get(leaf, 0) + (volume or 0)
    return {
        agent: [
            {
                "leaf": leaf,
                "action": _action(profile.policy(agent), leaf),
                "zones": counts[agent][leaf],
                "share": None if where.share is None else volumes[agent][leaf] / where.share.region,
            }
            for leaf in sorted(counts[agent], key=lambda leaf: (-volumes[agent][leaf], leaf))
        ]
        for agent in counts
    }


def _action(policy: AgentPolicy, leaf: int) -> str:
    return policy.actions[int(policy.tree.action[leaf])].name


def _most(profile: PolicyProfile, result: DecisionResult) -> list[dict[str, Any]]:
    """The combinations of leaves that make up most of what violates the claim, each with its largest zone in words."""
    extent = result.evidence.where
    assert extent is not None
    together: dict[tuple[tuple[str, int], ...], list[Ranked]] = {}  # a claim may speak of other agents for each goal
    for row in _rank_zones(extent):
        together.setdefault(tuple(zip(row[0].agents, row[1][0], strict=True)), []).append(row)
    sums = {leaves: sum(row[2] or 0 for row in rows) for leaves, rows in together.items()}
    facts: list[dict[str, Any]] = []
    for leaves in sorted(together, key=lambda leaves: (-sums[leaves], -len(together[leaves]), leaves))[:SHOWN]:
        failing, zone, _ = together[leaves][0]
        agents = [
            {"agent": agent, "leaf": leaf, "action": _action(profile.policy(agent), leaf)} for agent, leaf in leaves
        ]
        words = describe_bounds(failing, zone, result.region)
        share = None if extent.share is None else sums[leaves] / extent.share.region
        count = len(together[leaves])
        goal = goal_text(failing.goal)
        facts.append({"agents": agents, "zones": count, "share": share, "goal": goal, "words": words})
    return facts


def describe_bounds(failing: Failing, zone: Branch, region: Region) -> list[str]:
    """The bounds of a zone that no others and not the region's box imply, in words."""
    selected = _select_bounds(failing, zone, region)
    return [f"{_format_end(low)}{name}{_format_end(high, True)}" for name, low, high in selected]


def _format_end(end: tuple[Fraction, bool] | None, upper: bool = False) -> str:
    if end is None:
        return ""
    value = 0.0 if abs(end[0]) < SMALLEST else float(end[0])  # `x < 0` turns halfway to the last float32
    number, sign = f"{value:.4g}", "<" if end[1] else "<="
    return f" {sign} {number}" if upper else f"{number} {sign} "


def _select_bounds(
    failing: Failing, zone: Branch, region: Region
) -> list[tuple[str, tuple[Fraction, bool] | None, tuple[Fraction, bool] | None]]:
    """(coordinate or difference, lower end, upper end) of the bounds that no others and not the region's box imply."""
    bounds = failing.bounds(zone)
    names = ["", *failing.problem.places]
    tied: dict[str, str] = {}  # coordinate -> the first one, or "" for zero, from which it has one constant distance
    for place, name in enumerate(names):
        for other in names[:place]:
            if other not in tied and (name, other) in bounds and not bounds[name, other][0] + bounds[other, name][0]:
                tied.setdefault(name, other)
    ends: dict[tuple[str, str], list[tuple[Fraction, bool] | None]] = {}
    for (a, b), (most, below) in bounds.items():
        low, high = region.box[a or b]
        end = -low if not a else high
        given = not (a and b) and (most > end or (most == end and not below))
        if (
            given
            or (a in tied and tied[a] != b)
            or (b in tied and tied[b] != a)
            or any(
                most >= bounds[a, k][0] + bounds[k, b][0] and (bounds[a, k][1] or bounds[k, b][1] or not below)
                for x, k in bounds
                if x == a and k not in (a, b) and k not in tied and (k, b) in bounds
            )
        ):
            continue
        if not a or (b and (b, a) in ends):
            ends.setdefault((b, a), [None, None])[0] = -most, below
        else:
            ends.setdefault((a, b), [None, None])[1] = most, below
    return [(f"{a} - {b}" if b else a, low, high) for (a, b), (low, high) in sorted(ends.items())]


def _cut(region: Region, part: Region) -> list[str]:
    """The bounds in which a part of a region is narrower than the region, in words."""
    box, given = region.box, {(a, b): bounds for a, b, bounds in region.differences}
    rows = [(name, bounds, box[name]) for name, bounds in part.box.items()]
    for a, b, bounds in part.differences:
        whole = box[a][0] - box[b][1], box[a][1] - box[b][0]
        rows.append((f"{a} - {b}", bounds, given.get((a, b), whole)))
    return [
        f"{f'{decimal(low)} <= ' if low > least else ''}{name}{f' <= {decimal(high)}' if high < most else ''}"
        for name, (low, high), (least, most) in rows
        if low > least or high < most
    ]


def _part(result: DecisionResult) -> dict[str, Any]:
    """The largest region found, with the verdict in it."""
    where, inner = result.evidence.where, result.evidence.verdict_in_largest_region
    assert where is not None and where.part is not None and inner is not None
    part, known = where.part, inner.evidence
    return {
        "name": part.region.name,
        "region": region_document(part.region),
        "bounds": _cut(result.region, part.region),
        "exact": None if part.exact is None else _exact(part.exact),
        "share": part.share.document(),
        "start": None if part.start is None else part.start.document(),
        "conflict": None if known.shares.conflict is None else known.shares.conflict.document(),
        "contested": None if known.shares.contested is None else known.shares.contested.document(),
        "visited": None if known.visited is None else asdict(known.visited),
        "verdict": inner.verdict.value,
        "reason": inner.reason,
        "shuffled_control": known.control.verdict.value,
        "shuffled_leaves": known.control.words,
        "engines": [f"{opinion.engine} {opinion.verdict.value}" for opinion in known.opinions],
        "branches": known.branches,
        "checker": "accepted" if known.certificate is not None else "",
    }


def zones_json(profile: PolicyProfile, result: DecisionResult) -> str:
    """Violating zones with their exact bounds, as a JSON text: all, the largest first; FIRST if they are not all."""
    extent = result.evidence.where
    assert extent is not None
    ranked = _rank_zones(extent)
    facts = {
        "zones": FORM,
        "profile": content_hash(profile),
        "property": result.claim.name,
        "team": result.claim.team,
        "claim": spell_decisions(result.claim),
        "semantics": result.semantics,
        "region": region_document(result.region),
        "complete": extent.complete,
        "share": rational_literal(extent.share.value) if extent.share is not None and extent.share.exact else None,
        "found": extent.count,
        "violating": [
            zone_facts(result.question.profile, result.region, failing, zone, _share(volume, extent))
            for failing, zone, volume in ranked[: None if extent.complete else FIRST]
        ],
    }
    return layout(facts) + "\n"


def _share(volume: int | None, where: Where) -> str | float | None:
    """A zone's share of the region: exact, or a double where it has too many digits for that."""
    if volume is None or where.share is None:
        return None
    whole = where.share.region
    return rational_literal(Fraction(volume, whole)) if whole.bit_length() <= LONGEST else volume / whole


def zone_facts(
    profile: PolicyProfile, region: Region, failing: Failing, zone: Branch, share: str | float | None
) -> dict[str, Any]:
    """A zone with its exact bounds, as plain data."""
    bounds = failing.bounds(zone)
    names: Sequence[str] = list(failing.problem.places)
    whole = {name: (-low, high) for name, (low, high) in region.box.items()}
    ends = {name: (bounds["", name], bounds[name, ""]) for name in names}
    closed = {name: (low[0], high[0]) for name, (low, high) in ends.items() if not low[1] and not high[1]}
    box = {name: _interval(bounds, name, "") for name in names if closed.get(name) != whole[name]}
    differences = {
        f"{a} - {b}": _interval(bounds, a, b)
        for place, a in enumerate(names)
        for b in names[place + 1 :]
        if (a, b) in bounds and (_tighter(bounds, a, b) or _tighter(bounds, b, a))
    }
    return {
        "goal": goal_text(failing.goal),
        "leaves": dict(zip(failing.agents, zone[0], strict=True)),
        "actions": {
            agent: _action(profile.policy(agent), leaf) for agent, leaf in zip(failing.agents, zone[0], strict=True)
        },
        "share": share,
        "box": box,
        "difference": differences,
    }


def _tighter(bounds: Bounds, a: str, b: str) -> bool:
    """Returns True if a - b has a bound that the box does not imply."""
    (most, below), (high, from_high), (low, from_low) = bounds[a, b], bounds[a, ""], bounds["", b]
    return most < high + low or (below and not from_high and not from_low)


def _interval(bounds: Bounds, a: str, b: str) -> str:
    """The interval of a - b."""
    (high, open_high), (low, open_low) = bounds[a, b], bounds[b, a]
    ends = [plain(end) for end in (-low, high)]
    return f"{'(' if open_low else '['}{ends[0]}, {ends[1]}{')' if open_high else ']'}"
