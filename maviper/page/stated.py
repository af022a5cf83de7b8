"""What a page says of a proof in a world that a file states: the claim, an episode, and a monitor's word at each step.

Does: plays one episode of the statement with the trees, and asks what the proof covers of each of its states.
Assumes: a certificate with the world file beside it; a profile that plays it.
Does not: write HTML, or judge claims.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.covering import Cover
from codegen.lowering.watching import WORDS
from codegen.wording import format_count
from maviper.compilation.monitors import Proved
from maviper.episodes import measures
from maviper.page.document import Told
from maviper.page.games import Recorded
from maviper.worlds.stated.certified import read_certificate
from maviper.worlds.stated.environment import StatedEnv
from verify.result import Verdict

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
    """What a monitor says of the states of an episode, [steps, variables], from its start."""
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
    """What each agent observed before each step, [steps, n_features], and of the states the variables with these names,
    [steps, variables].
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
