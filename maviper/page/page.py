"""The page that plays a profile: one HTML file that needs no network, and the picture of its trees.

Does: renders data, generated code and trees; puts a report's verdicts beside the claims, with a button for each
  counterexample, an episode of a world file with the monitor's word at each step, or a second profile side by side,
  hatched where they act differently; lays trees out as one SVG, in which widths of edges and numbers at leaves are
  shares of on-policy decisions.
Assumes: `maviper.page.document` made the data; results of one profile, in the order of the report; a certificate with
  the world file beside it; trees that are looked at (`codegen.targets.svg` refuses larger ones).
Does not: decide, open a browser or write files.
"""

import contextlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from codegen import ir
from codegen.errors import InputError
from codegen.ir import FORK, PHYSICS
from codegen.lowering.covering import Cover
from codegen.lowering.lower import NESTED, lower
from codegen.lowering.model import Agent
from codegen.lowering.render import render
from codegen.lowering.tracking import Edges, Start
from codegen.lowering.watching import WORDS
from codegen.policy_json import content_hash
from codegen.profiles import ensure
from codegen.targets.svg import Box, Edge, Picture, picture
from codegen.wording import format_count
from codegen.world import RegionSpec
from maviper.compilation.games import restate_formula
from maviper.compilation.monitors import Proved, load_proof, spec_of
from maviper.episodes import measures
from maviper.episodes.trees import on_policy
from maviper.evaluation.players import find_shipped
from maviper.evaluation.show import bounds, rules
from maviper.experts.network import NetworkExpert
from maviper.files import runs
from maviper.page.document import (
    Contents,
    Recorded,
    Second,
    Shown,
    Stored,
    Told,
    document,
    knows_motion,
    record_episode,
)
from maviper.verification.diff import Compared
from maviper.worlds import World
from maviper.worlds.matching import matching_world
from maviper.worlds.stated.certified import read_certificate
from maviper.worlds.stated.environment import StatedEnv
from verify.checker import certificate as certificates
from verify.checker import decisions
from verify.checker.certificate import MAX_BYTES
from verify.checker.episodes import certificates as episodes
from verify.claims.decisions import DecisionClaim
from verify.claims.formula import agents
from verify.claims.region import Region
from verify.claims.region_files import START, name_region
from verify.claims.wording import OwnFormula
from verify.kinds import MACHINE, REAL
from verify.result import AnyResult, Verdict
from verify.systems.remembering import with_memory
from verify.verdicts.differences import unite_actions

FILE = "play.html"
MAX_RULES = 200  # leaves of an agent that a page shows as text, where scripts are off
MAX_CODE_NODES = 20_000  # of all trees whose generated code is in the page too


def contents_of(
    profile: ir.PolicyProfile, claims: tuple[Shown, ...], states: tuple[Stored, ...] = (), played: World | None = None
) -> Contents:
    """Returns the contents of a page of these claims and states, with visits in on-policy episodes and the shipped
    expert; of a world that a user names (`played`), one episode.
    """
    world = matching_world(profile)
    if world is None:
        episode = None if played is None else record_episode(profile, played)
        return Contents(claims, states, read_visits(profile), recorded=episode)
    visits = visits_of(profile, world)
    player = find_shipped(profile.provenance.expert, world)
    expert = player.controller if player is not None and isinstance(player.controller, NetworkExpert) else None
    return Contents(claims, states, visits, expert)


def read_visits(profile: ir.PolicyProfile) -> dict[str, list[int]]:
    """Returns the visits that the profile itself states: in held-out episodes of its extraction, against experts."""
    return {policy.agent: policy.tree.visits.tolist() for policy in profile.agents if len(policy.tree.visits)}


def visits_of(profile: ir.PolicyProfile, world: World) -> dict[str, list[int]]:
    """Agent -> how many decisions each of its leaves makes in on-policy episodes, by node."""
    episodes = on_policy(profile, world)
    return {
        policy.agent: np.bincount(
            ir.apply(policy.tree, seen[episodes.alive[..., place]]), minlength=len(policy.tree.feature)
        ).tolist()
        for place, (policy, seen) in enumerate(zip(profile.agents, episodes.observations, strict=True))
    }


def shows(file: Path, profile: ir.PolicyProfile) -> bool:
    """Returns True if a file is a page of this profile alone."""
    with contextlib.suppress(OSError, UnicodeDecodeError):
        return f'"profile":"{content_hash(profile)}","against":null,' in file.read_text(encoding="utf-8")
    return False


def unplayable(*profiles: ir.PolicyProfile) -> str:
    """Why no page plays these profiles, in words; "": one does."""
    if any(profile.world.options.get(PHYSICS) == FORK for profile in profiles):
        return f"a page moves agents as mpe2 does, and this world moves them as the authors' code ({PHYSICS}={FORK})"
    return ""


def page(profile: ir.PolicyProfile, contents: Contents) -> str:
    """The page's HTML. ProfileError for a profile that is not sound, InputError where no page plays it."""
    why = unplayable(profile, *([] if contents.second is None else [contents.second.profile]))
    if why:
        raise InputError(why, "", "leave the page out")
    data = document(ensure(profile), contents)
    leaves = sum(len(ir.leaves(policy.tree)) for policy in profile.agents)
    said = f"{format_count(len(profile.agents), 'agent')}, {format_count(leaves, 'leaf')}"
    said = said if contents.second is None else "two profiles compared"
    return render(
        "play/page.html.j2",
        title=f"{profile.world.name}: {said}",
        data=data,
        placed=knows_motion(profile),
        text=Markup(json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")),
        module=_module(profile),
        rules=[_rules(policy) for policy in profile.agents],
    )


def _module(profile: ir.PolicyProfile) -> Markup | None:
    """The generated JavaScript without its exports, since a page from a file path loads no modules; None where it is
    too large for a page, or would be a walk over tables.
    """
    if sum(len(policy.tree.feature) for policy in profile.agents) > MAX_CODE_NODES:
        return None
    model = lower(profile)
    if model.style != NESTED:
        return None
    code = render("javascript/module.js.j2", model=model).replace("\nexport ", "\n")
    # in strings alone, which stay what they are
    return Markup(re.sub(r"<(?=[/!]|script)", r"\\x3c", code, flags=re.IGNORECASE))


def _rules(policy: ir.AgentPolicy) -> dict[str, object]:
    more = max(0, len(ir.leaves(policy.tree)) - MAX_RULES)
    told = [*bounds(policy), *islice(rules(policy), MAX_RULES)]
    return {"name": policy.agent, "team": policy.team, "rules": told, "more": more}


GAP = 34  # above a tree, for its title
THINNEST, WIDEST = 1.0, 9.0  # of edges


@dataclass(frozen=True)
class Drawn:
    """A tree with its place: `top` of its picture, and of each edge and node the share of decisions, if known."""

    picture: Picture
    top: float
    edges: tuple[tuple[Edge, float], ...]  # with its width
    boxes: tuple[tuple[Box, float | None], ...]
    agent: Agent


def svg(profile: ir.PolicyProfile, agents: Sequence[str]) -> str:
    """The picture of these agents' trees. InputError for a tree that no page shows."""
    world = matching_world(profile)
    visits = read_visits(profile) if world is None else visits_of(profile, world)
    drawn = tuple(_stack_pictures(profile, agents, visits))
    width = max(one.picture.width for one in drawn)
    height = drawn[-1].top + drawn[-1].picture.height
    return render("svg/team.svg.j2", profile=profile.world.name, trees=drawn, width=width, height=height)


def _stack_pictures(
    profile: ir.PolicyProfile, agents: Sequence[str], visits: Mapping[str, Sequence[int]]
) -> Iterator[Drawn]:
    top = 0.0
    for agent in lower(profile).agents:
        if agent.name not in agents:
            continue
        drawing, shares = picture(agent), _shares(profile.policy(agent.name).tree, visits.get(agent.name))
        split = [box.node for box in drawing.boxes if box.split]
        children = [child for node in split for child in (node.left, node.right)]
        edges = [
            (edge, THINNEST + (WIDEST - THINNEST) * shares[child] if shares else THINNEST)
            for edge, child in zip(drawing.edges, children, strict=True)
        ]
        boxes = [(box, shares[box.node.id] if shares else None) for box in drawing.boxes]
        yield Drawn(drawing, top + GAP, tuple(edges), tuple(boxes), agent)
        top += GAP + drawing.height


def _shares(tree: ir.Tree, visits: Sequence[int] | None) -> list[float] | None:
    """The share of decisions that goes through each node. `visits`: of leaves, by node; None where they are unknown."""
    if visits is None or not sum(visits):
        return None
    counts = [float(count) for count in visits]
    for node in reversed(list(ir.splits(tree))):  # children come after their parents
        counts[node] = counts[tree.left[node]] + counts[tree.right[node]]
    return [count / counts[ir.ROOT] for count in counts]


SHOWN = 3  # zones of an agent that have a button
ALIKE, DIFFERENT, OPEN = "alike in the whole region", "acts differently in the region", "no answer for the region"
COMPARED = {"PROVED": ALIKE, "VIOLATED": DIFFERENT}


def compared_page_of(compared: Compared) -> str:
    """The page of two profiles."""
    first, second = compared.found.first, compared.found.second
    if any(policy.memory for policy in first.agents):  # the page has one list of actions for both trees
        first, second = unite_actions(first, second)
    facts = compared.facts["agents"]
    agents = tuple(one["agent"] for one in facts)
    within = " in real arithmetic" if compared.found.question.semantics == REAL else ""
    verdicts = tuple(COMPARED.get(one["verdict"], OPEN) + within for one in facts)
    states = tuple(
        state for place, one in enumerate(facts) for state in _iterate_states(one, place + (len(agents) > 1))
    )
    world = matching_world(first)
    numbers = tuple(f"{label}: {text}" for label, text in compared.lines if label)
    if world is None:
        return page(first, Contents((), states, second=Second(second, agents, verdicts, numbers)))
    other = Second(second, agents, verdicts, numbers, visits_of(second, world))
    return page(first, Contents((), states, visits_of(first, world), second=other))


def _iterate_states(one: Mapping[str, Any], claim: int) -> Iterator[Stored]:
    """A state of each of an agent's largest zones. `claim`: the place of what is said of it on the page."""
    shown = [zone for zone in one["zones"] if zone["example"]][:SHOWN]
    if not shown and one["example"]:
        yield Stored(f"{one['agent']} acts differently", claim, *_read_state(one["example"]))
    for zone in shown:
        named = f"{one['agent']}: {' or '.join(zone['actions'])}, leaf {' or '.join(map(str, zone['leaves']))}"
        yield Stored(named, claim, *_read_state(zone["example"]))


def _read_state(state: Mapping[str, Any]) -> tuple[dict[str, float], str | None]:
    position = {name: float(value) for name, value in state["position"].items()}
    return position, state["goal"] or None


def page_of(profile: ir.PolicyProfile, results: Sequence[AnyResult]) -> str:
    """The page of a profile with these results; without those over observations, which are not about its states."""
    results = [one for one in results if one.viewed is None]
    states = [_store_counterexample(number, result) for number, result in enumerate(results)]
    shown = tuple(Shown(result.claim, _verdict(profile, result), _find_watchable(result)) for result in results)
    return page(profile, contents_of(profile, shown, tuple(filter(None, states))))


def with_proof(contents: Contents, profile: ir.PolicyProfile, certificate: Path) -> Contents:
    """Adds to a page the claim of a certificate, first, and what a monitor of its proof says; of a claim about a stated
    system in an episode of it, which is recorded. InputError and RefusedError as for a monitor.
    """
    proved = load_proof(certificate, profile)
    if proved.stated and not isinstance(proved.region, RegionSpec):
        claim, episode = play_claim(profile, certificate, proved)
        return replace(contents, told=(claim, *contents.told), recorded=episode)
    return replace(contents, claims=(load_claim(profile, certificate, proved), *contents.claims))


def load_claim(profile: ir.PolicyProfile, certificate: Path, proved: Proved) -> Shown:
    """The claim of a certificate, with the region of its proof. InputError for the claim of another subject."""
    text = runs.read_unpacked(certificate, MAX_BYTES)
    if isinstance(proved.region, (Start, Edges)):
        stated = certificates.read(text, str(certificate), episodes.FORMS)
        where = f"{Verdict.PROVED.value} in {_name_region(profile, stated.header.region)}"
        return Shown(stated.claim, where, proved.region)
    if proved.stated and isinstance(proved.region, RegionSpec):
        # about decisions in a game that a world file states: as a formula over the game's own states
        stated = restate_formula(read_certificate(certificate)[0].claim.formula, profile, str(certificate))
        team = profile.policy(min(agents(stated), default=profile.agents[0].agent)).team
        whole = not (proved.region.difference or proved.region.apart)
        box = {name: (Fraction(low), Fraction(high)) for name, (low, high) in proved.region.box.items()}
        where = _name_region(profile, Region(box, proved.region.goals)) if whole else "a region of its own"
        return Shown(OwnFormula(team, statement=stated), f"{Verdict.PROVED.value} in {where}", proved.region)
    if isinstance(proved.region, Cover):
        what = "the certificate is about a stated system, and the page is of a game"
        raise InputError(what, str(certificate), "leave --certificate out; `maviper check` says what it proves")
    proof = certificates.read(text, str(certificate), decisions.FORMS)
    formula = proof.claim.formula
    claim = proof.claim.property or OwnFormula(profile.policy(min(agents(formula))).team, statement=formula)
    return Shown(claim, f"{Verdict.PROVED.value} in {_name_region(profile, proof.header.region)}", proved.region)


def _find_watchable(result: AnyResult) -> RegionSpec | None:
    """The region of a proof that a monitor can be made from."""
    watched = result.verdict is Verdict.PROVED and result.semantics == MACHINE
    return spec_of(result.region) if watched and isinstance(result.claim, DecisionClaim) else None


def _verdict(profile: ir.PolicyProfile, result: AnyResult) -> str:
    said = f"{result.verdict.value} in {_name_region(profile, result.region)}"
    return said + ("" if result.semantics == MACHINE else ", in real arithmetic")


def _name_region(profile: ir.PolicyProfile, region: Region) -> str:
    name = name_region(profile, region)
    return "the start region" if name == START else f"the region {name}" if name else "a region of its own"


def _store_counterexample(number: int, result: AnyResult) -> Stored | None:
    """The counterexample as a button, of the deployed arithmetic: the page decides by no other."""
    state = result.evidence.failing_state
    if result.verdict is not Verdict.VIOLATED or state is None or result.semantics != MACHINE:
        return None
    position = {name: float(value) for name, value in state.position.items()}
    return Stored(f"Counterexample: {result.claim.shown}", number, position, state.goal)


OK, LEAVING, OUTSIDE, INVALID = WORDS


def play_claim(profile: ir.PolicyProfile, certificate: Path, proved: Proved) -> tuple[Told, Recorded]:
    """The claim of a certificate about a stated system, and an episode of the trees in it; `proved`: what it proves.

    InputError for a system that gives no episodes in play.
    """
    proof, statement = read_certificate(certificate)
    if not isinstance(proved.region, Cover) or statement.gives or not statement.moves:
        what = "the certificate is about no system that moves by actions, and a page plays no other"
        raise InputError(what, str(certificate), "leave --certificate out; `maviper check` says what it proves")
    env = StatedEnv(with_memory(statement, profile), certificate.name)
    observed, _ = env.reset(measures.ON_POLICY_SEEDS)
    seen, states = {policy.agent: list[ir.Floats]() for policy in profile.agents}, list[list[float]]()
    order = {
        policy.agent: [[*env.statement.system.features[policy.agent]].index(each.name) for each in policy.features]
        for policy in profile.agents
    }
    while env.agents:
        states.append([float(env.state[one.name]) for one in proved.region.variables])
        actions: dict[str, int] = {}
        for policy in profile.agents:
            seen[policy.agent].append(np.asarray(observed[policy.agent])[order[policy.agent]])
            chosen = policy.actions[int(ir.act(policy, seen[policy.agent][-1][None])[0])].name
            actions[policy.agent] = env.action_names[policy.agent].index(chosen)
        observed = env.step(actions)[0]
    label = f"The recorded episode, of seed {measures.ON_POLICY_SEEDS}, took {format_count(len(states), 'step')}."
    sentence = f"{Verdict.PROVED.value}: {proved.claim}"
    told = Told(proof.claim.name, sentence, words(proved.region, np.array(states)))
    return told, Recorded(tuple(map(np.array, seen.values())), label)


def words(cover: Cover, states: ir.Float64) -> tuple[str, ...]:
    """Returns what a monitor says of the states of an episode, [steps, variables], from its start."""
    verdicts: list[str] = []
    ranges = [(one.low, one.high) for one in cover.variables]
    for step, state in enumerate(states):
        if verdicts and verdicts[-1] in (OUTSIDE, INVALID):
            verdicts.append(verdicts[-1])
        elif not all(low <= number <= high for number, (low, high) in zip(state.tolist(), ranges, strict=True)):
            verdicts.append(INVALID)
        elif not cover.holds(state[None], step)[0]:
            verdicts.append(OUTSIDE)
        else:
            verdicts.append(OK if cover.ever or step + 1 < len(cover.steps) else LEAVING)
    return tuple(verdicts)
