"""Everything that the tour hands out: a repaired team with its proof and code, and the team it was made from.

Does: makes all files from what the commands would make: extracted team, violation, repair, certificate, code, a page
  for its user, a manifest; as name -> text.
Assumes: the extracted profile's own seed, so that a committed one gives the same files again.
Does not: extract, write files or print.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata
from typing import Any

from codegen import ir
from codegen.form import layout
from codegen.lowering.render import render
from codegen.policy_json import content_hash, dumps
from maviper.compilation.compile import Compiled, compile_profile
from maviper.files import profiles, runs
from maviper.page.page import FILE
from maviper.page.results import page_of
from maviper.verification import run
from maviper.verification.ask import VerifyOptions, questions
from maviper.verification.repair import Repaired, repair_profile, request

MANIFEST = "manifest.json"
EXTRACTED = "extracted"  # the folder of the team before its repair, inside the tour's
_REPORTS = (runs.PROFILE_FILE, "report.html", "report.json", "report.txt", FILE)
_CODE = (".h", ".py", "_reader.py", ".json", ".agreement.json")
NAMES = (  # of all files but those that are numbered, of which others may have some of their own
    *(MANIFEST, "README.md", "example.c", "repair.json", *(f"physical_deception{ending}" for ending in _CODE)),
    *(*_REPORTS, *(f"{EXTRACTED}/{name}" for name in _REPORTS)),
)
MAX_DEPTH, EPISODES = 6, 1_000
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
    asked = request(claim, {"max_depth": MAX_DEPTH, "episodes": EPISODES})
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
    files["README.md"] = render(
        "report/policy.md.j2", model=model, verdicts=_verdicts(made), evaluation=evaluation, example=example
    )
    files[MANIFEST] = manifest(profile, files)
    return files


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
