"""Passes over a profile before it is compiled: smaller or quicker trees that decide the same.

Does: joins the passes of codegen with what they need as data: dead leaves from the verifier, on-policy states.
Assumes: the passes prove themselves what they claim.
Does not: change what is decided; `drop` changes it outside the stated region, which becomes part of the profile.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from codegen import ir
from codegen.boxes import read_bounds
from codegen.errors import InputError, UnknownNameError
from codegen.lowering import passes
from codegen.lowering.passes import DROP, MERGE, PASSES
from codegen.policy_json import content_hash
from codegen.profiles import ensure
from codegen.wording import format_count
from maviper.compilation.monitors import spec_of
from maviper.episodes.trees import on_policy
from maviper.files.profiles import find_region
from maviper.worlds.matching import NO_WORLD, matching_world

BUDGET = 20_000_000  # solver resource units per leaf; what stays open is kept


@dataclass(frozen=True)
class Transformed:
    """The profile after the passes, and what each did, in words."""

    profile: ir.PolicyProfile
    notes: tuple[str, ...]


def run_passes(profile: ir.PolicyProfile, names: Sequence[str], region: str | None = None) -> Transformed:
    """`profile` after the named passes, in the order of PASSES.

    `region`: `start` or a region file; `drop` needs one, and no other pass may have one. `reorder` needs a world that
    this version plays. InputError otherwise.
    """
    for name in names:
        if name not in PASSES:
            raise UnknownNameError("pass", name, PASSES, "--pass")
    if (DROP in names) != (region is not None):
        what = "the pass drop needs a region" if region is None else "a region is only for the pass drop"
        raise InputError(what, "--region", "use --pass drop --region start, or name a region file")
    ensure(profile)
    notes: list[str] = []
    before = profile
    for name in (each for each in PASSES if each in names):
        if name == DROP:
            after = _drop_leaves(before, region or "")
        elif name == MERGE:
            after = _with_trees(before, {each.agent: passes.merge_splits(each.tree) for each in before.agents})
        else:
            after = _reorder_trees(before)
        notes.append(f"{name}: {_format_sizes(before, after)}")
        before = after
    if not names:
        return Transformed(profile, ())
    done = ", ".join(name for name in PASSES if name in names)
    training = {**profile.provenance.training, "passes": done, "profile before passes": content_hash(profile)}
    return Transformed(replace(before, provenance=replace(profile.provenance, training=training)), tuple(notes))


def _format_sizes(before: ir.PolicyProfile, after: ir.PolicyProfile) -> str:
    """Leaves and longest paths of each agent before and after."""
    parts: list[str] = []
    for old, new in zip(before.agents, after.agents, strict=True):
        leaves = [len(ir.leaves(policy.tree)) for policy in (old, new)]
        levels = [int(ir.depth(policy.tree).max()) for policy in (old, new)]
        size, longest = format_count(leaves[1], "leaf"), format_count(levels[1], "test")
        parts.append(f"{new.agent} {leaves[0]} to {size}, at most {levels[0]} to {longest}")
    return "; ".join(parts)


def _with_trees(profile: ir.PolicyProfile, trees: Mapping[str, ir.Tree], **changes: object) -> ir.PolicyProfile:
    agents = tuple(replace(policy, tree=trees[policy.agent], **changes) for policy in profile.agents)
    return replace(profile, agents=agents)


def _drop_leaves(profile: ir.PolicyProfile, region: str) -> ir.PolicyProfile:
    from verify.solver.solve import dead_leaves

    if profile.region is not None:
        what = "the profile already has a region, outside which its trees may have changed"
        raise InputError(
            what, "--pass drop", "start from the profile without a region, and give the whole region at once"
        )
    domain = find_region(region, profile)
    dead = dead_leaves(profile, domain, BUDGET)
    if any(len(dead[policy.agent]) == len(ir.leaves(policy.tree)) for policy in profile.agents):
        raise InputError("the region contains no state, so nothing would be left of the trees", "--region")
    trees = {policy.agent: passes.drop_leaves(policy.tree, dead[policy.agent]) for policy in profile.agents}
    spec = spec_of(domain)
    for bound in read_bounds(spec):
        if not bound.second and bound.low > bound.high:
            where = f"--region: box.{bound.first}"
            raise InputError(
                "no double lies within the bounds of the region",
                where,
                "the generated code compares doubles: widen these bounds",
            )
    # the tree as grown decides otherwise outside the region
    return replace(_with_trees(profile, trees, grown=None), region=spec)


def _reorder_trees(profile: ir.PolicyProfile) -> ir.PolicyProfile:
    world = matching_world(profile)
    if world is None:
        raise InputError("the pass reorder needs on-policy states", NO_WORLD, "leave it out")
    seen = on_policy(profile, world).observations
    rows = {policy.agent: each.reshape(-1, each.shape[-1]) for policy, each in zip(profile.agents, seen, strict=True)}
    return _with_trees(
        profile, {policy.agent: passes.reorder_tests(policy.tree, rows[policy.agent]) for policy in profile.agents}
    )
