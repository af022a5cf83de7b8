"""The one-minute tour: the whole chain on the shipped expert, every step with the outcome that is expected of it.

Does: extracts, shows rules, compiles and replays, refutes one property, proves another, writes the report.
Assumes: nothing outside the package; without a C compiler that part is skipped and said.
Does not: do anything that the other commands cannot do.
"""

from pathlib import Path

from codegen import ir
from codegen.errors import ExitCode
from maviper.cli.agreement import say_agreement
from maviper.cli.results import say_results
from maviper.compilation import compile
from maviper.console import Console
from maviper.evaluation.held_out import measured_of
from maviper.evaluation.show import rules
from maviper.experts import store
from maviper.extraction.run import Found, extract_live
from maviper.extraction.settings import Settings
from maviper.files import runs
from maviper.tour import handout
from maviper.verification import join
from maviper.worlds import World
from maviper.worlds.physical_deception import DEFENDERS
from verify.claims.region import Verdict

WORLD = "physical-deception"
SEED = 0
ITERATIONS, ROLLOUTS, SELECTION_EPISODES, REFINEMENT, MAX_DEPTH = 10, 50, 50, 60_000, 4
LEAST_RATIO = 0.80  # of the expert's defender success


def run(folder: Path, console: Console, seed: int | None) -> int:
    """Runs the tour into `folder`; returns 0 when every step gave its expected outcome."""
    runs.folder(folder)
    expected = True
    seed = SEED if seed is None else seed
    expert, world = store.load(WORLD)
    sizes = {"max_depth": MAX_DEPTH, "iterations": ITERATIONS, "rollouts": ROLLOUTS}
    sizes |= {"selection_episodes": SELECTION_EPISODES, "refinement": REFINEMENT}
    settings = Settings.of(sizes | {"seed": seed})
    size = f"depth {MAX_DEPTH}, {ITERATIONS} iterations of {ROLLOUTS} rollouts"
    console.line("", f"{size}, selection on {SELECTION_EPISODES} episodes each, refinement on {REFINEMENT:,}")
    console.line("", "(a short extraction; the paper's is 100 iterations, see `maviper extract --help`)")
    profile = extract_live(Found(WORLD, expert, world, settings), console)
    expected &= _reached(profile, world, console)
    _say_rules(profile, console)

    compiled = compile.compile_profile(profile)
    say_agreement(compiled, console)
    asked = handout.questions(profile)
    results = join.verify_claims(asked)
    say_results(profile, results, console)
    verdicts = [result.verdict for result in results]
    if verdicts != [Verdict.VIOLATED, Verdict.PROVED] or results[1].control is not Verdict.VIOLATED:
        console.line("unexpected", "one VIOLATED and one PROVED with a refuted control were expected")
        expected = False
    files = handout.handout(profile, compiled, asked, results)
    for name, text in files.items():
        runs.write(folder / name, text)
    header = next(name for name in files if name.endswith(".h"))
    console.line("report", str(folder / "report.html"))
    console.line("header", f"{folder / header}, called in {folder / 'example.c'}")
    again = f"maviper verify {folder / runs.PROFILE_FILE} --region {folder / handout.REGION_FILE}"
    console.line("next", f"maviper show {folder / runs.PROFILE_FILE}; {again}")
    return ExitCode.DONE if expected else ExitCode.VIOLATED


def _reached(profile: ir.PolicyProfile, world: World, console: Console) -> bool:
    ours, theirs = measured_of(profile.provenance.evaluation, world.primary(DEFENDERS))
    if ours >= LEAST_RATIO * theirs:
        return True
    console.line(
        "unexpected", f"the {DEFENDERS}' trees reach {ours / theirs:.2f} of the expert, {LEAST_RATIO:.2f} was expected"
    )
    return False


def _say_rules(profile: ir.PolicyProfile, console: Console) -> None:
    policy = profile.team(DEFENDERS)[0]
    for number, rule in enumerate(rules(policy)):
        console.line(f"{policy.agent}" if number == 0 else "", rule)
