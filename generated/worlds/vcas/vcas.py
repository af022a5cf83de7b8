"""Trees for a collision advisory system, fitted to the table of its decision process, and the worlds to prove them in.

    python generated/worlds/vcas/vcas.py            writes vcas.json and the worlds, prints how the trees compare

Does: one tree per previous advisory, joined to one that asks for it first; world files of eight rows and more.
Assumes: process.py. Every draw is seeded: the same bytes again.
Does not: prove; `maviper verify` does.
"""

import sys
from contextlib import chdir
from pathlib import Path
from typing import Any

import numpy as np

from codegen.floats import FLOAT32
from codegen.importers.scikit import read_sklearn_tree
from codegen.ir import AgentPolicy, PolicyProfile, Provenance, Tree, act
from codegen.lowering.deploy import deploy_tree
from codegen.paths import in_preorder
from codegen.policy_json import dumps
from maviper.worlds import find

PLACE = Path(__file__).parent
sys.path.insert(0, str(PLACE))
import process  # noqa: E402
from process import ADVISORIES, HEIGHTS, HORIZON, NAMES, RATES, Floats, G, Ints, Table  # noqa: E402

AHEAD = (1, 2, 3, 4, 6)  # s: heights so much later, at the same rate, are features
LEAVES = 150  # of each tree
SHARE, REACHED = 0.12, 10.0  # of the grid that trees are fitted to, and the weight of states that episodes reach
GRAVE = 10.0  # how much more a state weighs in which some advisory loses all
SPEEDS = ("19.5", "22.5", "25.5", "28.5")
START = (-133.0, -129.0)  # ft
PILOTS = {"middle": "own.middle", "worst": "own.least", "every": "choice(own.least, own.middle, own.most)"}
WORDS = {
    "middle": "the middle one of its accelerations",
    "worst": "the least one, which climbs least: the intruder is below",
    "every": "any of its accelerations",
}
WORLD = """# VCAS (ARCH-COMP, verivital/ARCH-COMP2025): a level intruder is {above} below,
# and the own aircraft descends towards it with {rate} ft/s. Of each advisory the pilot takes {words}.
name = "vcas"
steps = 10
dt = "1 s"

[constants]
g = "32.2 ft/s^2"

[variables]
h = {{ unit = "ft", range = [-2000, 2000] }}      # the intruder's height above
v = {{ unit = "ft/s", range = [-200, 200] }}      # the own climb rate
tau = {{ unit = "s", range = [0, 25] }}           # until the two are no longer side by side
adv = {{ modes = [{modes}] }}

[agents.own.features]
h = "h"
v = "v"
tau = "tau"
{features}

[agents.own.actions]
{actions}

[start]
box = {{ h = [{low}, -129], v = -{rate}, tau = 25, adv = "COC" }}

[dynamics.let]
taken = "{taken}"

[dynamics.next]
h = "h - dt*v - dt**2*a/2"
v = "v + dt*a"
tau = "tau - dt"
adv = "acts(own)"

# A pilot who complies with an advisory that is repeated keeps the climb rate.
{cases}
[[dynamics.piece]]
when = "otherwise"
let = {{ a = "taken" }}

[[property]]
label = "at least 100 ft apart"
name = "avoids"
region = {{ box = {{ h = [-100, 100] }} }}
"""
HOPELESS = """
# No controller saves these starts: whatever the own aircraft does within g/3, it is lost.
[[property]]
label = "whatever is flown, within 100 ft"
name = "reaches"
region = { box = { h = [-100, 100] } }
"""


def bounds(name: str) -> str:
    """When a repeated advisory is complied with."""
    low, high = ADVISORIES[name].complies
    return f"v >= {low:g}/60*1[ft/s]" if np.isinf(high) else f"v <= {high:g}/60*1[ft/s]"


def multiple(units: int) -> str:
    """An acceleration as a file writes it."""
    return f"{units}*g/24"


def action(name: str) -> str:
    """What an advisory sets: three accelerations, and that it is the one."""
    choices = ADVISORIES[name].choices
    three = zip(("least", "middle", "most"), (choices[0], choices[len(choices) // 2], choices[-1]), strict=True)
    told = [f'{which} = "{multiple(units)}"' for which, units in three]
    return f"{name} = {{ {', '.join([*told, *([] if name == 'COC' else [f'{name} = 1'])])} }}"


def world(pilot: str, rate: str) -> str:
    """The file of a row."""
    alerts = NAMES[1:]
    actions = [action(name) for name in NAMES]
    cases = [
        f'[[dynamics.piece]]\nwhen = "adv == {name} and {bounds(name)}"\nlet = {{ a = "taken*(1 - own.{name})" }}\n'
        for name in alerts
    ]
    return WORLD.format(
        above="129 to 133 ft",
        rate=rate,
        low="-133",
        words=WORDS[pilot],
        modes=", ".join(f'"{name}"' for name in NAMES),
        features="\n".join(
            [f'h{k} = "h - {k}[s]*v"' for k in AHEAD] + [f'was_{name} = "adv == {name}"' for name in alerts]
        ),
        actions="\n".join(actions),
        taken=PILOTS[pilot],
        cases="\n".join(cases),
    )


def hopeless(rate: str, low: str) -> str:
    """The file of a claim that no controller saves a start: the acceleration is anything within g/3, in each second."""
    text = world("every", rate)
    head, rest = text.split("[start]")
    head = head.replace("adv = {", 'a = { unit = "ft/s^2", range = ["-g/3", "g/3"] }\nadv = {', 1)
    head = head.replace(
        "Of each advisory the pilot takes any of its accelerations.", "Any controller: advisories do nothing."
    )
    start = f'[start]\nbox = {{ h = [{low}, -129], v = -{rate}, tau = 25, a = ["-g/3", "g/3"], adv = "COC" }}\n'
    move = "[dynamics.next]" + rest.split("[dynamics.next]")[1].split("#")[0]
    return f'{head}{start}\n{move.rstrip()}\na = "0*a"\n\n[dynamics.error]\na = "g/3"\n{HOPELESS}'


def observed(height: Floats, rate: Floats, left: Ints) -> Any:
    """What trees see beside the previous advisory, [batch, features] float32."""
    return np.stack([height, rate, left, *(height - k * rate for k in AHEAD)], axis=1).astype(np.float32)


def starts(rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    """Heights and rates of the rows, and of encounters all around."""
    height, rate = rng.uniform(-400, 400, count), rng.uniform(-45, 45, count)
    own = rng.uniform(*START, count), -rng.choice([float(each) for each in SPEEDS], count)
    return np.concatenate([height, own[0]]), np.concatenate([rate, own[1]])


def reached(table: Table, decide: Any, seed: int, count: int) -> dict[str, Any]:
    """States that episodes of a controller reach while nobody is lost, and what table and controller say there."""
    rng = np.random.default_rng(seed)
    played = process.episodes(decide, starts(rng, count), rng, HORIZON)
    found = {name: played[name][played["alive"]] for name in ("height", "rate", "left", "before", "given")}
    return found | {"table": table.decide(found["height"], found["rate"], found["left"], found["before"])}


def grid() -> tuple[Floats, Floats, Ints]:
    """All grid points: heights, rates, times."""
    found = np.meshgrid(HEIGHTS, RATES, np.arange(1, HORIZON + 1), indexing="ij")
    return found[0].ravel(), found[1].ravel(), found[2].ravel()


def labels(table: Table, before: int) -> Ints:
    """What the table decides at all grid points."""
    return np.moveaxis(np.argmin(np.round(table.scores[1:, before].astype(float), 6), axis=1), 0, 2).ravel()


def fitted(table: Table) -> Tree:
    """One tree: it asks for the previous advisory, then for height, rate and time."""
    from sklearn.tree import DecisionTreeClassifier

    rng, points = np.random.default_rng(0), grid()
    seen = reached(table, table.decide, 1, 8_000)
    subtrees: list[Tree] = []
    for before in range(len(NAMES)):
        chosen, own = rng.random(len(points[0])) < SHARE, seen["before"] == before
        x = [
            observed(*(each[chosen] for each in points)),
            observed(*(seen[k][own] for k in ("height", "rate", "left"))),
        ]
        y = [labels(table, before)[chosen], seen["table"][own]]
        weights = np.repeat([1.0, REACHED], [len(each) for each in y])
        scores = np.moveaxis(table.scores[1:, before], (1, 0), (3, 2)).reshape(-1, len(NAMES))[chosen]
        scores = np.concatenate([scores, table.of(*(seen[k][own] for k in ("height", "rate", "left", "before")))])
        weights *= 1 + GRAVE * (scores.max(axis=1) - scores.min(axis=1))
        tree = DecisionTreeClassifier(max_leaf_nodes=LEAVES, random_state=0)
        tree.fit(np.concatenate(x), np.concatenate(y), sample_weight=weights)
        actions = tree.classes_[np.argmax(tree.tree_.value[:, 0], axis=1)]
        subtrees.append(deploy_tree(read_sklearn_tree(tree.tree_, actions)))
    return joined(subtrees)


def joined(subtrees: list[Tree]) -> Tree:
    """A tree that asks whether the previous advisory is the last one, the one before, ..., and goes on in its tree."""
    first = 3 + len(AHEAD)

    def parts(at: tuple[int, int]) -> Any:
        which, node = at
        if node < 0:  # a question for an advisory
            return (first + which - 1, 0.5, (which - 1, -1 if which > 1 else 0), (which, 0))
        tree = subtrees[which]
        if tree.feature[node] < 0:
            return int(tree.action[node])
        below = (which, int(tree.left[node])), (which, int(tree.right[node]))
        return int(tree.feature[node]), float(tree.threshold[node]), *below

    return in_preorder((len(subtrees) - 1, -1), parts, FLOAT32)


def profile() -> PolicyProfile:
    """The trees as a profile of the world."""
    table = Table()
    with chdir(PLACE):
        game = find("system:every_19.5.toml")
    facts = Provenance("fitted to a table", "none", 0, "generated/worlds/vcas/process.py", "scikit-learn")
    (features,), (actions,) = game.features, game.actions
    return PolicyProfile(game.spec, (AgentPolicy("own", "own", features, actions, fitted(table)),), facts)


def decisions(found: PolicyProfile) -> Any:
    """The controller that a profile is."""
    (policy,) = found.agents

    def decide(height: Floats, rate: Floats, left: Ints, before: Ints) -> Ints:
        asked = before[:, None] == np.arange(1, len(NAMES))
        return act(policy, np.concatenate([observed(height, rate, left), asked], axis=1)).astype(np.int64)

    return decide


def compared(found: PolicyProfile, count: int = 8_000, share: float = 1.0) -> dict[str, float]:
    """How trees and table agree: on a share of the grid, on states that each of them reaches in so many episodes, and
    how often they alert.
    """
    table, decide, points = Table(), decisions(found), grid()
    some = np.random.default_rng(3).random(len(points[0])) < share
    places = tuple(each[some] for each in points)
    said = [labels(table, before)[some] for before in range(len(NAMES))]
    alike = [np.mean(decide(*places, np.full(len(each), before)) == each) for before, each in enumerate(said)]
    by_table, by_trees = (reached(table, each, 2, count) for each in (table.decide, decide))
    trees = decide(*(by_table[name] for name in ("height", "rate", "left", "before")))
    return {
        "grid": float(np.mean(alike)),
        "reached by the table": float(np.mean(trees == by_table["table"])),
        "reached by the trees": float(np.mean(by_trees["given"] == by_trees["table"])),
        "alerts, trees to table": float(np.mean(by_trees["given"] > 0) / np.mean(by_table["given"] > 0)),
        "least share of other advisories than the first": min(
            float(1 - np.bincount(each).max() / len(each)) for each in said
        ),
        "scores in the table": float(table.entries),
        "decisions in the table": float(table.entries / len(NAMES)),
        "leaves of the trees": float(np.sum(found.agents[0].tree.feature < 0)),
    }


def files() -> dict[str, str]:
    """All world files by name."""
    rows = {f"{pilot}_{rate}.toml": world(pilot, rate) for pilot in PILOTS for rate in SPEEDS}
    return rows | {"nobody_25.5.toml": hopeless("25.5", '"-129.533"'), "nobody_28.5.toml": hopeless("28.5", "-133")}


def main() -> None:
    """The command."""
    assert G == 32.2
    for name, text in files().items():
        (PLACE / name).write_text(text)
    found = profile()
    (PLACE / "vcas.json").write_text(dumps(found))
    for name, value in compared(found).items():
        print(f"{name}: {value:.6g}")


if __name__ == "__main__":
    main()
