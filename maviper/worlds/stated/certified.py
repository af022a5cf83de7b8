"""Certificates about systems that files state, with the world file: read, and given to the checker.

Does: reads a certificate of any form and the world file beside it; has the pieces of the system shown again and the
  proof followed; says a claim in words.
Assumes: files that anyone wrote.
Does not: decide verdicts, or print.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from codegen.deciding import name_with_updates
from codegen.errors import InputError, RefusedError, UnknownNameError, escape_text
from codegen.ir import PolicyProfile
from maviper.files import runs
from maviper.worlds.stated.systems import read
from verify.checker.accept import Watch, accept
from verify.checker.certificate import MAX_BYTES, Bytes
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.checker.systems.proofs import SystemCertificate, from_json
from verify.systems.claims import SystemClaim
from verify.systems.observing import as_played, with_copies
from verify.systems.properties import spell_claim
from verify.systems.statement import Statement

WORLD_FILE = "world.toml"  # beside certificates and counterexamples


def leave_stated(profile: PolicyProfile, statement: Statement) -> PolicyProfile:
    """The profile without agents that a system does not state; as it is if that is all of them."""
    kept = tuple(policy for policy in profile.agents if policy.agent in statement.system.features)
    return replace(profile, agents=kept) if 0 < len(kept) < len(profile.agents) else profile


def ensure_plays(profile: PolicyProfile, statement: Statement) -> None:
    """InputError for agents, features or actions that the file does not state."""
    profile = with_copies(statement, profile)
    actions = {agent.name: () if agent.outputs else tuple(agent.actions) for agent in statement.agents}
    outputs = {agent.name: agent.outputs for agent in statement.agents}
    for policy in profile.agents:
        where = f"{statement.system.name}: {policy.agent}"
        if policy.agent not in actions:
            unknown = UnknownNameError("agent", policy.agent, actions, statement.system.name)
            what = f"{unknown.what}: the profile has it, and the world file does not"
            made = f"an imported tree is one of them by `maviper import --agents {next(iter(actions))}=FILE`"
            raise InputError(what, unknown.where, f"{unknown.next_step}; {made}")
        observed = [feature.name for feature in policy.features if feature.initial is None]
        for kind, names, known in (
            ("feature", observed, statement.system.features[policy.agent]),
            ("action", [each.name for each in policy.actions if not each.acts], actions[policy.agent]),
            ("output", [each.name for each in policy.outputs], outputs[policy.agent]),
        ):
            if kind == "output" and set(names) != set(known):
                said, stated = (", ".join(each) or "no numbers" for each in (names, known))
                advice = "name all outputs of the agent: [agents.A.outputs], or --outputs of import"
                raise InputError(f"{policy.agent} gives {said}, and in the file {stated}", where, advice)
            for name in names:
                if name not in known:
                    raise UnknownNameError(kind, name, known, where)
    missing = sorted(actions.keys() - {policy.agent for policy in profile.agents})
    if missing:
        raise InputError(f"the profile has no {', '.join(missing)}", statement.system.name, "name the file it plays in")


def sentence(claim: SystemClaim, statement: Statement, profile: PolicyProfile) -> str:
    """A claim in words, with its numbers. Statement and profile: as proofs read them."""
    actions = {policy.agent: list(map(name_with_updates, policy.actions)) for policy in profile.agents}
    return spell_claim(claim, actions, {variable.name: variable.range for variable in statement.system.variables})


def read_certificate(
    path: Path, world: Path | None = None, followed: Callable[[bytes], bytes] = Bytes
) -> tuple[SystemCertificate, Statement]:
    """A certificate of any form, its proofs given to `followed`, and the world file that it is about. InputError for
    files that cannot be read.
    """
    text, where = runs.read_unpacked(path, MAX_BYTES), str(path)
    statement = read(world or path.parent / WORLD_FILE)
    return from_json(text, where, followed), statement


def ensure_accepted(
    path: Path,
    certificate: SystemCertificate,
    statement: Statement,
    profile: PolicyProfile,
    watch: Watch | None = None,
    told: Callable[[int, int], None] = lambda done, most: None,
) -> int:
    """Checks a certificate that was read; its branches or boxes. `watch` is told of the boxes that its proof speaks of,
    or of the sets, where it is a proof by such; `told` of how far the pieces are shown.

    InputError for another profile or world, RefusedError where the proof does not hold.
    """
    ensure_plays(profile, statement)
    statement, profile = as_played(statement, profile)
    try:
        ensure_enclosed(statement, told)
        return accept(certificate, profile, statement.system, watch)
    except RejectedError as error:
        advice = "do not rely on it; run `maviper verify` again"
        raise RefusedError("the certificate is refused", f"{path}: {escape_text(error)}", advice) from None
