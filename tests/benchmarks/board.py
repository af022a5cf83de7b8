"""ARCH-COMP's board: every question of generated/arch proved and checked again, whole commands, processor seconds.

    python -m tests.benchmarks.board [--renew] [--vcas] [--json] [NAME ...]

Each row is `maviper verify` with the shuffled control and the report, then `maviper check` of what it wrote. A row must
end PROVED, or the script fails. `--renew` writes the folders of generated/arch, else a folder that goes away. `--vcas`
adds the eight rows of generated/worlds/vcas, where four are VIOLATED beside a proof that no controller can.
"""

import json
import sys
import tempfile
from pathlib import Path

from codegen.errors import ExitCode
from tests.benchmarks.common import listed, reader, spent, tell

PLACE = Path(__file__).parents[2] / "generated" / "arch"
NAMES = sorted(path.stem for path in PLACE.glob("*.toml"))
VCAS = PLACE.parent / "worlds" / "vcas"
TARGETS = {
    "questions PROVED": (11, 13, "higher"),
    "questions PROVED, or VIOLATED beside a proof that no controller can": (15, 17, "higher"),
    "the slowest, s": (60.0, 15.0, "lower"),
    "unicycle, s": (60.0, 10.0, "lower"),
    "checking over proving, the largest": (1.0, 0.3, "lower"),
}


def verified(profile, world, folder):
    """Seconds to verify and to check all certificates, and the set of verdicts."""
    proving = spent("verify", profile, "--system", world, "-o", folder)
    report = folder / "report.json"
    assert proving.code in (ExitCode.DONE, ExitCode.VIOLATED), f"maviper verify {profile} --system {world}"
    verdicts = {each["verdict"] for each in json.loads(report.read_text())["results"]}
    checks = [spent("check", path) for path in sorted(folder.glob("certificate-*.json"))]
    assert not any(check.code for check in checks), f"maviper check {folder}"
    return proving.seconds, sum(check.seconds for check in checks), verdicts


def board(names, renew):
    """The rows of flows: seconds to verify, seconds to check."""
    rows = {}
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            place = PLACE / name if renew else Path(folder, name)
            proving, checking, verdicts = verified(PLACE / f"{name}.json", PLACE / f"{name}.toml", place)
        assert verdicts == {"PROVED"}, (name, verdicts)
        rows[name] = proving, checking
        print(f"{name:<22} PROVED {proving:6.1f} s  check {checking:5.1f} s  {checking / proving:.2f}", file=sys.stderr)
    return rows


def vcas():
    """The eight rows, by verdict: how many are PROVED, and how many more have a proof that no controller can."""
    counts = {"PROVED": 0, "VIOLATED": 0}
    for kind in ("middle", "worst"):
        for speed in ("19.5", "22.5", "25.5", "28.5"):
            with tempfile.TemporaryDirectory() as folder:
                _, _, (verdict,) = verified(VCAS / "vcas.json", VCAS / f"{kind}_{speed}.toml", Path(folder))
                if verdict == "VIOLATED":
                    nobody = verified(VCAS / "vcas.json", VCAS / f"nobody_{speed}.toml", Path(folder, "nobody"))
                    assert nobody[2] == {"PROVED"}, speed
            counts[verdict] += 1
    return counts


def main():
    parser = reader(__doc__)
    parser.add_argument("names", nargs="*", default=NAMES)
    parser.add_argument("--renew", action="store_true", help="writes generated/arch")
    parser.add_argument("--vcas", action="store_true", help="also the rows of VCAS")
    options = parser.parse_args()
    rows = board(options.names, options.renew)
    values = {"the slowest, s": max(proving for proving, _ in rows.values())}
    values["checking over proving, the largest"] = max(checking / proving for proving, checking in rows.values())
    if "unicycle" in rows:
        values["unicycle, s"] = rows["unicycle"][0]
    if options.vcas and set(rows) == set(NAMES):
        counts = vcas()
        values["questions PROVED"] = len(rows) + counts["PROVED"]
        both = "questions PROVED, or VIOLATED beside a proof that no controller can"
        values[both] = len(rows) + sum(counts.values())
    tell(listed(values, TARGETS), options.json)


if __name__ == "__main__":
    main()
