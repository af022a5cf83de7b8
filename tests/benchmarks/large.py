"""Whether large things end: whole commands, with what they spend and whether they give an answer.

    python -m tests.benchmarks.large [--json] [CASE ...]

Questions: a verdict or an UNKNOWN. Commands: `verify` on the demo's profile, with all files, once its modules are
compiled; compilation of a wide tree and of many agents, extraction for many agents and for CartPole, whose expert
stable-baselines3 trains first (or is --expert ZIP). Teams of 8 and 12 agents, trees of depth 12 to 16, and 131,000
leaves; default options. A command gets two minutes of CPU time, process start included, and should stay below two
gigabytes. Trees: fixed roles under fitted splits (held), and full trees with splits and actions at random (full).
"""

import shutil
import sys
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from codegen.dynamics import motionless
from codegen.errors import ExitCode
from codegen.ir import ActionSpec, AgentPolicy, FeatureSpec, PolicyProfile, Provenance
from codegen.policy_json import dumps
from tests.benchmarks.common import Ended, figure, reader, spent, tell
from tests.benchmarks.verifier import Played, held_roles, navigators
from tests.support.teams import nested

LIMIT = 120  # seconds of CPU
RUNS = 6  # of a command that takes a second: the first one compiles its modules, and the least of the others counts
ANSWERS = {ExitCode.DONE: "PROVED", ExitCode.VIOLATED: "VIOLATED", ExitCode.INCONCLUSIVE: "UNKNOWN"}
Made = Callable[[], PolicyProfile]


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
    "8 agents, no_double": (lambda: navigators(8), "no_double"),
    "8 agents, own_target": (lambda: navigators(8), "own_target"),
    "12 agents, no_double": (lambda: navigators(12), "no_double"),
    "12 agents, own_target": (lambda: navigators(12), "own_target"),
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
    policy = AgentPolicy("agent_0", "agents", seen, actions, nested(grown(rng, list(range(features)), depth)))
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


def asked(profile: PolicyProfile, verb: str, *more: str) -> Ended:
    """One command about a profile, and how it ended."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "profile.json"
        path.write_text(dumps(profile))
        return spent(verb, path, *more, limit=LIMIT)


def command(name: str, expert: str = "") -> Ended:
    """A command of REACH, and how it ended. `expert`: of CartPole; "": one that is trained."""
    with tempfile.TemporaryDirectory() as folder:
        if name == DEMO:
            runs = [spent("verify", PROFILE, "-o", f"{folder}/answers", limit=LIMIT) for _ in range(RUNS)]
            return min(runs[1:], key=lambda run: run.seconds)
        if name == REFUSED:
            return asked(COMPILED[MANY](), "verify", "--claim", "distinct_targets")
        if name in COMPILED:
            return asked(COMPILED[name](), "compile", "--target", "c,python,json", "-o", f"{folder}/code")
        if name in EXTRACTIONS:
            return spent("extract", *EXTRACTIONS[name], "-o", f"{folder}/result.json", limit=LIMIT)
        if expert:
            shutil.copy(expert, Path(folder) / ZIP)
        else:
            train_cartpole(Path(folder) / ZIP)
        commands = {one: [word.format(folder=folder) for word in words] for one, words in OUTSIDE.items()}
        found = spent(*commands["extract CartPole"], limit=LIMIT)
        if name.startswith("evaluate"):
            found = spent(*commands[name], limit=LIMIT)
        return found


def train_cartpole(place: Path) -> None:
    """The expert of own.md: 50,000 steps of PPO, about a minute."""
    from stable_baselines3 import PPO

    learner = PPO("MlpPolicy", "CartPole-v1", n_steps=256, batch_size=256, gamma=0.98, seed=0, device="cpu")
    learner.learn(50_000)
    learner.save(place)


def answer_of(name: str, ended: Ended) -> str:
    """What a command said; "" where it gave no answer. What cannot be replayed is compiled all the same."""
    said = ANSWERS.get(ended.code, "")
    return "REFUSED" if name == REFUSED else said if name in CASES or not said else "DONE"


def main() -> None:
    """The table, or its figures."""
    parser = reader(__doc__)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"some of: {'; '.join([*CASES, *REACH])}")
    parser.add_argument("--expert", metavar="ZIP", default="", help="of CartPole, in place of one that is trained")
    options = parser.parse_args()
    installed = find_spec("stable_baselines3") is not None
    if not installed:
        print("not run: extract CartPole, evaluate CartPole (stable-baselines3 is not installed)", file=sys.stderr)
    found = {}
    for name in options.cases or [each for each in (*CASES, *REACH) if installed or each not in OUTSIDE]:
        if name in REACH:
            found[name] = command(name, options.expert)
        else:
            made, claim = CASES[name]
            found[name] = asked(made(), "verify", "--claim", claim)
        if not options.json:
            print(f"{name}: {answer_of(name, found[name]) or 'NO ANSWER'}", flush=True)
    questions = [one for name, one in found.items() if name in CASES]
    figures = [
        figure("large questions without an answer", sum(not answer_of(*each) for each in found.items()), 0),
        figure("large questions, most CPU, s", max((one.seconds for one in questions), default=0), LIMIT, 30),
        figure("large questions, most memory, GB", max((one.megabytes for one in questions), default=0) / 1000, 2, 0.5),
    ]
    for name, (seconds, megabytes) in REACH.items():
        if name in found:
            figures.append(figure(f"{name}, CPU, s", found[name].seconds, seconds, seconds / 2))
            figures.append(figure(f"{name}, memory, MB", found[name].megabytes, megabytes, megabytes / 2))
    tell(figures, options.json)


if __name__ == "__main__":
    main()
