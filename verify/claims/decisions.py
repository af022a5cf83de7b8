"""What can be claimed about a team: the built-in properties and users' own, as formulas over world states and actions.

Does: names the properties, finds one for a profile, writes its formula and its sentence.
Assumes: landmarks and agents are those of the profile's world; predicates.py defines closing, at and engaged.
Does not: read files (files.py) or decide.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.formula import TRUE, Acts, Formula, below, conjunction, disjunction, negated
from verify.claims.matching import matchings
from verify.claims.predicates import at, closes, closing
from verify.claims.region import MAX_NUMBER

ZERO, RADIUS, KAPPA = Fraction(0), Fraction(1, 10), Fraction(1, 2)


OWN = "formula"  # the name of properties that users state
DISTINCT, STEADY, LEAVES = "distinct_targets", "steady", "alive_leaves"
EPS = Fraction(1, 100)


@dataclass(frozen=True)
class DecisionClaim:
    """A claim about every world state of a region that meets the assumption. Which parameters count, see BUILT_IN."""

    name: str
    team: str
    margin: Fraction = ZERO
    radius: Fraction = RADIUS
    kappa: Fraction = KAPPA  # least share of ahead in sideways, for `aligned`
    landmarks: tuple[str, ...] = ()  # one for each agent of the team, for `own_target`; empty: in the world's order
    statement: Formula | None = None  # of a user's own property
    assume: Formula = TRUE  # about world states only
    eps: Fraction = ZERO  # each feature may be off by so much; above 0 for `steady`
    of: str = ""  # the property that `steady` is said of
    label: str = field(default="", compare=False)
    written: str = field(default="", compare=False)  # the statement as the user wrote it
    assumption: str = field(default="", compare=False)  # `assume` as the user wrote it

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name


class BuiltIn(NamedTuple):
    """How a property is stated: its sentence, its formula, and the parameters that it reads beside the team."""

    sentence: str
    formula: Callable[[PolicyProfile, DecisionClaim], Formula]
    parameters: tuple[str, ...] = ("margin", "radius")


def engaged(policy: AgentPolicy, landmark: str, claim: DecisionClaim) -> Formula:
    """The agent closes on the landmark or is at it."""
    return disjunction(closing(policy, landmark, claim.margin), at(policy.agent, landmark, claim.radius))


def _landmarks(profile: PolicyProfile) -> list[str]:
    return [landmark.name for landmark in profile.world.landmarks]


def _matchings(profile: PolicyProfile, claim: DecisionClaim) -> list[tuple[tuple[AgentPolicy, str], ...]]:
    team, landmarks = profile.team(claim.team), _landmarks(profile)
    return [
        tuple((policy, landmarks[number]) for policy, number in zip(team, numbers, strict=True))
        for numbers in matchings(len(team), len(landmarks))
    ]


def _distinct_targets(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
    return disjunction(
        *(
            conjunction(*(engaged(policy, landmark, claim) for policy, landmark in matching))
            for matching in _matchings(profile, claim)
        )
    )


def _own_target(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
    team = profile.team(claim.team)
    own = claim.landmarks or tuple(_landmarks(profile)[: len(team)])
    return conjunction(*(engaged(policy, landmark, claim) for policy, landmark in zip(team, own, strict=True)))


def _no_double(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
    team, landmarks = profile.team(claim.team), _landmarks(profile)

    def only(policy: AgentPolicy, landmark: str) -> Formula:
        others = (negated(closing(policy, other, claim.margin)) for other in landmarks if other != landmark)
        return conjunction(closing(policy, landmark, claim.margin), *others)

    if len(team) < 2:
        raise InputError(
            "no_double is about teams of two or more", f"team {claim.team}", "it says nothing about a single agent"
        )
    pairs = [(a, b) for index, a in enumerate(team) for b in team[index + 1 :]]
    return conjunction(
        *(negated(conjunction(only(a, landmark), only(b, landmark))) for a, b in pairs for landmark in landmarks)
    )


def _aligned(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
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


def _assignment(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
    """Engaged in a matching of least summed L1 distance. For teams of two: more have too many cases of signs."""
    if len(profile.team(claim.team)) != 2:
        raise InputError("assignment is defined for teams of two only", f"team {claim.team}", "use distinct_targets")
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
    DISTINCT: BuiltIn(
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
    STEADY: BuiltIn(
        "{of}, even when every feature of each of the {team} is off by up to eps, each by an error of its own",
        lambda profile, claim: BUILT_IN[claim.of].formula(profile, claim),
        ("eps", "of"),
    ),
    LEAVES: BuiltIn(
        "every leaf of every agent of the {team} is reached in some world state of the region", lambda *_: TRUE, ()
    ),
}
PLAIN = tuple(name for name in BUILT_IN if name not in (STEADY, LEAVES))  # what can be steady
PROPERTIES = tuple(BUILT_IN)


OWN_SENTENCE = "in every world state of the region, the formula holds for what the {team} do"


def sentence(claim: DecisionClaim) -> str:
    """The claim in words, without its assumption."""
    if claim.name == OWN:
        noise = ", even when every feature is off by up to eps, each by an error of its own" if claim.eps else ""
        return OWN_SENTENCE.format(team=claim.team) + noise
    of = BUILT_IN[claim.of].sentence.format(team=claim.team) if claim.of else ""
    return BUILT_IN[claim.name].sentence.format(team=claim.team, of=of)


def reads(claim: DecisionClaim) -> tuple[str, ...]:
    """The names of the parameters that the claim reads, beside its team."""
    if claim.name == OWN:
        return ("margin", "radius", *(("eps",) if claim.eps else ()))
    return BUILT_IN[claim.name].parameters + (BUILT_IN[claim.of].parameters if claim.of else ())


def formula(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
    """The claim as a formula: true in the world states, with the team's chosen actions, in which it holds or where
    its assumption fails. UnknownNameError where its team has no agents: what is said of all of nobody is true.
    """
    ensure_team(profile, claim.team)
    stated = claim.statement if claim.statement is not None else BUILT_IN[claim.name].formula(profile, claim)
    return stated if claim.assume == TRUE else disjunction(negated(claim.assume), stated)


def find_property(
    name: str,
    profile: PolicyProfile,
    team: str | None = None,
    landmarks: Sequence[str] = (),
    of: str = "",
    **parameters: Any,
) -> DecisionClaim:
    """The named property for a team of `profile`: `team`, or the one team with as many agents as landmarks.

    `of`: what `steady` is said of; `parameters`: exact numbers. InputError for a parameter that the
    property does not read.
    """
    if name not in BUILT_IN:
        raise UnknownNameError("property", name, BUILT_IN)
    if of and of not in PLAIN:
        raise UnknownNameError("property", of, PLAIN, "of")
    team = team_for(name, profile, team)
    given = [*parameters, *(["landmarks"] if landmarks else []), *(["of"] if of else [])]
    of = of or (PLAIN[0] if name == STEADY else "")
    check_read(name, given, reads(DecisionClaim(name, team, of=of)))
    claim = DecisionClaim(name, team, landmarks=tuple(landmarks), of=of, **parameters)
    if name == STEADY and "eps" not in parameters:
        claim = replace(claim, eps=EPS)
    return checked(profile, claim)


def checked(profile: PolicyProfile, claim: DecisionClaim) -> DecisionClaim:
    """The claim itself, if it is about a team of the profile and its parameters are in their ranges."""
    if claim.name in BUILT_IN:
        team_for(claim.name, profile, claim.team)
    ensure_team(profile, claim.team)
    for parameter in ("margin", "radius", "kappa", "eps"):
        check_range(parameter, getattr(claim, parameter))
    if claim.name == STEADY and not claim.eps:
        raise InputError("steady needs an eps above 0", "eps", f"verify {claim.of} itself")
    check_landmarks(profile, claim.team, claim.landmarks)
    return claim


def ensure_team(profile: PolicyProfile, team: str) -> None:
    """UnknownNameError for a team of which the profile has no agent."""
    if not profile.team(team):
        raise UnknownNameError("team", team, _teams(profile))


def _teams(profile: PolicyProfile) -> list[str]:
    return list(dict.fromkeys(policy.team for policy in profile.agents))


def check_read(name: str, given: Sequence[str], read: Sequence[str]) -> None:
    """InputError for a given parameter that the named property does not read."""
    for parameter in given:
        if parameter not in read:
            raise InputError(f"{name} has no parameter {parameter}", parameter, f"it has {', '.join(read) or 'none'}")


def check_range(parameter: str, value: Fraction | int, most: int = MAX_NUMBER, least: int = 0) -> None:
    """InputError for a value out of its range."""
    if not least <= value <= most:
        raise InputError(f"{parameter} must be between {least} and {most}", parameter)


def team_for(name: str, profile: PolicyProfile, team: str | None, any_size: bool = False) -> str:
    """The team that the named property speaks of: `team`, or the one team with as many agents as landmarks.

    `any_size`: the property needs no landmark for each agent, so that of one team alone nothing is asked.
    """
    teams = _teams(profile)
    wanted = len(profile.world.landmarks)
    if team is None and any_size and len(teams) == 1:
        return teams[0]
    if team is None:
        fitting = [candidate for candidate in teams if len(profile.team(candidate)) == wanted]
        if len(fitting) != 1:
            raise InputError(
                f"{name} needs a team of {wanted} agents, one for each landmark", "", f"teams: {', '.join(teams)}"
            )
        return fitting[0]
    ensure_team(profile, team)
    if len(profile.team(team)) > wanted and name != LEAVES and not any_size:
        raise InputError(
            f"{name} needs a landmark for each agent; team {team} has more agents than the world landmarks"
        )
    return team


def check_landmarks(profile: PolicyProfile, team: str, landmarks: Sequence[str]) -> None:
    """InputError unless `landmarks` is empty or names a different one for each agent of the team."""
    known = _landmarks(profile)
    for landmark in landmarks:
        if landmark not in known:
            raise UnknownNameError("landmark", landmark, known, "landmarks")
    if landmarks and (len(landmarks) != len(profile.team(team)) or len(set(landmarks)) != len(landmarks)):
        raise InputError("landmarks must name a different landmark for each agent of the team", "landmarks")
