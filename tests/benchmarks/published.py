"""The paper's comparison as it was published: MAVIPER with all of its rounds, and the authors' released code.

    python -m tests.benchmarks.published [--register NAME] [--plan | --tables] [--cells FOLDER] [--groups NAME,...]
        [--experts FOLDER] [--train] [--cell NAME] [--record PLACE]

The register stands in NAME.toml: claims, cells in the order in which they are made, and their words. `published` is the
default; `steps` undoes what the released code does besides its text, one by one, and has a figure; `splits` compares
splits by every threshold with histograms; `factorial` combines what MAVIPER and IVIPER differ in; `random-experts` has
the expert as the unit, `more-experts` has MADDPG's so, and predator-prey; `learner-experts` and `learner-more-experts`
have our algorithm over experts. Where a register has experts of its own they are trained first: --train makes those
that are missing in the folder of --experts, and goes on with those that were interrupted.
--plan prints a register with its cells, CPU time and power. Without an option the missing cells are made, one after the
other, then the tables are printed; --tables only prints. Every cell is a file in the folder, so an interrupted run goes
on where it was. --record writes what the finished cells come to, the tables and figures into a folder, in the form of
compact.py; a folder of cells may hold such a record, and its cells count as made.
--cell makes one cell alone, and prints the hash of its episodes beside that of the committed record.
"""

import argparse
import time
from collections import Counter, defaultdict
from itertools import product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from maviper.files import runs
from maviper.reproduction.statistics import holm, size
from tests.benchmarks import compact
from tests.benchmarks.drawings import absolute_of, drawn, levels
from tests.benchmarks.paired import BETTER, NOT_DECIDED, WORSE, detectable
from tests.benchmarks.registered import (
    Cell,
    Found,
    by_expert,
    cells_of,
    comparisons_of,
    kept_in,
    made,
    make,
    read_register,
    units_of,
)
from tests.benchmarks.trained import runs_of, train_missing, tree_seeds_of

FOLDER = "/tmp/maviper-{}"
RECORDS = Path(__file__).parents[2] / "generated" / "reproduction"
TEXT, README, FIGURE = "tables.txt", "README.md", "figure.svg"
UNTESTABLE = "UNTESTABLE"
BEST, WORST = "better than all", "worse than one"
MANY = 3  # algorithms beside one, from which on a register asks whether it is better than all of them
TITLE = "MAVIPER with all of its rounds, and the released code"


# --- what is told


def plan_lines(register):
    """The groups with their cells and CPU time, then what each comparison can see."""
    lines = [f"{'cells':>6}{'CPU s':>8}  group"]
    total = 0
    for group in register["groups"]:
        cells = cells_of(register, group)
        rate = sum(group["seconds"][cell.algorithm] for cell in cells)
        lines.append(f"{len(cells):>6}{rate:>8.0f}  {group['name']}")
        total += rate
    trained = Counter((game, label.rpartition("-")[0]) for game, label in runs_of(register, register["groups"]))
    for (game, name), count in trained.items():
        seconds = register["trained"][name]["seconds"][game] * count
        lines.append(f"{count:>6}{seconds:>8.0f}  experts {name}, {game}")
        total += seconds
    lines += [f"{total / 3600:.1f} CPU hours in all, by the register's seconds", "", "effect seen with power .8"]
    counts = {family: sum(each[0] == family for each in comparisons_of(register)) for family in families(register)}
    for family, claim, expert, depth in comparisons_of(register):
        alpha = register["alpha"] / counts[family]
        seen = detectable(claim["deviation"], units_of(register, expert), alpha, register["power"])
        lines.append(f"  {seen:.3f} of {claim['effect']:.3f}  {claim['id']}, {called(expert)}, depth {depth}")
    return lines


def called(expert):
    """An expert's label, or how many there are."""
    return f"{len(expert)} experts" if isinstance(expert, tuple) else expert


def families(register):
    return list(dict.fromkeys(claim["family"] for claim in register["claims"]))


def table_lines(register, found, each=False):
    """Ratios and rounds of every row, then the comparisons of each family. `each`: where experts are the units, the
    ratios of each expert too.
    """
    total = sum(len(cells_of(register, group)) for group in register["groups"])
    over = "experts, or an expert's seeds" if by_expert(register) else "seeds"
    lines = [
        f"{len(found.documents)} of {total} cells",
        "",
        f"joint ratio to the expert, mean and deviation over {over}",
    ]
    for group in register["groups"]:
        alone = group["experts"] if each or not by_expert(register) else []
        experts = [tuple(group["experts"]), *alone] if by_expert(register) else alone
        for expert, depth, algorithm in product(experts, group["depths"], group["algorithms"]):
            lines += row_lines(register, found, group, expert, depth, algorithm)
    for family in families(register):
        lines += family_lines(register, found, family)
    return lines + cell_lines(register, found)


def row_lines(register, found, group, expert, depth, algorithm):
    lines = []
    for label in group["measures"]:
        claim = {"game": group["game"], "measure": label, "row": {"preset": group["preset"], "algorithm": algorithm}}
        values = found.ratios(claim, "row", expert, depth)
        if values:
            numbers = list(values.values())
            spread = f"{np.std(numbers, ddof=1):.3f}" if len(numbers) > 1 else "-"
            name = f"{group['game']} {called(expert)} {group['preset']} {algorithm} depth {depth}: {label}"
            several = isinstance(expert, tuple)
            played = [(each, seed) for each in values for seed in tree_seeds_of(register, each)] if several else []
            played = played or [(expert, seed) for seed in values]
            cells = [Cell(group["game"], each, group["preset"], algorithm, depth, seed) for each, seed in played]
            rounds = np.median([found.document(cell)["training"]["stopped_after"] for cell in cells])
            absolute = np.mean([absolute_of(found.document(cell), label) for cell in cells], axis=0)
            told = f"{absolute[0]:.3f} of {absolute[1]:.3f}, median of {rounds:g} rounds"
            units = "experts" if several else "seeds"
            lines.append(f"  {np.mean(numbers):.3f} {spread:>6}  {len(values):>2} {units}  {name}, {told}")
    return lines


def judged(register, found, family):
    """The comparisons of a family, their pairs and their words, which are empty until all of the family is there."""
    named = [each for each in comparisons_of(register) if each[0] == family]
    pairs = [found.paired(*each[1:]) for each in named]
    whole = all(len(pair.differences) == units_of(register, each[2]) for pair, each in zip(pairs, named, strict=True))
    return named, pairs, words_of(pairs, register["alpha"], register["margin"]) if whole else [""] * len(pairs)


def family_lines(register, found, family):
    """Comparisons with interval and size; words only once the whole family has all of its seeds, or experts."""
    named, pairs, words = judged(register, found, family)
    whole = any(words)
    lines = ["", f"family {family}" + ("" if whole else ": not whole, so no word is given yet")]
    for (_, claim, expert, depth), pair, word in zip(named, pairs, words, strict=True):
        name = f"{claim['id']}, {called(expert)}, depth {depth}"
        count, units = len(pair.differences), units_of(register, expert)
        if count < units:
            lines.append(f"  {name}: {count} of {units} {'experts' if by_expert(register) else 'seeds'}")
            continue
        low, high = pair.interval()
        told = f"{size(claim['effect'], low, high)} against {claim['effect']:g}"
        beside = "; UNTESTABLE by the rule of the ceiling" if found.ceiling(claim, expert, depth) else ""
        if beside and by_expert(register):  # fresh experts: the rule applies
            word, beside = f"{UNTESTABLE} ({word or 'no word yet'} without the rule of the ceiling)", ""
        lines.append(f"  {name}: {pair.mean:+.3f} [{low:+.3f}, {high:+.3f}]  {word or 'no word yet'}; {told}{beside}")
    return lines


def cell_lines(register, found):
    """What a register asks that compares one algorithm with several others over experts: for each family and depth
    that is whole, whether it is better than all of them, or worse than one.
    """
    if not by_expert(register) or len({claim["first"]["algorithm"] for claim in register["claims"]}) > 1:
        return []
    lines, said = [], []
    for family in families(register):
        told = defaultdict(list)
        for (_, claim, experts, depth), pair, word in zip(*judged(register, found, family), strict=True):
            if word and word != WORSE and found.ceiling(claim, experts, depth):
                word = UNTESTABLE
            if word:
                told[claim["measure"], depth].append((pair.mean, word))
        for (_, depth), others in told.items():
            means, words = zip(*others, strict=True)
            if len(others) >= MANY:
                said.append(told_of(words))
                lines.append(f"  {family}, depth {depth}: {min(means):+.3f} over the best of {len(others)}; {said[-1]}")
    counts = ", ".join(f"{said.count(word)} {word}" for word in (BEST, WORST, UNTESTABLE))
    return ["", f"{len(lines)} cells: {counts}", *lines] if lines else []


def told_of(words):
    """What the words of a cell say together."""
    if WORSE in words or UNTESTABLE in words:
        return WORST if WORSE in words else UNTESTABLE
    return BEST if set(words) == {BETTER} else "neither"


def words_of(pairs, alpha, margin):
    """A word for each comparison of a family. Both tests of all are corrected together, as in verdicts.decide_family:
    of the two hypotheses of a comparison only one can be true.
    """
    adjusted = holm([p for pair in pairs for p in (pair.p_differs(), pair.p_equal(margin))], len(pairs))
    words = []
    for pair, differs, equal in zip(pairs, adjusted[::2], adjusted[1::2], strict=True):
        told = BETTER if pair.mean > 0 else WORSE
        words.append("EQUAL" if equal <= alpha else told if differs <= alpha else NOT_DECIDED)
    return words


# --- the record


def recorded(register, digest, found, place):
    """Writes what the finished cells come to, the tables and a page."""
    runs.write(place / compact.FILE, compact.packed({cell.name: of for cell, of in found.documents.items()}))
    runs.write(place / TEXT, "\n".join(table_lines(register, found)) + "\n")
    runs.write(place / README, page(register, digest, found))
    if "figure" in register:
        runs.write(place / FIGURE, drawn(register, found))
    for name, text in levels(register, found).items():
        runs.write(place / name, text)


def page(register, digest, found):
    """README.md: what is here, what is not yet, and how to go on."""
    lines = []
    for group in register["groups"]:
        cells = cells_of(register, group)
        lines.append(f"| {group['name']} | {sum(cell in found.documents for cell in cells)} of {len(cells)} |")
    total = sum(len(cells_of(register, group)) for group in register["groups"])
    hours = sum(document["seconds"] for document in found.documents.values()) / 3600
    partial = len(found.documents) < total
    state = (
        "**This record is partial.** Families that are not whole get no word." if partial else "The record is whole."
    )
    name = register.get("name", "published")
    figure = f"\n- `{FIGURE}`: {register['figure']['title']}." if "figure" in register else ""
    drawings = "".join(
        f"\n- `{file}`: what experts and their trees reach, absolute." for file in levels(register, found)
    )
    option = "" if name == "published" else f" --register {name}"
    experts = each = ""
    if by_expert(register):
        each = f"\n  Those of each expert: `--register {name} --tables --cells generated/reproduction/{name}`."
    if "trained" in register:
        experts = f"    python -m tests.benchmarks.published{option} --experts RUNS --train\n"
        option += " --experts RUNS"
    return f"""# {register.get("title", TITLE)}

{experts}    python -m tests.benchmarks.published{option} --cells FOLDER --record generated/reproduction/{name}

{state} {len(found.documents)} of {total} cells, {hours:.1f} core-hours.
Register: tests/benchmarks/{name}.toml, sha256 {digest}.
It was committed before the first cell was made.

| group | cells |
|---|---|
{chr(10).join(lines)}

- `{TEXT}`: ratios to the expert, then every comparison with its interval and words.{each}
- `{compact.FILE}`: of every cell its training, and of every line-up and measure the number of episodes and their mean.
  {compact.TOLD}{figure}{drawings}

Episodes are left out. `--cell NAME --cells FOLDER` in place of `--cells FOLDER --record ...` makes those of one cell
again, and prints their hash beside the recorded one. To go on, copy `{compact.FILE}` into FOLDER and run the command:
it makes only what is missing.
"""


def again_lines(register, digest, name, folder, record, experts=None):
    """Makes one cell, if it is not in the folder; the hash of its episodes, and what the committed record has."""
    (cell,) = {cell for group in register["groups"] for cell in cells_of(register, group) if cell.name == name} or (
        None,
    )
    if cell is None:
        raise SystemExit(f"no cell of the register is named {name}: copy the name from a record's {compact.FILE}")
    if not (folder / cell.name).exists():
        with threadpool_limits(1):
            make(register, digest, cell, folder, experts)
    recorded = kept_in(RECORDS / record).get(name, {}).get("sha256", "none")
    return [f"{made(digest, cell, folder)['sha256']}  {name}", f"{recorded}  in the committed record"]


def main():
    """Makes what is missing, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--register",
        default="published",
        help="published, steps, splits, factorial, random-experts, more-experts, learner-experts, learner-more-experts",
    )
    parser.add_argument("--plan", action="store_true", help="print cells, CPU time and power")
    parser.add_argument("--tables", action="store_true", help="make nothing")
    parser.add_argument("--cells", type=Path, help="where cells lie")
    parser.add_argument("--experts", type=Path, default=Path(FOLDER.format("experts")), help="where their runs lie")
    parser.add_argument("--train", action="store_true", help="train the experts that are missing, and make no cell")
    parser.add_argument("--groups", help="names, separated by commas; all others are left for another time")
    parser.add_argument("--cell", help="the only one that is made, by its name in a record")
    parser.add_argument("--record", type=Path, help="where the record is written")
    given = parser.parse_args()
    register, digest = read_register(given.register)
    folder = given.cells or Path(FOLDER.format(given.register))
    if given.plan:
        print("\n".join(plan_lines(register)))
        return
    if given.cell:
        print("\n".join(again_lines(register, digest, given.cell, folder, given.register, given.experts)))
        return
    wanted = given.groups.split(",") if given.groups else [group["name"] for group in register["groups"]]
    if given.train:
        groups = [group for group in register["groups"] if group["name"] in wanted]
        for game, label, card in train_missing(register, given.experts, groups):
            print(f"{time.strftime('%H:%M:%S')}  {game} {label}, {card['seconds']:.0f} s", flush=True)
        return
    with threadpool_limits(1):
        for group in register["groups"] if not given.tables else []:
            for cell in cells_of(register, group) if group["name"] in wanted else []:
                if made(digest, cell, folder) is None:
                    make(register, digest, cell, folder, given.experts)
                    print(f"{time.strftime('%H:%M:%S')}  {cell.name}", flush=True)
    found = Found(register, digest, folder)
    print("\n".join(table_lines(register, found, each=True)))
    if given.record:
        recorded(register, digest, found, given.record)


if __name__ == "__main__":
    main()
