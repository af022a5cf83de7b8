"""Certificates of flows: written and read, and refused where anything in them was changed for another claim."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, of_hashes
from tests.support.flows import CASES, case
from tests.support.system_cases import box
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import FlowSets, from_json
from verify.systems import documents
from verify.systems.claims import Pattern

SYSTEM, TEAM, CLAIM = case(*CASES["pendulum"])


def certificate(**changes):
    start = {"angle": F(11, 10), "spin": F(1, 10)}
    hashes = content_hash(TEAM), documents.content_hash(SYSTEM)
    return altered(of_hashes(*hashes, CLAIM, start, FlowSets(4, 1, {}, encode_numbers([0]))), **changes)


def test_a_certificate_is_read_as_it_was_written():
    wide = {"angle": F(1, 8), "spin": F(1, 4)}
    for made in (
        certificate(),
        certificate(cells={"angle": F(1, 16)}, cuts=encode_numbers([1, 0, 0])),
        certificate(cells=wide, joined_every=4, levels=2),
    ):
        again = from_json(to_json(made))
        assert again == made and again.claim.at_samples is False
        assert accept(again, TEAM, SYSTEM) > 20


def test_an_edited_text_is_refused():
    text = to_json(certificate())
    with pytest.raises(InputError):
        from_json(text.replace('"order": 4', '"order": 3'))
    with pytest.raises(InputError):
        from_json(text.replace('"at_samples": false', '"at_samples": true'))


OTHER = {
    "profile": {"profile": "0" * 64},
    "system": {"system": "0" * 64},
    "variable": {"cells": {"speed": F(1)}},
}


@pytest.mark.parametrize("name", OTHER)
def test_another_profile_system_or_variable_is_told(name):
    with pytest.raises(InputError):
        accept(certificate(**OTHER[name]), TEAM, SYSTEM)


FORGED = {
    "levels without cells": {"joined_every": 4, "levels": 1},
    "joins without levels": {"cells": {"angle": F(1, 8)}, "joined_every": 4},
    "no level": {"cells": {"angle": F(1, 8)}, "joined_every": 4, "levels": -1},
    "cuts beside levels": {
        "cells": {"angle": F(1, 8)},
        "joined_every": 4,
        "levels": 1,
        "cuts": encode_numbers([1, 0, 0]),
    },
    "too few levels": {"cells": {"angle": F(4), "spin": F(8)}, "joined_every": 1, "levels": 1},
    "order 0": {"order": 0},
    "no steps": {"steps": 0},
    "cuts that end": {"cuts": encode_numbers([1, 0])},
    "cuts that go on": {"cuts": encode_numbers([0, 0])},
    "cells of no width": {"cells": {"angle": F(0)}},
    "cells of a negative width": {"cells": {"angle": F(-1, 8)}},
    "no start": {"inhabitant": {"angle": F(3), "spin": F(0)}},
    "a narrower region": {"claim": replace(CLAIM, regions=(box(angle=(0, F(6, 10))),))},
    "an earlier time": {"claim": replace(CLAIM, by=5)},
    "another pattern": {"claim": replace(CLAIM, pattern=Pattern.AVOIDS, by=0)},
    "a region that is left": {"claim": replace(CLAIM, pattern=Pattern.STAYS_IN, by=0)},
    "a region that is never met": {
        "claim": replace(CLAIM, pattern=Pattern.REACHES, by=0, regions=(box(angle=(2, 3)),))
    },
    "steps without samples": {"claim": replace(CLAIM, at_samples=None)},
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_certificate_is_refused(name):
    with pytest.raises(RejectedError):
        accept(certificate(**FORGED[name]), TEAM, SYSTEM)


@pytest.mark.parametrize("count", [4, pytest.param(200, marks=pytest.mark.slow)])
def test_random_forgeries_are_refused_whatever_the_plan(count):
    """Regions that an episode leaves: no plan may show them."""
    random = np.random.default_rng(0)
    for _ in range(count):
        high = F(int(random.integers(20, 62)), 100)
        plan = {
            "order": int(random.integers(1, 9)),
            "steps": int(random.integers(1, 3)),
            "cells": {} if random.random() < 0.5 else {"angle": F(1, int(random.integers(4, 40)))},
            "cuts": encode_numbers([[0], [1, 0, 0], [2, 0, 0]][random.integers(3)]),
        }
        claim = replace(CLAIM, regions=(box(angle=(0, high)),), at_samples=bool(random.random() < 0.5))
        with pytest.raises(RejectedError):
            accept(certificate(claim=claim, **plan), TEAM, SYSTEM)


def test_a_system_in_steps_has_no_such_certificate():
    with pytest.raises(InputError, match="moves in steps"):
        accept(certificate(), TEAM, replace(SYSTEM, flow=None))
