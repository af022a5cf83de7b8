"""Questions as VNN-LIB 2.0, the language of tools that verify neural networks: one network an agent.

Does: writes, for each claim about decisions and each goal, a query that is satisfiable iff the claim fails somewhere in
  the region; the networks that it is about, as ONNX.
Assumes: meanings that are sums of coordinates, or functions of one; the package onnx.
Does not: solve anything, or know roundings: the queries are of real arithmetic. The reading of the agents' inputs, `X`,
  from the world state, `W`, is part of the query, since VNN-LIB relates networks by what is asserted of their inputs.

Source: https://www.vnnlib.org (VNN-LIB 2.0: several networks, a type `real`, queries that are satisfiable or not).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from importlib import import_module
from typing import Any, cast

from codegen import ir
from codegen.errors import MissingToolError
from codegen.ir import AgentPolicy, Meaning
from codegen.lowering.lower import lower
from codegen.lowering.render import comment
from codegen.targets import onnx as models
from verify.claims.formula import Acts, And, Formula, Linear, Not, Or, below, disjunction, for_goal, negate
from verify.claims.region import Region
from verify.claims.uncertified.starts import name_region
from verify.claims.uncertified.words import spell_decisions
from verify.decimals import plain
from verify.question import AnyClaim, DecisionQuestion, Question
from verify.states.state import measurable

STATE, OBSERVED, DECIDED = "W", "X", "Y"  # the world state; what agent k observes, and its action, are X_k and Y_k
WORLD = "world"
Names = Mapping[str, str]  # coordinate, or action of an agent -> the term that stands for it
Terms = Sequence[tuple[Fraction, str]]


def vnnlib_files(questions: Sequence[Question[AnyClaim]]) -> dict[str, str | bytes]:
    """The queries of the claims that have one, and every network that they name; name -> text or bytes.

    Claims about episodes and about leaves have none: neither speaks of actions alone. Nor have those for which an agent
    stands twice, as there is a network for each agent. MissingToolError without onnx.
    """
    files: dict[str, str | bytes] = {}
    about: ir.PolicyProfile | None = None  # the same for all
    for number, asked in enumerate(questions, 1):
        claim = asked.claim
        if not claim.per_state or (asked.viewed is not None and asked.viewed.view.copied):
            continue
        about = asked.profile
        for goal in asked.goals:
            files[f"{number:02d}-{claim.name}-{goal or 'no-goal'}.vnnlib"] = text(cast("DecisionQuestion", asked), goal)
    return files if about is None else files | networks(about)


def networks(profile: ir.PolicyProfile) -> dict[str, bytes]:
    """A network for each agent, and one for the world state, which hands it on; by file name."""
    model = lower(profile)
    return models.emit(model, profile) | {f"{model.prefix}_{WORLD}.onnx": _identity(len(profile.world.coordinates()))}


def text(question: DecisionQuestion, goal: str | None) -> str:
    """One query: world states of the region, goal `goal`, in which the claim fails."""
    profile, claim = question.profile, question.claim
    coordinates = profile.world.coordinates()
    at = {name: f"{STATE}[{place}]" for place, name in enumerate(coordinates)}
    at |= {f"{policy.agent}:": f"{DECIDED}_{number}[0]" for number, policy in enumerate(question.team)}
    model = lower(profile)
    called_in_files = {agent.name: f"{model.prefix}_{agent.lower}.onnx" for agent in model.agents}
    lines = [
        f"; {comment(claim.shown)}: {comment(claim.written or spell_decisions(claim))}",
        *([f"; assumed: {comment(claim.assumption)}"] if claim.assumption else []),
        f"; region {comment(name_region(profile, question.region) or 'given')}; goal {goal or 'none'}; real arithmetic",
        "; sat: a world state violates the claim; unsat for every goal: it holds in the whole region",
        "(vnnlib-version <2.0>)",
        f"; {WORLD}: {model.prefix}_{WORLD}.onnx, which hands on the world state",
        *(f";   {at[name]} is {name}" for name in coordinates),
        *_declare_network(WORLD, f"{STATE} real [{len(coordinates)}]", f"{STATE}_same real [{len(coordinates)}]"),
    ]
    for number, policy in enumerate(question.team):
        actions = ", ".join(f"{place} {action.name}" for place, action in enumerate(policy.actions))
        inputs = f"{OBSERVED}_{number} real [1, {len(policy.features)}]"
        lines += [
            f"; {policy.agent}: {called_in_files[policy.agent]}; actions {comment(actions)}",
            *_declare_network(f"agent_{number}", inputs, f"{DECIDED}_{number} int64 [1]"),
        ]
    lines += [f"(assert {each})" for each in _region(question.region, goal, at)]
    for number, policy in enumerate(question.team):
        lines += [f"(assert {each})" for each in _reading(number, policy, goal, at, claim.eps)]
    lines += ["; the claim fails", f"(assert {_write_formula(for_goal(negate(question.formula), goal), at)})"]
    return "\n".join(lines) + "\n"


def _declare_network(network: str, taken: str, given: str) -> list[str]:
    return [f"(declare-network {network}", f"  (declare-input {taken})", f"  (declare-output {given})", ")"]


def _region(region: Region, goal: str | None, at: Names) -> Iterator[str]:
    """What the region says of a world state, and where the goal is."""
    for name, (low, high) in region.box.items():
        yield _write_comparison("<=", [(Fraction(-1), at[name])], -low)
        yield _write_comparison("<=", [(Fraction(1), at[name])], high)
    for a, b, (low, high) in region.differences:
        yield _write_comparison("<=", [(Fraction(-1), at[a]), (Fraction(1), at[b])], -low)
        yield _write_comparison("<=", [(Fraction(1), at[a]), (Fraction(-1), at[b])], high)
    for a, b, least in region.apart:
        sides = [{f"{a}.{axis}": -sign, f"{b}.{axis}": sign} for axis in "xy" for sign in (1, -1)]
        yield _write_formula(disjunction(*(below(side, -least) for side in sides)), at)
    if goal is not None:
        for axis in "xy":
            yield f"(== {at[f'{ir.GOAL}.{axis}']} {at[f'{goal}.{axis}']})"


def _reading(number: int, policy: AgentPolicy, goal: str | None, at: Names, eps: Fraction) -> Iterator[str]:
    """What the features of an agent are, in terms of the world state; each measured one is off by up to `eps`."""
    for place, feature in enumerate(policy.features):
        assert feature.meaning is not None, feature
        seen, error = f"{OBSERVED}_{number}[0,{place}]", eps if measurable(feature.meaning) else Fraction(0)
        if feature.meaning.function:
            yield _function(feature.meaning, seen, at, error)
            continue
        summed = [(-Fraction(weight), at[name]) for weight, name in feature.meaning.terms]
        off = [(Fraction(1), seen), *summed]
        if error:
            yield _write_comparison("<=", off, error)
            yield _write_comparison("<=", [(-weight, name) for weight, name in off], error)
        else:
            yield _write_comparison("==", off, Fraction(0))


def _function(meaning: Meaning, seen: str, at: Names, error: Fraction) -> str:
    """The value of a function of a sum: each that it can have, where it has it."""
    terms = [(Fraction(weight), at[name]) for weight, name in meaning.terms]
    opposite = [(-weight, name) for weight, name in terms]
    above, under = _write_comparison("<", opposite, error), _write_comparison("<", terms, error)
    if meaning.function == "zero":
        cases = [(1, [_write_comparison("==", terms, Fraction(0))]), (0, [f"(or {under} {above})"])]
    elif meaning.function == "positive":
        cases = [(1, [above]), (0, [_write_comparison("<=", terms, error)])]
    else:
        cases = [(1, [above]), (-1, [under])]
        cases.append((0, [_write_comparison("<=", terms, error), _write_comparison("<=", opposite, error)]))
    return " ".join(["(or", *(f"(and (== {seen} {value}.0) {' '.join(facts)})" for value, facts in cases)]) + ")"


def _write_formula(formula: Formula, at: Names) -> str:
    """A formula whose negations stand before `Acts` only."""
    match formula:
        case Linear(terms, bound, strict):
            return _write_comparison("<" if strict else "<=", [(weight, at[name]) for weight, name in terms], bound)
        case Acts(agent, action):
            return f"(== {at[f'{agent}:']} {action})"
        case Not(Acts(agent, action)):
            return f"(!= {at[f'{agent}:']} {action})"
        case And(parts) | Or(parts):
            return _join_parts(
                "and" if isinstance(formula, And) else "or", [_write_formula(part, at) for part in parts], at
            )
        case _:
            raise AssertionError(f"{formula} is no part of a claim for one goal")


def _join_parts(word: str, parts: Sequence[str], at: Names) -> str:
    """And, or. Without parts: what is true, or false, of the first coordinate."""
    if len(parts) == 1:
        return parts[0]
    first = next(iter(at.values()))
    return f"({word} {' '.join(parts)})" if parts else f"({'==' if word == 'and' else '<'} {first} {first})"


def _write_comparison(sign: str, terms: Terms, bound: Fraction) -> str:
    """`sum SIGN bound`. Where a number has no finite decimal, all are multiplied until they do."""
    numbers = [*(weight for weight, _ in terms), bound]
    finite = not any("/" in plain(number) for number in numbers)
    scale = 1 if finite else math.lcm(*(number.denominator for number in numbers))
    parts = [name if weight * scale == 1 else f"(* {_number(weight * scale)} {name})" for weight, name in terms]
    summed = parts[0] if len(parts) == 1 else f"(+ {' '.join(parts)})"
    return f"({sign} {summed} {_number(bound * scale)})"


def _number(number: Fraction) -> str:
    """A decimal with a point: numbers without one are integers, which nothing of type `real` is compared with."""
    found = plain(number)
    return found if "." in found else f"{found}.0"


def _identity(size: int) -> bytes:
    try:
        onnx: Any = import_module("onnx")
    except ImportError:
        raise MissingToolError("writing VNN-LIB needs the package onnx", "--vnnlib", "pip install onnx") from None
    helper, double = onnx.helper, onnx.TensorProto.DOUBLE
    taken, given = (helper.make_tensor_value_info(name, double, [size]) for name in (STATE, f"{STATE}_same"))
    graph = helper.make_graph([helper.make_node("Identity", [taken.name], [given.name])], WORLD, [taken], [given])
    opsets = [helper.make_opsetid("", models.OLD_OPSETS[""])]
    made = helper.make_model(graph, opset_imports=opsets, ir_version=models.OLD_IR)
    onnx.checker.check_model(made, full_check=True)
    return made.SerializeToString(deterministic=True)
