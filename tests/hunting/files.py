"""Files of several claims for the hunt: each claim is asked alone, all are asked together, and in the reverse order.

Does: random world files with claims of every kind, assumptions, invariants and claims that differ in label and
  invariant alone; property files about decisions of games; tells where an answer is another one beside its neighbours.
Assumes: nothing of what is true: whether an answer is right, other kinds ask.
Does not: know flows.
"""

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import verdicts
from maviper.verification.stated import StatedWorld
from tests.hunting import questions, regions, teams
from tests.hunting.asking import Told
from tests.support.system_cases import policy, team
from tests.verify.reach.random_systems import nested, some
from verify.certificates.systems import to_json
from verify.claims.files import read_properties
from verify.question import Budgets, Question
from verify.subjects import Game

BOXES, CLAIMS, STEPS = 60_000, 4, 8
GAMES = 4  # of so many files one is about a game
ACTIONS = ("p", "q")
PATTERNS = ("decides", "stays_in", "avoids", "reaches", "reaches_and_stays", "always", "always")


def ask(seed: int, thorough: bool) -> Told:
    """The answers to the claims of a file. `thorough` asks nothing more."""
    rng = np.random.default_rng([seed, 71])
    tables, answer = _game(rng) if seed % GAMES == GAMES - 1 else _world(rng)
    alone = [answer([table])[0] for table in tables]
    told = Told(seed, alone[0][0], "file", len(tables))
    told.wrong += _differing("together", alone, answer(tables))
    told.wrong += _differing("in the reverse order", alone, answer(tables[::-1])[::-1])
    return told


def _differing(how: str, alone: list[Any], beside: list[Any]) -> list[str]:
    pairs = enumerate(zip(alone, beside, strict=True), 1)
    return [f"claim {number}: {was} alone, {found} {how}" for number, (was, found) in pairs if was != found]


# --- world files


def _world(rng: np.random.Generator) -> tuple[list[str], Any]:
    """The claims of a world file, and what answers some of them."""
    tree = nested(rng, 2, 2, len(ACTIONS))
    acting = team(policy("a", ["f0", "f1"], list(ACTIONS), tree))
    tables = [_table(rng, number) for number in range(CLAIMS - 1)]
    twin = tables[int(rng.integers(len(tables)))].replace('label = "claim', 'label = "twin')
    if 'name = "always"' in twin and "invariant" not in twin:
        twin += f"invariant = {_region(rng)}\n"
    tables.insert(int(rng.integers(CLAIMS)), twin)
    return tables, partial(_answer_world, _head(rng), acting)


def _answer_world(head: str, acting: Any, tables: list[str]) -> list[Any]:
    """The answer to each claim, in the order of the file."""
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "world.toml"
        file.write_text(head + "".join(tables))
        world = StatedWorld.of(acting, VerifyOptions(world=str(file), max_boxes=BOXES, verdict_only=True))
        found = {id(one.question.claim): world.answer(one.question, beside=False) for one in world.asked}
    return [_told(found[id(claim)]) for claim in world.claims]


def _told(result: Any) -> tuple[str, ...]:
    """All that is said of a claim."""
    certificate = result.evidence.certificate
    proof = "" if certificate is None else to_json(certificate)
    return result.verdict.value, result.claim.label, result.reason, proof, str(result.evidence.counterexample)


def _head(rng: np.random.Generator) -> str:
    def number() -> str:
        return f"{int(rng.integers(-7, 8)) / 8}"

    low = int(rng.integers(-4, 4)) / 4
    rules = [f'{name} = "{number()}*x + {number()}*v + a.u"' for name in "xv"]
    return f"""name = "file"
steps = {STEPS}
[variables]
x = {{ range = [-3, 3] }}
v = {{ range = [-3, 3] }}
[agents.a.features]
f0 = "x"
f1 = "v"
[agents.a.actions]
p = {{ u = {number()} }}
q = {{ u = {number()} }}
[start]
box = {{ x = [{low}, {low + 1}], v = [0, 0.5] }}
[dynamics.next]
{rules[0]}
{rules[1]}
"""


def _table(rng: np.random.Generator, number: int) -> str:
    name = some(rng, PATTERNS)
    lines = ["[[property]]", f'label = "claim {number}"', f"region = {_region(rng)}"]
    if name == "decides":
        return "\n".join([*lines, f'formula = "x >= {int(rng.integers(-4, 5)) / 2} implies acts(a) == p"']) + "\n"
    lines.append(f'name = "{name}"')
    if name == "reaches_and_stays" or (name == "always" and rng.random() < 0.4):
        lines.append(f"by = {int(rng.integers(1, 4))}")
    if name == "always" and rng.random() < 0.6:
        lines.append(f"assuming = {_region(rng)}")
    if name == "always" and rng.random() < 0.4:
        lines.append(f"invariant = {_region(rng)}")
    return "\n".join(lines) + "\n"


def _region(rng: np.random.Generator) -> str:
    low, high = int(rng.integers(-12, 9)) / 4, int(rng.integers(1, 13)) / 2
    sloped = ', where = ["x + v <= 2"]' if rng.random() < 0.3 else ""
    return f"{{ box = {{ x = [{max(low, -3)}, {min(low + high, 3)}], v = [-3, 3] }}{sloped} }}"


# --- property files about decisions of games


def _game(rng: np.random.Generator) -> tuple[list[str], Any]:
    """The claims of a property file, and what answers some of them."""
    world = str(rng.choice(list(teams.WORLDS)))
    profile = teams.bare(world)
    whole = teams.TEAMS[world.split(",")[0]]
    drawn = [questions.claim_of(rng, profile, whole) for _ in range(CLAIMS - 1)]
    drawn.append({**drawn[0], "assume": None if drawn[0]["assume"] else _assumed(rng, profile, whole)})
    made, _ = questions.team_of(rng, profile, drawn[0])
    tables = [questions.property_file(each, regions.table(regions.drawn(rng, made, whole))) for each in drawn]
    return tables, partial(_answer_game, made)


def _assumed(rng: np.random.Generator, profile: Any, whole: str) -> Any:
    agents, marks = [one.agent for one in profile.team(whole)], [mark.name for mark in profile.world.landmarks]
    return questions.assumption(rng, agents, marks, profile.world.goals)


def _answer_game(profile: Any, tables: list[str]) -> list[Any]:
    budgets = Budgets(solver_units=questions.UNITS, max_nodes=questions.NODES)
    try:
        stated = read_properties("".join(tables), profile, "hunt", questions._no_file)
        asked = [Question(Game(profile), each.claim, each.region, budgets=budgets) for each in stated]
        return [(verdict.value, reason) for verdict, reason in verdicts(asked)]
    except InputError as error:
        return [("refused", error.what)] * len(tables)
