"""Certificates of claims about single decisions: the members of their documents, and whether one is accepted.

Does: says what the members are; whether a certificate fits a profile; walks the search that README.md specifies, and
  adds exact numbers along the cycles of bounds that a proof names, so that each of its branches is closed again.
Assumes: a profile that was read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: search for cycles, import an engine, or write (verify/certificates).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias, get_args

import msgspec

from codegen.errors import InputError, escape_text
from codegen.ir import GOAL, NO_FEATURE, ROOT, AgentPolicy, PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.certificate import (
    REMAKE,
    Bytes,
    Certificate,
    Forms,
    Header,
    Members,
    ensure_about,
    numbers,
    stated_as,
)
from verify.checker.reading import (
    LONGEST,
    Bounds,
    Choice,
    Edge,
    Flat,
    Known,
    Reading,
    RejectedError,
    SearchTree,
    region_formula,
)
from verify.checker.thresholds import NO_ERROR, sides
from verify.claims.claim import check_range, read_by, verifiable
from verify.claims.decisions import BY_NAME, KAPPA, PLAIN, STEADY, DecisionClaim, ensure_askable, ensure_steady, formula
from verify.claims.formula import Formula, agents, conjuncts, coordinates, for_goal, holds, names_goal, read_formula
from verify.claims.observed import View, over, view_from
from verify.claims.region import Region, goal_of, goal_text
from verify.claims.relations import RELATIONS, alike, ensure_comparable, pair_profiles
from verify.exact import read_number
from verify.kinds import MACHINE, SEMANTICS, Semantics

FORM = "maviper-certificate-1"
PARTED = "maviper-certificate-2"  # its proofs are those of the conjuncts, one after the other
MET, MET_PARTED = "maviper-certificate-3", "maviper-certificate-4"  # the same, with the left sides of implications
STATED = {"name", "goals", "box", "difference", "apart"}  # of a region
NAMED = ("name", "team", "margin", "radius", "kappa", "landmarks")  # of a property, what a certificate states
NOISY = ("eps", "of")  # and of steady
COMPARED = tuple(dict.fromkeys(name for kind in RELATIONS.values() for name in kind.reads))  # of those that compare
TYPES = {each.name: each.type for kind in (*BY_NAME.values(), *RELATIONS.values()) for each in fields(kind)}
LARGEST = 2**1000  # more than any place of a world
UNREAD = {"kappa": KAPPA, "landmarks": ()}  # what it states of a property that does not read them


# --- members of a document that stand for something else


def read_region(document: Mapping[str, Any]) -> Region:
    """The region of a certificate, without its name: by that anybody could call any region the start."""

    def pair(text: str) -> tuple[str, str]:
        first, second = text.split(" - ")
        return first, second

    def interval(bounds: Any) -> tuple[Fraction, Fraction]:
        low, high = map(read_number, bounds)
        return low, high

    if strange := document.keys() - STATED:
        raise ValueError(f"$.region.{min(strange)[:40]}: a region does not state it")
    box = {name: interval(bounds) for name, bounds in document["box"].items()}
    differences = tuple((*pair(text), interval(bounds)) for text, bounds in document["difference"].items())
    apart = tuple((*pair(text), read_number(least)) for text, least in document["apart"].items())
    return Region(box, tuple(map(str, document["goals"])), differences, apart, said=str(document["name"]))


def _read_property(document: object) -> DecisionClaim | None:
    """The named property. ValueError for a name whose formula is not all that it claims, or another parameter."""
    stated: dict[str, str | list[str]] | None = msgspec.convert(document, dict[str, str | list[str]] | None)
    if stated is None:
        return None
    steady = stated["name"] == STEADY
    named, key = (NAMED + NOISY, "of") if steady else (NAMED, "name")
    kind = stated.get(key, "")
    named += () if kind in PLAIN else COMPARED
    if kind not in (*PLAIN, *RELATIONS):  # the formula of others is not all that they claim
        raise ValueError(f"$.property.{key}: {kind[:40]!r}")
    given: dict[str, Any] = {}
    for name, value in stated.items():
        if name not in named:
            raise ValueError(f"$.property.{name}: a certificate states {', '.join(named)}")
        if isinstance(value, str) == (TYPES.get(name) == tuple[str, ...]):
            raise ValueError(f"$.property.{name}: {value}")
        if name not in ("name", "of"):
            text = TYPES[name] is str
            given[name] = value if text else tuple(value) if isinstance(value, list) else read_number(value)
    made = (BY_NAME | RELATIONS)[str(kind)]
    for name, usual in UNREAD.items():
        if name not in made.reads and given.pop(name, usual) != usual:
            raise ValueError(f"$.property.{name}: {kind} does not read it")
    claim = made(**given)
    ensure_steady(STEADY if steady else claim.name, claim)
    return claim


def _read_error(document: object) -> Fraction:
    """By how much features may be off. ValueError for nothing: then it is not stated."""
    if (eps := read_number(document)) <= 0:
        raise ValueError(f"not an error of features: {eps}")
    return eps


if TYPE_CHECKING:
    StatedRegion = Region
    StatedFormula = Formula
    StatedProperty = DecisionClaim | None
    StatedError = Fraction
    StatedView = View | None
else:
    StatedRegion = stated_as(read_region, Region)
    StatedFormula = stated_as(read_formula, *get_args(Formula))
    StatedProperty = stated_as(_read_property, DecisionClaim, type(None))
    StatedError = stated_as(_read_error, Fraction)
    StatedView = stated_as(lambda each: view_from(msgspec.convert(each, dict[str, list[str]])), View)


# --- certificates


class GameHeader(Header, frozen=True):
    """The header of a certificate about a game: also where, and in which arithmetic (thresholds.py)."""

    semantics: str
    region: StatedRegion


class DecisionHeader(GameHeader, frozen=True):
    """The header of a certificate about single decisions."""

    against: str = ""  # content hash of a second profile: the claim is that agents act alike in both
    view: StatedView = None  # where the claim is over observations: how they are put together
    eps: StatedError = NO_ERROR  # by how much each measured feature may be off


class Premise(Members, frozen=True):
    """The left side of an implication, with a state that meets it."""

    formula: StatedFormula
    goal: str  # "" where there is none
    state: Mapping[str, Fraction]


class FormulaClaim(Members, frozen=True):
    """That a formula holds in all states of a region, whatever the goal."""

    property: StatedProperty  # None for a formula without a name
    formula: StatedFormula
    premises: tuple[Premise, ...] | msgspec.UnsetType = msgspec.UNSET  # left sides of implications, since form 3

    def read(self, header: DecisionHeader) -> FormulaClaim:
        """The claim itself. ValueError where its form states other members."""
        if header.semantics not in SEMANTICS:
            raise ValueError(f"$.semantics: {header.semantics[:40]!r}")
        if (self.premises is msgspec.UNSET) == (header.certificate in (MET, MET_PARTED)):
            raise ValueError(f"$.premises: stated by {MET} and {MET_PARTED}, and by no other")
        return self


class GoalProofs(Members, frozen=True):
    """A proof for each goal; "" where there is none."""

    proofs: Mapping[str, Bytes]


DecisionCertificate = Certificate[DecisionHeader, FormulaClaim, GoalProofs]
FORMS = Forms(DecisionHeader, FormulaClaim, dict.fromkeys((FORM, PARTED, MET, MET_PARTED), GoalProofs))


def check_certificate(
    certificate: DecisionCertificate, profile: PolicyProfile, against: PolicyProfile | None = None
) -> int:
    """Checks a certificate; the number of branches that its proofs close. `against`: the second profile, where it is
    about two.

    InputError when it is about another policy or names what the profile does not have; RejectedError when a proof is
    missing or does not hold, or the formula is not the property's.
    """
    header, claim, proofs = certificate.header, certificate.claim, certificate.proof.proofs
    ensure_about(header.profile, content_hash(profile), "profile", "--profile")
    if header.against:
        profile = _pair(certificate, profile, against)
    profile = profile if header.view is None else over(profile, header.view)
    named, region, premises = claim.property, header.region, claim.premises or ()
    speaking = (claim.formula, *(premise.formula for premise in premises))
    ensure_known_names(profile, header, None if named is None else named.team, speaking)
    if named is not None:
        _ensure_states(named, claim.formula, header, profile)
    check_range("eps", header.eps)
    if not holds(region_formula(region), header.inhabitant, {}):
        raise RejectedError("its inhabitant is not a state of the region, so the claim may be vacuous")
    for premise in premises:
        check_premise(premise, profile, region, header.semantics)
    goals = region.goal_cases
    if {*map(goal_text, goals)} != set(proofs):
        proved, stated = sorted(map(escape_text, proofs)), sorted(map(goal_text, goals))
        raise RejectedError(f"the proofs are for the goals {proved}, but the region has {stated}")
    closed, semantics = list[int](), Semantics(header.semantics, header.eps)
    parts = conjuncts(claim.formula) if header.certificate in (PARTED, MET_PARTED) else (claim.formula,)
    seen = any(GOAL in read_by(profile.policy(agent)) for agent in agents(claim.formula))
    for_any_goal = not seen and not names_goal(claim.formula)  # then all goals are one question
    for goal in goals:
        proof = proofs[goal_text(goal)]
        if for_any_goal and closed and proof == proofs[goal_text(goals[0])]:
            closed.append(closed[0])  # the same question, and the same proof
            continue
        try:
            asked = [for_goal(part, goal) for part in parts]
            closed.append(check(profile, asked, region, goal, semantics, numbers(proof)))
        except RejectedError as error:
            raise RejectedError(f"goal {goal or 'none'}: {error}") from None
    return sum(closed)


def _ensure_states(named: DecisionClaim, stated: Formula, header: DecisionHeader, profile: PolicyProfile) -> None:
    """RejectedError unless a property says of a profile what the certificate states of it."""
    verifiable(profile, named.team)
    try:
        same = formula(profile, named) == stated
    except (LookupError, ValueError):  # a property of other agents or landmarks
        same = False
    if not same:
        raise RejectedError(f"the formula is not the one that {named.name} has for this profile")
    view = header.view or View()
    if named.of_view(view) != view:  # a formula need not name the features in which a copy differs
        raise RejectedError(f"the view is not the one that {named.name} is about")
    ensure_askable(profile, named)
    if named.eps != header.eps:
        raise RejectedError(
            f"{named.name} is about errors up to {named.eps}, but the proof about errors up to {header.eps}"
        )


def check_premise(premise: Premise, profile: PolicyProfile, region: Region, semantics: str) -> None:
    """RejectedError where the state of a left side does not meet it."""
    formula, goal, state = premise.formula, goal_of(premise.goal), premise.state
    if set(state) != set(region.box) or goal not in region.goal_cases:
        raise RejectedError("the state of a left side is not one of the region's")
    if not holds(region_formula(region), state, {}):
        raise RejectedError("the state of a left side does not lie in the region")
    if semantics == MACHINE and any(abs(each) >= LARGEST or Fraction(float(each)) != each for each in state.values()):
        raise RejectedError("the state of a left side is not one of float64 numbers")
    at = state if goal is None else {**state, **{f"{GOAL}.{axis}": state[f"{goal}.{axis}"] for axis in "xy"}}
    actions = {agent: _act(profile.policy(agent), at, semantics) for agent in agents(formula)}
    if not holds(for_goal(formula, goal), at, actions):
        raise RejectedError("the state of a left side does not meet it")


def _act(policy: AgentPolicy, at: Mapping[str, Fraction], semantics: str) -> int:
    """The action that an agent takes in a state."""
    tree, node = policy.tree, ROOT
    while tree.feature[node] != NO_FEATURE:
        feature, threshold = policy.features[int(tree.feature[node])], float(tree.threshold[node])
        try:
            left = sides(feature, threshold, policy.numbers, semantics)[0]
        except InputError as error:
            raise RejectedError(error.what) from None
        node = int(tree.left[node] if holds(left, at, {}) else tree.right[node])
    return int(tree.action[node])


def _pair(certificate: DecisionCertificate, first: PolicyProfile, second: PolicyProfile | None) -> PolicyProfile:
    """Both profiles of a certificate about two as one; RejectedError where it claims anything but that agents act
    alike in them.
    """
    header, claim = certificate.header, certificate.claim
    if second is None:
        raise InputError("the certificate is about two profiles", "", "name the second one with --against")
    ensure_about(header.against, content_hash(second), "profile", "--against")
    compared = find_compared_agents(claim.formula, first)
    ensure_comparable(first, second, compared)
    other = claim.property is not None or header.eps or header.view is not None
    if other or claim.formula != alike(first, compared):
        raise RejectedError("the formula is not that agents act alike in both profiles")
    return pair_profiles(first, second)


def find_compared_agents(stated: Formula, first: PolicyProfile) -> list[str]:
    """The agents that a formula about two profiles compares, in the order of the first."""
    speaking = agents(stated)
    return [policy.agent for policy in first.agents if policy.agent in speaking]


def ensure_known_names(
    profile: PolicyProfile, header: GameHeader, team: str | None, stated: Sequence[Formula] = ()
) -> None:
    """InputError when a certificate, or the team of its claim, speaks of what the profile does not have."""
    region, world = header.region, profile.world
    entities = [entity.name for entity in world.agents + world.landmarks]
    bounded = {name for name in region.box if not name.startswith(f"{GOAL}.")}  # the goal's place is its landmark's
    differing, apart = ({name for a, b, _ in each for name in (a, b)} for each in (region.differences, region.apart))
    compared = differing | {f"{name}.{axis}" for name in apart for axis in "xy"}
    used = {*region.box, *differing, *(name for each in stated for name in coordinates(each))}
    strange = [
        *sorted(set(region.box) - bounded),
        *sorted(compared - bounded),
        *sorted(used - set(world.coordinates())),
        *sorted(apart - set(entities)),
        *sorted(set(region.goals) - set(world.goals)),
        *sorted({name for each in stated for name in agents(each)} - {policy.agent for policy in profile.agents}),
        *([f"the profile has no team {team}"] if team is not None and not profile.team(team) else []),
    ]
    if strange:
        what = "the certificate names what the profile does not have"
        raise InputError(what, ", ".join(map(escape_text, strange)), REMAKE)
    if set(header.inhabitant) != set(region.box) or (world.goals and not region.goals):
        raise InputError("the certificate's region and inhabitant do not fit together", "$.inhabitant", REMAKE)


UNKNOWN: Known = None, 0  # no action, and no part of the claim is known to hold
DENIED = -1  # in place of a tree's number: the denied claim was added, so no tree is left


# Where the search stands: a tree, its node, and what is known of each agent. Agents before the tree's are at leaves,
# those after it at their roots.
Place: TypeAlias = tuple[int, int, tuple[Known, ...]]
# A branch that must be closed: how many bounds of the path it keeps, what it adds to them, the choices that are still
# to be made, the parts that were chosen, and its place.
Branch: TypeAlias = tuple[int, Bounds, tuple[Choice, ...], tuple[Bounds, ...], Place]


def check(
    profile: PolicyProfile,
    claims: Sequence[Formula],
    region: Region,
    goal: str | None,
    semantics: Semantics,
    proof: Iterator[int],
) -> int:
    """The number of branches closed; RejectedError when `proof`, that of each claim, one after the other, does not show
    that all of them hold for this goal.
    """
    closed = sum(_check_claim(profile, claim, region, goal, semantics, proof) for claim in claims)
    if next(proof, None) is not None:
        raise RejectedError("the proof continues after its last branch")
    return closed


def _check_claim(
    profile: PolicyProfile, claim: Formula, region: Region, goal: str | None, semantics: Semantics, proof: Iterator[int]
) -> int:
    """The number of branches that the beginning of `proof` closes, which is the claim's own proof."""
    team = [policy for policy in profile.agents if policy.agent in agents(claim)]
    reading = Reading([policy.agent for policy in team], goal)
    start = reading.flat(region_formula(region), True)
    denied = cache(partial(reading.flat, claim, False))
    denied((UNKNOWN,) * len(team))  # numbers the claim's bounds and parts
    trees = [reading.tree(policy, semantics) for policy in team]
    edges, known, closed = reading.edges(), list[list[Known]](), 0
    try:
        for agent, tree in enumerate(trees):
            lemmas = Lemmas(reading, agent, tree, next(proof))
            if lemmas.claimed:
                closed += lemmas.close(start, edges, proof)
            known.append(lemmas.find_known())
        closed += Denial(denied, trees, known).close(start, edges, proof)
    except (StopIteration, IndexError):
        raise RejectedError("the proof ends early, or names a bound that its branch does not have") from None
    return closed


class DecisionWalk:
    """A walk through trees, one after the other, in which the proof closes every branch."""

    def __init__(self, trees: Sequence[SearchTree], known: Sequence[Sequence[Known]]) -> None:
        self.trees, self.known = trees, known

    def ends(self, leaf: int, known: tuple[Known, ...], proof: Iterator[int]) -> list[Flat]:
        """Returns the conditions that must be impossible when all agents are at leaves; `leaf` is the last agent's."""
        raise NotImplementedError

    def is_settled(self, place: Place) -> bool:
        """Returns True if a place needs no proof, because nothing that follows it can deny the claim."""
        return False

    def close(self, start: Flat, edges: Sequence[Edge], proof: Iterator[int]) -> int:
        """Closes every branch that begins with `start`; the number of branches."""
        closed, path = 0, list[int]()  # the numbers of the bounds of the branch at hand
        root = 0, ROOT, tuple(known[ROOT] for known in self.known)
        branches: list[Branch] = [] if start is None else [(0, start, (), (), root)]
        while branches:
            kept, (added, more), choices, chosen, place = branches.pop()
            path[kept:] = added
            if self.is_settled(place):
                closed += 1
            elif length := next(proof):
                cycle = [edges[path[next(proof)]] for _ in range(length)]
                if not negative(cycle):
                    raise RejectedError(f"the bounds of branch {closed} do not contradict each other: {cycle[:9]}")
                closed += 1
            else:
                choices += more
                while choices and any(part in chosen for part in choices[0]):  # it holds already
                    choices = choices[1:]
                kept = len(path)
                if choices:
                    parts = reversed(choices[0])
                    branches += [(kept, part, choices[1:], (*chosen, part), place) for part in parts]
                elif place[0] != DENIED:
                    branches += [(kept, flat, (), (), to) for flat, to in self.following(place, proof) if flat]
                else:
                    raise RejectedError(f"branch {closed} is left open: the claim may fail there")
        return closed

    def following(self, place: Place, proof: Iterator[int]) -> list[tuple[Flat, Place]]:
        """Returns the next places, the last first: the sides of the next test, or the ends when none is left."""
        tree, node, known = place
        leaf = ROOT
        while tree < len(self.trees):
            sides, below = self.trees[tree][node], self.known[tree]
            if not isinstance(sides, int):
                before, after, ((under, left), (over, right)) = known[:tree], known[tree + 1 :], sides
                return [
                    (over, (tree, right, (*before, below[right], *after))),
                    (under, (tree, left, (*before, below[left], *after))),
                ]
            leaf, tree, node = node, tree + 1, ROOT
        return [(flat, (DENIED, ROOT, known)) for flat in reversed(self.ends(leaf, known, proof))]


class Lemmas(DecisionWalk):
    """The walk over one agent's tree, which shows at each leaf that some of the claim's parts hold there."""

    def __init__(self, reading: Reading, agent: int, tree: SearchTree, claimed: int) -> None:
        super().__init__([tree], [[UNKNOWN] * len(tree)])
        self.reading, self.agent, self.tree, self.claimed = reading, agent, tree, claimed
        self.holding = [-claimed] * len(tree)  # sets of parts, as bits: none (0), or all (-1) where nobody comes

    def ends(self, leaf: int, known: tuple[Known, ...], proof: Iterator[int]) -> list[Flat]:
        """The denials of all parts that the proof says to hold at the leaf."""
        parts, action = next(proof), self.tree[leaf]
        assert isinstance(action, int)
        self.holding[leaf] &= parts
        return self.reading.deny_parts(self.agent, action, parts)

    def find_known(self) -> list[Known]:
        """Of each node: the action if it is a leaf, and the parts that hold at all leaves below it."""
        for node, split in reversed([*enumerate(self.tree)]):  # children come after their parents
            if not isinstance(split, int):
                (_, left), (_, right) = split
                self.holding[node] = self.holding[left] & self.holding[right]
        actions = [node if isinstance(node, int) else None for node in self.tree]
        return list(zip(actions, self.holding, strict=True))


class Denial(DecisionWalk):
    """The walk over all trees, which shows that the denied claim is impossible."""

    def __init__(
        self, denied: Callable[..., Flat], trees: Sequence[SearchTree], known: Sequence[Sequence[Known]]
    ) -> None:
        super().__init__(trees, known)
        self.denied = denied

    def ends(self, leaf: int, known: tuple[Known, ...], proof: Iterator[int]) -> list[Flat]:
        """The denied claim, given all actions."""
        return [self.denied(known)]

    def is_settled(self, place: Place) -> bool:
        """Returns True if what is known of the agents already makes the denied claim false."""
        tree, _, known = place
        return tree != DENIED and self.denied(known) is None


def negative(cycle: Sequence[Edge]) -> bool:
    """Returns True if bounds form a cycle whose sum is negative, so that they cannot hold together."""
    end, total = cycle[-1][1], 0
    for upper, lower, weight in cycle:
        if upper != end:
            return False
        end, total = lower, total + weight
    return total < 0 and len(cycle) < LONGEST
