"""The one-minute tour: the whole chain on the shipped expert, every step with the outcome that is expected of it.

Does: extracts, refutes a claim, repairs the trees, proves the claim, has the proof checked, compiles, writes reports.
Assumes: nothing outside the package; without a C compiler that part is skipped and said.
Does not: do anything that the other commands cannot do.
"""

from pathlib import Path
from typing import TYPE_CHECKING, cast

from codegen import ir
from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.compilation.compile import Compiled
from maviper.console import Console
from maviper.evaluation.comparison import sizes
from maviper.evaluation.held_out import EVALUATION_EPISODES, read_measure
from maviper.experts import store
from maviper.experts.cards import how_learned
from maviper.extraction.run import Found, extract_live
from maviper.extraction.settings import Settings
from maviper.files import outputs, runs
from maviper.tour import handout
from maviper.verification.files.certificates import check_file
from maviper.verification.repair import Repaired
from maviper.verification.run import Verified
from maviper.worlds import World
from maviper.worlds.games.physical_deception import DEFENDERS
from verify.reports.report import as_lines
from verify.result import Verdict

if TYPE_CHECKING:
    from verify.verdicts.decisions import DecisionResult

WORLD = "physical-deception"
SEED = 0
ITERATIONS, ROLLOUTS, SELECTION_EPISODES, REFINEMENT, MAX_DEPTH = 10, 50, 50, 60_000, 4
LEAST_RATIO = 0.80  # of the expert's defender success


def run(folder: Path, console: Console, seed: int | None) -> int:
    """Runs the tour into `folder`; returns 0 when every step gave its expected outcome."""
    runs.room(folder)
    outputs.ensure_listed(folder, dict.fromkeys(handout.NAMES, ""), handout.MANIFEST)  # before the work, not after it
    profile, world = _extract_trees(SEED if seed is None else seed, console)
    with console.busy("verifying", "a claim about the defenders in every state of the start region"):
        before = handout.verify_trees(profile)
    _say_violation(before, folder, console)
    with console.busy("repairing", "the leaves from which the claim can fail"):
        repair = handout.repair_trees(profile)
    with console.busy("compiling", "the trees, and replaying the code"):
        made = handout.compile_trees(before, repair)
    outputs.write_listed(folder, handout.handout(made), handout.MANIFEST)
    _say_repair(repair, world, folder, console)
    _say_code(made.code, folder, console)
    console.line("report", str(folder / "report.html"))
    console.line("next", f"maviper play {folder / runs.PROFILE_FILE}")
    unexpected = _find_surprises(made, world)
    for reason in unexpected:
        console.line("unexpected", reason)
    return ExitCode.VIOLATED if unexpected else ExitCode.DONE


def _extract_trees(seed: int, console: Console) -> tuple[ir.PolicyProfile, World]:
    expert, world = store.load(WORLD)
    asked = {"max_depth": MAX_DEPTH, "iterations": ITERATIONS, "rollouts": ROLLOUTS, "seed": seed}
    settings = Settings.of({**asked, "selection_episodes": SELECTION_EPISODES, "refinement": REFINEMENT})
    console.line("expert", f"{expert.card['algorithm'].upper()}, which learned by {how_learned(expert.card)}")
    profile = extract_live(Found(WORLD, expert, world, settings), Console(console.quiet, lines=False))
    ours, theirs = _success(profile, world)
    console.line("extracted", f"trees of depth {MAX_DEPTH}; the defenders succeed in {ours:.1%} of episodes")
    console.line("", f"(their expert: {theirs:.1%}; {EVALUATION_EPISODES:,} held-out episodes)")
    return profile, world


def _success(profile: ir.PolicyProfile, world: World) -> tuple[float, float]:
    """How often the defenders' trees reach their goal, and how often their expert does."""
    return read_measure(profile.provenance.evaluation, world.primary(DEFENDERS))


def _say_violation(before: Verified, folder: Path, console: Console) -> None:
    (result,) = before.results
    console.line(result.verdict.value, as_lines(before.profile, result)[0])
    counterexample = cast("DecisionResult", result).evidence.counterexample
    if counterexample is None:
        return
    for view in counterexample.agents:
        near = " and ".join(view.engaged_with) or "no landmark"
        console.line("", f"{view.agent} goes {view.action}, towards or at {near}")
    replayed = " and ".join(name for name in counterexample.replayed if name != "reference")
    console.line("", f"replayed by {replayed}: {folder / handout.EXTRACTED / 'report.html'}")


def _say_repair(repair: Repaired, world: World, folder: Path, console: Console) -> None:
    if repair.after is None:
        console.line("UNKNOWN", f"no repair was found: {repair.repair.reason}")
        return
    after = sizes(repair.after, list(repair.repair.roles))
    depth = max(each["depth"] for each in after.values())
    ours = _success(repair.after, world)[0]
    guards = format_count(len(repair.repair.guards), "guard")
    told = f"{guards}, depth {depth}; the defenders succeed in {ours:.1%} of episodes"
    console.line("repaired", told)
    for result in repair.results:
        console.line(result.verdict.value, as_lines(repair.after, result)[0])
    for name in repair.certificates:
        proof = check_file(folder / name)
        size = f"{format_count(proof.closed, 'branch')}, {format_count(proof.size, 'byte')}"
        console.line("accepted", f"the proof, by the independent checker: {size}")


def _say_code(compiled: Compiled, folder: Path, console: Console) -> None:
    report = compiled.report
    console.line("code", f"C, Python and JSON; {report.observations:,} decisions compared with the trees, 0 differ")
    console.line("", f"{folder / (compiled.build.model.prefix + '.h')}, called in {folder / 'example.c'}")
    for reason in report.skipped:
        console.line("SKIPPED", reason)


def _find_surprises(made: handout.Toured, world: World) -> list[str]:
    """What came out otherwise than it should."""
    reasons: list[str] = []
    if [result.verdict for result in made.before.results] != [Verdict.VIOLATED]:
        reasons.append("the extracted trees were expected to be VIOLATED")
    proved = [(result.verdict, result.evidence.control.verdict) for result in made.repair.results]
    if proved != [(Verdict.PROVED, Verdict.VIOLATED)]:
        reasons.append("the repaired trees were expected to be PROVED, and their shuffled control to be VIOLATED")
    ours, theirs = _success(made.profile, world)
    if ours < LEAST_RATIO * theirs:
        reasons.append(
            f"the {DEFENDERS}' trees reach {ours / theirs:.2f} of the expert, {LEAST_RATIO:.2f} was expected"
        )
    return reasons
