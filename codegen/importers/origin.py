"""A tree of others, read in full, and the profile that is made of one such tree for each agent.

Does: says what every reader hands over; names features and actions; replays each tree before it returns a profile.
Assumes: the reader understood all of its source.
Does not: read any source.

What is kept: the decision for every observation of the numbers that the origin compares, without NaN; `Origin.nan` says
whether also with NaN. Tests are read as doubles, exactly as the origin compares. Where it compares doubles, the agent
does so too. Else, or where float32 is asked for, the doubles are kept in the grown tree, and `lowering/deploy.py`
rounds them down to float32, which changes no decision for a float32 observation.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.deciding import kind_decided
from codegen.dynamics import motionless
from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64, WHOLE
from codegen.importers import names, replay
from codegen.importers.reading import MEMORY, NOT_COMPARED, SUMS, Answers, Origin
from codegen.importers.symbolic.paths import renumber
from codegen.ir import CONSTANT, MAX_LENGTH
from codegen.lowering.deploy import Given, deploy_tree, with_given
from codegen.lowering.passes import confine_tree
from codegen.lowering.render import comment
from codegen.profiles import ensure
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, divisor_of

MAX_NOTES = 8
OTHER_NUMBERS = (
    "games and --numbers float32 need float32: C of float has it, and if/else Python with --arrays float32; "
    "else leave --numbers out, or give --world a name that is no game"
)
HOW = ("is", "plus")
TEAM = "team"
NAN_KEPT, NAN_RIGHT = "decided as in the origin", "goes right, whatever the origin does"


@dataclass(frozen=True)
class Names:
    """The user's choice of names for every agent: names.py has what may be said."""

    features: Sequence[str] | None = None
    actions: Sequence[str] | None = None
    world: str = "imported"
    outputs: Sequence[str] | None = None


def profile_of(origins: Mapping[str, Origin], given: Names, numbers: str | None = None) -> ir.PolicyProfile:
    """A profile with an agent for each origin, replayed. `numbers`: what agents compare; None: what their origins do.

    InputError for names that do not fit, and for float64 of an origin that compares float32; DisagreementError where a
    tree decides otherwise than its origin.
    """
    agents = names.clean_names(list(origins), "agent")
    wanted = names.renaming(given.features), names.renaming(given.actions)
    named_origins = [
        _name_origin(agent, origin, *wanted, given.outputs)
        for agent, origin in zip(agents, origins.values(), strict=True)
    ]
    names.ensure_known(wanted[0], [each.features for each in named_origins], "feature")
    names.ensure_known(wanted[1], [each.actions for each in named_origins if not each.origin.vectors], "action")
    policies = [_policy(agent, each, numbers) for agent, each in zip(agents, named_origins, strict=True)]
    numbered = ", ".join(dict.fromkeys(policy.whole or policy.numbers for policy in policies))
    facts: dict[str, float | int | str] = {"observations": numbered}
    for policy, named in zip(policies, named_origins, strict=True):
        origin, features, actions = named
        compared = origin.act is not None or origin.second is not None
        count, takes = _replay(policy, named) if compared else (0, "")
        facts |= {f"{policy.agent} from": comment(origin.kind), f"{policy.agent} replayed": count}
        facts[f"{policy.agent} replayed by"] = comment(origin.replayed_by if compared else NOT_COMPARED)
        facts[f"{policy.agent} given"] = comment(takes or origin.given)
        facts[f"{policy.agent} features"] = comment(names.format_first(features.lines))
        facts[f"{policy.agent} {kind_decided(policy)}"] = comment(names.format_first(actions.lines))
        facts |= {f"{policy.agent} sums": policy.tree.arithmetic} if policy.tree.arithmetic else {}
        leaves = zip(ir.leaves(policy.tree).tolist(), origin.permits, strict=False)
        several = [f"leaf {leaf}: {' | '.join(labels)}" for leaf, labels in leaves if labels]
        facts |= {f"{policy.agent} permits": comment("; ".join(several))} if several else {}
        if origin.notes:
            facts[f"{policy.agent} notes"] = comment("; ".join(origin.notes[:MAX_NOTES]))
        facts[f"{policy.agent} NaN"] = NAN_KEPT if origin.nan else NAN_RIGHT
    kinds = ", ".join(dict.fromkeys(origin.kind for origin in origins.values()))
    provenance = ir.Provenance("imported", "none", 0, "", comment(kinds), facts)
    world = motionless(names.clean_names([given.world], "imported")[0], "", agents)
    return ensure(ir.PolicyProfile(world, tuple(policies), provenance))


def _replay(policy: ir.AgentPolicy, named: "_Named") -> tuple[int, str]:
    """Compares a tree with its source: how many observations, and what the source takes ("": what its reader says)."""
    origin, observed = named.origin, len(policy.features) - len(policy.memory)
    columns = np.array([*named.features.place, *range(observed, len(policy.features))])
    place = np.array(named.actions.place, dtype=np.int32)

    def place_told(told: Any) -> Any:
        if policy.memory:
            return np.column_stack([np.where(told[:, 0] < 0, -1, place[told[:, 0]]), told[:, 1:]])
        return told if origin.vectors else np.where(told < 0, told, place[told])

    if origin.act is not None:
        rows = replay.observations(policy, nan=origin.nan, finite=origin.finite)
        rows = rows if origin.takes is None else rows[origin.takes(rows[:, columns])]
        told, every = place_told(np.asarray(origin.act(rows[:, columns]))), np.ones(len(rows), np.bool_)
        return replay.compare_answers(policy, rows, Answers(told, every, every, lambda row: f"{told[row]}")), ""
    assert origin.second is not None, "an origin that is compared answers"
    with origin.second() as running:
        rows = replay.source_observations(policy, running, columns.tolist(), nan=origin.nan, finite=origin.finite)
        known = None
        if policy.memory:
            rows, known = replay.with_sequences(policy, rows, walks=origin.takes is None)
        answers = running.ask(rows[:, columns])
    answers = replace(answers, told=place_told(answers.told))
    return replay.compare_answers(policy, rows, answers, known), answers.given


class _Named(NamedTuple):
    """An origin, its tree over the profile's features and actions, and what these are called."""

    origin: Origin
    features: names.Placed
    actions: names.Placed


def _name_origin(
    agent: str, origin: Origin, features: names.Renaming, actions: names.Renaming, outputs: Sequence[str] | None
) -> _Named:
    """The origin with its features and actions, or outputs, in their places."""
    n_tested = max(origin.n_named, origin.n_read)
    alone = None if features.plain is None or origin.features else len(features.plain)
    width = origin.n_features or max(n_tested, len(origin.features) or alone or 0, 1)
    try:
        placed = names.features_of(origin.features, width, features, keyed=origin.keyed)
        if origin.vectors:
            chosen = names.outputs_of(len(origin.vectors[0]), outputs)
        else:
            chosen = names.actions_of(origin.labels, origin.called, actions)
    except InputError as error:
        raise InputError(error.what, ": ".join(filter(None, (agent, error.where))), error.next_step) from None
    order: Sequence[int] = range(len(origin.vectors)) if origin.vectors else chosen.place
    if origin.pairs:  # actions that change memory come behind the others
        changing = iter(range(len(chosen.names), len(chosen.names) + len(origin.pairs)))
        order = [next(changing) if updates else chosen.place[label] for label, updates in origin.pairs]
    return _Named(renumber(origin, placed.place, order), placed, chosen)


def _policy(agent: str, named: _Named, numbers: str | None) -> ir.AgentPolicy:
    """The policy of an origin. InputError for trees that are too deep, and for other numbers than its own."""
    origin, features, _ = named
    if int(ir.depth(origin.grown).max()) > ir.MAX_DEPTH:
        raise InputError(f"the tree is deeper than {ir.MAX_DEPTH} splits", agent, "simplify it first")
    whole, ranges = _find_whole(named, numbers)
    numbers = WHOLE.get(whole) or numbers or origin.numbers
    if (numbers, origin.numbers) == (FLOAT64, FLOAT32) and not whole:
        raise InputError(f"{origin.kind} compares float32, not float64", agent, "leave --numbers out")
    specs = tuple(ir.FeatureSpec(each, "none", *ends, None) for each, ends in zip(features.names, ranges, strict=True))
    if whole:  # a test of whole numbers says the same of the whole number below
        grown = replace(origin.grown, threshold=np.floor(origin.grown.threshold) + 0.0)
        named = named._replace(origin=replace(origin, grown=grown))
    policy = _policy_of(agent, named, specs, numbers)
    if not whole:
        return policy
    limits, at = np.iinfo(whole), policy.tree.threshold[policy.tree.feature != ir.NO_FEATURE]
    beyond = ((at < limits.min) | (at >= limits.max)).any()
    tree = confine_tree(policy.tree, limits.min, limits.max) if beyond else policy.tree
    return replace(policy, tree=tree, whole=whole, grown=None)


def _find_whole(named: "_Named", numbers: str | None) -> tuple[str, list[tuple[float, float]]]:
    """The type of whole numbers that the user says, or the narrowest that has all features and memories, with the range
    of each feature; "" where some are floats, or the user asks for floats, or sums are tested. InputError for a type
    that cannot be kept.
    """
    origin, width, said = named.origin, len(named.features.names), numbers if numbers in WHOLE else ""
    free, kept = [(-MAX_LENGTH, MAX_LENGTH)] * width, [(each.low, each.high) for each in origin.memory]
    if said and origin.arithmetic:
        raise InputError(f"sums are tested or given, and {said} numbers are not added", "--numbers", "leave it out")
    if (numbers and not said) or not (said or origin.whole) or origin.arithmetic:
        return "", free
    ends = kept if said else (*origin.whole, *kept)
    low, high = min((one for one, _ in ends), default=0), max((one for _, one in ends), default=0)
    fits = (each for each in ([said] if said else WHOLE) if np.iinfo(each).min <= low and high <= np.iinfo(each).max)
    whole = next(fits, "")
    if not whole and said:
        raise InputError(f"memory goes from {low} to {high}, which {said} has not", "--numbers", "name a wider type")
    if not whole:
        return "", free
    least, most = float(np.iinfo(whole).min), float(np.iinfo(whole).max)
    ranges = [(least, most)] * width
    for place, (first, last) in zip(named.features.place, origin.whole, strict=False):
        ranges[place] = max(least, float(first)), min(most, float(last))
    return whole, ranges


def _policy_of(agent: str, named: "_Named", specs: tuple[ir.FeatureSpec, ...], numbers: str) -> ir.AgentPolicy:
    """The policy that observes these features, as the numbers that it compares."""
    origin, _, chosen = named
    if origin.memory:
        return _remembering(agent, named, specs, numbers)
    outputs, actions = (), _list_actions(chosen)
    if origin.vectors:
        bounds = origin.bounds or [(None, None)] * len(chosen.names)
        outputs = tuple(ir.OutputSpec(name, "none", *each) for name, each in zip(chosen.names, bounds, strict=True))
        actions = ()
    tree, grown = _deploy(agent, origin, len(specs), numbers)
    return ir.AgentPolicy(agent, TEAM, specs, actions, tree, grown, outputs=outputs)


def _deploy(agent: str, origin: Origin, width: int, numbers: str) -> tuple[ir.Tree, ir.GrownTree | None]:
    """The tree of an origin, and as it was grown, where that is evidence. `width`: features, memory counted."""
    if origin.arithmetic:
        if numbers != origin.numbers:
            what = f"sums of {origin.numbers} numbers would be others as {numbers}"
            raise InputError(what, agent, OTHER_NUMBERS)
        # such as 0.1 among float32 steps, which their arithmetic does not have
        gives = FLOAT32 if origin.arithmetic == FLOAT32_STEPS else FLOAT64
        weights = FLOAT32 if origin.arithmetic == DOUBLE_SUMS else gives
        for each in (*origin.sums, *(one for vector in origin.vectors for one in vector)):
            for weight, place in (term for part in each.parts() for term in part.terms):
                type_, divisor = gives if place == CONSTANT else weights, divisor_of(weight)
                if divisor is not None and origin.arithmetic == DOUBLE_SUMS:
                    advice = "compute in float32 throughout, or let the observation be float64"
                    raise InputError("a float32 number is divided in double", agent, advice)
                number = float(weight) if divisor is None else divisor
                if float(np.dtype(type_).type(number)) != number:
                    what = f"{number!r} stands in a sum of {type_} numbers, and is none"
                    raise InputError(what, agent, f"round it in the source to {type_}")
        given = Given(origin.sums, origin.vectors, origin.arithmetic, gives)
        return with_given(origin.grown, given, width, SUMS, origin.numbers), None
    tree = deploy_tree(origin.grown, numbers)
    if not np.isfinite(tree.threshold).all():
        raise InputError(f"a threshold lies below every {numbers} number", agent, "rescale that feature")
    return tree, origin.grown if numbers == FLOAT32 else None


def _list_actions(chosen: names.Placed) -> tuple[ir.ActionSpec, ...]:
    pairs = zip(chosen.names, chosen.labels, strict=False)
    return tuple(ir.ActionSpec(name, None, label=label) for name, label in pairs)


def _remembering(agent: str, named: _Named, specs: Sequence[ir.FeatureSpec], numbers: str) -> ir.AgentPolicy:
    """The policy of an origin that remembers."""
    origin, chosen = named.origin, named.actions
    called = names.clean_names([*named.features.names, *(each.name for each in origin.memory)], "memory")[len(specs) :]
    memory = {each.name: new for each, new in zip(origin.memory, called, strict=True)}
    kept = (
        ir.FeatureSpec(memory[each.name], "none", each.low, each.high, None, each.initial) for each in origin.memory
    )
    plain = _list_actions(chosen)
    actions = [
        replace(plain[chosen.place[label]], acts=chosen.names[chosen.place[label]], updates=updates)
        for label, updates in origin.pairs
        if updates
    ]
    told = [
        "_".join([each.acts, *(f"{one.memory}_{HOW[one.adds]}_{one.value}" for one in each.updates)])
        for each in actions
    ]
    new = names.clean_names([*chosen.names, *told], "action")[len(plain) :]
    changed = (
        replace(each, name=name, updates=tuple(replace(one, memory=memory[one.memory]) for one in each.updates))
        for each, name in zip(actions, new, strict=True)
    )
    feature, width = origin.grown.feature, len(specs)
    remembered = (feature >= MEMORY) & (feature < SUMS)
    grown = replace(origin.grown, feature=np.where(remembered, feature - MEMORY + width, feature))
    features, actions = (*specs, *kept), (*plain, *changed)
    tree, evidence = _deploy(agent, replace(origin, grown=grown), len(features), numbers)
    return ir.AgentPolicy(agent, TEAM, features, actions, tree, evidence)
