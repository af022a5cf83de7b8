"""What the page that plays a profile knows: its world, trees, claims, states and networks, as plain data.

Does: writes them so that a browser needs nothing else; words a profile's world; chooses ranges in which every test of a
  tree can be crossed; records one episode of the trees where the world is at hand; claims as formulas with exact
  numbers; sums, vectors and outputs, and which two outputs are a force in the plane; the layers that decide for an
  expert's agent.
Assumes: a checked profile; `templates/play/engine.js` reads the data, `slice.js` draws it.
Does not: write HTML, decide or play in the browser.
"""

import base64
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.boxes import read_bounds, read_distances
from codegen.deciding import describe_action, list_decided
from codegen.errors import InputError
from codegen.floats import FLOAT32, deciding_double, rational_literal
from codegen.importers.reading import find_uncompared
from codegen.ir import Floats
from codegen.lowering.tracking import Edges, Start
from codegen.policy_json import content_hash
from codegen.sums import CONSTANT, Sum, divisor_of
from codegen.wording import NO_UNIT, describe_sum, format_count
from codegen.world import RegionSpec
from maviper.episodes import measures
from maviper.episodes.play import play, tree_policies
from maviper.evaluation.show import bounds
from maviper.experts.network import ACTOR, LAYERS, VALUE, NetworkExpert
from maviper.worlds import World
from verify.claims.catalogue import NAMES, Claim, find_claim
from verify.claims.claim import teams
from verify.claims.decisions import DecisionClaim, formula
from verify.claims.episodes import EpisodeClaim, KeepsApart
from verify.claims.formula import TRUE, And, Formula, Or
from verify.claims.wording import account_of, formula_document, spell_decisions
from verify.kinds import Kind
from verify.states.state import measurable

BOUNDED = 1e6  # a range that is wider on one side says nothing of what is seen
MARGIN = 0.5  # of the thresholds' span, beyond them
MAX_NAMED = 8  # features or actions that a paragraph names


@dataclass(frozen=True)
class Recorded:
    """An episode of the trees: what each agent observed before each step, [steps, n_features] each, and its words."""

    seen: tuple[Floats, ...]
    label: str


def record_episode(profile: ir.PolicyProfile, world: World) -> Recorded:
    """One on-policy episode, of the first seed that such episodes start from."""
    controller = tree_policies(profile.agents)
    seed = measures.ON_POLICY_SEEDS
    episodes = play(world, [controller] * len(profile.agents), world.start_from_seeds([seed]))
    steps = int(episodes.alive[:, 0].any(axis=1).sum())
    seen = tuple(rows[:steps, 0] for rows in episodes.observations)
    figures = [
        f"{measure.name} {value:.4g}"
        for measure, value in zip(world.measures, episodes.values[:, 0].tolist(), strict=True)
    ]
    return Recorded(
        seen, f"The recorded episode, of seed {seed}, took {format_count(steps, 'step')}: {', '.join(figures)}."
    )


def about(profile: ir.PolicyProfile) -> str:
    """Describes the game, in a paragraph."""
    world, teams = profile.world, list(dict.fromkeys(policy.team for policy in profile.agents))
    agents = [policy.agent for policy in profile.agents]
    who = f"{len(agents)} agents" if len(agents) > 1 else "one agent" + f", {agents[0]}" * (agents[0] != "agent")
    if len(teams) > 1:
        who += f" in {len(teams)} teams ({', '.join(teams)})"
    first = profile.agents[0]
    alike = all((each.actions, each.outputs) == (first.actions, first.outputs) for each in profile.agents)
    observed = {len(policy.features) - len(policy.memory) for policy in profile.agents}
    each = "It" if len(agents) == 1 else "Each"
    sees = f"{each} observes {format_count(max(observed), 'number')}" if len(observed) == 1 else "They observe"
    seen, kept = first.features[: len(first.features) - len(first.memory)], first.memory
    sees += f" ({_list_names([feature.name for feature in seen])})" if len(agents) == 1 else ""
    sees += f", remembers {_list_names([each.name for each in kept])}" if len(agents) == 1 and kept else ""
    if len(observed) > 1:
        sees += f" {min(observed)} to {max(observed)} numbers"
    does = f"and {'' if len(observed) == 1 else 'each '}{_does(first, alike)}"
    moment = f"every {world.dt:g} s" if world.dt else "at each step"
    length = f", for at most {format_count(world.episode_steps, 'step')}" if world.episode_steps > 1 else ""
    places = f" and {format_count(len(world.landmarks), 'landmark')}" if world.landmarks else ""
    # another's environment is known by its own name, ours by the name that commands take
    name = world.reference if ":" in world.reference else world.name
    game = f"{name} is a game of {who}{places}"
    if profile.provenance.algorithm == "imported" and not world.reference:
        game = f"An imported tree for {who}" if len(agents) == 1 else f"Imported trees for {who}"
    trusted = [f" The source of {agent} was not compared." for agent in find_uncompared(profile)]
    return f"{game}. {sees} {does} {moment}{length}.{''.join(trusted)}"


def _does(policy: ir.AgentPolicy, alike: bool) -> str:
    """Describes what an agent chooses or gives; `alike`: as do all others."""
    if not alike:
        return "chooses an action or gives numbers" if policy.outputs else "chooses an action"
    if not policy.outputs:
        named = list_decided(policy)
        return f"chooses one of {format_count(len(named), 'action')} ({_list_names(named)})"
    gives = [each.name + (f" in {each.unit}" if each.unit not in NO_UNIT else "") for each in policy.outputs]
    return f"gives {format_count(len(policy.outputs), 'number')} ({_list_names(gives)})"


def _list_names(names: Sequence[str]) -> str:
    shown = list(names[:MAX_NAMED])
    return ", ".join(shown) + (", ..." if len(names) > MAX_NAMED else "")


def _turning(policy: ir.AgentPolicy, place: int) -> Iterator[float]:
    """Where a feature alone, all others being 0, turns a test of a sum, or takes an output to one of its bounds."""
    tree, width = policy.tree, len(policy.features)
    tested = [
        (tree.sums[int(tree.feature[node]) - width], float(tree.threshold[node]))
        for node in ir.splits(tree)
        if tree.feature[node] >= width
    ]
    for vector in tree.vectors:
        for each, output in zip(vector, policy.outputs, strict=True):
            tested += [(each, bound) for bound in (output.low, output.high) if bound is not None]
    for each, limit in tested:
        exact = each.expand()
        rest, weight = Fraction(limit) - exact.get(CONSTANT, 0), exact.get(place, Fraction(0))
        if abs(rest) < BOUNDED * abs(weight):
            yield float(rest / weight)


def bound_sliders(policy: ir.AgentPolicy, seen: Floats | None = None) -> list[tuple[float, float]]:
    """For each feature the least and the most that a slider shows: what the profile says was seen, or its stated range
    where that is bounded, else what was `seen` [n, n_features]; with the tree's thresholds, and a margin.
    """
    tree = policy.tree
    ranges: list[tuple[float, float]] = []
    for place, feature in enumerate(policy.features):
        if not policy.seen and -BOUNDED < feature.low < feature.high < BOUNDED:
            ranges.append((feature.low, feature.high))
            continue
        known = tree.threshold[tree.feature == place].astype(float).tolist() + list(_turning(policy, place))
        known += [policy.seen[place][0], policy.seen[place][-1]] if policy.seen else []
        known += [] if seen is None else seen[:, place].astype(float)[np.isfinite(seen[:, place])].tolist()
        low, high = min(known, default=0.0), max(known, default=0.0)
        margin = MARGIN * (high - low) or max(1.0, abs(high))
        ranges.append((max(feature.low, low - margin), min(feature.high, high + margin)))
    return ranges


def layers_of(expert: NetworkExpert, agent: str) -> list[dict[str, str]]:
    """The layers that decide: float32 weights [inputs, outputs], row by row, little-endian, in base64."""
    net = ACTOR if expert.centralized else VALUE
    layers = [
        (expert.tensors[f"{agent}.{net}.{layer}.weight"], expert.tensors[f"{agent}.{net}.{layer}.bias"])
        for layer in LAYERS
    ]
    return [{"weight": _pack_numbers(weight), "bias": _pack_numbers(bias)} for weight, bias in layers]


def _pack_numbers(numbers: ir.Float32) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers, "<f4").tobytes()).decode()


DIGITS = 3  # of weights, where people read them


def tree_data(policy: ir.AgentPolicy) -> dict[str, Any]:
    """Returns what the tree of such an agent has beside its arrays: its sums and those of its leaves, with words."""
    tree, names = policy.tree, [feature.name for feature in policy.features]
    if not tree.arithmetic:
        return {}
    return {
        "arithmetic": tree.arithmetic,
        "gives": tree.gives,
        "sums": [_sum(each, names) for each in tree.sums],
        "vectors": [[_sum(each, names) for each in vector] for vector in tree.vectors],
    }


def _sum(each: Sum, names: Sequence[str]) -> dict[str, Any]:
    return {"terms": _terms(each), "words": describe_sum(each.terms, names, DIGITS)}


def _terms(each: Sum) -> list[list[Any]]:
    """Weights and what they weigh; a text divides by its number."""
    divisors = [divisor_of(weight) for weight, _ in each.terms]
    weights = [weight if over is None else repr(over) for over, (weight, _) in zip(divisors, each.terms, strict=True)]
    places = [_terms(place) if isinstance(place, Sum) else place for _, place in each.terms]
    return [[weight, place] for weight, place in zip(weights, places, strict=True)]


def outputs_data(policy: ir.AgentPolicy, ranges: Sequence[tuple[float, float]]) -> list[dict[str, Any]]:
    """The outputs of an agent. `ranges`: of its features, as sliders show them."""
    data: list[dict[str, Any]] = []
    for place, output in enumerate(policy.outputs):
        reached = [_bound_sum(vector[place], ranges) for vector in policy.tree.vectors]
        least, most = min(low for low, _ in reached), max(high for _, high in reached)
        # a bar shows the output's bounds, where it has none what intervals say of its sums
        span = least if output.low is None else output.low, most if output.high is None else output.high
        known = {"name": output.name, "unit": output.unit, "low": output.low, "high": output.high}
        data.append({**known, "span": span})
    return data


def _bound_sum(each: Sum, ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
    ends = [
        [float(weight)] * 2 if place == CONSTANT else sorted(float(weight) * end for end in ranges[place])
        for place, weight in each.expand().items()
    ]
    return sum(low for low, _ in ends), sum(high for _, high in ends)


def plane(policy: ir.AgentPolicy) -> tuple[int, int] | None:
    """The outputs that are the two parts of an arrow: of one unit, with names that differ in an x and a y alone."""
    for first, one in enumerate(policy.outputs):
        for second, other in enumerate(policy.outputs):
            unlike = [pair for pair in zip(one.name.lower(), other.name.lower(), strict=False) if pair[0] != pair[1]]
            if len(one.name) == len(other.name) and one.unit == other.unit and unlike == [("x", "y")]:
                return first, second
    return None


ALIKE = "alike"  # the name of the claim that two profiles act alike
EVERY_STEP = "about every step, of which a page plays some"
MAX_PARTS = 20_000  # of a formula that a page evaluates while somebody drags an agent


@dataclass(frozen=True)
class Shown:
    """A claim on the page. `verdict`: in words, with the region that it is about; "" where nobody asked. `proved`: the
    region, where a monitor can be made from the proof; of a claim about episodes, their starts, or edges for ever.
    """

    claim: Claim
    verdict: str = ""
    proved: RegionSpec | Start | Edges | None = None


@dataclass(frozen=True)
class Told:
    """A claim about a stated system: its name, the sentence that its proof shows, and what a monitor of the proof says
    at each step of the recorded episode.
    """

    name: str
    sentence: str
    words: tuple[str, ...]


@dataclass(frozen=True)
class Stored:
    """A world state behind a button: coordinates by name; `claim`: the place of the claim that fails there."""

    label: str
    claim: int
    position: Mapping[str, float]
    goal: str | None


@dataclass(frozen=True)
class Second:
    """Another profile of the same agents, beside the first. `visits`: as in `Contents`."""

    profile: ir.PolicyProfile
    agents: tuple[str, ...]  # that are compared
    verdicts: tuple[str, ...]  # of each of these, in words
    numbers: tuple[str, ...] = ()  # how often who acts differently, in words
    visits: Mapping[str, Sequence[int]] = field(default_factory=dict[str, Sequence[int]])


@dataclass(frozen=True)
class Contents:
    """The contents of a page beside the profile. `visits`: agent -> decisions at each node; `expert`: of all agents."""

    claims: tuple[Shown, ...] = ()
    states: tuple[Stored, ...] = ()
    visits: Mapping[str, Sequence[int]] = field(default_factory=dict[str, Sequence[int]])
    expert: NetworkExpert | None = None
    recorded: Recorded | None = None  # an episode to go through, where agents have no places
    told: tuple[Told, ...] = ()  # of stated systems, in the episode that is recorded
    second: Second | None = None  # with it, that both act alike is what the first claims of the page say


def usual_claims(profile: ir.PolicyProfile) -> tuple[Shown, ...]:
    """The built-in claims that can be made about a profile without saying more; where there are none, that each team
    keeps apart from the others.
    """
    if any(policy.outputs for policy in profile.agents):
        return ()  # these claims speak of actions and of episodes
    claims: list[Claim] = []
    for name in NAMES:
        try:
            claim = find_claim(name, profile)
            judged = _claim(profile, Shown(claim))
        except InputError:  # it needs another team, or a parameter
            continue
        if judged["unjudged"] != EVERY_STEP:
            claims.append(claim)
    for team in () if claims else teams(profile):
        others = tuple(policy.agent for policy in profile.agents if policy.team != team)
        if others and profile.world.contact_force:
            claims.append(find_claim(KeepsApart.title, profile, team, others=others))
    return tuple(map(Shown, claims))


def knows_motion(profile: ir.PolicyProfile) -> bool:
    """Returns True if a page knows how all move: entities with places, observations made of them, actions that push."""
    known = all(feature.meaning for policy in profile.agents for feature in policy.features)
    entities = profile.world.agents + profile.world.landmarks
    return bool(entities) and known and not any(policy.outputs for policy in profile.agents)


def document(profile: ir.PolicyProfile, contents: Contents) -> dict[str, Any]:
    """The data of a page."""
    experts = None if contents.expert is None else [layers_of(contents.expert, one.agent) for one in profile.agents]
    second, recorded = contents.second, contents.recorded
    claims = [_claim(profile, shown) for shown in contents.claims]
    erring = {claim["team"] for claim in claims if claim["eps"] is not None}

    def entity(one: ir.EntitySpec) -> dict[str, Any]:
        return {
            "name": one.name,
            "size": one.size,
            "force": one.force,
            "maxSpeed": one.max_speed,
            "collides": one.collides,
            "start": one.start,
        }

    return {
        "profile": content_hash(profile),
        "against": None if second is None else content_hash(second.profile),
        "numbers": [] if second is None else list(second.numbers),
        "tool": profile.provenance.tool,
        "about": about(profile),
        "recorded": recorded
        and {"label": recorded.label, "seen": [rows.astype(float).tolist() for rows in recorded.seen]},
        "world": {
            "name": profile.world.name,
            "reference": profile.world.reference,
            "agents": [entity(one) for one in profile.world.agents],
            "landmarks": [entity(one) for one in profile.world.landmarks],
            "goals": list(profile.world.goals),
            "dt": profile.world.dt,
            "damping": profile.world.damping,
            "low": profile.world.start_low,
            "high": profile.world.start_high,
            "steps": profile.world.episode_steps,
            "contactForce": profile.world.contact_force,
            "contactMargin": profile.world.contact_margin,
        },
        "agents": [
            _agent(policy, contents, recorded and recorded.seen[place], policy.team in erring)
            for place, policy in enumerate(profile.agents)
        ],
        "claims": [*_alike(profile, second), *map(_encode_unjudged, contents.told), *claims],
        "states": [
            {"label": state.label, "claim": state.claim, "position": dict(state.position), "goal": state.goal}
            for state in contents.states
        ],
        "experts": experts,
    }


# --- trees


def _agent(policy: ir.AgentPolicy, contents: Contents, seen: Floats | None, erring: bool) -> dict[str, Any]:
    """An agent with its tree, the ranges of its sliders, what it observes where that is not float32, and what it gives.
    `seen`: as of `bound_sliders`; `erring`: whether a claim allows errors of what it observes.
    """
    second, visits, shown = contents.second, contents.visits.get(policy.agent), bound_sliders(policy, seen)
    entry: dict[str, Any] = {
        "name": policy.agent,
        "team": policy.team,
        "features": [_feature(feature) for feature in policy.features],
        "actions": [_action(policy, action) for action in policy.actions],
        "tree": _tree(policy.tree, visits) | tree_data(policy),
    }
    if policy.memory:
        entry["machine"] = list(bounds(policy))
    if second is not None:  # who is not compared acts as in the first
        compared = second.profile if policy.agent in second.agents else None
        tree = policy.tree if compared is None else compared.policy(policy.agent).tree
        entry["other"] = _tree(tree, visits if compared is None else second.visits.get(policy.agent))
    entry |= {"cuts": _cuts(policy) if erring else None, "shown": shown}
    if policy.numbers != FLOAT32:
        entry["numbers"] = policy.numbers
    if policy.outputs:
        entry |= {"outputs": outputs_data(policy, shown), "plane": plane(policy)}
    return entry


def _action(policy: ir.AgentPolicy, action: ir.ActionSpec) -> dict[str, Any]:
    """An action, with what it updates: the feature's place, whether that is kept, and what is added."""
    places = {each.name: place for place, each in enumerate(policy.features)}
    updates = [[places[each.memory], int(each.adds), each.value] for each in action.updates]
    return {"name": describe_action(action), "effect": action.effect} | ({"updates": updates} if updates else {})


def _tree(tree: ir.Tree, visits: Sequence[int] | None) -> dict[str, Any]:
    return {
        "feature": tree.feature.tolist(),
        "threshold": tree.threshold.astype(float).tolist(),
        "left": tree.left.tolist(),
        "right": tree.right.tolist(),
        "action": tree.action.tolist(),
        "visits": None if visits is None else list(visits),
    }


def _feature(feature: ir.FeatureSpec) -> dict[str, Any]:
    meaning = feature.meaning
    return {
        "name": feature.name,
        "unit": feature.unit,
        "low": feature.low,
        "high": feature.high,
        "terms": None if meaning is None else [[weight, name] for weight, name in meaning.terms],
        "function": "" if meaning is None else meaning.function,
        "measured": meaning is not None and measurable(meaning),
    } | ({} if feature.initial is None else {"initial": feature.initial})


@dataclass(frozen=True, order=True)
class Cut:
    """Where a test divides what a feature measures before it is rounded: left at most `at`, or below it."""

    at: Fraction
    closed: bool


def cut_of(meaning: ir.Meaning, threshold: np.float32) -> Cut | bool:
    """Where a test of a measured feature divides its sums; True or False where all go left, or none does."""
    if not meaning.function:
        last = deciding_double(threshold)  # the sum is rounded to double, then to float32
        above = math.nextafter(last, math.inf)
        return Cut((Fraction(last) + Fraction(above)) / 2, int(np.float64(last).view(np.uint64)) % 2 == 0)
    lowest = -1 if meaning.function == "sign" else 0
    if threshold < lowest:
        return False
    return True if threshold >= 1 else Cut(Fraction(0), bool(threshold >= 0))


def _cuts(policy: ir.AgentPolicy) -> list[dict[str, Any] | bool | None]:
    """For each node the cut of its test, with its place among those of the same feature; of tests of what is not
    measured, and of leaves, None.
    """
    tree, by_node = policy.tree, dict[int, Cut | bool]()
    for node in ir.splits(tree):
        meaning = policy.features[int(tree.feature[node])].meaning
        if meaning is not None and measurable(meaning):
            by_node[node] = cut_of(meaning, tree.threshold[node])
    of_feature: dict[int, set[Cut]] = {}
    for node, cut in by_node.items():
        if isinstance(cut, Cut):
            of_feature.setdefault(int(tree.feature[node]), set()).add(cut)
    ranks = {feature: {cut: rank for rank, cut in enumerate(sorted(cuts))} for feature, cuts in of_feature.items()}

    def encode_cut(node: int) -> dict[str, Any] | bool | None:
        cut = by_node.get(node)
        if not isinstance(cut, Cut):
            return cut
        return {"at": rational_literal(cut.at), "closed": cut.closed, "rank": ranks[int(tree.feature[node])][cut]}

    return [encode_cut(node) for node in range(len(tree.feature))]


# --- claims


def _claim(profile: ir.PolicyProfile, shown: Shown) -> dict[str, Any]:
    claim = shown.claim
    entry: dict[str, Any] = {
        "name": claim.name,
        "title": f"{claim.shown} of the {claim.team}",
        "team": claim.team,
        "sentence": claim.name,
        "verdict": shown.verdict,
        "formula": None,
        "eps": None,
        "episode": None,
        "unjudged": "about no single state",
        "region": _region(shown.proved) if isinstance(shown.proved, RegionSpec) else None,
    }
    if isinstance(shown.proved, Edges):
        entry |= {"region": _region(shown.proved.region), "coasting": shown.proved.coasting}
    if isinstance(shown.proved, Start):
        followed = [at for at, policy in enumerate(profile.agents) if policy.agent in shown.proved.followed]
        entry["follows"] = {"bounds": _region(shown.proved.region), "steps": shown.proved.steps, "followed": followed}
    known = JUDGED.get(claim.kind)
    return entry if known is None else entry | {"sentence": known.spell(claim)} | known.judge(profile, claim)


def _region(spec: RegionSpec) -> dict[str, Any]:
    """A region as a monitor compares it."""
    return {
        "bounds": [list(bound) for bound in read_bounds(spec)],
        "apart": [list(pair) for pair in read_distances(spec)],
        "goals": list(spec.goals),
    }


def _encode_unjudged(one: Told) -> dict[str, Any]:
    """A claim that is not judged here. In a stated system a page knows the states of one episode alone."""
    unsaid: dict[str, Any] = {"team": "", "verdict": "", "formula": None, "eps": None, "episode": None, "region": None}
    said = {"name": one.name, "title": f"{one.name} in the stated system", "sentence": one.sentence}
    return unsaid | said | {"unjudged": "proved for the stated system", "words": list(one.words)}


def _alike(profile: ir.PolicyProfile, second: Second | None) -> list[dict[str, Any]]:
    """That both profiles act alike: all agents that are compared, then each."""
    if second is None:
        return []
    names = [policy.agent for policy in profile.agents]
    places = [names.index(agent) for agent in second.agents]
    each = [
        {"title": f"{agent} acts alike", "alike": [place], "verdict": verdict}
        for agent, place, verdict in zip(second.agents, places, second.verdicts, strict=True)
    ]
    everyone = [{"title": "all agents act alike", "alike": places, "verdict": ""}] if len(each) > 1 else []
    unsaid: dict[str, Any] = {"name": ALIKE, "team": "", "formula": None, "eps": None, "episode": None, "region": None}
    said = "the same action in both profiles"
    return [unsaid | {"sentence": said, "unjudged": ""} | one for one in (*everyone, *each)]


def _decisions(profile: ir.PolicyProfile, claim: DecisionClaim) -> dict[str, Any]:
    stated = formula(profile, claim)
    if stated == TRUE:  # about leaves, so of no world state
        return {}
    shared = _share_parts(stated)
    if shared is None:
        return {"unjudged": f"not judged here: more than {MAX_PARTS:,} inequalities and actions"}
    if not claim.eps:
        return {"formula": shared}
    if any(policy.tree.sums or policy.numbers != FLOAT32 for policy in profile.team(claim.team)):
        return {"unjudged": "not judged here: errors of features that sums or float64 tests read"}
    return {"formula": shared, "eps": rational_literal(claim.eps)}


def _share_parts(stated: Formula) -> list[dict[str, Any]] | None:
    """The formula as a list of its joined parts, each once, the whole last; numbers in a part are places in the list.
    None where they have more than `MAX_PARTS` parts of their own.

    Of 720 matchings of six agents there are 4,320 pairs, and only 36 different ones.
    """
    found: dict[Formula, int] = {}
    written: list[dict[str, Any]] = []
    left = MAX_PARTS

    def place(node: Formula) -> int | dict[str, Any]:
        nonlocal left
        if not isinstance(node, (And, Or)):
            return formula_document(node)
        if node not in found:
            left -= len(node.parts)
            if left < 0:  # whatever follows
                raise OverflowError
            parts = [place(part) for part in node.parts]
            written.append({"all" if isinstance(node, And) else "any": parts})
            found[node] = len(written) - 1
        return found[node]

    try:
        whole = place(stated)
    except OverflowError:
        return None
    return written if isinstance(whole, int) else [{"all": [whole]}]


def _episode(profile: ir.PolicyProfile, claim: EpisodeClaim) -> dict[str, Any]:
    if claim.by_edges:
        return {"unjudged": EVERY_STEP}
    agents = [policy.agent for policy in profile.agents]
    entities = [one.name for one in profile.world.agents + profile.world.landmarks]
    account = account_of(claim)
    judged = {
        "team": [agents.index(policy.agent) for policy in profile.team(claim.team)],
        "marks": [entities.index(name) for name in account.marks(profile)],
        "pairs": account.way(profile),
        "steps": claim.steps,
        "radius": rational_literal(Fraction(claim.radius)),
        "always": claim.always,
        "apart": claim.apart,
    }
    return {"episode": judged}


def _spell_episodes(claim: EpisodeClaim) -> str:
    return account_of(claim).sentence


class Judging(NamedTuple):
    """The words in which the page tells claims of a kind, and what it judges states by, if it does."""

    spell: Callable[[Any], str]
    judge: Callable[[ir.PolicyProfile, Any], dict[str, Any]]


JUDGED: Mapping[Kind, Judging] = {
    Kind.DECISIONS: Judging(spell_decisions, _decisions),
    Kind.LEAVES: Judging(spell_decisions, _decisions),
    Kind.EPISODES: Judging(_spell_episodes, _episode),
}
