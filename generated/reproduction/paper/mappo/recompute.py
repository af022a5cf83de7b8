"""Computes the report's numbers and words again, from its files or from cells.json.xz (needs numpy): python recompute.py [FOLDER]"""
import csv, functools, json, lzma, pathlib, sys
import numpy as np

np.seterr(all="ignore")  # a ratio to nothing is no number
AT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
RECORD = json.loads(lzma.open(AT / "cells.json.xz").read()) if (AT / "cells.json.xz").exists() else {}
if "numbers" not in RECORD and not (AT / "numbers.json").exists():
    sys.exit(f"{AT} holds no numbers and no episodes: play them again in a folder (README.md has the command), which gets this script too")
NUMBERS = RECORD["numbers"] if RECORD else json.loads((AT / "numbers.json").read_text())  # what each is made of
FACTS = functools.cache(lambda cell: RECORD["cells"][cell]["facts"] if RECORD else json.loads((AT / "cells" / cell / "facts.json").read_text()))
TABLE = functools.cache(lambda cell: list(csv.reader((AT / "cells" / cell / "episodes.csv").open()))[1:])
DRAWS = functools.cache(lambda seeds, n: ((rng := np.random.default_rng([17, seeds, n])).integers(0, seeds, (2000, seeds)),
    np.stack([np.bincount(rng.integers(0, n, n), minlength=n) for _ in range(2000)]) / n))  # seeds drawn, each episode's share
MODES = {"value": lambda a, b, c: a, "ratio": lambda a, b, c: a / b, "inverse": lambda a, b, c: b / a}
MODES |= {"reward": lambda a, b, c: 1 + (a - b) / c, "paper": lambda a, b, c: abs(abs(b) - abs(a)) / b}

@functools.cache
def episodes(cell, lineup, measure, size=float):  # {episode: value, or its size}; a record has their mean in each
    if not RECORD:
        parts = [(int(row[2]), row[3:]) for row in TABLE(cell) if row[:2] == [lineup, measure]]
        return {first + k: size(float(value)) for first, values in parts for k, value in enumerate(values)}
    told = RECORD["cells"][cell]["values"][lineup][measure]
    values = told.get("values") or [told["mean"] if size is float else told.get("size", told["mean"])] * told["count"]
    return dict(zip(told.get("episodes") or range(told["first"], told["first"] + told["count"]), map(size, values)))

def by_seed(source, size=float):  # {episode: value} of each seed; of facts, a weighted sum
    if not source["facts"]:
        return [episodes(cell, lineup, source["measure"], size) for cell, lineup in source["places"]]
    told, sign = [FACTS(cell) for cell, _ in source["places"]], abs if source["absolute"] else float
    return [{0: size(sign(sum(w * functools.reduce(dict.__getitem__, p, of) for w, p in source["facts"])))} for of in told]

def estimate(parts):  # value, standard error by the bootstrap, degrees of freedom
    rows = [by_seed(part["ours"]) for part in parts]
    seen = [sorted(set.intersection(*(set(each[k]) for each in rows))) for k in range(len(rows[0]))]
    seeds, count = len(seen), min(map(len, seen))
    table = lambda rows: np.array([list(map(row.__getitem__, wanted[:count])) for row, wanted in zip(rows, seen)])
    (drawn, counts), even = DRAWS(seeds, count), np.full((1, count), 1 / count)
    shared = all(each[:count] == seen[0][:count] for each in seen)  # all seeds played the same episodes
    pairs = [(part, table(mine), *(table(by_seed(part["theirs"] or part["ours"], size)) for size in (float, abs)))
             for mine, part in zip(rows, parts)]
    whole, every = (sum(p["weight"] * MODES[p["mode"]](w @ a.T, w @ b.T, w @ c.T) for p, a, b, c in pairs)
                    for w in (even, counts if shared else even))
    every, n = np.take_along_axis(np.broadcast_to(every, drawn.shape), drawn, 1).mean(1), seeds if seeds > 1 else count
    return whole.mean(), every.std(ddof=1) * (n / (n - 1)) ** .5 if n > 1 else np.nan, n - 1

@functools.cache
def student(n):  # values of t and its distribution function; t is the tangent of an angle
    angle = np.linspace(-np.pi / 2, np.pi / 2, 400_001)
    mass = np.cumsum(np.cos((angle[1:] + angle[:-1]) / 2) ** (n - 1))
    return np.tan(angle[1:-1]) * n ** .5, mass[:-1] / mass[-1]

def p_above(number, bound, sign=1):  # one-sided; for sign -1 that of lying below
    value, error, n = NUMBER[number]
    if n < 1 or not np.isfinite(value):
        return 1.0
    return float(np.interp(sign * (bound - value) / error, *student(n)) if error >= 1e-12 else sign * (value - bound) <= 0)

def tests(claim, compared):  # p of each test
    name, bound = compared["number"], claim["bound"] or 0.0
    above, below = (functools.partial(p_above, name, sign=sign) for sign in (1, -1))
    told = {"differs": lambda: min(1.0, 2 * min(above(0.0), below(0.0))), "above": lambda: above(bound), "below": lambda: below(bound),
            "equal": lambda: max(above(-CLAIMS["margin"]), below(CLAIMS["margin"]))}
    return {test: told[test]() for test in compared.get("p", {})}

def words(family):  # of each comparison, after Holm's correction within its family, and of each claim
    asked = [(k, test, p) for k, (claim, each) in enumerate(family) for test, p in tests(claim, each).items()]
    least, adjusted, at_once = 0.0, [{} for _ in family], len({k for k, *_ in asked})
    for rank, (k, test, p) in enumerate(sorted(asked, key=lambda each: each[2])):
        adjusted[k][test] = least = max(least, min(1.0, min(len(asked) - rank, at_once) * p))
    for (_, each), p in zip(family, adjusted):
        low, number = [test for test in ("equal", "differs", "above", "below") if p.get(test, 1.0) <= CLAIMS["alpha"]], each["number"]
        enough = number and each["seeds"] >= CLAIMS["least_seeds"]
        word = (low[0] if low[0] != "differs" else "better" if NUMBER[number][0] > 0 else "worse") if enough and low else "not decided"
        yield word if number else "not run"

def verdict(claim, found):
    yes = {"greater": ["better"], "some above": ["above"], "second best": ["better", "equal"]}.get(claim["test"], [claim["test"]])
    good, bad = [word in yes for word in found], [word not in (*yes, "not decided", "not run") for word in found]
    good, bad = ([any(good)], [bool(bad) and all(bad)]) if claim["test"] == "some above" else (good, bad)
    if claim["test"] == "second best":  # at each opponent all but one are no better
        at = [each["label"].partition(", ")[2] for each in claim["comparisons"]]
        groups = [[k for k, there in enumerate(at) if there == place] for place in dict.fromkeys(at)]
        good, bad = [sum(good[k] for k in of) >= len(of) - 1 for of in groups], [sum(bad[k] for k in of) > 1 for of in groups]
    return "DIFFERS" if any(bad) else "AGREES" if good and all(good) else "NOT DECIDED"

pairs = [(" ".join(list(row.values())[:12]), np.mean(list(episodes(row["cell"], row["lineup"], row["measure"]).values())),
          float(row["mean"])) for row in ([] if RECORD else csv.DictReader((AT / "cells.csv").open()))]  # what, ours, the report's
NUMBER = {name: estimate(told["parts"]) for name, told in NUMBERS.items()}
for name, (value, error, n) in NUMBER.items():
    told, half = NUMBERS[name], np.interp(.975, *student(n)[::-1]) * error if n else np.inf
    pairs += [(name, value, told["value"]), (name, value - half, told["low"]), (name, value + half, told["high"])]
off = [f"{name}: {ours}, the report has {told}" for name, ours, told in pairs if np.isfinite(ours) != (told is not None)
       or told is not None and abs(ours - told) > 1e-6 * max(1, abs(told))]
CLAIMS = json.loads((AT / "claims.json").read_text())
families, judged = {}, [claim for claim in CLAIMS["claims"] if claim["test"] != "number"]
for claim in judged:
    families.setdefault((claim["expert"], claim["family"]), []).extend((claim, each) for each in claim["comparisons"])
told = {id(each): word for family in families.values() for (_, each), word in zip(family, words(family))}
for claim in judged:
    found = [told[id(each)] for each in claim["comparisons"]]
    said = [(f"{claim['id']}: {each['label']}", word, each["word"]) for each, word in zip(claim["comparisons"], found)]
    said += [(claim["id"], verdict(claim, found), claim["verdict"])]
    off += [f"{name}: {ours}, the report has {theirs}" for name, ours, theirs in said if ours != theirs]
print(*off, f"{len(NUMBERS)} numbers and {len(judged)} verdicts computed again, {len(off)} come out otherwise", sep="\n")
sys.exit(bool(off))
