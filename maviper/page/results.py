"""What a page shows beside a profile: a report's verdicts, or a proof in a world file.

Does: verdicts beside the claims, and a button for each counterexample; an episode of a world file with the monitor's
  word at each step.
Assumes: results of one profile, in the order of the report; a certificate with the world file beside it.
Does not: decide, or write HTML.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.covering import Cover
from codegen.lowering.tracking import Edges, Start
from codegen.lowering.watching import WORDS
from codegen.region import RegionSpec
from codegen.wording import format_count
from maviper.compilation.games import restate_formula
from maviper.compilation.monitors import Proved, load_proof, spec_of
from maviper.episodes import measures
from maviper.files import runs
from maviper.page.document import Contents, Shown, Stored, Told
from maviper.page.games import Recorded
from maviper.page.page import contents_of, page
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
from verify.kinds import MACHINE
from verify.result import AnyResult, Verdict


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
        return _show_stated(profile, certificate, proved.region)
    if isinstance(proved.region, Cover):
        what = "the certificate is about a stated system, and the page is of a game"
        raise InputError(what, str(certificate), "leave --certificate out; `maviper check` says what it proves")
    proof = certificates.read(text, str(certificate), decisions.FORMS)
    formula = proof.claim.formula
    claim = proof.claim.property or OwnFormula(profile.policy(min(agents(formula))).team, statement=formula)
    return Shown(claim, f"{Verdict.PROVED.value} in {_name_region(profile, proof.header.region)}", proved.region)


def _show_stated(profile: ir.PolicyProfile, certificate: Path, spec: RegionSpec) -> Shown:
    """A claim about decisions in a game that a world file states: as a formula over the game's own states."""
    stated = restate_formula(read_certificate(certificate)[0].claim.formula, profile, str(certificate))
    team = profile.policy(min(agents(stated), default=profile.agents[0].agent)).team
    whole = not (spec.difference or spec.apart)
    box = {name: (Fraction(low), Fraction(high)) for name, (low, high) in spec.box.items()}
    where = _name_region(profile, Region(box, spec.goals)) if whole else "a region of its own"
    return Shown(OwnFormula(team, statement=stated), f"{Verdict.PROVED.value} in {where}", spec)


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
    env = StatedEnv(statement, certificate.name)
    seen, states = _play_trees(profile, env, [one.name for one in proved.region.variables])
    label = f"The recorded episode, of seed {measures.ON_POLICY_SEEDS}, took {format_count(len(states), 'step')}."
    sentence = f"{Verdict.PROVED.value}: {proved.claim}"
    return Told(proof.claim.name, sentence, words(proved.region, states)), Recorded(seen, label)


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


def _play_trees(
    profile: ir.PolicyProfile, env: StatedEnv, names: Sequence[str]
) -> tuple[tuple[ir.Floats, ...], ir.Float64]:
    """Returns each agent's observations before each step, [steps, n_features], and the variables with these names in
    the states, [steps, variables].
    """
    observed, _ = env.reset(measures.ON_POLICY_SEEDS)
    seen, states = {policy.agent: list[ir.Floats]() for policy in profile.agents}, list[list[float]]()
    while env.agents:
        states.append([float(env.state[name]) for name in names])
        actions: dict[str, int] = {}
        for policy in profile.agents:
            seen[policy.agent].append(np.asarray(observed[policy.agent]))
            actions[policy.agent] = int(ir.act(policy, seen[policy.agent][-1][None])[0])
        observed = env.step(actions)[0]
    return tuple(np.array(rows) for rows in seen.values()), np.array(states)
