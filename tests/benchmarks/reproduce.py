"""What the cells of a reproduction cost in CPU seconds, beside the estimate of `maviper reproduce --plan`.

    python -m tests.benchmarks.reproduce [--folder FOLDER] [--quick] [--write] [--json]

Makes one seed of the default tier (--quick: of the quick one) in FOLDER, or what of it is missing there, in one
process. --finished: takes the cells of FOLDER as they are, and makes none. Prints the median cost of each kind of cell
and depth, the estimate, and their ratio. --write renews the table that estimates come from, as far as it was measured
here. --effort: makes cells of responders to the quick tier's MAVIPER trees instead, and prints what a thousand steps of
networks and a thousand episodes of refinement cost beyond what it costs to begin, which a tenth of the default tier's
effort tells from the whole of it. Costs are of one core of this machine, and grow when other work shares the core. The
target of the sum is 30 % of the estimate.
"""

import tempfile
import tomllib
from dataclasses import replace
from pathlib import Path
from statistics import median

from maviper.console import Console
from maviper.reproduction.cells import cell as cells
from maviper.reproduction.cells.cell import DONE, EXPLOITABILITY, EXTRACTION, Source, Task
from maviper.reproduction.cells.making import UNTRAINED, USUAL, make_cell
from maviper.reproduction.cells.plan import Asked, plan_cells
from maviper.reproduction.cells.table import Store
from maviper.reproduction.run import reproduce_paper, request
from tests.benchmarks.common import figure, reader, tell

TABLE = Path(cells.__file__).with_name(cells.FILE)
HEAD = (
    "# CPU seconds of one cell by depth. Made by `python -m tests.benchmarks.reproduce --write`; those of MAVIPER, of\n"
    "# IVIPER and of imitation at depth 4: of paper/ and experts/; at others, and those of `released`, of an\n"
    "# earlier record that is in the history.\n"
)
REACH, STRETCH = 0.3, 0.15
SMALL = 10  # times less than the default tier's effort


def measured(folder):
    """(key, depth) -> the CPU seconds of its cells, and a task of that kind."""
    found, tasks = {}, {}
    for _, document in Store(folder).documents():
        cell = document.cell
        if document.outcome == DONE:
            effort = {name: document.identity[name] for name in UNTRAINED if name in document.identity}
            key = cells.key_of(cell), cell.depth
            found.setdefault(key, []).append(document.cpu_seconds)
            tasks[key] = Task(cell, Source(cell.game, world=cell.game), "", "", effort=effort)
    return found, tasks


def responders(folder):
    """("effort NAME", BEGUN or UNIT) -> the CPU seconds to begin, and of so many steps or episodes more."""
    plan = plan_cells(Asked(quick=True), "")
    task = next(task for task in plan.tasks if (task.cell.kind, task.cell.algorithm) == (EXPLOITABILITY, "maviper"))
    store = Store(folder)
    stored = {doc.cell.algorithm: id_ for id_, doc in store.documents() if doc.cell.kind == EXTRACTION}
    profiles = {name: store.profile(stored[name]) for name in task.of}

    def seconds(**effort):
        return make_cell(replace(task, effort={**UNTRAINED, **effort}), profiles).document.cpu_seconds

    found = {}
    for name, whole in USUAL.items():
        seconds(**{name: whole // SMALL})  # a process imports what it needs once
        none, small, large = (seconds(**{name: count}) for count in (0, whole // SMALL, whole))
        rate = (large - small) / (whole - whole // SMALL)
        found[f"effort {name}", cells.UNIT] = [rate * cells.UNIT]
        found[f"effort {name}", cells.BEGUN] = [max(0.0, large - none - rate * whole)]
    return found


def write(found):
    """Renews what was measured in the table of estimates, and keeps the rest."""
    table = {key: dict(rows) for key, rows in tomllib.loads(TABLE.read_text()).items()}
    for (key, depth), seconds in found.items():
        table.setdefault(key, {})[str(depth)] = round(median(seconds), 4 if key.startswith("effort") else 1)
    lines = [HEAD]
    for key, rows in sorted(table.items()):
        ordered = ", ".join(f"{depth} = {rows[depth]}" for depth in sorted(rows, key=int))
        lines.append(f'"{key}" = {{ {ordered} }}\n')
    TABLE.write_text("".join(lines))


def main():
    parser = reader(__doc__)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--finished", action="store_true")
    parser.add_argument("--effort", action="store_true")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.folder or Path(scratch)
        if not given.finished:
            quick = given.quick or given.effort
            reproduce_paper(folder, request({"quick": quick, "seeds": 1}), Console())
        found, tasks = (responders(folder), {}) if given.effort else measured(folder)
    if given.effort:
        for (name, unit), (seconds,) in found.items():
            print(f"{seconds:.3f} CPU s " + (f"for {unit} of {name}" if unit else f"to begin {name}"))
    else:
        compare(found, tasks, given.json)
    if given.write:
        trained = {key for key, task in tasks.items() if any(task.effort.values())}  # --effort is for these
        write({key: seconds for key, seconds in found.items() if key not in trained})


def compare(found, tasks, as_json):
    """Prints what was measured beside what was estimated."""
    spent = {key: sum(seconds) for key, seconds in found.items()}
    expected = {key: len(found[key]) * cells.estimate(tasks[key]) for key in found}
    ratio = sum(spent.values()) / sum(expected.values())
    if not as_json:
        print(f"{'cells':>6}  {'median':>7}  {'estimate':>8}  {'ratio':>6}  what, depth")
        for key in sorted(found):
            middle, guess = median(found[key]), cells.estimate(tasks[key])
            print(f"{len(found[key]):>6}  {middle:>7.1f}  {guess:>8.1f}  {middle / guess:>6.2f}  {key[0]}, {key[1]}")
        print(f"all together {sum(spent.values()):.0f} CPU s, {ratio:.2f} of the estimate")
    tell([figure("CPU time less its estimate, share", abs(ratio - 1), REACH, STRETCH)], as_json)


if __name__ == "__main__":
    main()
