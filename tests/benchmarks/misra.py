"""What cppcheck's MISRA C:2012 checker finds in the generated headers, by rule.

    python -m tests.benchmarks.misra [HEADER ...] [--lines] [--json]

Without headers: the committed profile's, in each style. A header is checked as a translation unit that only includes
it; rules about a whole program (unused macros and tags, one definition) are the including program's matter. The text of
the rules is not free, so only their numbers are printed. What the checker does not implement it does not find.
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from codegen.targets import emit
from maviper import load
from tests.benchmarks.common import figure, reader, tell

STYLES = ("nested", "ordered", "walk")
FOLDER = Path(__file__).parents[2] / "generated" / "physical_deception"
ADDONS = ("lib*/cppcheck/addons", "lib/*/cppcheck/addons", "share/cppcheck/addons")
HEADER = "checked.h"


def checker() -> Path | None:
    """cppcheck's MISRA add-on, or None where it is not installed."""
    program = shutil.which("cppcheck")
    if program is None:
        return None
    places = [place for pattern in ADDONS for place in Path(program).resolve().parents[1].glob(pattern)]
    return next((place / "misra.py" for place in places if (place / "misra.py").exists()), None)


def findings(header: str) -> dict[str, list[str]]:
    """The lines of a header's text that break a rule (`line number: text`), by rule (`10.4`); {} where none does.

    RuntimeError where cppcheck did not get through the whole header, FileNotFoundError where there is no checker.
    """
    addon = checker()
    if addon is None:
        raise FileNotFoundError("cppcheck with its add-on misra.py is not installed")
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        Path(folder, HEADER).write_text(header)
        Path(folder, "checked.c").write_text(f'#include "{HEADER}"\n')
        said = [
            subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            for command in (
                ["cppcheck", "-q", "--dump", "--std=c99", "checked.c"],
                [sys.executable, str(addon), "--cli", "checked.c.dump"],
            )
        ]
        read = Path(folder, "checked.c.dump").read_text()
    names = re.findall(r"^static [\w *]*?(\w+)\(", header, re.M)
    missing = [name for name in names if f'name="{name}"' not in read]
    if not names or missing or any(done.returncode for done in said):
        printed = "\n".join(done.stdout + done.stderr for done in said)
        raise RuntimeError(f"cppcheck did not read {missing or 'any function'}\n{printed}")
    text = header.splitlines()
    found: dict[str, list[str]] = {}
    for item in map(json.loads, said[1].stdout.splitlines()):
        if "errorId" in item:  # the others sum up a unit for the checks of a whole program
            assert Path(item["file"]).name == HEADER, item
            rule = item["errorId"].removeprefix("c2012-")
            found.setdefault(rule, []).append(f"{item['linenr']}: {text[item['linenr'] - 1].strip()}")
    return dict(sorted(found.items(), key=lambda pair: [int(part) for part in pair[0].split(".")]))


def headers(paths: list[str]) -> dict[str, str]:
    """The headers to check, name -> text."""
    if paths:
        return {path: Path(path).read_text() for path in paths}
    profile = load(FOLDER / "profile.json")
    return {style: next(iter(emit(profile, ["c"], style=style).values())) for style in STYLES}


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("headers", nargs="*")
    parser.add_argument("--lines", action="store_true", help="every line that breaks a rule")
    options = parser.parse_args()
    figures = []
    for name, text in headers(options.headers).items():
        found = findings(text)
        reach = 0 if name == "walk" or options.headers else None
        figures.append(figure(f"{name}: MISRA findings", sum(map(len, found.values())), reach))
        if not options.json:
            print(name)
            for rule, lines in found.items():
                print(f"  {rule:>5}  {len(lines)}")
                for line in lines if options.lines else ():
                    print(f"           {line}")
    tell(figures, options.json)


if __name__ == "__main__":
    main()
