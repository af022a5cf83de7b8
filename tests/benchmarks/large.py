"""Whether large things end: whole commands, with what they spend and whether they give an answer.

    python tests/benchmarks/large.py [--json] [CASE ...]

Questions: a verdict or an UNKNOWN. Commands: `verify` on the demo's profile, with all files, once its modules are
compiled; compilation of a wide tree and of many agents, extraction for many agents and for CartPole, whose expert
stable-baselines3 trains first (or is --expert ZIP); beside the evaluation stands what Gymnasium's own loop takes for as
many steps. Teams of 8 and 12 agents, trees of depth 12 to 16, and 131,000 leaves; default options. A command gets two
minutes of CPU time, process start included, and should stay below two gigabytes. Trees: fixed roles under fitted splits
(held), and full trees with splits and actions at random (full).
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

import numpy as np

from codegen.dynamics import motionless
from codegen.errors import ExitCode
from codegen.ir import ActionSpec, AgentPolicy, FeatureSpec, PolicyProfile, Provenance
from codegen.policy_json import dumps
from tests.benchmarks.verifier import Played, below, flat, held_roles, offset, towards

LIMIT = 120  # seconds of CPU
RUNS = 6  # of a command that takes a second: the first one compiles its modules, and the least of the others counts
ANSWERS = {ExitCode.DONE: "PROVED", ExitCode.VIOLATED: "VIOLATED", ExitCode.INCONCLUSIVE: "UNKNOWN"}
Made = Callable[[], PolicyProfile]


class Ended(NamedTuple):
    """How a command ended: its answer, or "" where it gave none; seconds of CPU, megabytes at most."""

    answer: str
    seconds: float
    megabytes: float


def held(count: int) -> PolicyProfile:
    """A team with fixed roles under fitted splits, of depth 6 in all."""
    game = Played(f"cooperative-navigation,agents={count}")
    trees = {}
    for k, agent in enumerate(game.world.agents):
        above = game.fitted(agent, game.heading(agent, np.full(len(game.states), k)), 3)
        trees[agent] = below(above, towards(*offset(game, agent, f"landmark_{k}")))
    return game.profile(trees)


def full(world: str, depth: int, team: str, seed: int = 0) -> PolicyProfile:
    """Full trees over the features that measure positions, with splits and actions at random."""
    game, rng = Played(world), np.random.default_rng(seed)
    trees = {}
    for agent, features in zip(game.world.agents, game.world.features, strict=True):
        if game.world.team_of(agent) == team:
            places = [place for place, feature in enumerate(features) if measures_positions(feature)]
            trees[agent] = grown(rng, places, depth)
    return game.profile(trees)


def measures_positions(feature):
    """Whether it is a coordinate or a sum of such, of positions alone."""
    meaning = feature.meaning
    return bool(meaning and not meaning.function) and all(name.endswith((".x", ".y")) for _, name in meaning.terms)


def grown(rng, places, depth):
    """A nested tree with all its leaves at that depth."""
    if not depth:
        return int(rng.integers(0, 5))
    split = int(rng.choice(places)), np.float32(rng.uniform(-0.9, 0.9))
    return *split, grown(rng, places, depth - 1), grown(rng, places, depth - 1)


CASES: dict[str, tuple[Made, str]] = {
    "8 agents, no_double": (lambda: held(8), "no_double"),
    "8 agents, own_target": (lambda: held(8), "own_target"),
    "12 agents, no_double": (lambda: held(12), "no_double"),
    "12 agents, own_target": (lambda: held(12), "own_target"),
    "12 agents, full trees, no_double": (lambda: full("cooperative-navigation,agents=12", 6, "agents"), "no_double"),
    "8 agents, 33,000 leaves, no_double": (lambda: full("cooperative-navigation,agents=8", 12, "agents"), "no_double"),
    "2 agents, depth 17, fixed roles": (lambda: held_roles(Played("physical-deception"), 14), "distinct_targets"),
    "2 agents, 131,000 leaves": (lambda: full("physical-deception", 16, "defenders"), "distinct_targets"),
}


def wide(features: int = 200, depth: int = 10, seed: int = 0) -> PolicyProfile:
    """One agent that observes so much, with splits and actions at random."""
    rng = np.random.default_rng(seed)
    seen = tuple(FeatureSpec(f"f{place}", "none", -1e9, 1e9, None) for place in range(features))
    actions = tuple(ActionSpec(f"a{place}", None) for place in range(5))
    policy = AgentPolicy("agent_0", "agents", seen, actions, flat(grown(rng, list(range(features)), depth)))
    return PolicyProfile(
        motionless("wide", "none", ["agent_0"]), (policy,), Provenance("random", "none", 0, "", "bench")
    )


WIDE, MANY = "compile 200 features", "compile 12 agents"
DEMO = "verify the demo's profile"
PROFILE = Path(__file__).parents[2] / "generated" / "physical_deception" / "profile.json"
EXTRACTIONS = {
    "extract 6 agents": ["cooperative-navigation,agents=6", "--max-episodes", "200"],
    "extract 12 agents": ["cooperative-navigation,agents=12", "--max-episodes", "500"],
}
ZIP, CARTPOLE = "cartpole.zip", "gymnasium:CartPole-v1"
TREE = ["--algorithm", "viper", "--max-leaves", "5"]
OUTSIDE = {  # the commands of own.md about an expert of stable-baselines3, which is trained for them, untimed
    "extract CartPole": ["extract", f"sb3:{{folder}}/{ZIP}", "--world", CARTPOLE, *TREE, "-o", "{folder}/tree.json"],
    "evaluate CartPole": ["evaluate", "{folder}/tree.json", "--world", CARTPOLE, "--expert", f"sb3:{{folder}}/{ZIP}"],
}
COMPILED: dict[str, Made] = {WIDE: wide, MANY: lambda: full("cooperative-navigation,agents=12", 6, "agents")}
# seconds of CPU on an idle core, and megabytes
REFUSED = "refuse matchings of 12 agents"
REACH = {
    DEMO: (1, 200),
    REFUSED: (2, 300),
    WIDE: (4, 400),
    MANY: (10, 400),
    "extract 6 agents": (20, 400),
    "extract 12 agents": (60, 400),
    "extract CartPole": (15, 1000),
    "evaluate CartPole": (8, 1000),
}


def ended(profile: PolicyProfile, claim: str, *more: str) -> Ended:
    """One question, and how it ended."""
    return ran(profile, "verify", "--property", claim, *more)


def ran(profile: PolicyProfile, verb: str, *more: str) -> Ended:
    """One command about a profile, and how it ended."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "profile.json"
        path.write_text(dumps(profile))
        return spent([verb, str(path), *more])


# A process counts the memory of the one that it came from, and this benchmark grows: so a small one stands between.
SPENDING = """
import os, resource, subprocess, sys
limit, *words = sys.argv[1:]
command = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
resource.prlimit(command.pid, resource.RLIMIT_CPU, (int(limit), int(limit)))
_, status, used = os.wait4(command.pid, 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss)
"""


def spent(words: list[str]) -> Ended:
    """A command of maviper's, and how it ended."""
    return spent_by([sys.executable, "-m", "maviper", *words])


def spent_by(words: list[str]) -> Ended:
    """Any command, and how it ended."""
    compiled = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-S", "-c", SPENDING, str(LIMIT), *words]
    ended = subprocess.run(command, capture_output=True, text=True, check=True, env=compiled)
    code, seconds, kilobytes = ended.stdout.split()
    return Ended(ANSWERS.get(int(code), ""), float(seconds), int(kilobytes) / 1024)


def command(name: str, expert: str = "") -> Ended:
    """A command of REACH, and how it ended; what cannot be replayed is compiled all the same. `expert`: of
    CartPole; "": one that is trained.
    """
    with tempfile.TemporaryDirectory() as folder:
        if name == DEMO:
            runs = [spent(["verify", str(PROFILE), "-o", f"{folder}/answers"]) for _ in range(RUNS)]
            found = min(runs[1:], key=lambda run: run.seconds)
        elif name == REFUSED:
            return ran(COMPILED[MANY](), "verify", "--property", "distinct_targets")._replace(answer="REFUSED")
        elif name in OUTSIDE:
            if expert:
                shutil.copy(expert, Path(folder) / ZIP)
            else:
                train_cartpole(Path(folder) / ZIP)
            if name.startswith("evaluate"):
                spent([word.format(folder=folder) for word in OUTSIDE["extract CartPole"]])
            found = spent([word.format(folder=folder) for word in OUTSIDE[name]])
            if name.startswith("evaluate"):
                rows = json.loads((Path(folder) / "tree.json").read_text())["provenance"]["evaluation"]
                beside(round(rows["episodes"] * (rows["agent return"] + rows["agent expert return"])), found.seconds)
        elif name in EXTRACTIONS:
            found = spent(["extract", *EXTRACTIONS[name], "-o", str(Path(folder) / "result.json")])
        else:
            code = str(Path(folder) / "code")
            found = ran(COMPILED[name](), "compile", "--target", "c,python,json", "-o", code)
    return found._replace(answer="DONE" if found.answer else "")


def beside(steps: int, seconds: float) -> None:
    """Says what so many steps of CartPole take in Gymnasium's own loop, in the same minute."""
    import gymnasium

    game, clock = gymnasium.make("CartPole-v1", disable_env_checker=True), time.process_time()
    seen, _ = game.reset(seed=0)
    for _ in range(steps):
        seen, _, ended, cut, _ = game.step(int(seen[2] + seen[3] > 0))
        if ended or cut:
            seen, _ = game.reset()
    alone = time.process_time() - clock
    told = f"{steps:,} steps in Gymnasium's own loop: CPU {alone:.1f} s"
    print(f"{told}; the command takes {seconds / alone:.2f} times that", file=sys.stderr)


def train_cartpole(place: Path) -> None:
    """The expert of own.md: 50,000 steps of PPO, about a minute."""
    from stable_baselines3 import PPO

    learner = PPO("MlpPolicy", "CartPole-v1", n_steps=256, batch_size=256, gamma=0.98, seed=0, device="cpu")
    learner.learn(50_000)
    learner.save(place)


def main() -> None:
    """The table, or its figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"some of: {'; '.join([*CASES, *REACH])}")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--expert", metavar="ZIP", default="", help="of CartPole, in place of one that is trained")
    options = parser.parse_args()
    found = {}
    installed = find_spec("stable_baselines3") is not None
    if not installed and not options.json:
        print("not run: extract CartPole, evaluate CartPole (stable-baselines3 is not installed)")
    for name in options.cases or [each for each in (*CASES, *REACH) if installed or each not in OUTSIDE]:
        found[name] = one = command(name, options.expert) if name in REACH else ended(CASES[name][0](), CASES[name][1])
        if not options.json:
            answer = one.answer or "NO ANSWER"
            print(f"{name:36} {answer:9}  CPU {one.seconds:6.1f} s  {one.megabytes:6.0f} MB", flush=True)
    asked = [one for name, one in found.items() if name in CASES]
    figures = [
        figure("large questions without an answer", sum(not one.answer for one in found.values()), 0, 0),
        figure("large questions, most CPU, s", max((one.seconds for one in asked), default=0), LIMIT, 30),
        figure("large questions, most memory, GB", max((one.megabytes for one in asked), default=0) / 1000, 2, 0.5),
    ]
    for name, (seconds, megabytes) in REACH.items():
        if name in found:
            figures.append(figure(f"{name}, CPU, s", found[name].seconds, seconds, seconds / 2))
            figures.append(figure(f"{name}, memory, MB", found[name].megabytes, megabytes, megabytes / 2))
    if options.json:
        print(json.dumps({"figures": figures}))


def figure(name: str, value: float, reach: float, stretch: float) -> dict[str, str | float]:
    """A figure beside its targets; less is better."""
    return {"name": name, "value": value, "reach": reach, "stretch": stretch, "better": "lower"}


if __name__ == "__main__":
    main()
