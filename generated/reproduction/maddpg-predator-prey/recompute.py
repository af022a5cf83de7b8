"""Computes the report's numbers again from episodes/ and facts/ (needs numpy): python recompute.py [FOLDER]"""
import csv, functools, json, lzma, pathlib, sys
import numpy as np

np.seterr(all="ignore")  # a ratio to nothing is no number
AT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
if not (AT / "numbers.json").exists():
    sys.exit(f"{AT} holds no numbers.json and no episodes/: unpack episodes.tar.xz there, or play them again (README.md has the command)")
NUMBERS = json.loads((AT / "numbers.json").read_text())  # what each is made of
FACTS = functools.cache(lambda cell: json.loads((AT / "facts" / f"{cell}.json").read_text()))
DRAWS = functools.cache(lambda seeds, n: ((rng := np.random.default_rng([17, seeds, n])).integers(0, seeds, (2000, seeds)),
    np.stack([np.bincount(rng.integers(0, n, n), minlength=n) for _ in range(2000)]) / n))  # seeds drawn, each episode's share
MODES = {"value": lambda a, b, c: a, "ratio": lambda a, b, c: a / b, "inverse": lambda a, b, c: b / a}
MODES |= {"reward": lambda a, b, c: 1 + (a - b) / c, "paper": lambda a, b, c: abs(abs(b) - abs(a)) / b}

@functools.cache
def episodes(cell):  # {(line-up, measure): {episode: value}}
    found = {}
    for lineup, measure, first, *values in list(csv.reader((AT / "episodes" / f"{cell}.csv").open()))[1:]:
        found.setdefault((lineup, measure), {}).update(enumerate(map(float, values), int(first)))
    return found

def by_seed(source):  # {episode: value} of each seed; of facts, a weighted sum
    if not source["facts"]:
        return [episodes(cell)[lineup, source["measure"]] for cell, lineup in source["places"]]
    told, size = [FACTS(cell) for cell, _ in source["places"]], abs if source["absolute"] else float
    return [{0: size(sum(w * functools.reduce(dict.__getitem__, p, of) for w, p in source["facts"]))} for of in told]

def estimate(parts):  # value, standard error by the bootstrap, degrees of freedom
    rows = [by_seed(part["ours"]) for part in parts]
    seen = [sorted(set.intersection(*(set(each[k]) for each in rows))) for k in range(len(rows[0]))]
    seeds, count = len(seen), min(map(len, seen))
    table = lambda rows: np.array([[row[k] for k in wanted[:count]] for row, wanted in zip(rows, seen)])
    (drawn, counts), even = DRAWS(seeds, count), np.full((1, count), 1 / count)
    shared = all(each[:count] == seen[0][:count] for each in seen)  # all seeds played the same episodes
    pairs = [(part, table(mine), table(by_seed(part["theirs"] or part["ours"]))) for mine, part in zip(rows, parts)]
    whole, every = (sum(p["weight"] * MODES[p["mode"]](w @ a.T, w @ b.T, w @ abs(b).T) for p, a, b in pairs)
                    for w in (even, counts if shared else even))
    every, n = np.take_along_axis(np.broadcast_to(every, drawn.shape), drawn, 1).mean(1), seeds if seeds > 1 else count
    return whole.mean(), every.std(ddof=1) * (n / (n - 1)) ** .5 if n > 1 else np.nan, n - 1

@functools.cache
def student(n):  # values of t and its distribution function; t is the tangent of an angle
    angle = np.linspace(-np.pi / 2, np.pi / 2, 400_001)
    mass = np.cumsum(np.cos((angle[1:] + angle[:-1]) / 2) ** (n - 1))
    return np.tan(angle[1:-1]) * n ** .5, mass[:-1] / mass[-1]

tables = ((lzma.open if at.suffix == ".xz" else open)(at, "rt", encoding="utf-8") for at in sorted(AT.glob("cells.csv*")))
pairs = [(" ".join(list(row.values())[:12]), np.mean(list(episodes(row["cell"])[row["lineup"], row["measure"]].values())),
          float(row["mean"])) for row in csv.DictReader(next(tables))]  # what, ours, the report's
for name, told in NUMBERS.items():
    value, error, n = estimate(told["parts"])
    half = np.interp(.975, *student(n)[::-1]) * error if n else np.inf
    pairs += [(name, value, told["value"]), (name, value - half, told["low"]), (name, value + half, told["high"])]
off = [f"{name}: {ours}, the report has {told}" for name, ours, told in pairs if np.isfinite(ours) != (told is not None)
       or told is not None and abs(ours - told) > 1e-6 * max(1, abs(told))]
print(*off, f"{len(NUMBERS)} numbers computed again, {len(off)} come out otherwise", sep="\n")
sys.exit(bool(off))
