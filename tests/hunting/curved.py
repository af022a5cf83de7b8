"""Random systems whose rules are curved: a world file, and what it states as plain data for the judge.

Does: rules with squares and products of two variables, within ranges; actions that push, errors.
Assumes: the judge (stated.py) knows products.
Does not: ask anything.
"""

from fractions import Fraction as F

from tests.support.system_cases import policy, team
from tests.verify.reach.random_systems import affine, nested, some
from verify.systems.files import statement_of

RANGE = F(4)
NAMES = ("x", "y")
ACTIONS = ("go", "rest", "back")
FACTORS = (F(-1, 2), F(1, 2), F(3, 4), F(1, 4))
BENT = (F(1, 8), F(-1, 8), F(1, 4))
PUSHES = (F(1, 8), F(-1, 8), F(1, 2), F(-1, 2), F(0))
ERROR = F(1, 64)
CUTS = 4


def _rule(random):
    """A rule: multiples of variables and of products."""
    terms = {name: some(random, FACTORS) for name in NAMES if random.random() < 0.7} or {"x": F(1, 2)}
    products = [(some(random, BENT), [some(random, NAMES), some(random, NAMES)])] if random.random() < 0.8 else []
    return {"constant": "0", "terms": {name: str(weight) for name, weight in terms.items()}, "products": products}


def _written(form):
    """A sum as a world file has it."""
    found = [f"({weight})*{name}" for name, weight in form["terms"].items()]
    found += [f"({weight})*{'*'.join(names)}" for weight, names in form.get("products", ())]
    return " + ".join([f"({form['constant']})", *found])


def _plain(form):
    return {"constant": str(form.constant), "terms": {name: str(weight) for name, weight in form.terms}}


def case(random):
    """(statement, team, the plain data of the system)."""
    features = {f"f{number}": _plain(affine(random, NAMES)) for number in range(2)}
    pushed, rules = some(random, NAMES), {name: _rule(random) for name in NAMES}
    pushes = {action: some(random, PUSHES) for action in ACTIONS}
    errors = {name: ERROR for name in NAMES if random.random() < 0.4}
    middles = {name: F(int(random.integers(-4, 5)), 4) for name in NAMES}
    half = some(random, [F(1, 16), F(1, 4), F(1, 2)])
    lines = ['name = "curved"', "steps = 6", "[variables]"]
    lines += [f'{name} = {{ range = ["{-RANGE}", "{RANGE}"] }}' for name in NAMES]
    lines += ["[agents.a.features]", *(f'{name} = "{_written(form)}"' for name, form in features.items())]
    lines += ["[agents.a.actions]", *(f'{name} = {{ push = "{push}" }}' for name, push in pushes.items())]
    starts = [f'{name} = ["{middles[name] - half}", "{middles[name] + half}"]' for name in NAMES]
    lines += [f"[start]\nbox = {{ {', '.join(starts)} }}", "[dynamics.cuts]", *(f"{name} = {CUTS}" for name in NAMES)]
    lines += ["[dynamics.error]", *(f'{name} = "{error}"' for name, error in errors.items())]
    lines += ["[dynamics.next]"]
    lines += [f'{name} = "{_written(rule)}{" + a.push" * (name == pushed)}"' for name, rule in rules.items()]
    tree = nested(random, 3, 2, len(ACTIONS))
    return (
        statement_of("\n".join(lines), "curved"),
        team(policy("a", list(features), ACTIONS, tree)),
        {
            "variables": [[name, "1", str(-RANGE), str(RANGE)] for name in NAMES],
            "features": {
                "a": {name: {"form": form, "measure": "value", "bounds": None} for name, form in features.items()}
            },
            "start": [
                {"most": {"constant": str(sign * -middles[name] - half), "terms": {name: str(sign)}}}
                for name in NAMES
                for sign in (1, -1)
            ],
            "pieces": [
                {
                    "where": {name: [str(-RANGE), str(RANGE)] for name in NAMES},
                    "move": rules,
                    "effect": [
                        ["a", action, {pushed: {"constant": str(push), "terms": {}}}] for action, push in pushes.items()
                    ],
                    "error": {name: [str(-error), str(error)] for name, error in errors.items()},
                }
            ],
        },
    )
