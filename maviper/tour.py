"""The one-minute tour: the whole chain on the shipped expert, every step with the outcome that is expected of it.

Does: extracts, refutes a claim, repairs the trees, proves the claim, has the proof checked, compiles, writes reports;
  makes all files that it hands out, as name -> text: extracted team, violation, repair, certificate, code, a page for
  its user, a manifest.
Assumes: nothing outside the package; without a C compiler that part is skipped and said. The extracted profile's own
  seed, so that a committed one gives the same files again.
Does not: do anything that the commands cannot do.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from codegen import ir
from codegen.errors import ExitCode
from codegen.form import layout
from codegen.lowering.render import render
from codegen.policy_json import content_hash, dumps
from codegen.wording import format_count
from maviper.compilation.compile import Compiled, compile_profile
from maviper.console import Console
from maviper.evaluation.comparison import sizes
from maviper.evaluation.held_out import EVALUATION_EPISODES, read_measure
from maviper.experts import network
from maviper.experts.cards import how_learned
from maviper.extraction.run import Found, extract_live
from maviper.extraction.settings import Settings
from maviper.files import outputs, profiles, runs
from maviper.page.page import FILE, page_of, svg
from maviper.verification import run
from maviper.verification.ask import VerifyOptions, questions
from maviper.verification.files.certificates import check_file
from maviper.verification.repair import Repaired, repair_profile, request
from maviper.verification.run import Verified
from maviper.worlds import World
from maviper.worlds.games.physical_deception import DEFENDERS
from maviper.worlds.matching import matching_world
from verify.reports.drawing import draw_picture
from verify.reports.report import as_html, as_lines
from verify.result import Verdict

if TYPE_CHECKING:
    from verify.verdicts.decisions import DecisionResult


MANIFEST = "manifest.json"
EXTRACTED = "extracted"  # the folder of the team before its repair, inside the tour's
_REPORTS = (runs.PROFILE_FILE, "report.html", "report.json", "report.txt", FILE)
_CODE = (".h", ".py", "_reader.py", ".json", ".agreement.json")
NAMES = (  # of all files but those that are numbered, of which others may have some of their own
    *(MANIFEST, "README.md", "example.c", "repair.json", *(f"physical_deception{ending}" for ending in _CODE)),
    *(*_REPORTS, *(f"{EXTRACTED}/{name}" for name in _REPORTS)),
)
REPAIRED_DEPTH, EPISODES = 6, 1_000
TOOLS = ("mpe2", "numpy", "scikit-learn", "z3-solver")


@dataclass(frozen=True)
class Toured:
    """The stages of the tour. `code` is that of the repaired team; of the extracted one where no repair was found."""

    before: run.Verified
    repair: Repaired
    code: Compiled

    @property
    def profile(self) -> ir.PolicyProfile:
        """The team that is handed out."""
        return self.repair.after or self.before.profile


def verify_trees(profile: ir.PolicyProfile) -> run.Verified:
    """Verifies the usual claim in the start region, as `maviper verify` does."""
    options = VerifyOptions().ensure_usable()
    return run.verify_questions(profile, questions(profile, runs.PROFILE_FILE, options), options)


def repair_trees(profile: ir.PolicyProfile) -> Repaired:
    """Repairs the trees as `maviper repair --max-depth 6` does."""
    claim = "distinct_targets"
    asked = request(claim, {"max_depth": REPAIRED_DEPTH, "episodes": EPISODES})
    return repair_profile(profile, claim, "start", asked)


def compile_trees(before: run.Verified, repair: Repaired) -> Toured:
    """The stages with their code."""
    return Toured(before, repair, compile_profile(repair.after or before.profile))


def handout(made: Toured) -> dict[str, str | bytes]:
    """All files, name -> text; the manifest names the hash of every other one."""
    model, profile = made.code.build.model, made.profile
    files: dict[str, str | bytes] = {runs.PROFILE_FILE: dumps(profile), **made.repair.files, **made.code.files}
    before = made.before
    files |= {f"{EXTRACTED}/{name}": text for name, text in before.files.items() if name not in before.states}
    files[f"{EXTRACTED}/{FILE}"] = page_of(before.profile, before.results)
    files[FILE] = page_of(profile, made.repair.results or before.results)
    example = render("c/example.c.j2", model=model)
    files["example.c"] = example
    evaluation = dict(profile.provenance.evaluation)
    files["report.html"] = as_html(json.loads(files["report.json"]), story(made, files))
    files["README.md"] = render(
        "report/policy.md.j2", model=model, verdicts=_verdicts(made), evaluation=evaluation, example=example
    )
    files[MANIFEST] = manifest(profile, files)
    return files


WHAT_IS = (  # the end of a file's name, what is in it
    ("report.json", "the verification report as data"),
    ("report.txt", "the verification report as text"),
    ("report.html", "the verification report"),
    (FILE, "a page to move the agents, and to see what the trees do"),
    (runs.PROFILE_FILE, "the trees"),
    ("repair.json", "what the repair changed, and what it cost"),
    ("example.c", "a program that calls the header"),
    ("_reader.py", "a short program that reads the trees and decides"),
    (".agreement.json", "how the code was compared with the trees"),
    (MANIFEST, "the hashes of all files, and the versions of the tools"),
    (".json", "the trees as data, for any language"),
    (".h", "the trees as one C header"),
    (".md", "how to call the code"),
    (".py", "the trees as a Python module"),
)
WHAT_ELSE = {"certificate": "the proof", "counterexample": "the state, with exact numbers", "test_": "a test of it"}


def _describe_file(name: str) -> str:
    folder, _, last = name.rpartition("/")
    whose = " before the repair" if folder else ""
    kinds = [words for start, words in WHAT_ELSE.items() if last.startswith(start)]
    return (kinds or [words for end, words in WHAT_IS if last.endswith(end)] or [""])[0] + whose


def story(made: Toured, files: Mapping[str, str | bytes]) -> dict[str, Any]:
    """Returns what the first page tells of the tour, for `report/story.html.j2`. `files`: all that it can link."""
    before, world = made.before.profile, matching_world(made.before.profile)
    assert world is not None
    (claimed,) = made.before.document["results"]
    team = [policy.agent for policy in before.team(DEFENDERS)]
    cost = made.repair.cost
    changed = None if cost is None else cost.exact or (cost.uniform and cost.uniform.value)
    return {
        "team": DEFENDERS,
        "teams": stages(made, world),
        "wrong": [draw_picture(claimed)] if claimed["counterexample"] and made.repair.after is not None else [],
        "guards": [
            {"agent": one.agent, "node": one.node, "landmark": one.landmark, "leaves": len(ir.leaves(one.tree))}
            for one in made.repair.repair.guards
        ],
        "cost": cost,
        "changed": None if changed is None else float(changed),
        "trees": [
            {"title": f"The trees as {name}", "svg": svg(profile, team)} for name, profile, *_ in _list_stages(made)
        ],
        "proofs": [
            {"file": name, "branches": result.evidence.branches}
            for name, result in zip(made.repair.certificates, made.repair.results, strict=False)
        ],
        "header": f"{made.code.build.model.prefix}.h",
        "compared": made.code.report.observations,
        "skipped": made.code.report.skipped,
        "example": files["example.c"],
        "files": [(name, _describe_file(name)) for name in sorted({*files, "README.md", MANIFEST} - {"report.html"})],
    }


def stages(made: Toured, world: World) -> list[dict[str, Any]]:
    """A row for the neural team, and one for each team of trees: how it does, how large it is, what was decided."""
    unknown = dict.fromkeys(("leaves", "depth", "verdict", "report"), "")
    rows: list[dict[str, Any]] = [{"name": "neural", "success": _success(made.before.profile, world)[1], **unknown}]
    for name, profile, results, report in _list_stages(made):
        trees = sizes(profile, [policy.agent for policy in profile.agents]).values()
        row = {"leaves": sum(each["leaves"] for each in trees), "depth": max(each["depth"] for each in trees)}
        (verdict,) = [result.verdict.value for result in results]
        rows.append({"name": name, "success": _success(profile, world)[0], **row, "verdict": verdict, "report": report})
    return rows


def _list_stages(made: Toured) -> list[tuple[str, ir.PolicyProfile, tuple[Any, ...], str]]:
    """The teams of trees: name, profile, results, and the report of what is not on the first page."""
    before = ("extracted", made.before.profile, tuple(made.before.results), f"{EXTRACTED}/report.html")
    after = ("repaired", made.profile, tuple(made.repair.results), "")
    return [before, after] if made.repair.after is not None else [before]


def _verdicts(made: Toured) -> list[dict[str, Any]]:
    """Returns what is known of the team before and after."""
    before = f"{EXTRACTED}/{runs.PROFILE_FILE}"
    stages = ((before, made.before.results), (runs.PROFILE_FILE, made.repair.results))
    return [
        {
            "profile": profile,
            "property": result.claim.name,
            "region": result.region.name,
            "verdict": result.verdict.value,
        }
        for profile, results in stages
        for result in results
    ]


def manifest(profile: ir.PolicyProfile, files: Mapping[str, str | bytes]) -> str:
    """Hashes of profile, expert and files, and the versions of the tools that took part."""
    facts = {
        "profile": content_hash(profile),
        "expert": profile.provenance.expert,
        "versions": {"maviper": profiles.version()} | {name: metadata.version(name) for name in TOOLS},
        "sha256": run.digests(files),
    }
    return layout(facts) + "\n"


WORLD = "physical-deception"
SEED = 0
ITERATIONS, ROLLOUTS, SELECTION_EPISODES, REFINEMENT, MAX_DEPTH = 10, 50, 50, 60_000, 4
LEAST_RATIO = 0.80  # of the expert's defender success


def run_tour(folder: Path, console: Console, seed: int | None) -> int:
    """Runs the tour into `folder`; returns 0 when every step gave its expected outcome."""
    runs.room(folder)
    outputs.ensure_listed(folder, dict.fromkeys(NAMES, ""), MANIFEST)  # before the work, not after it
    profile, world = _extract_trees(SEED if seed is None else seed, console)
    with console.busy("verifying", "a claim about the defenders in every state of the start region"):
        before = verify_trees(profile)
    _say_violation(before, folder, console)
    with console.busy("repairing", "the leaves from which the claim can fail"):
        repair = repair_trees(profile)
    with console.busy("compiling", "the trees, and replaying the code"):
        made = compile_trees(before, repair)
    outputs.write_listed(folder, handout(made), MANIFEST)
    _say_repair(repair, world, folder, console)
    _say_code(made.code, folder, console)
    console.line("report", str(folder / "report.html"))
    console.line("next", f"maviper play {folder / runs.PROFILE_FILE}")
    unexpected = _find_surprises(made, world)
    for reason in unexpected:
        console.line("unexpected", reason)
    console.give({"wrote": str(folder), "teams": stages(made, world), "unexpected": unexpected})
    return ExitCode.VIOLATED if unexpected else ExitCode.DONE


def _extract_trees(seed: int, console: Console) -> tuple[ir.PolicyProfile, World]:
    expert, world = network.load(WORLD)
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
    console.line("", f"replayed by {replayed}: {folder / EXTRACTED / 'report.html'}")


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


def _find_surprises(made: Toured, world: World) -> list[str]:
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
