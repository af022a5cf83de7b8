"""Names that odd texts of the language speak of: agents and actions with words for names, variables with units."""

from fractions import Fraction

import numpy as np

from codegen.ir import NO_CHILD, NO_FEATURE, ActionSpec, AgentPolicy, Tree
from verify.claims.wording import formula_document
from verify.claims.written import Vocabulary, formula_of
from verify.language.units import Typed, format_unit, unit_of
from verify.systems.expressions import Call, Name, Number, Power
from verify.systems.parsing import Names, expression_of, half_spaces

EFFECTS = {"stay": (0.0, 0.0), "left": (-1.0, 0.0), "right": (1.0, 0.0), "up": (0.0, 1.0)}
LEAF = Tree(*(np.array([number]) for number in (NO_FEATURE, 0, NO_CHILD, NO_CHILD, 0)))


def acting(**actions):
    return {
        name.replace("_", "-"): AgentPolicy(
            name.replace("_", "-"), "team", (), tuple(ActionSpec(one, EFFECTS.get(one, (0.0, 0.0))) for one in of), LEAF
        )
        for name, of in actions.items()
    }


MARKS = ("landmark_0", "landmark_1")
ENTITIES = ("a", "b", "in-between", *MARKS, "goal", "not", "or")
GAME = Vocabulary(
    (*(f"{entity}.{axis}" for entity in ENTITIES for axis in "xy"), "b.vx", "x"),
    acting(
        a=["stay", "left", "right", "in", "true"],
        b=["left", "right", "not", "stay", "goal", "x"],
        in_between=["up", "stay"],
    ),
    ENTITIES,
    MARKS,
    Fraction(1, 8),
    Fraction(1, 4),
)
UNITS = {
    name: unit_of(unit, "")
    for name, unit in (("x", "m"), ("v", "m/s"), ("cart.y", "m"), ("max", ""), ("implies", "m"), ("true", "s"))
}
CONSTANTS = {
    "dt": Typed(Fraction(1, 5), unit_of("s", "")),
    "g": Typed(Fraction(98, 10), unit_of("m/s^2", "")),
    "k": Typed(Fraction(3), unit_of("", "")),
}
STATED = Vocabulary(tuple(UNITS), acting(cart=["left", "right", "stay", "x"]), units=UNITS, constants=CONSTANTS)
NAMES = Names(
    {**UNITS, "cart.a": unit_of("m/s^2", "")},
    {name: Typed(Number(value), unit) for name, (value, unit) in CONSTANTS.items()},
)


def spelled(expression):
    """An expression with parentheses around all that it is made of."""
    match expression:
        case Number(value):
            return str(value)
        case Name(name):
            return name
        case Power(base, exponent):
            return f"({spelled(base)} ** {exponent})"
        case Call(function, argument, bounds):
            return f"{function}({', '.join([spelled(argument), *map(str, bounds or ())])})"
        case _:
            sign = {"Sum": "+", "Product": "*", "Quotient": "/"}[type(expression).__name__]
            return f"({spelled(expression.left)} {sign} {spelled(expression.right)})"


def expression(text):
    found = expression_of(text, NAMES, "here")
    return [spelled(found.value), None if found.unit is None else format_unit(found.unit)]


def condition(text):
    return [
        [
            "<" if half.strict else "<=",
            str(half.form.constant),
            *(f"{factor}*{name}" for name, factor in half.form.terms),
        ]
        for half in half_spaces(text, NAMES, "here")
    ]


READERS = {
    "game": lambda text: formula_document(formula_of(text, GAME, str)),
    "stated": lambda text: formula_document(formula_of(text, STATED, str)),
    "expression": expression,
    "condition": condition,
}
