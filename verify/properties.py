"""The built-in properties: what each claims about a team, as a formula over world states and actions.

Does: names the properties, finds one for a profile, writes its formula and its sentence.
Assumes: action effects are unit directions; landmarks and agents are those of the profile's world.
Does not: read files (property_file.py) or decide.

With u(a) the direction of the chosen action, agent i closes on landmark k iff u(a_i) . (l_k - p_i) > margin; it is at k
iff their L-infinity distance is at most the radius; engaged is either. Lengths are in the world's unit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations, product
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.formula import Acts, Formula, below, conjunction, disjunction, negated
from verify.spec import MOST

ZERO, RADIUS, KAPPA = Fraction(0), Fraction(1, 10), Fraction(1, 2)


@dataclass(frozen=True)
class Property:
    """A claim about every world state of a region. Which parameters count, its built-in says (see BUILT_IN)."""

    name: str
    team: str
    margin: Fraction = ZERO
    radius: Fraction = RADIUS
    kappa: Fraction = KAPPA  # least share of ahead in sideways, for `aligned`
    landmarks: tuple[str, ...] = ()  # one for each agent of the team, for `own_target`; empty: in the world's order


class BuiltIn(NamedTuple):
    """How a property is stated: its sentence, its formula, and the parameters that it reads beside the team."""

    sentence: str
    formula: Callable[[PolicyProfile, Property], Formula]
    parameters: tuple[str, ...] = ("margin", "radius")


def closes(policy: AgentPolicy, action: int, landmark: str, margin: Fraction) -> Formula:
    """The action takes the agent towards the landmark: u(action) . (l - p) > margin."""
    effect = policy.actions[action].effect or (0.0, 0.0)
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", effect, strict=True):
        terms |= {f"{policy.agent}.{axis}": Fraction(part), f"{landmark}.{axis}": -Fraction(part)}
    return below(terms, -margin, strict=True)


def closing(policy: AgentPolicy, landmark: str, margin: Fraction) -> Formula:
    """The agent's chosen action closes on the landmark."""
    return disjunction(
        *(
            conjunction(Acts(policy.agent, action), closes(policy, action, landmark, margin))
            for action in range(len(policy.actions))
        )
    )


def at(agent: str, landmark: str, radius: Fraction) -> Formula:
    """The L-infinity distance of agent and landmark is at most the radius."""
    gaps = [{f"{agent}.{axis}": sign, f"{landmark}.{axis}": -sign} for axis in "xy" for sign in (1, -1)]
    return conjunction(*(below(gap, radius) for gap in gaps))


def engaged(policy: AgentPolicy, landmark: str, claim: Property) -> Formula:
    """The agent closes on the landmark or is at it."""
    return disjunction(closing(policy, landmark, claim.margin), at(policy.agent, landmark, claim.radius))


def _landmarks(profile: PolicyProfile) -> list[str]:
    return [landmark.name for landmark in profile.world.landmarks]


def _matchings(profile: PolicyProfile, claim: Property) -> list[tuple[tuple[AgentPolicy, str], ...]]:
    team = profile.team(claim.team)
    return [tuple(zip(team, chosen, strict=True)) for chosen in permutations(_landmarks(profile), len(team))]


def _distinct_targets(profile: PolicyProfile, claim: Property) -> Formula:
    return disjunction(
        *(
            conjunction(*(engaged(policy, landmark, claim) for policy, landmark in matching))
            for matching in _matchings(profile, claim)
        )
    )


def _own_target(profile: PolicyProfile, claim: Property) -> Formula:
    team = profile.team(claim.team)
    own = claim.landmarks or tuple(_landmarks(profile)[: len(team)])
    return conjunction(*(engaged(policy, landmark, claim) for policy, landmark in zip(team, own, strict=True)))


def _no_double(profile: PolicyProfile, claim: Property) -> Formula:
    team, landmarks = profile.team(claim.team), _landmarks(profile)

    def only(policy: AgentPolicy, landmark: str) -> Formula:
        others = (negated(closing(policy, other, claim.margin)) for other in landmarks if other != landmark)
        return conjunction(closing(policy, landmark, claim.margin), *others)

    pairs = [(a, b) for index, a in enumerate(team) for b in team[index + 1 :]]
    return conjunction(
        *(negated(conjunction(only(a, landmark), only(b, landmark))) for a, b in pairs for landmark in landmarks)
    )


def _aligned(profile: PolicyProfile, claim: Property) -> Formula:
    """Some matching in which each agent is at its landmark, or closes on it, ahead by kappa times what is sideways."""

    def straight(policy: AgentPolicy, landmark: str) -> Formula:
        ways = [at(policy.agent, landmark, claim.radius)]
        for action, spec in enumerate(policy.actions):
            ux, uy = (Fraction(part) for part in spec.effect or (0.0, 0.0))
            sides = [
                _along(policy.agent, landmark, (sign * claim.kappa * -uy - ux, sign * claim.kappa * ux - uy))
                for sign in (1, -1)
            ]
            ways.append(conjunction(Acts(policy.agent, action), closes(policy, action, landmark, claim.margin), *sides))
        return disjunction(*ways)

    return disjunction(
        *(
            conjunction(*(straight(policy, landmark) for policy, landmark in matching))
            for matching in _matchings(profile, claim)
        )
    )


def _along(agent: str, landmark: str, direction: tuple[Fraction, Fraction]) -> Formula:
    """The direction's product with the landmark's offset is at most 0."""
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", direction, strict=True):
        terms |= {f"{landmark}.{axis}": part, f"{agent}.{axis}": -part}
    return below(terms, 0)


def _assignment(profile: PolicyProfile, claim: Property) -> Formula:
    """Engaged in a matching of least summed L1 distance. For teams of two: more have too many cases of signs."""
    if len(profile.team(claim.team)) != 2:
        raise InputError("assignment is stated for teams of two", f"team {claim.team}", "use distinct_targets")
    matchings = _matchings(profile, claim)
    ways = []
    for matching in matchings:
        least = [_no_longer(matching, other) for other in matchings if other != matching]
        ways.append(conjunction(*least, *(engaged(policy, landmark, claim) for policy, landmark in matching)))
    return disjunction(*ways)


def _no_longer(matching: tuple[tuple[AgentPolicy, str], ...], other: tuple[tuple[AgentPolicy, str], ...]) -> Formula:
    """The summed L1 length of one matching is at most that of another: some signs of the other's offsets give a sum
    that no signs of the one's exceed.
    """

    def sums(pairs: tuple[tuple[AgentPolicy, str], ...]) -> list[dict[str, int]]:
        found = []
        for signs in product((1, -1), repeat=2 * len(pairs)):
            terms: dict[str, int] = {}
            for sign, (policy, landmark, axis) in zip(
                signs, [(*pair, axis) for pair in pairs for axis in "xy"], strict=True
            ):
                terms[f"{landmark}.{axis}"] = terms.get(f"{landmark}.{axis}", 0) + sign
                terms[f"{policy.agent}.{axis}"] = terms.get(f"{policy.agent}.{axis}", 0) - sign
            found.append(terms)
        return found

    def difference(a: Mapping[str, int], b: Mapping[str, int]) -> dict[str, int]:
        return {name: a.get(name, 0) - b.get(name, 0) for name in {**a, **b}}

    return disjunction(
        *(conjunction(*(below(difference(own, bound), 0) for own in sums(matching))) for bound in sums(other))
    )


BUILT_IN: dict[str, BuiltIn] = {
    "distinct_targets": BuiltIn(
        "in every world state of the region, the {team} can be matched one-to-one to the landmarks so that each closes "
        "on its own landmark or is at it",
        _distinct_targets,
    ),
    "own_target": BuiltIn(
        "in every world state of the region, each of the {team} closes on its fixed landmark or is at it",
        _own_target,
        ("margin", "radius", "landmarks"),
    ),
    "no_double": BuiltIn(
        "in no world state of the region do two of the {team} close on exactly the same single landmark",
        _no_double,
        ("margin",),
    ),
    "aligned": BuiltIn(
        "in every world state of the region, the {team} can be matched one-to-one to the landmarks so that each is at "
        "its own landmark, or closes on it and is ahead by at least kappa times the sideways offset",
        _aligned,
        ("margin", "radius", "kappa"),
    ),
    "assignment": BuiltIn(
        "in every world state of the region, each of the {team} closes on or is at its landmark in a matching of least "
        "summed L1 distance",
        _assignment,
    ),
}
PROPERTIES = tuple(BUILT_IN)


def sentence(claim: Property) -> str:
    """The claim in words."""
    return BUILT_IN[claim.name].sentence.format(team=claim.team)


def formula(profile: PolicyProfile, claim: Property) -> Formula:
    """The claim as a formula: true in the world states, with the team's chosen actions, in which it holds."""
    return BUILT_IN[claim.name].formula(profile, claim)


def find_property(
    name: str, profile: PolicyProfile, team: str | None = None, landmarks: Sequence[str] = (), **parameters: Fraction
) -> Property:
    """The named property for a team of `profile`: `team`, or the one team with as many agents as landmarks."""
    if name not in BUILT_IN:
        raise UnknownNameError("property", name, BUILT_IN)
    team = team_for(name, profile, team)
    for parameter, value in parameters.items():
        if not 0 <= value <= MOST:
            raise InputError(f"{parameter} must be between 0 and {MOST}", f"--{parameter}")
    check_landmarks(profile, team, landmarks)
    return Property(name, team, landmarks=tuple(landmarks), **parameters)


def team_for(name: str, profile: PolicyProfile, team: str | None) -> str:
    """The team that the named property speaks of: `team`, or the one team with as many agents as landmarks."""
    teams = list(dict.fromkeys(policy.team for policy in profile.agents))
    wanted = len(profile.world.landmarks)
    if team is None:
        fitting = [candidate for candidate in teams if len(profile.team(candidate)) == wanted]
        if len(fitting) != 1:
            raise InputError(
                f"{name} needs a team of {wanted} agents, one for each landmark", "", f"teams: {', '.join(teams)}"
            )
        return fitting[0]
    if team not in teams:
        raise UnknownNameError("team", team, teams)
    if len(profile.team(team)) > wanted:
        raise InputError(
            f"{name} needs a landmark for each agent; team {team} has more agents than the world landmarks"
        )
    return team


def check_landmarks(profile: PolicyProfile, team: str, landmarks: Sequence[str]) -> None:
    """InputError unless `landmarks` is empty or names a different one for each agent of the team."""
    for landmark in landmarks:
        if landmark not in _landmarks(profile):
            raise UnknownNameError("landmark", landmark, _landmarks(profile), "landmarks")
    if landmarks and (len(landmarks) != len(profile.team(team)) or len(set(landmarks)) != len(landmarks)):
        raise InputError("landmarks must name a different landmark for each agent of the team", "landmarks")
