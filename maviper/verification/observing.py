"""Claims over observations: a number in a formula is what an agent compares, and a region what was seen of it.

Does: says how the agents of a view compare its variables; finds regions by name.
Assumes: a view, whose variables are features.
Does not: read formulas (verify/claims/language/compared.py).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from codegen.errors import InputError
from codegen.ir import Meaning, PolicyProfile
from maviper.files.profiles import find_region
from verify.checker.thresholds import sides
from verify.claims.formula import Formula
from verify.claims.language.compared import Compared, read_as_compared
from verify.claims.region import Region
from verify.claims.wording.starts import START
from verify.claims.wording.views import RANGES, SEEN, UNLIKE, Viewed, build_seen_region, find_numbers


def as_compared(view: PolicyProfile, semantics: str) -> Callable[[Formula], Formula]:
    """Returns a function that reads a view's formulas as compared. Variables observed in unlike types stay."""
    numbers, known = find_numbers(view), dict[str, Compared]()
    for policy in view.agents:
        for feature in policy.features:
            for _, variable in feature.meaning.terms if feature.meaning is not None else ():
                if numbers[variable] != UNLIKE:
                    alone = replace(feature, meaning=Meaning(((1.0, variable),)))
                    cut = partial(sides, alone, numbers=policy.numbers, semantics=semantics)
                    known[variable] = Compared(policy.numbers, cut)
    return partial(read_as_compared, known=known)


def resolve_region(about: PolicyProfile, viewed: Viewed | None, name: str) -> Region:
    """The region of that name, or in that file. Over observations `start` is what was seen, where somebody looked, and
    `ranges` what the features' ranges are.
    """
    if viewed is None or name not in (START, SEEN, RANGES):
        return find_region(name, about)
    known = build_seen_region(viewed)
    if known is None and name == SEEN:
        raise InputError("the profile does not say what was seen", "--region seen", "leave it out")
    if known is None:
        return find_region(START, about)
    return known if name != RANGES else replace(find_region(START, about), name=RANGES)
