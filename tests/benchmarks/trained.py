"""Experts that a register has trained, so that the expert can be the unit: which these are, and where their runs lie.

Does: finds the recipe behind a label such as mappo-200, trains what is missing, and goes on with what was interrupted.
Assumes: the extra `maviper[train]` where something is trained; a run's folder is that of one register.
Does not: extract, judge, or choose among experts: all seeds of a recipe count.
"""

from codegen.errors import InputError
from maviper.console import Console
from maviper.experts.finding import find_expert
from maviper.experts.training.train import CARD_FILE, train_expert
from maviper.files import runs


def recipe_of(register, label):
    """The recipe and seed of a label, None for a shipped expert's."""
    name, _, seed = label.rpartition("-")
    recipe = register.get("trained", {}).get(name)
    return (recipe, int(seed)) if recipe and seed.isdecimal() and int(seed) in recipe["seeds"] else None


def labels_of(register):
    """All experts of all recipes."""
    return [f"{name}-{seed}" for name, recipe in register.get("trained", {}).items() for seed in recipe["seeds"]]


def tree_seeds_of(register, expert):
    """The seeds of an expert's trees: each trained expert has its own, and so its own held-out episodes."""
    seeds, labels = register["seeds"], labels_of(register)
    place = labels.index(expert) if expert in labels else 0
    return [seed + place * len(seeds) for seed in seeds]


def runs_of(register, groups):
    """The runs that groups play, as (game, label), each once."""
    known = labels_of(register)
    return list(dict.fromkeys((each["game"], label) for each in groups for label in each["experts"] if label in known))


def run_of(folder, game, label):
    """The run folder of an expert."""
    return folder / f"{game}.{label}"


def find_trained(folder, game, label):
    """The expert of a finished run, and its world."""
    run = run_of(folder, game, label)
    if not (run / CARD_FILE).exists():
        raise InputError(
            f"the expert {label} of {game} is not trained", str(run), "train it first, with --train FOLDER"
        )
    return find_expert(str(run))


def train_missing(register, folder, groups):
    """Trains what is missing in groups, one after the other; yields the game, the label and the card of each expert."""
    for game, label in runs_of(register, groups):
        recipe, seed = recipe_of(register, label)
        run, options = run_of(folder, game, label), recipe["options"][game]
        resume = runs.holds_run(run)
        yield game, label, train_expert(game, run, Console(quiet=True), **options, seed=seed, resume=resume)
