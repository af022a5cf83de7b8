"""What the cells of a reproduction cost in CPU seconds, beside the estimate of `maviper reproduce --plan`.

    python -m tests.benchmarks.reproduce [--folder FOLDER] [--quick | --full] [--write] [--json]

Makes one seed of the default tier (--quick: of the quick one; --full: of the full one) in FOLDER, or what of it is
missing there, in one process. Prints the median cost of each kind of cell and depth, the estimate, and their ratio.
--write renews the table that estimates come from, as far as it was measured here. Costs are of one core of this
machine, and grow when other work shares the core. The target of the sum is 30 % of the estimate.
"""

import argparse
import json
import tempfile
import tomllib
from pathlib import Path
from statistics import median

from maviper.console import Console
from maviper.reproduction.cells import costs
from maviper.reproduction.cells.cell import DONE
from maviper.reproduction.cells.store import Store
from maviper.reproduction.run import ReproduceOptions, reproduced

TABLE = Path(costs.__file__).with_name(costs.FILE)
HEAD = "# CPU seconds of one cell by depth. Made by `python -m tests.benchmarks.reproduce --write`.\n"
REACH, STRETCH = 0.3, 0.15


def measured(folder):
    """(key, depth) -> the CPU seconds of its cells, and a cell of that kind."""
    found, cells = {}, {}
    for _, document in Store(folder).documents():
        if document.outcome == DONE:
            key = costs.key_of(document.cell), document.cell.depth
            found.setdefault(key, []).append(document.cpu_seconds)
            cells[key] = document.cell
    return found, cells


def write(found):
    """Renews what was measured in the table of estimates, and keeps the rest."""
    table = {key: dict(rows) for key, rows in tomllib.loads(TABLE.read_text()).items()}
    for (key, depth), seconds in found.items():
        table.setdefault(key, {})[str(depth)] = round(median(seconds), 1)
    lines = [HEAD]
    for key, rows in sorted(table.items()):
        ordered = ", ".join(f"{depth} = {rows[depth]}" for depth in sorted(rows, key=int))
        lines.append(f'"{key}" = {{ {ordered} }}\n')
    TABLE.write_text("".join(lines))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--json", action="store_true")
    tier = parser.add_mutually_exclusive_group()
    tier.add_argument("--quick", action="store_true")
    tier.add_argument("--full", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.folder or Path(scratch)
        reproduced(folder, ReproduceOptions(quick=given.quick, full=given.full, seeds=1), Console())
        found, cells = measured(folder)
    spent = {key: sum(seconds) for key, seconds in found.items()}
    expected = {key: len(found[key]) * costs.estimate(cells[key]) for key in found}
    ratio = sum(spent.values()) / sum(expected.values())
    if given.json:
        figure = {"name": "CPU time less its estimate, share", "value": abs(ratio - 1), "better": "lower"}
        print(json.dumps({"figures": [{**figure, "reach": REACH, "stretch": STRETCH}]}))
    else:
        print(f"{'cells':>6}  {'median':>7}  {'estimate':>8}  {'ratio':>6}  what, depth")
        for key in sorted(found):
            middle, guess = median(found[key]), costs.estimate(cells[key])
            print(f"{len(found[key]):>6}  {middle:>7.1f}  {guess:>8.1f}  {middle / guess:>6.2f}  {key[0]}, {key[1]}")
        print(f"all together {sum(spent.values()):.0f} CPU s, {ratio:.2f} of the estimate")
    if given.write:
        write(found)


if __name__ == "__main__":
    main()
