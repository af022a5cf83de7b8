"""Signals of cities: what is proved about them for ever, beside a search of our own through all that can happen."""

import ctypes
import json
import random
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import maviper
from codegen.dynamics import motionless
from maviper.answers import Guarded
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from tests.support.system_cases import policy, team
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

WORLDS = Path(__file__).parent.parent / "generated" / "signals" / "worlds"
PROOFS, HOUR = WORLDS.parent / "proofs", WORLDS.parent / "hour"
MOST_RED, LEAST_GREEN, STEP = 120, 10, 5  # seconds


def possible(tree, phases, on, green, red, bounds):
    """The actions that some traffic asks of a nested tree; `bounds`: what is left of each count, as (low, high]."""
    if isinstance(tree, int):
        return {tree}
    (feature, threshold), left, right = tree
    kind, _, number = feature.partition("_")
    known = {"on": lambda: number == str(on), "green": lambda: green, "red": lambda: red[int(number)]}
    if kind in known:
        return possible(left if known[kind]() <= threshold else right, phases, on, green, red, bounds)
    low, high = bounds[feature]
    asked = set()
    if low <= threshold:
        asked |= possible(left, phases, on, green, red, {**bounds, feature: (low, min(high, threshold))})
    if high > threshold:
        asked |= possible(right, phases, on, green, red, {**bounds, feature: (max(low, threshold), high)})
    return asked


def states(tree, phases, rooms):
    """All that can be met: the phase that is on, seconds of its green, seconds of red of each."""
    open_: list[tuple[int, int, tuple[int, ...]]] = [(0, 0, (0,) * phases)]
    met = set(open_)
    while open_:
        on, green, red = open_.pop()
        yield on, green, red
        bounds = {name: (0, room) for name, room in rooms.items()}
        for action in possible(tree, phases, on, green, red, bounds) if green >= LEAST_GREEN else {on}:
            clocks = tuple(0 if k == action else min(red[k] + STEP, 240) for k in range(phases))
            after = (action, min(green + STEP, 240) if action == on else 0, clocks)
            if after not in met:
                met.add(after)
                open_.append(after)


def is_kept(tree, phases, needed, rooms):
    """True if no traffic keeps a phase that is needed red for too long, by all states that can be met."""
    return all(red[k] + STEP <= MOST_RED for *_, red in states(tree, phases, rooms) for k in needed)


class Plant:
    """A committed world, read by its text."""

    def __init__(self, name):
        self.text = (WORLDS / f"{name}.toml").read_text()
        document = tomllib.loads(self.text)
        ((self.agent, described),) = document["agents"].items()
        self.features, self.actions = list(described["features"]), list(described["actions"])
        self.rooms = {
            name: most["range"][1] for name, most in document["variables"].items() if most.get("unit") == "vehicles"
        }
        (region,) = document["claim"][1]["region"]
        self.needed = [int(name.removeprefix("red_")) for name in region["box"]]

    def profile(self, tree):
        def placed(nested):
            if isinstance(nested, int):
                return nested
            (name, threshold), left, right = nested
            return (self.features.index(name), threshold), placed(left), placed(right)

        return team(policy(self.agent, self.features, self.actions, placed(tree)))

    def ask(self, profile):
        """The answers about least green and longest red."""
        statement = statement_of(self.text, "world.toml")
        subject = ClosedLoop(profile, statement.system)
        return [
            decide(Question(subject, claim, UNBOUNDED, budgets=Budgets(samples=64)))
            for claim in claims_of(statement, profile, "world.toml")
        ]


def draw(plant, depth, chance):
    """A random tree; in half of the cases below guards that give each needed phase green in time, or not quite."""
    phases = len(plant.actions)

    def below(left):
        if not left or chance.random() < 0.15:
            return chance.randrange(phases)
        count = chance.choice(list(plant.rooms))
        feature, threshold = chance.choice(
            [
                (f"on_{chance.randrange(phases)}", 0.5),
                ("green", 5 * chance.randrange(1, 12) + 2.5),
                (f"red_{chance.choice(plant.needed)}", 5 * chance.randrange(1, 22) + 2.5),
                (count, chance.randrange(plant.rooms[count]) + 0.5),
            ]
        )
        return (feature, threshold), below(left - 1), below(left - 1)

    tree = below(depth)
    if chance.random() < 0.6:
        for phase in plant.needed:
            tree = (f"red_{phase}", 5 * chance.randrange(8, 23) + 2.5), tree, phase
    return tree


def compare(seed, names=("cologne8-signal_1", "cologne3-signal_0")):
    """The verdict about a random tree, and whether it is right; UNKNOWN is never wrong."""
    chance = random.Random(seed)
    plant = Plant(chance.choice(names))
    tree = draw(plant, chance.randrange(1, 5), chance)
    profile = plant.profile(tree)
    verdict = plant.ask(profile)[1].verdict
    kept = is_kept(tree, len(plant.actions), plant.needed, plant.rooms)
    return verdict, kept, {Verdict.PROVED: kept, Verdict.VIOLATED: not kept}.get(verdict, True)


@pytest.mark.parametrize("seed", range(4))
def test_verdicts_of_random_trees_are_those_of_a_search_of_all_states(seed):
    assert compare(seed)[2]


def test_least_green_is_proved_of_any_tree_and_a_mask_that_ends_too_early_is_refuted():
    plant = Plant("cologne8-signal_1")
    hasty = plant.profile((("on_0", 0.5), 0, 1))
    least, longest = plant.ask(hasty)
    assert (least.verdict, longest.verdict) == (Verdict.PROVED, Verdict.PROVED)
    plant.text = plant.text.replace("green < 2[steps]", "green < 1[steps]").replace("green >= 2[s", "green >= 1[s")
    assert plant.ask(hasty)[0].verdict is Verdict.VIOLATED


def test_a_tree_without_a_clock_is_refuted_by_traffic_that_it_keeps_to():
    plant = Plant("cologne8-signal_1")
    queue = (("north_halting", 3.5), (("west_halting", 3.5), 0, 1), 0)
    assert not is_kept(queue, 2, plant.needed, plant.rooms)
    found = plant.ask(plant.profile(queue))[1]
    assert found.verdict is Verdict.VIOLATED
    assert found.counterexample is not None
    assert max(found.counterexample.states[-1][clock] for clock in ("red_0", "red_1")) == 24


@pytest.mark.slow
def test_a_tree_without_a_clock_is_repaired_and_keeps_to_itself_otherwise():
    plant = Plant("cologne8-signal_1")
    queue = (("north_halting", 3.5), (("west_halting", 3.5), 0, 1), 0)
    before = replace(plant.profile(queue), world=motionless("stated", "", (plant.agent,), 10, {}))
    done = maviper.repair(before, WORLDS / "cologne8-signal_1.toml")
    assert isinstance(done, Guarded)
    assert [guard[1:] for guard in done.guards] == [(f"red_{k}", True, 58.75, f"green_{k}") for k in (1, 0)]
    assert done.after is not None
    repaired = nested(done.after.policy(plant.agent))
    assert repaired == (("red_1", 58.75), (("red_0", 58.75), queue, 0), 1)
    assert is_kept(repaired, 2, plant.needed, plant.rooms) and not is_kept(queue, 2, plant.needed, plant.rooms)


@pytest.mark.slow
@pytest.mark.skipif(find_spec("libsumo") is None or find_spec("sumo_rl") is None, reason="reads programs of SUMO")
def test_rules_without_a_longest_red_are_repaired_in_a_network(tmp_path):
    rules, hasty = tmp_path / "rules.py", tmp_path / "hasty.json"
    subprocess.run([sys.executable, PROOFS.parent / "actuated.py", "cologne1", rules], check=True)
    maviper.from_file(rules, arrays="float32", run=False).save(hasty)
    command = [sys.executable, PROOFS.parent / "repaired.py", "cologne1", hasty, tmp_path]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "signal_0: red_2 > 58.75 -> green_2" in told and "2 certificates accepted" in told
    plant, repaired = Plant("cologne1-signal_0"), maviper.load(tmp_path / "cologne1.json")["signal_0"]
    assert is_kept(nested(repaired), len(plant.actions), plant.needed, plant.rooms)


def test_a_rare_course_is_found_along_cells():
    """No random traffic keeps both counts just so for two minutes."""
    plant = Plant("cologne8-signal_1")
    narrow = (
        ("north_halting", 6.5),
        1,
        (("north_halting", 7.5), (("west_ahead", 40.5), 1, (("west_ahead", 41.5), 0, 1)), 1),
    )
    tree = (("red_0", 57.5), narrow, 0)
    assert not is_kept(tree, 2, plant.needed, plant.rooms)
    assert plant.ask(plant.profile(tree))[1].verdict is Verdict.VIOLATED


CERTIFICATES = sorted(path.stem for path in PROOFS.glob("*-[12].json"))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * ("ingolstadt" in name)) for name in CERTIFICATES]
)
def test_committed_certificates_are_accepted(name):
    network, signal, _ = name.split("-")
    team = PROOFS / f"{network}.json"  # of all signals of the network, and the world states one
    assert maviper.check(PROOFS / f"{name}.json", team, world=WORLDS / f"{network}-{signal}.toml").subject


def test_each_signal_has_both_certificates():
    assert sorted(f"{path.stem}-{claim}" for path in WORLDS.glob("*.toml") for claim in (1, 2)) == CERTIFICATES
    assert len(CERTIFICATES) == 2 * 41


def test_neighbours_on_one_road_serve_it_together_but_may_both_leave_it():
    file = PROOFS.parent / "neighbours.toml"
    done = maviper.verify_file(PROOFS / "cologne3.json", file, region="ranges", observations=True)
    assert [str(result.verdict) for result in done] == ["PROVED", "PROVED", "VIOLATED", *["PROVED"] * 4]


def test_a_profile_may_have_agents_that_a_world_does_not_state():
    options = VerifyOptions(world=WORLDS / "cologne3-signal_0.toml")
    world = StatedWorld.of(maviper.load(PROOFS / "cologne3.json"), options)
    assert [policy.agent for policy in world.profile.agents] == ["signal_0"]


@pytest.mark.parametrize("numbers", ["float32", "floats"])
def test_the_c_of_a_team_drives_sumo(numbers, tmp_path, monkeypatch):
    for needed in ("libsumo", "sumo_rl", "pettingzoo"):
        pytest.importorskip(needed, reason="simulates in SUMO")
    monkeypatch.syspath_prepend(PROOFS.parent)
    drive, rules = import_module("drive"), tmp_path / "rules.py"
    command = [sys.executable, PROOFS.parent / "actuated.py", "cologne3", rules, "62.5"]
    subprocess.run(command, check=True)  # a process of its own, as libsumo has one simulation in each
    maviper.compile(maviper.from_file(rules, arrays=numbers), targets=("shared", "json")).write(tmp_path / "code")
    found = drive.drive("cologne3", str(tmp_path / "code"), seconds=100)
    assert found["decisions"] > 5 and found["differ"] == 0


@pytest.mark.slow
@pytest.mark.compile
def test_the_monitor_beside_the_c_is_silent_in_sumo_and_speaks_where_a_phase_is_kept(tmp_path, monkeypatch):
    for needed in ("libsumo", "sumo_rl", "pettingzoo"):
        pytest.importorskip(needed, reason="simulates in SUMO")
    monkeypatch.syspath_prepend(PROOFS.parent)
    drive, watching, signals = map(import_module, ("drive", "watching", "signals"))
    (tmp_path / "world.toml").write_bytes((WORLDS / "cologne1-signal_0.toml").read_bytes())
    (tmp_path / "proof.json").write_bytes((PROOFS / "cologne1-signal_0-2.json").read_bytes())
    asked = {"targets": ("shared", "json", "monitor"), "certificate": tmp_path / "proof.json"}
    maviper.compile(PROOFS / "cologne1.json", **asked).write(tmp_path / "code")
    found = drive.drive("cologne1", str(tmp_path / "code"), seconds=600)
    assert (found["watched"], found["doubted"], found["differ"]) == (600 // STEP, 0, 0)
    env = signals.make("cologne1", seconds=300)
    code = drive.library(tmp_path / "code", "imported", watched=True)
    watch = watching.Watch(env.signals["signal_0"], code, LEAST_GREEN)
    env.reset(0)
    while env.agents:
        env.step(dict.fromkeys(env.acting, 0))
    env.close()
    assert (300 - MOST_RED) // STEP <= watch.counts["doubted"] < 300 // STEP == watch.counts["watched"]


def nested(policy, node=0):
    """A tree of a profile as the search reads it."""
    tree = policy.tree
    if tree.feature[node] < 0:
        return int(policy.actions[int(tree.action[node])].name.removeprefix("green_"))
    test = policy.features[int(tree.feature[node])].name, float(tree.threshold[node])
    return test, nested(policy, int(tree.left[node])), nested(policy, int(tree.right[node]))


def test_the_picture_follows_from_the_proofs(tmp_path):
    subprocess.run([sys.executable, PROOFS.parent / "picture.py", tmp_path / "signals.svg"], check=True)
    drawn = (tmp_path / "signals.svg").read_text()
    assert drawn == (PROOFS.parents[2] / "maviper" / "manual" / "signals.svg").read_text()
    plant, policy = Plant("cologne3-signal_0"), maviper.load(PROOFS / "cologne3.json")["signal_0"]
    met = states(nested(policy), len(plant.actions), plant.rooms)
    worst = max(red[k] + STEP for *_, red in met for k in plant.needed)
    assert worst == 70 and "within 75 s" in drawn  # sets of states have clocks that are not whole, too


def longest_red(phases, served):
    """Seconds from the end of a green to the next one, whose step of clearance is red, too."""
    steps = "".join("G" if int(phase) in served else "r" for phase in phases)
    shown = re.sub("rG", "rr", steps[0] + steps)[1:]
    return STEP * max(map(len, shown.split("G")))


def test_the_picture_of_the_hour_has_its_numbers_and_the_bound_of_its_certificate(tmp_path):
    subprocess.run([sys.executable, PROOFS.parent / "city.py", tmp_path / "city.svg"], check=True)
    drawn = (tmp_path / "city.svg").read_text()
    assert drawn == (PROOFS.parents[2] / "maviper" / "manual" / "city.svg").read_text() and len(drawn) < 60_000
    hour = json.loads((HOUR / "hour.json").read_text())
    for player in ("expert", "tree", "guarded"):
        reds = [longest_red(hour[player]["phases"], each["phases"]) for each in hour["approaches"].values()]
        assert all(f">{red} s<" in drawn for red in reds if red)
        assert player != "guarded" or max(reds) <= 70
    assert f"stood {hour['expert']['stood']['west_2']} s by the expert" in drawn
    assert f"guards: {hour['guarded']['delay']:.1f} s" in drawn and "proved: 70 s" in drawn
    name, policy = "ingolstadt1-signal_0", maviper.load(HOUR / "ingolstadt1.json")["signal_0"]
    assert maviper.check(HOUR / f"{name}-2.json", HOUR / "ingolstadt1.json", world=HOUR / f"{name}.toml").subject
    plant = Plant(name)
    met = states(nested(policy), len(plant.actions), plant.rooms)
    assert max(red[k] + STEP for *_, red in met for k in plant.needed) <= 70


def test_the_record_is_told_by_its_own_script_and_its_cells_can_be_gone_on_with(tmp_path):
    script = PROOFS.parents[1] / "reproduction" / "signals" / "recompute.py"
    told = subprocess.run([sys.executable, "-I", script], check=True, capture_output=True, text=True).stdout
    assert told == script.with_name("tables.txt").read_text()
    subprocess.run([sys.executable, "-I", script, "unpack", tmp_path], check=True)
    cells = [json.loads(path.read_text()) for path in tmp_path.glob("cells/*/cell.json")]
    assert len(cells) == 35 and all(each["outcome"] == "done" for each in cells)
    found = defaultdict(list)
    for place in tmp_path.glob("cells/*/profile.json"):
        cell = json.loads((place.parent / "cell.json").read_text())["cell"]
        lines = (place.parent / "episodes.csv").read_text().splitlines()
        delays = [float(line.rpartition(",")[2]) for line in lines if ",signal delay," in line]
        leaves = int((maviper.load(place)["signal_0"].tree.feature < 0).sum())
        assert len(delays) == 50
        found[f"{cell['algorithm']}, depth {cell['depth']} "].append((np.mean(delays), leaves))
    assert len(found) == 6
    for name, of in found.items():
        delays, leaves = np.transpose(of)
        (row,) = (row for row in told.splitlines() if row.startswith(name))
        assert f" {delays.mean():.1f} +-" in row and f" {leaves.min():.0f} to {leaves.max():.0f} " in row


@pytest.mark.slow
@pytest.mark.skipif(find_spec("libsumo") is None or find_spec("sumo_rl") is None, reason="simulates in SUMO")
def test_sumo_plays_the_hour_of_the_picture(monkeypatch):
    monkeypatch.syspath_prepend(PROOFS.parent)
    assert import_module("hour").hour() == json.loads((HOUR / "hour.json").read_text())


@pytest.mark.slow
@pytest.mark.skipif(find_spec("libsumo") is None or find_spec("sumo_rl") is None, reason="simulates in SUMO")
def test_sumo_shows_the_wait_of_a_tree_without_a_clock_and_its_end_with_one(tmp_path):
    rules, hasty, traffic = tmp_path / "rules.py", tmp_path / "hasty.json", tmp_path / "routes.xml"
    subprocess.run([sys.executable, PROOFS.parent / "actuated.py", "cologne3", rules], check=True)
    maviper.from_file(rules, arrays="float32", run=False).save(hasty)

    def waits(team):
        command = [sys.executable, PROOFS.parent / "routes.py", "cologne3", "signal_0", team, traffic]
        return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)

    assert max(waits(hasty).values()) == 240  # where clocks end
    written = traffic.read_text()
    assert MOST_RED / 2 < max(waits(PROOFS / "cologne3.json").values()) <= MOST_RED
    assert traffic.read_text() == written  # since no traffic keeps anybody waiting there


@pytest.mark.slow
@pytest.mark.compile
def test_the_monitor_of_the_claim_never_speaks_of_its_tree_and_tells_of_one_whose_clocks_stand_still(tmp_path):
    world, certificate = WORLDS / "cologne3-signal_0.toml", PROOFS / "cologne3-signal_0-2.json"
    (tmp_path / "world.toml").write_bytes(world.read_bytes())
    (tmp_path / "proof.json").write_bytes(certificate.read_bytes())
    whole, plant = maviper.load(PROOFS / "cologne3.json"), Plant("cologne3-signal_0")
    own = replace(whole, agents=(policy := whole["signal_0"],))
    maviper.compile(own, targets=("monitor",), certificate=tmp_path / "proof.json").write(tmp_path)
    (tmp_path / "m.c").write_text(
        '#include "imported_monitor.h"\nstatic imported_monitor m;\n'
        "int ask(const double *w, int first) { if (first) imported_monitor_start(&m);\n"
        "imported_monitor_renew_all(&m); return imported_monitor_step(&m, w, 1.0) == IMPORTED_M_OK; }\n"
    )
    command = ["cc", "-std=c99", "-O1", "-shared", "-fPIC", tmp_path / "m.c", "-o", tmp_path / "m.so"]
    subprocess.run(command, check=True)
    ask = ctypes.CDLL(str(tmp_path / "m.so")).ask

    def last_red(told, counts, steps=100):
        """Steps of red of phase 2 once the monitor speaks; None: it does not. `told`: whether the tree sees clocks."""
        on, green, ended, red = 0, 0, LEAST_GREEN // STEP, [0] * len(plant.actions)
        for step in range(steps):
            now = counts()
            state = [on, green, ended, *red, *now]
            if not ask((ctypes.c_double * len(state))(*state), not step):
                return red[2]
            seen = [*(k == on for k in range(len(red))), STEP * green, *(told * STEP * each for each in red), *now]
            action = int(policy.act([np.array(seen, np.float32)])[0]) if green >= LEAST_GREEN // STEP else on
            name = policy.actions[action].name if green >= LEAST_GREEN // STEP else f"green_{on}"
            after = int(name.removeprefix("green_"))
            green, ended = (min(green + 1, 48), ended) if after == on else (0, green)
            on, red = after, [0 if k == after else each + 1 for k, each in enumerate(red)]
        return None

    chance = random.Random(0)
    assert last_red(True, lambda: [chance.randint(0, int(room)) for room in plant.rooms.values()]) is None
    assert last_red(True, lambda: [9] * len(plant.rooms)) is None
    assert 12 < last_red(False, lambda: [9] * len(plant.rooms)) <= MOST_RED // STEP
