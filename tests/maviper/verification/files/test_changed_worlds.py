"""`maviper check` of a certificate about a stated system, with a world file in which one entry is another one.

It refuses, or the certificate holds of what the changed file states too: then it says the same, of the same system.
"""

import re
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import ExitCode, MaviperError
from maviper.cli.main import run as command
from maviper.verification.files.certificates import check_file
from tests.support.stated import BRAKES, profile
from verify.systems.files import statement_of
from verify.systems.observing import function

WORLD = """
name = "cart"
steps = 6
dt = "0.2 s"

[constants]
push = "0.5 m/s^2"
bend = "0.01 m/s^2"

[variables]
x = { unit = "m", range = [-10, 10] }
v = { unit = "m/s", range = [-5, 5] }

[agents.cart]
reward = "0.1[1/m]*x"
[agents.cart.features]
place = "x"
ahead = "x + 1[s]*v"
side = "sign(x - 0.1)"
near = "clip(x, -1, 1)"

[agents.cart.actions]
stay = {}
left = { a = "-0.5 m/s^2" }
right = { a = "push" }

[start]
box = { x = [-1, 1], v = [0, 0] }
where = ["x + 1[s]*v <= 0.9"]

[dynamics]
error = { x = "0.001 m" }
cuts = { x = 4 }
[dynamics.let]
pull = "bend*sin(x/1[m])"
[[dynamics.piece]]
where = { x = [-10, 0] }
next = { x = "x + dt*v", v = "v + dt*(cart.a - pull)" }
[[dynamics.piece]]
where = { x = [0, 10] }
next = { x = "x + dt*v", v = "v + dt*(cart.a - pull)" }
error = { v = "0.002 m/s" }

[[property]]
label = "not far"
name = "stays_in"
region = { box = { x = [-3, 3] } }
"""
WORDS = {  # of entries that are no numbers, what they become
    '"m"': '"km"',
    '"m/s"': '"km/h"',
    "sign(": "positive(",
    "sin(": "cos(",
    '"not far"': '"very far"',
    '"stays_in"': '"avoids"',
    '"cart"': '"wagon"',
    "<=": ">=",
    "ahead =": "behind =",
    "left =": "leftwards =",
    '"push"': '"-push"',
    "+ dt": "- dt",
    "- pull": "+ pull",
    '"x + dt*v"': '"x"',
    'error = { x = "0.001 m" }': "",
    "cuts = { x = 4 }": "cuts = { x = 4, v = 2 }",
    'where = ["x + 1[s]*v <= 0.9"]': "",
    "stay = {}": 'stay = { a = "0.01 m/s^2" }',
    'near = "clip(x, -1, 1)"': "",
}


def edits():
    """The file with each number changed a little or by one, up or down, and with each word exchanged."""
    random = np.random.default_rng(0)
    for found in re.finditer(r"(?<![\w.])\d+(?:\.\d+)?", WORLD):
        number = F(found[0])
        number = (number + F(1, 8), number * F(9, 10), number + 1)[int(random.integers(3))]
        text = str(int(number)) if number.denominator == 1 else str(float(number))
        yield WORLD[: found.start()] + text + WORLD[found.end() :]
    for old, new in WORDS.items():
        assert old in WORLD
        for found in re.finditer(re.escape(old), WORLD):
            yield WORLD[: found.start()] + new + WORLD[found.end() :]


def meaning(statement):
    """What a file says of a system, by values at states: knows nothing of pieces, hashes or certificates."""
    system, random = statement.system, np.random.default_rng(0)
    found = [[(one.name, one.unit, one.range) for one in system.variables], [agent.name for agent in statement.agents]]
    for _ in range(40):
        state = {one.name: F(random.integers(-900, 900), 300) for one in system.variables}
        floats = {name: float(number) for name, number in state.items()}
        found += [half.holds({name: number / 3 for name, number in state.items()}) for half in system.start]
        for agent, features in system.features.items():
            found += [(agent, name, each.measure, each.bounds, each.form.at(state)) for name, each in features.items()]
        for rule in statement.rules:
            if all(low <= state[name] <= high for name, (low, high) in rule.where.items()):
                moved = {name: round(function(each)(floats), 12) for name, each in rule.move.items()}
                acted = {
                    (choice, name): round(function(each)(floats), 12)
                    for choice, added in rule.effect.items()
                    for name, each in added.items()
                }
                found.append((moved, acted, dict(rule.error)))
    return found


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """A folder with a profile, a world file and, in `out`, the certificate of a proof."""
    folder = tmp_path_factory.mktemp("changed")
    (folder / "profile.json").write_text(profile(BRAKES))
    (folder / "world.toml").write_text(WORLD)
    asked = ["verify", folder / "profile.json", "--system", folder / "world.toml", "-o", folder / "out"]
    assert command([*map(str, asked)]) == ExitCode.DONE
    return folder


def said_of(certificate, world):
    """What the check says, without the label, which is the file's word for a claim that it states as well."""
    return re.sub(r" \(in the file: '(not|very) far'\)", "", check_file(certificate, None, None, world).subject)


def sweep(folder):
    """(how many changed files are refused, how many are accepted)."""
    (certificate,) = (folder / "out").glob("certificate-*.json")
    before, meant = said_of(certificate, folder / "world.toml"), meaning(statement_of(WORLD, "w"))
    changed, refused, accepted = folder / "changed.toml", 0, 0
    for text in edits():
        changed.write_text(text)
        try:
            subject = said_of(certificate, changed)
        except MaviperError:
            refused += 1
            continue
        accepted += 1
        assert subject == before, text
        assert meaning(statement_of(text, "w")) == meant, text
    return refused, accepted


def test_a_changed_world_is_refused_or_means_the_same(proved):
    refused, accepted = sweep(proved)
    assert refused > 50 and accepted > 3, (refused, accepted)  # a label, a property and a reward change nothing


def test_a_checker_that_does_not_look_is_found_out(proved, monkeypatch):
    for form in ("systems.branch_proofs", "covers.sweep"):
        monkeypatch.setattr(f"verify.checker.{form}.check_certificate", lambda *given: 1)
    with pytest.raises(AssertionError):
        sweep(proved)
