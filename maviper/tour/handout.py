"""Everything that is handed out with a profile: code, evidence, claims, report, a page for its user, a manifest.

Does: asks the tour's two questions about a profile and makes all files from the answers, as name -> text.
Assumes: the profile's own seed, so that a committed profile gives the same files again.
Does not: extract, write files or print.
"""

from collections.abc import Mapping, Sequence
from importlib import metadata

from codegen import ir, policy_json
from codegen.lowering.render import render
from codegen.policy_json import content_hash, layout
from maviper.compilation.compile import Compiled
from maviper.files import runs
from maviper.verification import join
from maviper.verification.ask import command
from verify.claims.catalogue import find_property
from verify.claims.region import Region
from verify.extent.boxes import best_proved_box
from verify.question import DecisionQuestion, from_start
from verify.verdicts.decisions import Result

REGION_FILE = "region.toml"
TOOLS = ("maviper", "mpe2", "numpy", "scikit-learn", "z3-solver")


def questions(profile: ir.PolicyProfile) -> list[DecisionQuestion]:
    """`distinct_targets` in the start region and, where one is found, in a box around conflicting states."""
    claim = find_property("distinct_targets", profile)
    asked = [from_start(profile, claim)]
    box = best_proved_box(profile, claim, profile.provenance.seed)
    if box is not None:
        asked.append(asked[0].within(Region(box.region.box, box.region.goals, name=REGION_FILE)))
    return asked


def handout(
    profile: ir.PolicyProfile, compiled: Compiled, asked: Sequence[DecisionQuestion], results: Sequence[Result]
) -> dict[str, str | bytes]:
    """All files, name -> text; the manifest names the hash of every other one."""
    model = compiled.build.model
    files: dict[str, str | bytes] = {runs.PROFILE_FILE: policy_json.dumps(profile), **compiled.files}
    files |= {one.region.name: one.region.toml() for one in asked if one.region.name == REGION_FILE}
    example = render("c/example.c.j2", model=model)
    files["example.c"] = example
    commands = [command(runs.PROFILE_FILE, one) for one in asked]
    files |= join.report_files(profile, results, commands, files)
    verdicts = [
        {
            "property": result.claim.name,
            "region": result.region.name,
            "verdict": result.verdict.value,
            "conflict": str(result.shares.conflict),
            "command": line,
        }
        for result, line in zip(results, commands, strict=True)
    ]
    evaluation = dict(profile.provenance.evaluation)
    files["README.md"] = render(
        "report/policy.md.j2", model=model, verdicts=verdicts, evaluation=evaluation, example=example
    )
    files["manifest.json"] = manifest(profile, files)
    return files


def manifest(profile: ir.PolicyProfile, files: Mapping[str, str | bytes]) -> str:
    """Hashes of profile, expert and files, and the versions of the tools that took part."""
    facts = {
        "profile": content_hash(profile),
        "expert": profile.provenance.expert,
        "versions": {name: metadata.version(name) for name in TOOLS},
        "sha256": join.digests(files),
    }
    return layout(facts) + "\n"
