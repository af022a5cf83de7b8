"""What a run-time monitor costs, how often it refuses noisy states, and whether its words hold.

    python -m tests.benchmarks.monitor [--json] [--states N] [--only WORD] [--record [--new]]

Of all committed proofs that have a monitor, and of some about committed worlds, which are made first.
With --record what holds for all machines is written to generated/monitors, row by row; with --new what is missing.

Cost: a step of the monitor beside the decision of all agents from the same state, in C, in turn, over states of
episodes; the decision makes its observations from the state, too. Both are functions that are called for each state by
a loop that knows nothing of them. No state comes twice, and steps of all episodes are mixed, so that no branch is
foreseen. Monitors of whole episodes of games are built into such a loop.
Refused: states of unperturbed episodes for which the monitor does not vouch (of games: states within the
region). Words: episodes in which every state is pushed at random after each step. A word of a game is judged by numpy
from the claim's formula; one of a stated system also by what the file makes of the state one step on: that must be
vouched for again, and keep the claim. At edges of games rounding may refuse a state: `lost` counts those that came from
one that was vouched for, and keep the claim. Noise: the monitor is given numbers that are off by a
normal error of 1/1000 of the side of the region, or of the hull of the proof's boxes; a false alarm is a word that does
not vouch for a state that is vouched for. Warning: of a game, the share of departures that LEAVING comes before; of
episodes, how many steps before the claim breaks the monitor stops to vouch, on average; nan where no pushed episode
breaks the claim.
Control: the same states with other trees, which must be seen to fail; of games the worst of all shifts of actions. Of
claims about episodes of games whole episodes are played: they fail while vouched for if no word was another; the
control has the landmarks of other episodes. Where trees test differences, episodes start in the region of the claim.
"""

import json
import math
import tempfile
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from codegen.boxes import is_inside
from maviper import load, verify
from maviper.compilation.monitors import load_proof
from maviper.files.runs import read_unpacked
from maviper.worlds.stated.certified import read_certificate
from maviper.worlds.stated.observing import call_in_file
from tests.benchmarks.common import figure, reader, tell
from tests.support.followed import arriving, flying
from tests.support.monitored import acting, compiled, formula_of, meets
from tests.support.monitors import certify
from tests.support.pushed import COSTED, NOISE, STEPS, Watching, cost_watched, episodes, lasting, perturbed, unperturbed
from verify.certificates.games import to_json
from verify.checker.certificate import MAX_BYTES

GENERATED = Path(__file__).parents[2] / "generated"
GAMES = (
    "verdicts/physical_deception/certificate-1-distinct_targets",
    "verdicts/physical_deception/certificate-2-own_target",
    "verdicts/cooperative_navigation/certificate-1-distinct_targets",
    "verdicts/predator_prey/certificate-1-formula",
    "verdicts/predator_prey/certificate-2-formula",
    "physical_deception/certificate-1-distinct_targets",  # what the demo writes
    "proved_defenders/certificate-1-distinct_targets",
    "proved_navigation/certificate-1-distinct_targets",
)
EPISODES = ("verdicts/physical_deception/certificate-7-reaches", "verdicts/physical_deception/certificate-8-reaches")
FLOWN = "flight/certificate-1-reaches"  # with numbers that are off, in a closed loop
BESIDE = GENERATED / "verdicts" / "physical_deception" / "profile.json"
OFF = 0.007  # by how much its monitor lets numbers be off: 3.5 standard deviations of the noise
SYSTEMS = (
    "worlds/cart_pole/certificate-1-stays_in",
    "worlds/cart_pole/certificate-2-stays_in",
    "worlds/corridor/certificate-1-avoids",
    "worlds/crossing/certificate-1-stays_in",
    "worlds/mountain_car/certificate-1-stays_in",
    "worlds/pendulum/certificate-1-stays_in",
    "worlds/pendulum/certificate-2-decides",
    "worlds/quadrotor/certificate-1-stays_in",
    "worlds/quadrotor/certificate-2-reaches_and_stays",
    "worlds/tanks/certificate-1-stays_in",
    "worlds/tanks/certificate-2-always",
    "worlds/tanks/certificate-3-decides",
    "worlds/pendulum_v1/certificate-1-stays_in",
    "worlds/pendulum_v1/certificate-2-decides",
    "arch/acc/certificate-1-stays_in",
    "arch/airplane/certificate-1-stays_in",
    "arch/double_pendulum_less/certificate-1-stays_in",
    "arch/double_pendulum_more/certificate-1-stays_in",
    "arch/quad/certificate-1-reaches_and_stays",
    "arch/docking/certificate-1-stays_in",
)
SUMS = (  # of a team whose trees test differences of features
    "differences/certificate-1-decides",
    "differences/certificate-2-decides",
    "differences/certificate-3-decides",
)
SUMS_FOLLOWED = "differences/episodes/certificate-1-stays_in"
LASTING = "proved_defenders/always"
RADIUS = Fraction(5, 2)  # within which its defenders stay
PUSHED = 0.25  # of its states in each step: next to no state is in its sets once it was pushed
MADE = {  # claims about committed worlds that are proved first, by the world and what they are called
    "quadrotor/always": 'name = "always"\nregion = { box = { x = [-0.6, 0.6], y = [-0.6, 0.6], z = [-0.6, 0.6] } }',
    "pendulum/always": 'name = "always"\nregion = { box = { angle = [-0.15, 0.15] } }',
    "crossing/always": 'name = "always"\nregion = { box = { north = [0, 6], east = [0, 6] } }',
    "pendulum/always-sums": """name = "always"
region = { where = ["angle + 0.1[s]*spin <= 0.058", "angle + 0.1[s]*spin >= -0.058"] }""",
    "pendulum/decides-sums": """formula = "not acts(cart) == left"
region = { where = ["angle + 0.3[s]*spin > 0.2", "spin >= 0", "v*1[s]/3 + x/7 - 0.1[m]*angle <= 0.1[m]"] }""",
}
STATES = 1_000_000
SIDE = 2.0  # of the start region of games
RECORDED = (
    *("states", "vouched", "fails_while_vouched", "lost", "fails_elsewhere", "control_fails"),
    *("calm", "refused", "false_alarms", "warning"),
)
TARGETS = {"ratio": 2.0, "fails_while_vouched": 0, "refused": 0, "false_alarms": 0.05}
FIGURES = ("ratio", "decision_ns", "step_ns", *RECORDED)
RECORD = GENERATED / "monitors"
INTRO = """# Whether the words of monitors hold

Each row is a monitor in C, of a committed proof or of one that is made first. `python -m
tests.benchmarks.monitor --record` renews table.json and this page, and `--help` says how it is measured.

- `states`: of episodes in which states are pushed at random; `vouched`: the share that the monitor vouches for.
- `fails while vouched`: of these, where the claim is broken, or one step on, or where a stated system is not vouched
  for one step on. At edges of games the last is `lost`: rounding refuses there. `fails elsewhere`: of all others.
- `control fails`: how often the same judge says so where trees take other actions.
- `calm`: states of episodes that nobody pushes, or of decisions in games those in the region; `refused`: of these.
- `false alarms`: the share of states that are vouched for, but not once numbers are off by a thousandth of the region.
  Monitors of whole episodes of games know no such numbers without `--noise`, as in `flight/`.
- `warning`: of games, the share of departures that `LEAVING` comes before; of episodes, how many steps the monitor is
  ahead of a broken claim, on average.

"""


def game(name: str, states: int) -> dict[str, Any]:
    """The figures of a claim about decisions of a game."""
    certificate = GENERATED / f"{name}.json"
    profile = load(certificate.parent / "profile.json")
    proved = load_proof(certificate, profile)
    formula, names = formula_of(certificate, proved.stated), profile.world.coordinates()
    played = episodes(profile, -(-states // STEPS), 0, proved.region.box if proved.stated else None)
    w = np.ascontiguousarray(played.reshape(-1, len(names))[:states])
    at = dict(zip(names, w.T, strict=True))
    goal = {axis: at[f"goal.{axis}"] for axis in "xy"} if profile.world.goals else {}
    at |= {call_in_file(name): at[name] for name in names}
    acted = acting(profile, w)
    failing = ~meets(formula, at, acted, goal)
    within = is_inside(proved.region, w, names)
    with compiled(profile, proved) as made:
        step = np.zeros(len(w), np.int32)
        found = made.words(w, step)
        vouched = found <= 1
        seen, rng = w.copy(), np.random.default_rng(1)
        moving = [names.index(f"{agent.name}.{axis}") for agent in profile.world.agents for axis in "xy"]
        side = profile.world.start_high - profile.world.start_low
        seen[:, moving] += rng.normal(scale=NOISE * side, size=(len(w), len(moving)))
        noisy = made.words(seen, step)
        figures = made.costs(w[:COSTED], step[:COSTED])

    def fail_otherwise(shift: int) -> int:
        """How many states that are vouched for break the claim where every agent takes another action."""
        wrong = {policy.agent: (acted[policy.agent] + shift) % len(policy.actions) for policy in profile.agents}
        return int((~meets(formula, at, wrong, goal) & vouched).sum())

    whole = found[: len(found) // STEPS * STEPS].reshape(-1, STEPS)
    out = (whole[:, 1:] == 2) & (whole[:, :-1] <= 1)
    return figures | {
        "states": len(w),
        "vouched": float(vouched.mean()),
        "fails_while_vouched": int((failing & vouched).sum()),
        "fails_elsewhere": int((failing & ~vouched).sum()),
        "control_fails": max(fail_otherwise(shift) for shift in range(1, len(profile.agents[0].actions))),
        "calm": int(within.sum()),
        "refused": int((within & ~vouched).sum()),
        "false_alarms": float((noisy[found == 0] != 0).mean()),
        "warning": float((whole[:, :-1] == 1)[out].mean()) if out.any() else np.nan,
    }


def system(certificate: Path, states: int, beside: str = "profile.json", share: float = 1.0) -> dict[str, Any]:
    """The figures of a claim about a stated system; `beside`: where its profile is, `share`: as in `perturbed`."""
    profile = load(certificate.parent / beside)
    proved = load_proof(certificate, profile)
    _, statement = read_certificate(certificate)
    with compiled(profile, proved, statement.system) as made:
        watching = Watching(certificate, made, proved, profile)
        calm, refused = unperturbed(watching, max(100, states // 200))
        calm = [watching.measured(w) for w in calm]
        figures = cost_watched(watching, calm) | {"calm": sum(map(len, calm)), "refused": refused}
        return figures | perturbed(watching, states, share)


def made_anew(name: str, states: int) -> dict[str, Any]:
    """The figures of a proof that is made anew."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        return system(certify(Path(folder), name.split("/")[0], MADE[name]), states)


def made_lasting(states: int) -> dict[str, Any]:
    """The figures of a proof that the defenders stay within a radius for ever, made anew."""
    profile = GENERATED / "proved_defenders" / "profile.json"
    found = verify(load(profile), "stays_in", steps="always", radius=RADIUS)
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        certificate = Path(folder) / "certificate.json"
        certificate.write_text(to_json(found.evidence.certificate))
        return lasting(certificate, profile, states, min(COSTED, states))


def file_of(name: str) -> Path:
    """A certificate, which may be packed."""
    packed = GENERATED / f"{name}.json.xz"
    return packed if packed.exists() else GENERATED / f"{name}.json"


def rows() -> dict[str, Callable[[int], dict[str, Any]]]:
    """By the name of a proof what measures it over so many states."""
    files = {name: file_of(name) for name in (*EPISODES, FLOWN, SUMS_FOLLOWED, *SYSTEMS)}
    return {
        **{name: partial(game, name) for name in (*GAMES, *SUMS)},
        **{name: partial(arriving, files[name]) for name in EPISODES},
        FLOWN: lambda states: flying(files[FLOWN], BESIDE, states, OFF, NOISE * SIDE),
        LASTING: made_lasting,
        SUMS_FOLLOWED: lambda states: system(files[SUMS_FOLLOWED], states, "../profile.json", PUSHED),
        **{name: partial(system, files[name]) for name in SYSTEMS},
        **{f"worlds/{name}": partial(made_anew, name) for name in MADE},
    }


def measured(states: int, only: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """The figures of each proof, by its name."""
    for name, measure in rows().items():
        if only in name:
            yield name, measure(states)


# --- the record: what follows from seeds alone, so no times


def certificate_of(name: str) -> str:
    """The hash of a committed certificate; "" of proofs that are made anew."""
    path = file_of(name)
    return json.loads(read_unpacked(path, MAX_BYTES))["content_hash"] if path.exists() else ""


def record_rows(states: int, only: str, *, new: bool) -> None:
    """Renews the rows whose name holds a word, and writes each when it is there, so that a run may be cut off; of `new`
    ones those that are not recorded for the certificate and so many states.
    """
    kept = {row["proof"]: row for row in read_record()}
    for name, measure in rows().items():
        known, row = kept.get(name, {}), {"proof": name, "certificate": certificate_of(name)}
        if only not in name or (new and known.items() >= row.items() and known["states"] >= states):
            continue
        found = measure(states)
        kept[name] = row | {key: encode(found[key]) for key in RECORDED if key in found}
        write_record([kept[each] for each in rows() if each in kept])


def read_record() -> list[dict[str, Any]]:
    """The rows that are recorded."""
    path = RECORD / "table.json"
    return json.loads(path.read_text()) if path.exists() else []


def write_record(kept: list[dict[str, Any]]) -> None:
    """Writes rows and their page."""
    RECORD.mkdir(exist_ok=True)
    (RECORD / "table.json").write_text(json.dumps(kept, indent=1) + "\n")
    (RECORD / "README.md").write_text(page_of(kept))


def encode(value: float) -> float | None:
    """A figure as the record has it: with five digits, None where it is no number."""
    return value if isinstance(value, int) else None if math.isnan(value) else float(f"{value:.5g}")


def page_of(kept: list[dict[str, Any]]) -> str:
    """The page of a record."""
    lines = [f"| {' | '.join(('proof', *(name.replace('_', ' ') for name in RECORDED)))} |"]
    lines.append("|---" * (len(RECORDED) + 1) + "|")
    for row in kept:
        cells = ("" if row.get(name) is None else f"{row[name]:,}" for name in RECORDED)
        lines.append(f"| {' | '.join((row['proof'], *cells))} |")
    return INTRO + "\n".join(lines) + "\n"


def main() -> None:
    """Prints the figures, or records what of them follows from seeds alone."""
    parser = reader(__doc__)
    parser.add_argument("--states", type=int, default=STATES)
    parser.add_argument("--only", default="", metavar="WORD", help="proofs whose name holds it")
    parser.add_argument("--record", action="store_true", help="renew generated/monitors, a row after the other")
    parser.add_argument("--new", action="store_true", help="of the record only rows that it lacks")
    given = parser.parse_args()
    if given.record:
        record_rows(given.states, given.only, new=given.new)
        return
    found = measured(given.states, given.only)
    told = TARGETS if given.json else dict.fromkeys(FIGURES) | TARGETS
    rows = (
        (f"{proof}: {name}", row[name], reach) for proof, row in found for name, reach in told.items() if name in row
    )
    tell((figure(*row) for row in rows), given.json)


if __name__ == "__main__":
    main()
