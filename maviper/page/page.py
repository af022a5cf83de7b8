"""The page that plays a profile: one HTML file that needs no network.

Does: renders data, generated code and trees into it.
Assumes: `maviper.page.document` made the data.
Does not: open a browser or write files.
"""

import json
import re
from itertools import islice

import numpy as np
from markupsafe import Markup

from codegen import ir
from codegen.errors import InputError
from codegen.ir import FORK, PHYSICS
from codegen.lowering.lower import NESTED, lower
from codegen.lowering.render import render
from codegen.profiles import ensure
from codegen.wording import format_count
from maviper.episodes.trees import on_policy
from maviper.evaluation.players import find_shipped
from maviper.evaluation.show import rules
from maviper.experts.network import NetworkExpert
from maviper.page.document import Contents, Shown, Stored, document, knows_motion
from maviper.page.games import record_episode
from maviper.worlds import World
from maviper.worlds.matching import matching_world

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
        policy.agent: _visits(policy, seen[episodes.alive[..., place]])
        for place, (policy, seen) in enumerate(zip(profile.agents, episodes.observations, strict=True))
    }


def _visits(policy: ir.AgentPolicy, observations: ir.Float32) -> list[int]:
    """Counts the observations that reach each leaf, by node."""
    return np.bincount(ir.apply(policy.tree, observations), minlength=len(policy.tree.feature)).tolist()


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
    return render(
        "play/page.html.j2",
        title=f"{profile.world.name}: {format_count(len(profile.agents), 'agent')}, {format_count(leaves, 'leaf')}",
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
    return {"name": policy.agent, "team": policy.team, "rules": list(islice(rules(policy), MAX_RULES)), "more": more}
