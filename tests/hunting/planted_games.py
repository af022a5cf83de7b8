"""Faults in the world files of games whose teams test sums, each of which the hunt must notice.

Does: patches what a file states of motion, of observations, of errors, or of a claim.
Assumes: pytest's monkeypatch, or anything with its `setattr`.
Does not: look for them. Roundings are too small for a hunt; test_game_sums.py looks for those that are forgotten.
"""

from maviper.verification import stated
from maviper.verification.games import decisions, episodes
from maviper.worlds.stated import observing


def _pushes(patch):
    """Every action pushes half as hard."""
    pushes = episodes._list_pushes
    patch.setattr(episodes, "_list_pushes", lambda *given: [(x / 2, y / 2) for x, y in pushes(*given)])


def _steps(patch):
    """Episodes are a step shorter."""
    property_ = episodes._property
    patch.setattr(episodes, "_property", lambda label, name, steps, *given: property_(label, name, steps - 1, *given))


def _errors(patch):
    """No feature is off."""
    noise = decisions.list_noise
    patch.setattr(decisions, "list_noise", lambda profile, ranges, errors: noise(profile, ranges, {}))


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


FAULTS = {
    "motion: pushes are half as hard": _pushes,
    "episodes: a step is left out": _steps,
    "steady: errors are forgotten": _errors,
    "observations: the sign is turned": _features,
    "regions: half of the ranges": _region,
}
