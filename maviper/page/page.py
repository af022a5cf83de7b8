"""The page that plays a profile: one HTML file that needs no network.

Does: renders data, generated code and trees into it.
Assumes: `maviper.page.document` made the data.
Does not: open a browser or write files.
"""

import json
import re
from itertools import islice

from markupsafe import Markup

from codegen import ir
from codegen.check import ensure
from codegen.lowering.lower import NESTED, lower
from codegen.lowering.render import render
from maviper.episodes.on_policy import on_policy
from maviper.evaluation.players import shipped_expert
from maviper.evaluation.show import rules
from maviper.experts.network import NetworkExpert
from maviper.page.document import Contents, document, usual_claims
from maviper.worlds.matching import matching_world

FILE = "play.html"
MAX_RULES = 200  # leaves of an agent that a page shows as text, where scripts are off
MAX_CODE_NODES = 20_000  # of all trees whose generated code is in the page too


def contents_of(profile: ir.PolicyProfile) -> Contents:
    """What a page shows when nobody asked anything: usual claims, visits in on-policy episodes, the shipped expert."""
    world = matching_world(profile)
    if world is None:
        return Contents(usual_claims(profile))
    episodes = on_policy(profile, world)
    visits = {
        policy.agent: _visits(policy, seen[episodes.alive[..., place]])
        for place, (policy, seen) in enumerate(zip(profile.agents, episodes.observations, strict=True))
    }
    player = shipped_expert(profile.provenance.expert, world)
    expert = player.controller if player is not None and isinstance(player.controller, NetworkExpert) else None
    return Contents(usual_claims(profile), visits=visits, expert=expert)


def _visits(policy: ir.AgentPolicy, observations: ir.Float32) -> list[int]:
    """How many of the observations reach each leaf, by node."""
    found = [0] * len(policy.tree.feature)
    for leaf in ir.apply(policy.tree, observations).tolist():
        found[leaf] += 1
    return found


def page(profile: ir.PolicyProfile, contents: Contents) -> str:
    """The page's HTML. InvalidProfileError for a profile that is not sound."""
    data = document(ensure(profile), contents)
    leaves = sum(len(ir.leaves(policy.tree)) for policy in profile.agents)
    return render(
        "play/page.html.j2",
        title=f"{profile.world.name}: {len(profile.agents)} agents, {leaves} leaves",
        data=data,
        text=Markup(json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")),
        module=_module(profile),
        rules=[_rules(policy) for policy in profile.agents],
    )


def _module(profile: ir.PolicyProfile) -> Markup | None:
    """The generated JavaScript without its exports, since a page from a file path loads no modules; None where it is
    too large for a page, or would be a walk over tables.
    """
    model = lower(profile)
    if model.style != NESTED or sum(len(agent.nodes) for agent in model.agents) > MAX_CODE_NODES:
        return None
    code = render("javascript/module.js.j2", model=model)
    code = code.replace("\nexport ", "\n")
    return Markup(
        re.sub(r"<(?=[/!]|script)", r"\\x3c", code, flags=re.IGNORECASE)
    )  # of names; strings stay what they are


def _rules(policy: ir.AgentPolicy) -> dict[str, object]:
    more = max(0, len(ir.leaves(policy.tree)) - MAX_RULES)
    return {"name": policy.agent, "team": policy.team, "rules": list(islice(rules(policy), MAX_RULES)), "more": more}
