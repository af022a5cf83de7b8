"""What it takes to say where a claim holds: the parts of `maviper verify --where`, one after the other.

    python tests/benchmarks/where.py [--profile PATH ...] [--json]

Teams: the shipped demo's, trees of depth 6 fitted to the nearer of two matchings, and every profile named. Measured
for `distinct_targets` in the start region: the enumeration of all violating zones, their exact share, the search for
the largest region, with what they found. The whole question is timed beside them, so that the extra cost can be told.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

from maviper import load
from tests.benchmarks.verifier import Played, deception_team, seconds
from verify.claims.catalogue import find_property
from verify.claims.region import Region
from verify.claims.wording.starts import everywhere
from verify.extent import violations
from verify.extent.largest import largest
from verify.question import Question
from verify.states.shares import SAMPLE_SEED, measure
from verify.subjects import Game
from verify.verdicts import decisions
from verify.zones import search

DEMO = Path(__file__).parents[2] / "generated" / "physical_deception" / "extracted" / "profile.json"
TARGETS = {
    "demo, all zones and their exact share, s": (5.0, 1.0, "lower"),
    "demo, largest region, s": (30.0, 5.0, "lower"),
}


def parts(profile):
    """Seconds of each part, and what it found."""
    claim, region = find_property("distinct_targets", profile), everywhere(profile)
    whole, _ = seconds(lambda: decisions.verify(Question(Game(profile), claim, region), {}))
    listing, found = seconds(lambda: violations.violations(Question(Game(profile), claim, region)))
    adding, share = seconds(lambda: violations.exact_share(Question(Game(profile), claim, region), found))
    growing, part = seconds(lambda: largest(Question(Game(profile), claim, region), found, SAMPLE_SEED))
    facts = {
        "verdict s": whole,
        "zones s": listing,
        "exact share s": adding,
        "largest region s": growing,
        "zones": sum(len(one.zones) for one in found),
        "complete": all(one.complete for one in found),
        "violating": None if isinstance(share, str) else float(share.value),
        "sampled": str(measure(Question(Game(profile), claim, region), SAMPLE_SEED).violating),
        "region": None,
    }
    if isinstance(part, Region):
        facts["region"] = float(violations.exact_part(Question(Game(profile), claim, region), part))
        facts["conflict in region"] = measure(Question(Game(profile), claim, part), SAMPLE_SEED).conflict.value
    return facts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--profile", type=Path, action="append", default=[])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    teams = {"demo": load(DEMO), "nearer, depth 6": deception_team(Played("physical-deception"), "nearer", 6)}
    teams |= {str(path.name): load(path) for path in options.profile}
    rows = {name: parts(profile) for name, profile in teams.items()}
    demo = rows["demo"]
    values = {
        "demo, all zones and their exact share, s": demo["zones s"] + demo["exact share s"],
        "demo, largest region, s": demo["largest region s"],
    }
    if options.json:
        figures = [
            {"name": name, "value": values[name], "reach": reach, "stretch": stretch, "better": better}
            for name, (reach, stretch, better) in TARGETS.items()
        ]
        print(json.dumps({"figures": figures, "teams": rows}))
        return
    print(f"zone search: {'compiled' if search.AVAILABLE else 'Python (the extension is not built)'}")
    for name, facts in rows.items():
        print(name)
        for key, value in facts.items():
            print(f"    {key:20} {value:.4g}" if isinstance(value, float) else f"    {key:20} {value}")


if __name__ == "__main__":
    main()
