"""Planted faults: what could go wrong in text, IR, thresholds, encoder and zones, each with what must catch it.

A fault plants itself and says whether it was caught: `plant(profile, patch)` returns True when the named guard saw it.
`patch` is pytest's monkeypatch. A fault that changes nothing is an error of the fault, not a success of the guard.
"""

import itertools
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import z3

from codegen import ir, policy_json, profiles
from codegen.agreement import selfcheck
from codegen.agreement.compiled import Build
from codegen.errors import DisagreementError, MaviperError
from codegen.lowering.deploy import deploy_tree
from codegen.lowering.lower import lower
from codegen.targets import TARGETS, emit
from maviper.compilation import compile, proofs
from tests.support import contact_readings, episode_cases
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, towards, tree
from verify.checker.episodes import contacts
from verify.checker.episodes.contacts import Contact, ContactReading
from verify.checker.episodes.reading import GRID
from verify.claims import decisions as properties
from verify.claims.decisions import DistinctTargets, OwnTarget
from verify.claims.files import read_properties
from verify.claims.formula import FALSE, TRUE, negate
from verify.claims.region_files import start_region
from verify.episodes import composition, unroll
from verify.episodes import zones as batch
from verify.question import Question, from_start
from verify.result import Verdict
from verify.solver import encode
from verify.solver import solve as deciding
from verify.solver.solve import decide
from verify.states.state import State, violates
from verify.subjects import Game

CLAIM = DistinctTargets("defenders")


@dataclass(frozen=True)
class Fault:
    name: str
    guard: str  # what catches it
    plant: Callable[..., bool]
    change: Callable[[str], str] = str  # of a text
    style: str = "auto"


TIES, TEAMS, STARTS = "referee at ties", "teams with a known verdict", "episodes of single starts"
NOTICING = {  # what guards, by the function that asks it
    "encoder_wrong": TIES, "sums_wrong": TIES, "verdicts_wrong": TEAMS, "steady_wrong": TEAMS, "signs_wrong": TEAMS,
    "assuming_wrong": "claims with a known verdict", "starts_lost": STARTS, "courses_stray": STARTS,
}  # fmt: skip


def put(name: str, owner, attribute: str, change: Callable[[Callable], Callable], wrong: Callable[..., bool]) -> Fault:
    """Changes something of ours, and asks whether that is noticed."""

    def plant(profile, patch):
        patch.setattr(owner, attribute, change(getattr(owner, attribute)))
        return wrong(profile)

    return Fault(name, NOTICING[wrong.__name__], plant)


# --- in the emitted text: the agreement check


_EMITTED: dict[str, tuple[ir.PolicyProfile, dict]] = {}  # style -> the last profile, and its files


def emitted(profile: ir.PolicyProfile, style: str) -> dict:
    """All files of a profile without a fault, written once for all faults of a style."""
    if style not in _EMITTED or _EMITTED[style][0] is not profile:
        _EMITTED[style] = profile, emit(profile, TARGETS, style=style)
    return _EMITTED[style][1]


def text_fault(name: str, file: str, change: Callable[[str], str], style: str = "auto") -> Fault:
    def plant(profile, patch):
        patch.setattr(selfcheck, "ensure_strict", lambda header, model: ())  # decisions tell it, not warnings
        files = emitted(profile, style)
        text, beside = files[file], {JSON: files[JSON]} if file == READER else {}
        wrong = change(text)
        assert wrong != text, f"the fault {name} changes nothing"
        report = selfcheck.check_files(profile, beside | {file: wrong}, random=1_000, style=style)
        found = list(report.agreements)
        if file == SMT:
            found += compile.ask_solver(Build(profile, lower(profile), {file: wrong}))
        return any(item.differences for item in found)

    return Fault(f"{file.rpartition('.')[2]}: {name}", "agreement check", plant, change, style)


def within(function: str, old: str, new: str) -> Callable[[str], str]:
    """Replaces text once, inside the first function whose name ends so."""

    def change(text: str) -> str:
        start = re.search(rf"{function}\([^;]*?\)\n{{", text).start()
        return text[:start] + text[start:].replace(old, new, 1)

    return change


def swap_leaves(text: str) -> str:
    """Swaps the first leaf of the C text with the next one that acts differently."""
    found = list(re.finditer(r"return \w+; /\* leaf \d+ \*/", text))
    first = found[0]
    other = next(leaf for leaf in found if leaf[0].split(";")[0] != first[0].split(";")[0])
    return text[: first.start()] + other[0] + text[first.end() : other.start()] + first[0] + text[other.end() :]


def thresholds(change: Callable[[float], str]) -> Callable[[str], str]:
    """Rewrites every threshold of the C text."""
    pattern = re.compile(r"-?0x[0-9a-f.]+p[+-]\d+f(?=\) \{ /\* node)")
    return lambda text: pattern.sub(lambda match: change(float.fromhex(match[0][:-1])), text)


def next_float(value: float) -> float:
    return float(np.nextafter(np.float32(value), np.float32(np.inf)))


H, PY, JSON = "physical_deception.h", "physical_deception.py", "physical_deception.json"
READER = "physical_deception_reader.py"
JS, RS, SMT, SVG = (
    "physical_deception.mjs",
    "physical_deception.rs",
    "physical_deception.smt2",
    "physical_deception_agent_0.svg",
)
FINITE = "!((x[i] >= -0x1.fffffep+127f) && (x[i] <= 0x1.fffffep+127f))"
TEXT = [
    text_fault("< for <=", H, lambda text: text.replace("] <= 0x", "] < 0x").replace("] <= -0x", "] < -0x")),
    text_fault("> for <= once", H, lambda text: re.sub(r"(if \(x\[\w+\]) <=", r"\1 >", text, count=1)),
    text_fault("swapped child", H, swap_leaves),
    text_fault("six decimals", H, thresholds(lambda value: f"{value:.6f}f")),
    text_fault("nine digits, but of the next float", H, thresholds(lambda value: f"{next_float(value):.9g}f")),
    text_fault("integer thresholds", H, thresholds(lambda value: f"{round(value * 4096) / 4096:.12f}f")),
    text_fault("neighbouring feature", H, lambda text: re.sub(r"(if \(x\[\w+_X_\w+_D)X\]", r"\1Y]", text, count=1)),
    text_fault("renumbered feature", H, lambda text: re.sub(r"(_X_LANDMARK_0_DX) = \d+", r"\1 = 1", text)),
    text_fault("renumbered action", H, lambda text: re.sub(r"(_AGENT_1_LEFT) = 1", r"\1 = 2", text)),
    text_fault("no upper end in the input check", H, lambda text: text.replace(" && (x[i] <= 0x1.fffffep+127f)", "")),
    text_fault("NaN passes the input check", H, lambda text: text.replace(FINITE, "x[i] < -0x1.fffffep+127f || x[i] > 0x1.fffffep+127f")),
    text_fault("no lower end in the range check", H, lambda text: re.sub(r"\(x\[0\] >= \S+\) && ", "", text)),
    text_fault("< for <= in a batch of rows", H, within("agent_1_act_rows", "<= physical_", "< physical_")),
    text_fault("the last rows are forgotten", H, within("agent_0_act_rows", "row < n; row++", "row < n - 1; row++")),
    text_fault("the wrong child in a batch of rows", H, within("agent_0_act_rows", "? 0 : 1", "? 1 : 0")),
    text_fault("a NaN goes left in a batch of rows", H, lambda text: re.sub(r"(agent_0_feature\[i\[k\]\]\]) <= (.*) \? 0 : 1", r"\1 > \2 ? 1 : 0", text, count=1)),
    text_fault("the wrong child in a call for all", H, lambda text: re.sub(r"(i_1 = .*) \? 0 : 1", r"\1 ? 1 : 0", text, count=1)),
    text_fault("another's observation in a call for all", H, lambda text: text.replace("x_1 = x[1]", "x_1 = x[2]")),
    text_fault("< for <= in a batch of columns", H, lambda text: text.replace("[first + row] <= ", "[first + row] < ")),
    text_fault("swapped sides in a batch of columns", H, lambda text: re.sub(r"(const float n0 = .*) \? (\w+) : (\w+);", r"\1 ? \3 : \2;", text, count=1)),
    text_fault("another's column", H, within("agent_1_act_columns", "= x[PHYSICAL_DECEPTION_AGENT_1_X_", "= x[1 + (int)PHYSICAL_DECEPTION_AGENT_1_X_")),
    text_fault("turned difference in a world state", H, lambda text: re.sub(r"_sum\((w\[\w+\]), -(w\[\w+\])\)", r"_sum(\2, -\1)", text)),
    text_fault("rounded before it is subtracted", H, lambda text: re.sub(r"\w+_single\(\w+_sum\((w\[\w+\]), -(w\[\w+\])\)\)", r"((float)\1 - (float)\2)", text)),
    text_fault("agents' actions in another order", H, lambda text: text.replace("actions[1] =", "actions[9] =").replace("actions[2] =", "actions[1] =").replace("actions[9] =", "actions[2] =")),
    text_fault("signed compare below zero", H, lambda text: re.sub(r"\(uint32_t\)(\w+_bits\(x\[\w+\]\)) >= UINT32_C\((0x\w+)\)", r"\1 >= (int32_t)\2", text), "ordered"),
    text_fault("the next integer", H, lambda text: re.sub(r"<= INT32_C\((0x\w+)\)", lambda m: f"<= INT32_C({int(m[1], 16) + 1:#x})", text), "ordered"),
    text_fault("signed compare below zero of bits", H, lambda text: re.sub(r"\(unsigned int\)(x\[\w+\]) >= (0x\w+)U", r"\1 >= (int)\2", text), "freestanding"),
    text_fault("the next integer of bits", H, lambda text: re.sub(r"<= (0x\w+)\) \{ /", lambda m: f"<= {int(m[1], 16) + 1:#x}) {{ /", text), "freestanding"),
    text_fault("infinite bits pass the input check", H, lambda text: text.replace("== 0x7f800000U", "== 0x7f000000U"), "freestanding"),
    text_fault("the threshold before", H, lambda text: re.sub(r"(threshold\[\d+\] = \{)([^,}]+)", lambda m: m[1] + float(np.nextafter(np.float32(float.fromhex(m[2][:-1])), np.float32(-9))).hex() + "f", text), "walk"),
    text_fault("a NaN goes left", H, lambda text: re.sub(r"(\(x\[\w+_agent_0_feature\[i\]\]) <= (.*) \? 0 : 1", r"\1 > \2 ? 1 : 0", text, count=1), "walk"),
    text_fault("< for <=", PY, lambda text: text.replace(")) <= ", ")) < ")),
    text_fault("six decimals", PY, lambda text: re.sub(r"(?<=\)\) <= )-?[\d.e-]+", lambda m: f"{float(m[0]):.6f}", text)),
    text_fault("the float32 for the deciding double", PY, lambda text: re.sub(r"(?<=\)\) <= )-?[\d.e-]+", lambda m: repr(float(np.float32(float(m[0])))), text)),
    text_fault("one action", PY, lambda text: text.replace("return 1  #", "return 2  #", 1)),
    text_fault("< for <= in the batch function", PY, lambda text: re.sub(r"( x\d+) <= ", r"\1 < ", text)),
    text_fault("swapped sides in the batch function", PY, lambda text: text.replace("actions ^= right", "actions ^= left")),
    text_fault("a column for another in the batch function", PY, lambda text: re.sub(r"(x\d+), (x\d+)(, .* = _columns)", r"\2, \1\3", text)),
    text_fault("the last rows of the batch function", PY, lambda text: text.replace("found[:, whole:] = rows[whole:, features].T", "found[:, whole:] = rows[: len(rows) - whole, features].T")),
    text_fault("two rows of a tile in the batch function", PY, lambda text: text.replace(".reshape(tiles, 256, rows.shape[1]).", ".reshape(256, tiles, rows.shape[1]).swapaxes(0, 1).")),
    text_fault("NaN replaced in the batch function", PY, lambda text: text.replace("rows = x[start : start + 65536]", "rows = np.nan_to_num(x[start : start + 65536])")),
    text_fault("any length", PY, lambda text: re.sub(r"elif len\(x\) != \d+:", "elif False:", text)),
    text_fault("any length of an array of floats", PY, lambda text: re.sub(r"len\(seen := given.tolist\(\)\) == \d+", "(seen := given.tolist())", text)),
    text_fault("numbers compared as they are", PY, lambda text: text.replace("is float else _double(v)", "is float else v")),
    text_fault("texts as numbers", PY, lambda text: text.replace("    if not number or issubclass(whose, (str, bytes, complex)) or", "    if")),
    text_fault("long doubles rounded once in the batch function", PY, lambda text: text.replace("rows = rows.astype(np.float64)", "pass")),
    text_fault("texts as numbers in the batch function", PY, lambda text: text.replace('"cmMSU"', '"mM"')),
    text_fault("any length of an array", PY, lambda text: text.replace("list and len(values) == n and", "list and").replace("shape != (n,)", "not shape")),
    text_fault("any width in the batch function", PY, lambda text: text.replace("rows.ndim != 2 or rows.shape[1] != n", "rows.ndim != 2")),
    text_fault("< for <=", JS, lambda text: text.replace("] <= ", "] < ")),
    text_fault("six decimals", JS, lambda text: re.sub(r"(?<=\] <= )-?[\d.e-]+", lambda m: f"{float(m[0]):.6f}", text)),
    text_fault("the float32 for the deciding double", JS, lambda text: re.sub(r"(?<=\] <= )-?[\d.e-]+", lambda m: repr(float(np.float32(float(m[0])))), text)),
    text_fault("another row", JS, lambda text: re.sub(r"x\.subarray\(row \* (\d+), \(row \+ 1\) \* \d+\)", r"x.subarray((n - 1 - row) * \1, (n - row) * \1)", text)),
    text_fault("any length", JS, lambda text: text.replace("x.length !== n)", "x.length < 0)")),
    text_fault("texts as numbers", JS, lambda text: text.replace('!== "number"', '=== "object"')),
    text_fault("big integers as numbers", JS, lambda text: text.replace("? 1 : n;", "? 0 : n;")),
    text_fault("any number of rows", JS, lambda text: text.replace(" || x.length !== width * n", "")),
    text_fault("< for <=", RS, lambda text: text.replace("] <= f32", "] < f32")),
    text_fault("the next bits", RS, lambda text: re.sub(r"from_bits\((0x\w+)\)", lambda m: f"from_bits({int(m[1], 16) + 1:#x})", text)),
    text_fault("infinity passes the input check", RS, lambda text: text.replace("value.is_finite()", "!value.is_nan()")),
    text_fault("fp.lt for fp.leq", SMT, lambda text: text.replace("fp.leq", "fp.lt")),
    text_fault("a NaN goes left", SMT, lambda text: re.sub(r"\(fp\.leq (\|\w+\|) (\(fp [^)]*\))\)", r"(not (fp.gt \1 \2))", text)),
    text_fault("another feature", SMT, lambda text: text.replace("|landmark_0_dx| (_", "|landmark_9_dx| (_").replace("|landmark_0_dy| (_", "|landmark_0_dx| (_").replace("|landmark_9_dx| (_", "|landmark_0_dy| (_")),
    text_fault("< for <= in the reader", READER, lambda text: text.replace(") <= threshold", ") < threshold")),
    text_fault("any length in the reader", READER, lambda text: text.replace("if given != len(self.features):", "if given == 0:")),
    text_fault("texts as numbers in the reader", READER, lambda text: text.replace("float32(x[feature])", "float32(float(x[feature]))").replace("(kind, numbers.Real)", "(kind, object)")),
    text_fault("NaN goes left in the reader", READER, lambda text: text.replace("left if float32(x[feature]) <= threshold else right", "right if float32(x[feature]) > threshold else left")),
    text_fault("swapped children", SVG, lambda text: re.sub(r'data-left="(\d+)" data-right="(\d+)"', r'data-left="\2" data-right="\1"', text)),
    text_fault("a leaf's action", SVG, lambda text: re.sub(r'data-action="(\d)"', lambda m: f'data-action="{(int(m[1]) + 1) % 5}"', text, count=1)),
    text_fault("six decimals", JSON, lambda text: re.sub(r'"threshold": (-?[\d.e-]+), "float32"', lambda m: f'"threshold": {float(m[1]):.6f}, "float32"', text)),
    text_fault("swapped children", JSON, lambda text: re.sub(r'"left": (\d+), "right": (\d+)', r'"left": \2, "right": \1', text)),
]  # fmt: skip


def proof_fault(fault: Fault) -> Fault:
    """The same fault, to be found by the solver alone."""
    file = H if fault.name.startswith("h: ") else PY

    def plant(profile, patch):
        text = emitted(profile, fault.style)[file]
        wrong = fault.change(text)
        assert wrong != text, f"the fault {fault.name} changes nothing"
        try:
            proofs.prove(Build(profile, lower(profile, style=fault.style), {file: wrong}))
        except DisagreementError:
            return True
        return False

    return Fault(f"{fault.name}, proof", "solver, for all observations", plant, fault.change, fault.style)


def next_below(text: str) -> str:
    """The first threshold of the first tree that has one, one float32 lower."""
    return re.sub(
        r"(if \(x\[\w+\] <= )(-?0x[\w.+-]+)f",
        lambda m: m[1] + float(np.nextafter(np.float32(float.fromhex(m[2])), np.float32(-9))).hex() + "f",
        text,
        count=1,
    )


PROVED_ALONE = (
    "h: < for <=", "h: > for <= once", "h: swapped child", "h: six decimals", "h: nine digits", "h: integer thresholds",
    "h: neighbouring feature", "h: renumbered", "h: signed compare", "h: the next integer", "h: the threshold before",
    "h: a NaN goes left", "py: < for <=", "py: six decimals", "py: the float32 for", "py: one action",
)  # fmt: skip
ELSEWHERE = ("in a batch", "in the batch", "in the reader")
PROOF = [
    proof_fault(fault) for fault in [
        *(fault for fault in TEXT if fault.name.startswith(PROVED_ALONE) and not any(place in fault.name for place in ELSEWHERE)),
        text_fault("one float lower, once", H, next_below),
        text_fault("a NaN goes left in nested ifs", H, lambda text: re.sub(r"if \((x\[\w+\]) <= (-?0x[\w.+-]+)\)", r"if (!(\1 > \2))", text)),
        text_fault("a swapped leaf", H, swap_leaves, "ordered"),
        text_fault("the next double", PY, lambda text: re.sub(r"(?<=\)\) <= )-?[\d.e-]+", lambda m: repr(math.nextafter(float(m[0]), math.inf)), text, count=1)),
    ]
]  # fmt: skip


# --- in extraction and in the IR: comparison with the grown tree, the checker, the hash


def grown_fault(name: str, change: Callable[[ir.AgentPolicy], ir.Tree]) -> Fault:
    def plant(profile, patch):
        found = 0
        for policy in profile.agents:
            wrong = replace(policy, tree=change(policy))
            nothing = np.zeros((0, len(policy.features)), dtype=np.float32)
            found += selfcheck.check_grown(wrong, nothing).differences
        return found > 0

    return Fault(f"extraction: {name}", "comparison with the tree as grown", plant)


def rounded(how: Callable[[float], np.float32]) -> Callable[[ir.AgentPolicy], ir.Tree]:
    def change(policy):
        other = np.array([float(how(float(value))) for value in policy.grown.threshold])
        return deploy_tree(replace(policy.grown, threshold=other))

    return change


def up(value: float) -> np.float32:
    near = np.float32(value)
    return near if near >= value else np.nextafter(near, np.float32(np.inf))


def swapped_children(policy: ir.AgentPolicy) -> ir.Tree:
    return deploy_tree(replace(policy.grown, left=policy.grown.right, right=policy.grown.left))


def shifted_feature(policy: ir.AgentPolicy) -> ir.Tree:
    split = policy.tree.feature != ir.NO_FEATURE
    return replace(
        policy.tree, feature=np.where(split, (policy.tree.feature + 1) % len(policy.features), ir.NO_FEATURE)
    )


def lowest_leaf_class(policy: ir.AgentPolicy) -> ir.Tree:
    leaf = policy.tree.feature == ir.NO_FEATURE
    return replace(policy.tree, action=np.where(leaf, 0, policy.tree.action))


GROWN = [
    grown_fault("round to nearest", rounded(np.float32)),
    grown_fault("round up", rounded(up)),
    grown_fault("half precision", rounded(lambda value: np.float32(np.float16(value)))),
    grown_fault("swapped children", swapped_children),
    grown_fault("features off by one", shifted_feature),
    grown_fault("every leaf takes action 0", lowest_leaf_class),
]


def json_fault(name: str, guard: str, change: Callable[[dict], None]) -> Fault:
    def plant(profile, patch):
        document = json.loads(policy_json.dumps(profile))
        change(document)
        try:
            profiles.loads(json.dumps(document))
        except MaviperError:
            return True
        return False

    return Fault(f"profile: {name}", guard, plant)


def first_split(document: dict) -> dict:
    return next(node for agent in document["agents"] for node in agent["tree"] if "feature" in node)


def first_leaf(document: dict) -> dict:
    return next(node for agent in document["agents"] for node in agent["tree"] if "action" in node)


PROFILE = [
    json_fault("another action at a leaf", "content hash", lambda d: first_leaf(d).update(action="stay" if first_leaf(d)["action"] != "stay" else "up")),
    json_fault("another force", "content hash", lambda d: d["world"]["agents"][0].update(force=4.0)),
    json_fault("another meaning", "content hash", lambda d: d["agents"][0]["features"][0].update(meaning="landmark_0.y - adversary_0.x")),
    json_fault("threshold without its float32", "checker", lambda d: first_split(d).update(threshold=0.5)),
    json_fault("a cycle", "checker", lambda d: first_split(d).update(left=0)),
    json_fault("a shared leaf", "checker", lambda d: first_split(d).update(right=first_split(d)["left"])),
    json_fault("a child out of range", "checker", lambda d: first_split(d).update(right=10_000)),
    json_fault("an unreachable node", "checker", lambda d: d["agents"][0]["tree"].append({"action": "stay"})),
    json_fault("an unknown feature", "checker", lambda d: first_split(d).update(feature="goal_dz")),
    json_fault("a missing member", "schema", lambda d: d["world"].pop("dt")),
    json_fault("an extra member", "schema", lambda d: d["world"].update(gravity=9.8)),
]  # fmt: skip


# --- in the machine thresholds and in the encoder: the referee, point by point


def encoder_wrong(profile: ir.PolicyProfile) -> bool:
    """Whether encoder and referee disagree on some float64 world state near the ends of half lines."""
    rng = np.random.default_rng(5)
    # -t1 and t2 have odd and even significands, zero and a plain decimal join them
    sharp = [0.1, float(np.nextafter(np.float32(0.1), np.float32(1))), 0.0, -0.7]
    for threshold, axis in itertools.product(sharp, (0, 1)):
        first = tree((2 + axis, threshold, 1, 2), STAY, (RIGHT, UP)[axis])
        second = tree((4 + axis, threshold, 1, 2), (LEFT, DOWN)[axis], STAY)
        for profile_here in (team(profile, first, towards(1, 1)), team(profile, towards(0, 0), second)):
            question = encode.query(Question(Game(profile_here), CLAIM, start_region(profile.world)), "landmark_0")
            for state in sharp_points(threshold, axis, rng):
                exact = [
                    (question.variables[name], encode.number(Fraction(value))) for name, value in state.position.items()
                ]
                said = z3.simplify(z3.substitute(question.constraints[-1], *exact))
                if z3.is_true(said) != violates(from_start(profile_here, CLAIM), state):
                    return True
    return False


def sharp_points(threshold: float, axis: int, rng: np.random.Generator):
    """World states in which offsets to landmarks are at, and one float64 beside, the places where roundings tie."""
    letter = "xy"[axis]
    for end, base in sharp_pairs(float(np.float32(threshold))):
        position = {f"{name}.{letter}": float(rng.uniform(-1, 1)) for name in ENTITIES for letter in "xy"}
        for agent, landmark in (("agent_0", "landmark_0"), ("agent_1", "landmark_1")):
            position |= {f"{agent}.{letter}": base, f"{landmark}.{letter}": end}
        yield State(position, "landmark_0")


def sharp_pairs(threshold: float):
    """(a, b) of float64 whose exact difference is at or beside a tie of the first, the second or both roundings."""
    single = np.float32(threshold)
    beside = [float(np.nextafter(single, np.float32(side * np.inf))) for side in (-1, 1)]
    for center in (threshold, *((threshold + other) / 2 for other in beside)):
        for base, steps in itertools.product((0.0, 0.3), (-2, -1, 0, 1, 2)):
            end = float(Fraction(center) + Fraction(base))
            for _ in range(abs(steps)):
                end = math.nextafter(end, math.copysign(math.inf, steps))
            yield end, base
        for side in (-1, 1):
            # a - b lies exactly halfway between `center` and the next float64, where the first rounding ties
            yield center, -(math.nextafter(center, side * math.inf) - center) / 2


ENTITIES = ("adversary_0", "agent_0", "agent_1", "landmark_0", "landmark_1")


SUM = ("landmark_0.x", "agent_0.x", "landmark_0.y", "agent_0.y")  # with signs + - + -
EDGE = float(np.float32(0.3))


def pinned_states():
    """World states in which the sum of SUM, rounded after each addition, lies beyond EDGE, and the exact sum does not."""
    rng = np.random.default_rng(7)
    half = encode.last_double(EDGE, True).end
    for _ in range(400):
        position = {f"{name}.{axis}": float(rng.uniform(-3, 3)) for name in ENTITIES for axis in "xy"}
        a, b, c = (position[name] for name in SUM[:3])
        nearest = float(Fraction(a) - Fraction(b) + Fraction(c) - half)
        for last in (np.nextafter(nearest, -np.inf).item(), nearest, np.nextafter(nearest, np.inf).item()):
            exact = Fraction(a) - Fraction(b) + Fraction(c) - Fraction(last)
            if np.float32(a - b + c - last) > np.float32(EDGE) and exact <= half:
                yield State(position | {SUM[3]: last}, "landmark_0")


def sums_wrong(profile: ir.PolicyProfile) -> bool:
    """Whether something is proved of a state in which the referee sees it fail, because of a rounding within a sum."""
    meaning = ir.Meaning(tuple(zip((1, -1, 1, -1), SUM, strict=True)))
    policy = profile.policy("agent_0")
    place = len(policy.features)
    summed = replace(policy, features=(*policy.features, ir.FeatureSpec("sum", "length", -9.0, 9.0, meaning)))
    agents = tuple(summed if one is policy else one for one in profile.agents)
    for state in itertools.islice(pinned_states(), 10):
        near = RIGHT if state.position["landmark_0.x"] > state.position["agent_0.x"] else LEFT
        away = LEFT if near == RIGHT else RIGHT
        one = team(replace(profile, agents=agents), tree((place, EDGE, 1, 2), near, away), towards(1, 1))
        box = {name: (Fraction(value), Fraction(value)) for name, value in state.position.items()}
        region = replace(start_region(profile.world), box=box, goals=("landmark_0",))
        question = Question(Game(one), OwnTarget("defenders"), region)
        if violates(question, state) and decide(question).verdict is Verdict.PROVED:
            return True
    return False


def verdicts_wrong(profile: ir.PolicyProfile) -> bool:
    """Whether a team whose verdict is known gets another one."""
    start = start_region(profile.world)
    roles, swapped = team(profile, towards(0, 0), towards(1, 1)), team(profile, towards(1, 0), towards(0, 1))
    same, still = team(profile, towards(0, 0), towards(0, 1)), team(profile, tree(STAY), tree(STAY))
    # agent_0 follows the goal, agent_1 goes to landmark 1: fails only when the goal is landmark 1
    follower = team(
        profile, tree((0, -0.05, 1, 2), LEFT, (0, 0.05, 3, 6), (1, 0.0, 4, 5), DOWN, UP, RIGHT), towards(1, 1)
    )
    known = [
        (roles, start, Verdict.PROVED), (swapped, start, Verdict.PROVED), (same, start, Verdict.VIOLATED),
        (still, start, Verdict.VIOLATED), (follower, start, Verdict.VIOLATED),
        (follower, replace(start, goals=("landmark_0",)), Verdict.PROVED),
    ]  # fmt: skip
    return any(decide(Question(Game(one), CLAIM, region)).verdict is not verdict for one, region, verdict in known)


def steady_wrong(profile: ir.PolicyProfile) -> bool:
    """Whether a team whose verdict with errors of up to 1/10 is known gets another one."""
    claim = replace(CLAIM, eps=Fraction(1, 10))
    box = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    box |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    region = replace(start_region(profile.world), box=box | {"agent_0.x": (Fraction(-2), Fraction(2))})
    # standing still fails where one feature is above 0.3 and another one, or the same again, at most 0.15
    twice = team(profile, tree((2, 0.3, 1, 2), UP, (2, 0.15, 3, 4), STAY, UP), tree(UP))
    apart = team(profile, tree((0, 0.3, 1, 2), UP, (2, 0.15, 3, 4), STAY, UP), tree(UP))
    # both at the same place: each fails alone, and together only if their errors have different signs
    stated = (
        "distance(agent_0, agent_1) == 0 and landmark_0.x - agent_0.x == 1/4 implies "
        "not (acts(agent_0) == left and acts(agent_1) == right)"
    )
    opposite = team(profile, tree((2, 0.25, 1, 2), LEFT, RIGHT), tree((2, 0.25, 1, 2), LEFT, RIGHT))
    source = f'[[property]]\nformula = "{stated}"\neps = 0.1'
    ((own, *_),) = read_properties(source, profile, "faults", lambda name: region)
    known = [(twice, claim, region, Verdict.PROVED), (apart, claim, region, Verdict.VIOLATED)]
    known.append((opposite, own, start_region(profile.world), Verdict.VIOLATED))
    return any(decide(Question(Game(one), asked, where)).verdict is not verdict for one, asked, where, verdict in known)


def assuming_wrong(profile: ir.PolicyProfile) -> bool:
    """Whether a claim with an assumption, whose verdict is known, gets another one."""
    same = team(profile, towards(0, 0), towards(0, 1))
    # both go to landmark 0: wrong, but not where the landmarks coincide, and not for the one that is meant to
    known = {
        "agent_0.x < agent_1.x and agent_1.x < agent_0.x": Verdict.VACUOUS,
        "goal == landmark_0 and goal != landmark_0": Verdict.VACUOUS,
        "distance(landmark_0, landmark_1) <= 0.01": Verdict.PROVED,
        "distance(landmark_0, landmark_1) >= 0.5 and goal == landmark_1": Verdict.VIOLATED,
    }
    for assume, verdict in known.items():
        source = f'[[property]]\nname = "{CLAIM.name}"\nradius = 0.2\nassume = "{assume}"'
        ((claim, region, _),) = read_properties(source, same, "faults", lambda name: start_region(profile.world))
        if decide(Question(Game(same), claim, region)).verdict is not verdict:
            return True
    return False


THRESHOLD = [
    put("encoder: thresholds as real numbers", encode, "half_line", lambda _: lambda t, _: encode.HalfLine(Fraction(t), False), encoder_wrong),
    put("encoder: the second rounding only", encode, "half_line", lambda _: lambda t, _: encode.last_double(t, True), encoder_wrong),
    put("encoder: ties always included", encode, "half_line", lambda f: lambda t, _: f(t, True)._replace(strict=False), encoder_wrong),
    put("encoder: ties never included", encode, "half_line", lambda f: lambda t, _: f(t, True)._replace(strict=True), encoder_wrong),
    put("encoder: one float32 too far", encode, "half_line", lambda f: lambda t, _: f(float(np.nextafter(np.float32(t), np.float32(9))), True), encoder_wrong),
]  # fmt: skip
ENCODER = [
    put("encoder: long sums without rounding", encode._Encoder, "_rounding", lambda _: lambda *given: encode.number(Fraction(0)), sums_wrong),
    put("encoder: sides of a split swapped", encode._Encoder, "_tests", lambda f: lambda *given: f(*given)[::-1], encoder_wrong),
    put("encoder: errors forgotten", encode, "measurable", lambda _: lambda meaning: False, steady_wrong),
    put("encoder: an error a test, not a feature", encode._Encoder, "_error", lambda f: lambda self, agent, feature: f(self, agent, f"{feature}{len(self.variables)}"), steady_wrong),
    put("encoder: agents share errors", encode._Encoder, "_error", lambda f: lambda self, agent, feature: f(self, "agent_0", feature), steady_wrong),
    put("assumption: not asked whether it can hold", deciding, "about_nothing", lambda _: lambda question: ("", 0), assuming_wrong),
    put("assumption: emptiness of the region alone", deciding, "region_only", lambda f: lambda region, *_: f(region), assuming_wrong),
    put("assumption: forgotten in the claim", deciding, "query", lambda f: lambda q, goal: f(q.about(replace(q.claim, assume=TRUE)), goal), assuming_wrong),
    put("assumption: another goal than the question's", encode, "for_goal", lambda f: lambda claim, goal: f(claim, "landmark_0"), assuming_wrong),
    put("decisions: only one matching tried", properties, "matchings", lambda f: lambda n, m: f(n, m)[:1], verdicts_wrong),
    put("decisions: no matching tried", properties, "matchings", lambda _: lambda n, m: [], verdicts_wrong),
    put("decisions: engaged taken for not engaged", properties, "engages", lambda f: lambda *given: negate(f(*given)), verdicts_wrong),
    put("decisions: always engaged", properties, "engages", lambda f: lambda *given: TRUE, verdicts_wrong),
    put("decisions: never at a landmark", properties, "at", lambda f: lambda *given: FALSE, verdicts_wrong),
    put("solve: goal taken for landmark 0", deciding, "query", lambda f: lambda question, goal: f(question, "landmark_0"), verdicts_wrong),
    put("encode: region forgotten", encode, "_region", lambda f: lambda region, at: [z3.BoolVal(False)], verdicts_wrong),
    put("encoder: not negated", encode, "negate", lambda f: lambda claim: claim, encoder_wrong),
    put("encode: the other way round", encode, "negate", lambda f: lambda claim: claim, verdicts_wrong),
    put("encoder: margin of one", encode, "query", lambda f: lambda q, goal: f(q.with_margin(Fraction(1)), goal), encoder_wrong),
    put("encoder: at a landmark within one", encode, "query", lambda f: lambda q, goal: f(q.about(replace(q.claim, radius=Fraction(1))), goal), encoder_wrong),
]  # fmt: skip


# --- in the zones of whole episodes


def starts_lost(profile: ir.PolicyProfile) -> bool:
    """Whether zones lose the course of some start, also of starts on which thresholds tie."""
    first, second = episode_cases.arriving(0), episode_cases.arriving(1)
    pair = team(profile, episode_cases.on_lattice(first), episode_cases.on_lattice(second))
    return any(
        episode_cases.lost(pair, 9, 1, 300, lattice, (agent,)) for lattice in (None, 0.125) for agent in ENTITIES[1:3]
    )


def hasty(f: Callable) -> Callable:
    """Positions move with the new velocity as well."""
    return lambda *given: (found := f(*given))._replace(
        offset=found.offset + np.rint(found.velocity * 0.1 * batch.SCALE).astype(np.int64)
    )


def forgetful(f: Callable) -> Callable:
    """Nobody is ever noted to have moved, so first answers stay."""
    return lambda *given: (found := f(*given))._replace(moved=np.zeros_like(found.moved))


ZONES = [
    put("zones: tests do not shift", unroll, "_shift", lambda f: lambda *given: tuple(0 * end for end in f(*given)), starts_lost),
    put("zones: tests shift the wrong way", unroll, "_shift", lambda f: lambda *given: tuple(-end for end in f(*given)), starts_lost),
    put("zones: sides of a split swapped", unroll, "_sides", lambda f: lambda *given: f(*given)[::-1], starts_lost),
    put("zones: a threshold a millionth too low", unroll, "deciding_double", lambda f: lambda t: f(t) - 1e-6, starts_lost),
    put("zones: both ends of a sign are one test", unroll, "_line", lambda f: lambda *given: (f(*given)[0], False), episode_cases.signs_wrong),
    put("zones: an action moves at once", unroll.EpisodeSearch, "_step_zones", hasty, starts_lost),
    put("zones: first answers stay", unroll.EpisodeSearch, "_step_zones", forgetful, starts_lost),
    put("zones: arrived within one", composition, "away", lambda f: lambda z, g, a, k, radius: f(z, g, a, k, Fraction(1)), episode_cases.verdicts_wrong),
    put("zones: never arrived", composition, "away", lambda f: lambda zones, *given: zones, episode_cases.verdicts_wrong),
    put("zones: always matched", composition, "find_unmatched", lambda f: lambda zones, *given: zones.take(slice(0)), episode_cases.verdicts_wrong),
    put("zones: never matched", composition, "find_unmatched", lambda f: lambda zones, *given: zones, episode_cases.verdicts_wrong),
]  # fmt: skip

# --- in the checker's reading of contacts


def courses_stray(profile: ir.PolicyProfile) -> bool:
    """Whether played episodes of teams that touch leave the bounds that the checker knows them between."""
    return any(contact_readings.strays(seed)[0] for seed in range(10))


CONTACTS = [
    put("contacts: no contacts", contacts, "contacts", lambda _: lambda world: (), courses_stray),
    put("contacts: pushes a tenth too weak", Contact, "overlap", lambda f: lambda *given: tuple(9 * end // 10 for end in f(*given)), courses_stray),
    put("contacts: noticed only when they overlap", Contact, "apart", lambda f: lambda pair, gap: f(pair._replace(reach=int(pair.touching * GRID)), gap), courses_stray),
    put("contacts: pushed the wrong way", Contact, "push", lambda f: lambda *given: tuple((-high, -low) for low, high in f(*given)), courses_stray),
    put("contacts: the first alone is pushed", ContactReading, "_forces", lambda f: lambda self, *given: {k: v for k, v in f(self, *given).items() if k in {pair.first for pair in self.contacts}}, courses_stray),
    put("contacts: each part of a speed cut alone", contacts, "limit_speed", lambda _: lambda velocity, limit: tuple((max(low, -int(limit * GRID)), min(high, int(limit * GRID))) for low, high in velocity), courses_stray),
    put("contacts: who is not followed stands still", ContactReading, "_bound_places", lambda f: lambda self: [self.start._replace(step=step) for step in range(self.steps + 1)], courses_stray),
    put("contacts: forty times as soft", contacts, "contacts", lambda f: lambda world: tuple(pair._replace(margin=40 * pair.margin) for pair in f(world)), courses_stray),
    put("contacts: the middle of a push for all of it", ContactReading, "_forces", lambda f: lambda self, *given: {agent: tuple(((low + high) // 2,) * 2 for low, high in force) for agent, force in f(self, *given).items()}, courses_stray),
    put("contacts: tests do not shift", ContactReading, "bound", lambda f: lambda self, side, now: f(self, side, self.start), courses_stray),
]  # fmt: skip

ALL = [*TEXT, *PROOF, *GROWN, *PROFILE, *THRESHOLD, *ENCODER, *ZONES, *CONTACTS]
