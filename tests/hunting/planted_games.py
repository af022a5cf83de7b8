"""Faults in the world files of games whose teams test sums, each of which the hunt must notice.

Does: patches what a file states of motion, of observations, of errors, or of a claim.
Assumes: pytest's monkeypatch, or anything with its `setattr`.
Does not: look for them. Roundings of features are too small for a hunt, since tests of a claim's states rarely lie at
  its bound; test_game_sums.py looks for those that are forgotten.
"""

from dataclasses import replace
from fractions import Fraction

from maviper.verification import stated, worlds
from maviper.worlds.stated import observing
from tests.hunting.planted_driven import forget_steps


def _pushes(patch):
    """Every action pushes half as hard."""
    pushes = worlds._list_pushes
    patch.setattr(worlds, "_list_pushes", lambda *given: [(x / 2, y / 2) for x, y in pushes(*given)])


def _steps(patch):
    """Episodes are a step shorter."""
    property_ = worlds._property

    def shorter(label, name, steps, regions, by=None):
        return property_(label, name, steps - 1, regions, by and min(by, steps - 1))

    patch.setattr(worlds, "_property", shorter)


def _errors(patch):
    """No feature is off."""
    noise = worlds.list_noise
    patch.setattr(worlds, "list_noise", lambda profile, ranges, errors: noise(profile, ranges, {}))


def _features(patch):
    """What agents observe has the opposite sign."""
    spell = observing._spell_feature
    patch.setattr(observing, "_spell_feature", lambda *given: f"0 - ({spell(*given)})")


def _region(patch):
    """The file is about a half of each range."""
    region = stated.resolve_region

    def half(*given):
        whole = region(*given)
        box = {name: (low, (low + high) / 2) for name, (low, high) in whole.box.items()}
        return whole.__class__(box, whole.goals, whole.differences, whole.apart, whole.name)

    patch.setattr(stated, "resolve_region", half)


def _distances(patch):
    """Who is a sixteenth too far is near."""
    near = worlds._near

    def nearly(one, other, radius, strict=False):
        return near(one, other, radius * (Fraction(15, 16) if strict else Fraction(17, 16)), strict)

    patch.setattr(worlds, "_near", nearly)


def _side(patch):
    """Of two sides of a bound the second is forgotten."""
    sides = worlds._sides
    patch.setattr(worlds, "_sides", lambda *given: sides(*given)[:1])


def _damping(patch):
    """Nothing is damped."""
    spell = worlds._spell_next
    undamped = 1.0

    def fast(profile, name):
        text = spell(profile, name)
        kept = f"{worlds.plain(Fraction(1.0 - profile.world.damping))}*{name}"
        return text.replace(kept, f"{undamped}*{name}")

    patch.setattr(worlds, "_spell_next", fast)


def _goal(patch):
    """Agents take the other landmark for their goal."""
    spell = worlds.describe_agent

    def elsewhere(policy, noise, actions, mark=worlds.PLACE):
        return spell(policy, noise, actions, {"landmark_0": "landmark_1", "landmark_1": "landmark_0"}.get(mark, mark))

    patch.setattr(worlds, "describe_agent", elsewhere)


def _leaves(patch):
    """The last leaf of each tree does what the first one does."""
    played = stated.as_played

    def other(statement, profile):
        statement, profile = played(statement, profile)
        policies = tuple(replace(each, tree=_without_last(each.tree)) for each in profile.agents)
        return statement, replace(profile, agents=policies)

    patch.setattr(stated, "as_played", other)


def _without_last(tree):
    action = tree.action.copy()
    leaves = [place for place, each in enumerate(action.tolist()) if each >= 0]
    action[leaves[-1]] = action[leaves[0]]
    return replace(tree, action=action)


FAULTS = {
    "checker: covers are asked about at first only": forget_steps,
    "distances: what is a little too far is near": _distances,
    "distances: a side is forgotten": _side,
    "motion: nothing is damped": _damping,
    "goals: the other landmark": _goal,
    "trees: the last leaf is left out": _leaves,
    "motion: pushes are half as hard": _pushes,
    "episodes: a step is left out": _steps,
    "steady: errors are forgotten": _errors,
    "observations: the sign is turned": _features,
    "regions: half of the ranges": _region,
}
