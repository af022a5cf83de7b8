"""The language of formulas: texts mean what a plain evaluator says; whatever else a text holds is an error in words."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen.errors import InputError
from verify.claims.formula import Goal, for_goal, holds, negate, normal
from verify.claims.written import FUNCTIONS, WORDS, Vocabulary, formula_of

AGENTS, MARKS = ("agent_0", "agent_1"), ("landmark_0", "landmark_1")
ENTITIES = (*AGENTS, *MARKS, "goal")
COORDINATES = tuple(f"{name}.{axis}" for name in ENTITIES for axis in "xy")
ACTIONS = ("stay", "left", "right", "down", "up")
MARGIN, RADIUS = Fraction(1, 8), Fraction(1, 4)


@pytest.fixture(scope="module")
def vocabulary(profile):
    policies = {policy.agent: policy for policy in profile.agents}
    return Vocabulary(COORDINATES, policies, ENTITIES, MARKS, MARGIN, RADIUS)


def read(text, vocabulary):
    return formula_of(text, vocabulary, lambda place: f"column {place + 1}")


# --- a generator of texts, each with what it means: a function of (coordinates, actions, goal)


NUMBERS = st.sampled_from(["0", "1", "0.25", "1/4", "3", ".5", "2.5e-1"])
NAMED = st.sampled_from(ENTITIES)
ARROWS = {"stay": (0, 0), "left": (-1, 0), "right": (1, 0), "down": (0, -1), "up": (0, 1)}


def apart(at, a, b):
    return max(abs(at[f"{a}.{axis}"] - at[f"{b}.{axis}"]) for axis in "xy")


def ahead(at, action, agent, mark):
    return sum(u * (at[f"{mark}.{axis}"] - at[f"{agent}.{axis}"]) for u, axis in zip(ARROWS[action], "xy", strict=True))


@st.composite
def plain_sums(draw):
    """(text, function) of a linear sum."""
    kind = draw(st.sampled_from(["number", "coordinate", "scaled", "added", "minus"]))
    if kind == "number":
        number = draw(NUMBERS)
        return number, lambda at, number=number: Fraction(number)
    if kind in ("coordinate", "scaled"):
        name, number = draw(st.sampled_from(COORDINATES)), draw(NUMBERS)
        if kind == "coordinate":
            return name, lambda at: at[name]
        way = draw(st.sampled_from(["{n} * {c}", "{c} * {n}", "{c} / (1 + {n})"]))
        factor = 1 / (1 + Fraction(number)) if "/ (" in way else Fraction(number)
        return way.format(n=number if "/" not in number else f"({number})", c=name), lambda at: factor * at[name]
    (a, f), (b, g) = draw(plain_sums()), draw(plain_sums())
    if kind == "minus":
        return f"-({a})", lambda at: -f(at)
    sign = draw(st.sampled_from("+-"))
    return f"{a} {sign} ({b})", lambda at: f(at) + g(at) if sign == "+" else f(at) - g(at)


@st.composite
def sums(draw):
    """As `plain_sums`, with distances and extremes in them."""
    kind = draw(st.sampled_from(["plain", "plain", "distance", "bars", "abs", "max", "min", "scaled", "added"]))
    if kind == "distance":
        a, b = draw(NAMED), draw(NAMED)
        return f"distance({a}, {b})", lambda at: apart(at, a, b)
    if kind in ("scaled", "added"):
        (a, f), (b, g) = draw(sums()), draw(plain_sums())
        if kind == "added":
            return f"({a}) - ({b})", lambda at: f(at) - g(at)
        number = draw(st.integers(-2, 2))
        return f"{number} * ({a})", lambda at: number * f(at)
    (a, f), (b, g) = draw(plain_sums()), draw(plain_sums())
    if kind == "plain":
        return a, f
    if kind in ("bars", "abs"):
        return (f"|{a}|" if kind == "bars" else f"abs({a})"), lambda at: abs(f(at))
    join = max if kind == "max" else min
    return f"{kind}({a}, {b})", lambda at: join(f(at), g(at))


SIGNS = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "!=": lambda a, b: a != b,
}  # fmt: skip


@st.composite
def relations(draw):
    kind = draw(st.sampled_from(["compare", "compare", "chain", "acts", "in", "both", "goal", "predicate", "word"]))
    if kind == "compare":
        (a, f), (b, g), sign = draw(sums()), draw(sums()), draw(st.sampled_from(sorted(SIGNS)))
        return f"{a} {sign} {b}", lambda at, acts, goal: SIGNS[sign](f(at), g(at))
    if kind == "chain":
        (a, f), (b, g), (c, h) = draw(sums()), draw(plain_sums()), draw(sums())
        return f"{a} <= {b} < {c}", lambda at, acts, goal: f(at) <= g(at) < h(at)
    if kind == "word":
        word = draw(st.sampled_from(["true", "false"]))
        return word, lambda at, acts, goal: word == "true"
    agent, action = draw(st.sampled_from(AGENTS)), draw(st.sampled_from(ACTIONS))
    if kind == "acts":
        sign = draw(st.sampled_from(["==", "!="]))
        return f"acts({agent}) {sign} {action}", lambda at, acts, goal: SIGNS[sign](acts[agent], action)
    if kind == "both":
        return "acts(agent_0) == acts(agent_1)", lambda at, acts, goal: acts["agent_0"] == acts["agent_1"]
    if kind == "in":
        some, way = draw(st.lists(st.sampled_from(ACTIONS), min_size=1)), draw(st.sampled_from(["in", "not in"]))
        text = f"acts({agent}) {way} [{', '.join(some)}]"
        return text, lambda at, acts, goal: (acts[agent] in some) == (way == "in")
    mark = draw(st.sampled_from(MARKS))
    if kind == "goal":
        return draw(st.sampled_from([f"goal == {mark}", f"{mark} == goal"])), lambda at, acts, goal: goal == mark
    mark = draw(st.sampled_from([*MARKS, "goal", *(other for other in AGENTS if other != agent)]))
    name, bound = draw(st.sampled_from(["closes", "engaged", "at"])), draw(st.sampled_from(["", "0.5"]))

    def true(at, acts, goal):
        margin = Fraction(bound) if bound and name != "at" else MARGIN
        radius = Fraction(bound) if bound and name == "at" else RADIUS
        closing = ahead(at, acts[agent], agent, mark) > margin
        near = apart(at, agent, mark) <= radius
        return {"closes": closing, "at": near, "engaged": closing or near}[name]

    return f"{name}({agent}, {mark}{', ' + bound if bound else ''})", true


@st.composite
def claims(draw, depth=3):
    kind = draw(st.sampled_from(["relation", "not", "and", "or", "implies"])) if depth else "relation"
    if kind == "relation":
        return draw(relations())
    (a, f), (b, g) = draw(claims(depth=depth - 1)), draw(claims(depth=depth - 1))
    if kind == "not":
        return f"not ({a})", lambda *given: not f(*given)
    true = {
        "and": lambda *given: f(*given) and g(*given),
        "or": lambda *given: f(*given) or g(*given),
        "implies": lambda *given: not f(*given) or g(*given),
    }[kind]
    return f"({a}) {kind}\n ({b})", true


EIGHTHS = st.integers(-8, 8).map(lambda n: Fraction(n, 8))
PLACES = st.fixed_dictionaries(dict.fromkeys([name for name in COORDINATES if not name.startswith("goal")], EIGHTHS))
CHOSEN = st.fixed_dictionaries(dict.fromkeys(AGENTS, st.sampled_from(ACTIONS)))


@settings(max_examples=150)
@given(claims(), st.lists(st.tuples(PLACES, CHOSEN, st.sampled_from(MARKS)), min_size=1, max_size=6))
def test_formulas_mean_what_they_say(vocabulary, claim, states):
    text, true = claim
    try:
        found = read(text, vocabulary)
    except InputError as error:
        assert "cases" in error.what, (text, str(error))  # a comparison of many distances is refused
        return
    for place, acts, goal in states:
        at = place | {f"goal.{axis}": place[f"{goal}.{axis}"] for axis in "xy"}
        numbers = {agent: ACTIONS.index(action) for agent, action in acts.items()}
        wanted = true(at, acts, goal)
        assert holds(for_goal(found, goal), at, numbers) is wanted, text
        assert holds(for_goal(normal(found), goal), place, numbers) is wanted, text
        assert holds(for_goal(negate(found), goal), place, numbers) is not wanted, text


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("not true and false or true", "((not true) and false) or true"),
        ("false implies false implies false", "false implies (false implies false)"),
        ("true or true and false", "true or (true and false)"),
        ("agent_0.x + 1 * 2 - 3 < 0", "(agent_0.x + (1 * 2)) - 3 < 0"),
        ("not acts(agent_1) == up", "acts(agent_1) != up"),
        ("acts(agent_0) in [left, stay] implies not acts(agent_1) == up",
         "acts(agent_0) not in [left, stay] or acts(agent_1) != up"),
        ("|agent_0.x - agent_1.x| >= 0.3", "max(agent_0.x - agent_1.x, agent_1.x - agent_0.x) >= 3/10"),
        ("- - 1 < agent_0.x", "1 < agent_0.x"),
    ],
)  # fmt: skip
def test_words_bind_as_documented(vocabulary, text, same):
    assert read(text, vocabulary) == read(same, vocabulary)


def test_the_goal_is_a_name_and_a_place(vocabulary):
    assert read("goal == landmark_1", vocabulary) == Goal("landmark_1")
    nowhere = for_goal(read("goal == landmark_0 and distance(goal, landmark_0) > 0", vocabulary), "landmark_0")
    assert nowhere == read("false", vocabulary)


def test_names_with_a_dash_stand_in_quotes(vocabulary):
    from dataclasses import replace

    dashed = replace(vocabulary, entities=("left-wing", "goal"), coordinates=("left-wing.x",))
    assert read("'left-wing'.x > 1", dashed) == read("1 < 'left-wing'.x", dashed)


ERRORS = [
    ("", 1, "ends too early"), ("agent_0.x >", 12, "ends too early"), ("(agent_0.x > 1", 15, "expected ')'"),
    ("agent_0.x > 1)", 14, "cannot go on"), ("closes(agnt_0, landmark_0)", 8, "did you mean 'agent_0'"),
    ("closes(agent_0, landmrk_1)", 17, "did you mean 'landmark_1'"), ("acts(agent_0) == lft", 18, "mean 'left'"),
    ("acts(agent_0) in [left, upp]", 25, "mean 'up'"), ("agent_0.z > 0", 1, "did you mean 'agent_0."),
    ("closs(agent_0, goal)", 1, "mean 'closes'"), ("agent_0 > 1", 1, "write agent_0.x"),
    ("agent_0.x * agent_1.x > 1", 11, "linear"), ("1 / agent_0.x > 1", 3, "linear"), ("agent_0.x / 0 > 1", 11, "zero"),
    ("agent_0.x ** 2 > 1", 11, "linear"), ("agent_0.x = 1", 11, "write =="), ("true && false", 6, "write and"),
    ("agent_0.x > 1 => true", 15, "write implies"), ("5", 1, "a number is no claim"), ("goal", 1, "unknown word"),
    ("acts(agent_0)", 1, "write acts(agent_0) == ACTION"), ("agent_0 == agent_1", 9, "only the goal"),
    ("goal == agent_0", 9, "unknown landmark"), ("goal < landmark_0", 6, "not ordered"), ("true > 1", 1, "no number"),
    ("at(agent_0, agent_0)", 13, "itself"), ("at(agent_0, goal, -1)", 19, "not negative"),
    ("max(|agent_0.x|, 1) > 0", 5, "do not nest"), ("1e999999999 < agent_0.x", 1, "not a number"),
    ("9999999999 < agent_0.x", 1, "at most"), ("import os", 8, "operator may stand here"),
    ("agent_0.x > 1 or", 17, "too early"),
    ("__import__('os')", 1, "unknown function"), ("agent_0.x > \u0661", 13, "cannot read"), ("(" * 99, 42, "nested"),
    ("not " * 30 + "(" * 50 + "true", 162, "nested"), ("|" * 99, 42, "nested"),
    ("true" + " implies true" * 99, 534, "nested"),
    ("+".join(["distance(agent_0, agent_1)"] * 9) + " > 1", 244, "cases"), ("x" * 100_001, 1, "at most 100000"),
    ("agent_0.x " + "* 1e-900 " * 3 + "> 1", 20, "too long"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "column", "words"), ERRORS)
def test_errors_tell_the_place_and_what_to_do(vocabulary, text, column, words):
    with pytest.raises(InputError) as error:
        read(text, vocabulary)
    assert words in str(error.value)
    told, line, mark = error.value.where.split("\n")
    assert told == f"column {column}" and mark.strip() == "^"
    marked = line[mark.index("^") : mark.index("^") + 1]
    assert marked.strip() in (text[column - 1 : column].strip(), "\\")


PIECES = st.sampled_from(
    [
        *WORDS,
        *FUNCTIONS,
        *ENTITIES,
        *COORDINATES,
        *ACTIONS,
        *"()[]|,+-*/<>=!.'\"\n",
        "==",
        "<=",
        "1",
        "1/4",
        "x",
        "\x00",
    ]
)


@settings(max_examples=200)
@given(st.one_of(st.text(max_size=60), st.lists(PIECES, max_size=25).map(" ".join), st.lists(PIECES).map("".join)))
def test_any_text_is_a_formula_or_an_error_in_words(vocabulary, text):
    try:
        found = read(text, vocabulary)
    except InputError as error:
        assert error.what and error.where
        return
    place = dict.fromkeys([name for name in COORDINATES if not name.startswith("goal")], Fraction(0))
    assert holds(for_goal(found, "landmark_0"), place, {"agent_0": 0, "agent_1": 0, "adversary_0": 0}) in (True, False)
