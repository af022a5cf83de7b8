"""Certificates that are covers: their text, what they are refused for, and forgeries of false claims."""

import json
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, of_hashes
from tests.support.covers import question, recipe
from tests.support.exact_play import refuted, start
from tests.support.system_cases import box, double_integrator, stays, switching
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.certificate import body_hash
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Cover, from_json
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim


def certificate(profile, system, claim, state, cells):
    names = [one.name for one in system.variables]
    widths = {names[column]: F(width) for column, width in cells.widths.items()}
    hashes = content_hash(profile), documents.content_hash(system)
    return of_hashes(*hashes, claim, state, Cover(widths, encode_numbers(cells.cuts)))


@pytest.fixture(scope="module")
def proved():
    system, profile = double_integrator(axes=1), switching(1)
    claim = stays(system, 20, x=(F(-1), F(1)))
    hashes = content_hash(profile), documents.content_hash(system)
    found = of_hashes(*hashes, claim, {"x": F(0), "vx": F(0)}, Cover({"vx": F(1, 16)}, b"\0"))
    return found, profile, system


def test_the_text(proved):
    found, profile, system = proved
    assert accept(found, profile, system) > 20
    text = to_json(found)
    assert from_json(text) == found and to_json(from_json(text)) == text
    assert "maviper-system-certificate-2" in text and len(text) < 2_000


def test_the_text_of_forms(proved):
    found, profile, system = proved
    of_forms = altered(found, cells={}, sets="forms", claim=replace(found.claim, regions=(box(x=(F(-2), F(2))),)))
    assert accept(of_forms, profile, system) > 20
    text = to_json(of_forms)
    assert from_json(text) == of_forms and json.loads(text)["sets"] == "forms"
    assert "sets" not in json.loads(to_json(found))
    with pytest.raises(RejectedError, match="cells"):
        accept(altered(of_forms, cells=found.proof.cells), profile, system)


def edited(text, change, whole=True):
    body = json.loads(text)
    change(body)
    body.pop("content_hash")
    return json.dumps(body | {"content_hash": body_hash(body) if whole else "0" * 64})


EDITS = {
    "another version": lambda body: body.update(certificate="maviper-system-certificate-3"),
    "no cells": lambda body: body.pop("cells"),
    "other sets": lambda body: body.update(sets="clouds"),
    "a member more": lambda body: body.update(more=1),
    "no number": lambda body: body["cells"].update(vx="wide"),
    "a division by 0": lambda body: body["cells"].update(vx="1/0"),
    "no base64": lambda body: body.update(cuts=["?"]),
    "about decisions": lambda body: body["claim"].update(kind="decides", name="decides"),
}


@pytest.mark.parametrize("change", EDITS.values(), ids=EDITS)
def test_damaged_texts(proved, change):
    with pytest.raises(InputError):
        from_json(edited(to_json(proved[0]), change))


def test_an_edited_text(proved):
    with pytest.raises(InputError, match="edited"):
        from_json(edited(to_json(proved[0]), lambda body: body["claim"].update(steps=21), whole=False))


def test_what_is_refused(proved):
    found, profile, system = proved
    for change in (
        {"cells": {"vx": F(-1)}}, {"cells": {"vx": F(0)}}, {"cells": {"vx": F(2) ** 300}}, {"cuts": b""},
        {"cuts": b"\3\0\0"}, {"cuts": b"\x80"}, {"inhabitant": {"x": F(9), "vx": F(0)}},
        {"claim": replace(found.claim, regions=(box(x=(F(-1, 2), F(1, 4))),))},
        {"claim": replace(found.claim, pattern=Pattern.DECIDES)},
        {"claim": SystemClaim(Pattern.AVOIDS, (box(x=(F(1, 4), F(1, 2))),), 20)},
    ):  # fmt: skip
        with pytest.raises(RejectedError):
            accept(altered(found, **change), profile, system)
    for change in ({"cells": {"y": F(1)}}, {"inhabitant": {"x": F(0)}}, {"profile": "0" * 64}, {"system": "0" * 64}):
        with pytest.raises(InputError):
            accept(altered(found, **change), profile, system)


def forged(seeds, each):
    """How many forgeries of claims that some episode breaks there were. AssertionError where one is accepted."""
    tried = 0
    for seed in seeds:
        random = np.random.default_rng([8, seed])
        asked = question(random)
        system, profile, claim = asked
        state = next((found for found in (start(random, system) for _ in range(20)) if found), None)
        if state is None or not refuted(random, asked, 40):
            continue
        for _ in range(each):
            found = certificate(profile, system, claim, state, recipe(random, system))
            for forgery in (found, altered(found, cells={}, sets="forms")):
                with pytest.raises(RejectedError):
                    accept(forgery, profile, system)
            tried += 2
    return tried


def test_forgeries_of_false_claims():
    assert forged(range(20), 5) >= 50


@pytest.mark.slow
def test_thousands_of_forgeries_of_false_claims():
    assert forged(range(1_000, 1_400), 8) >= 2_000
