"""Decisions read back from the text of targets, each by means that its emitter does not use.

Does: runs JavaScript under Node.js and Rust by rustc, ONNX under onnxruntime, array modules under JAX and PyTorch,
  walks JSON and pictures as a stranger would, with numpy's scalars where sums are added.
Assumes: programs on the path; a scratch folder; the JSON of a profile, and pictures of `codegen.targets.svg`.
Does not: compare (selfcheck.py), or share code with the reference (ir.py) and the reader that is handed out.
"""

import json
import re
import runpy
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, cast
from xml.etree import ElementTree

import numpy as np

from codegen.agreement import entries
from codegen.agreement.entries import Asked, Told, drive_machine
from codegen.agreement.probes import iterate_rows
from codegen.agreement.programs import run
from codegen.check import identifier
from codegen.errors import DisagreementError, MissingToolError
from codegen.ir import Float64, Floats, Int32, Int64
from codegen.lowering.model import Agent, Model
from codegen.targets.rendered import harness


def json_answer(policy: Mapping[str, Any], row: Sequence[float]) -> Any:
    """The name of the action, or the list of numbers given, for an observation in the agent's numbers."""
    number = np.float32 if policy["arithmetic"] == "float32 steps" else np.float64
    seen = {each["name"]: value for each, value in zip(policy["features"], row, strict=True)}
    nodes: Any = policy["tree"]
    node = nodes[0]
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        while "threshold" in node:
            value = _add_scalars(node["sum"], seen, number) if "sum" in node else seen[node["feature"]]
            node = nodes[node["left"] if value <= node["threshold"] else node["right"]]
        if "action" in node:
            return node["action"]
        given = np.float32 if policy["gives"] == "float32" else np.float64
        pairs = zip(node["outputs"], policy["outputs"], strict=True)
        return [float(given(_cut_scalar(_add_scalars(terms, seen, number), output))) for terms, output in pairs]


def _add_scalars(terms: Sequence[tuple[float | str, Any]], seen: Mapping[str, float], number: Any) -> Any:
    def weigh(weight: float | str, what: Any) -> Any:
        if what is None:
            return number(weight)
        value = number(seen[what]) if isinstance(what, str) else _add_scalars(what, seen, number)
        return value / number(weight[1:]) if isinstance(weight, str) else number(weight) * value

    values = [weigh(*term) for term in terms]
    total = values.pop(0)
    while values:
        total = number(total + values.pop(0))
    return total


def _cut_scalar(value: Any, output: Mapping[str, Any]) -> Any:
    low, high = output["low"], output["high"]
    if low is not None and value < low:
        return low
    return high if high is not None and value > high else value


_SVG = "{http://www.w3.org/2000/svg}"


def svg_act(text: str, agent: str, rows: Floats) -> Any:
    """Decisions read from the attributes of a picture's elements, or what is given. `agent`: whose picture it is."""
    root = ElementTree.fromstring(text)
    nodes = {int(group.attrib["data-node"]): group.attrib for group in root.iter(f"{_SVG}g")}
    if "data-arithmetic" in root.attrib:
        bounds = [each.split(":") for each in root.attrib["data-bounds"].split(";") if each]
        policy = {  # as the JSON has it
            "arithmetic": root.attrib["data-arithmetic"],
            "gives": root.attrib["data-gives"],
            "features": [{"name": str(place)} for place in range(rows.shape[1])],
            "outputs": [{"low": _number(low), "high": _number(high)} for low, high in bounds],
            "tree": [_node(nodes[place]) for place in sorted(nodes)],
        }
        return np.array([json_answer(policy, row) for row in rows.tolist()])
    actions = np.empty(len(rows), dtype=np.int32)
    for place, row in enumerate(rows):
        node = nodes[0]
        while "data-feature" in node:
            threshold = float.fromhex(node["data-threshold"].rstrip("f"))
            goes_left = float(row[int(node["data-feature"])]) <= threshold
            node = nodes[int(node["data-left" if goes_left else "data-right"])]
        actions[place] = int(node["data-action"])
    return actions


def _node(node: Mapping[str, str]) -> dict[str, Any]:
    if "data-outputs" in node:
        return {"outputs": [_sum(each) for each in node["data-outputs"].split(";")]}
    if "data-action" in node:
        return {"action": int(node["data-action"])}
    tested = {"sum": _sum(node["data-sum"])} if "data-sum" in node else {"feature": node["data-feature"]}
    limit = {"threshold": _number(node["data-threshold"])}
    return {**tested, **limit, "left": int(node["data-left"]), "right": int(node["data-right"])}


def _sum(text: str) -> list[tuple[float | str, Any]]:
    terms, rest = list[tuple[float | str, Any]](), text
    while rest:
        weight, _, rest = rest.partition(":")
        if rest.startswith("("):
            end = next(at for at in range(len(rest)) if rest[: at + 1].count("(") == rest[: at + 1].count(")"))
            terms.append((_read_weight(weight), _sum(rest[1:end])))
            rest = rest[end + 2 :]
        else:
            place, _, rest = rest.partition(",")
            terms.append((_read_weight(weight), None if place == "-1" else place))
    return terms


def _read_weight(text: str) -> float | str:
    """A factor, or a divisor behind its stroke, as profiles have them."""
    return f"/{float.fromhex(text[1:])!r}" if text.startswith("/") else float.fromhex(text)


def _number(text: str) -> float | None:
    return float.fromhex(text.rstrip("f")) if text else None


_ST = re.compile(
    r"^ *(?:IF (\w+)(?: (<=?) (\S+))? THEN|(ELSE)|(END_IF);|(\w+) := (?:\6 ([+-]) )?(-?\d+);)", re.MULTILINE
)


def st_act(text: str, agent: str, rows: Floats) -> Int64:
    """Decisions of a function block, which remembers nothing."""
    return st_steps(text, rows)[1:, 0]


def st_steps(text: str, rows: Floats | Float64, *, reset: bool = False) -> Int64:
    """Answers of a function block, statement by statement for all observations, as `expected_answers`: each reaches the
    row's own. `rows`: [n, n_features], the last of which are remembered.
    """
    inputs = dict(re.findall(r"^    (x_\w+) : (\w+);", text, re.MULTILINE))
    kept = dict(re.findall(r"^    (\w+) : DINT := (-?\d+);", text, re.MULTILINE))
    state: dict[str, Any] = {
        name: rows[:, at].astype(np.float32 if kind == "REAL" else np.int64)
        for at, (name, kind) in enumerate(inputs.items())
    }
    state |= {name: rows[:, at].astype(np.int64) for at, name in enumerate(kept, len(inputs))}
    state |= {"reset": np.full(len(rows), reset), "act": np.full(len(rows), -1)}
    reached = [np.ones(len(rows), dtype=bool)]  # of each open IF, who is in the part that is read
    holding = list[Any]()
    for name, sign, literal, otherwise, ended, target, added, number in _ST.findall(text):
        if name:
            limit = np.float32(literal) if "." in literal else int(literal or 0)
            holding.append(state[name] < limit if sign == "<" else state[name] <= limit if sign else state[name])
            reached.append(reached[-1] & holding[-1])
        elif otherwise:
            reached[-1] = reached[-2] & ~holding[-1]
        elif ended:
            reached.pop()
            holding.pop()
        else:
            value = int(added + number) + (state[target] if added else 0)
            state[target] = np.where(reached[-1], value, state[target])
    told = np.column_stack([state[name] for name in ("act", *kept)])
    return np.concatenate([[[0, *map(int, kept.values())]], told]).astype(np.int64)


class Reader(NamedTuple):
    """The way to read back a target that is read agent by agent: `act(*contents, agent, rows)` gives the actions."""

    target: str
    files: tuple[str, ...]  # the names of what it reads, of {prefix} and {agent}
    act: Callable[..., Any]
    every: int = 1  # asked about one observation in so many, where reading is slow


def json_act(text: str, agent: str, rows: Any) -> list[Any]:
    """Decisions read from the JSON alone, as a stranger's program would make them."""
    document = cast(dict[str, Any], json.loads(text))
    policy = next(item for item in document["agents"] if item["agent"] == agent)
    if policy.get("arithmetic"):
        answers = [json_answer(policy, row) for row in iterate_rows(rows)]
        places = {action["name"]: place for place, action in enumerate(policy["actions"])}
        return [places[each] if places else each for each in answers]
    index: dict[str, int] = {feature["name"]: place for place, feature in enumerate(policy["features"])}
    number: dict[str, int] = {action["name"]: place for place, action in enumerate(policy["actions"])}
    nodes = cast(list[dict[str, Any]], policy["tree"])
    tests: list[tuple[int, float, int, int] | int] = [
        (index[node["feature"]], node["threshold"], node["left"], node["right"])
        if "feature" in node
        else number[node["action"]]
        for node in nodes
    ]
    decisions: list[int] = []
    numbers = np.ascontiguousarray(rows).reshape(-1).data  # gives doubles, and only those that are asked for
    for row in range(len(rows)):
        node, first = tests[0], row * len(index)
        while isinstance(node, tuple):
            feature, threshold, left, right = node
            node = tests[left if numbers[first + feature] <= threshold else right]
        decisions.append(node)
    return decisions


def load_reader(reader: str, text: str, agent: str) -> Any:
    """Returns the policy of the reference reader that is handed out with the JSON `text`; `act` decides."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        path = Path(folder) / "profile.json"
        path.write_text(text)
        return load_python(reader)["load"](path)[agent]


def reader_act(reader: str, text: str, agent: str, rows: Any) -> list[Any]:
    """Decisions of the reference reader."""
    act = load_reader(reader, text, agent).act
    return [act(row) for row in iterate_rows(rows)]


def drive_reader(policy: Any, rows: Float64) -> Int64:
    """The answers of the reference reader's policy, which remembers, to the rows of a sequence."""
    return drive_machine(policy.decide, policy.memory, rows)


def load_python(text: str) -> Mapping[str, Any]:
    """The namespace of a generated module, run from a file as its user would import it."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        path = Path(folder) / "generated_policy.py"
        path.write_text(text)
        return runpy.run_path(str(path))


def python_told(module: Mapping[str, Any], asked: Asked) -> Told:
    """Collects the answers of a Python module's namespace, beside decisions from observations."""
    agents = [policy.agent for policy in asked.profile.agents]
    tables: list[dict[str, Any]] = [module.get(name, {}) for name in ("FINITE", "IN_RANGE", "OBSERVE", "ACT_WORLD")]
    finite, in_range, observe, act_world = tables
    functions = [*observe.values(), *act_world.values()]
    functions += [module[name] for name in ("act_team", "in_region") if name in module]
    wrong = entries.single(len(asked.states[0]), asks=True)
    let = [each for function in functions for each in entries.find_accepted(function, wrong)]
    states, bordering = asked.states.tolist(), asked.bordering.tolist()
    checks = {
        agent: np.array([finite[agent](row) + 2 * in_range[agent](row) for row in iterate_rows(asked.rows[agent])])
        for agent in agents
    }
    remembered: dict[str, Any] = {}
    for agent, questions in asked.sequences.items():
        machine = module["MACHINE"][agent]()
        remembered[agent] = drive_machine(machine.step, machine.__dict__, questions.rows)
    return Told(
        checks=checks,
        constants=_python_constants(module, agents),
        observed={agent: np.array([see(w) for w in states], dtype=np.float64) for agent, see in observe.items()},
        acted={agent: np.array([act(w) for w in states]) for agent, act in act_world.items()},
        team=np.array([module["act_team"](w) for w in states]) if "act_team" in module else None,
        within=np.array([module["in_region"](w) for w in bordering]) if "in_region" in module else None,
        remembered=remembered,
        misused=len(wrong) * len(functions),
        accepted=tuple(let),
    )


def _python_constants(module: Mapping[str, Any], agents: Sequence[str]) -> list[float | str]:
    constants: list[float | str] = [module["DT"], module["DAMPING"], *module["COORDINATES"]]
    for agent in agents:
        constants.append(module["FORCE"][agent])
        constants += [value for effect in module["EFFECTS"][agent] for value in effect or (np.nan, np.nan)]
        constants += [end for pair in module["RANGES"][agent] for end in pair]
        constants += [meaning or "" for meaning in module["MEANINGS"][agent]]
        names: Any = module.get(f"Action_{identifier(agent)}", ())
        constants += [f"{action.name}={action.value}" for action in names]
        outputs, bounds = (module.get(table, {}).get(agent, ()) for table in ("OUTPUTS", "BOUNDS"))
        for output, ends in zip(outputs, bounds, strict=True):
            constants += [output, *(np.nan if end is None else end for end in ends)]
    return constants


class Ran(NamedTuple):
    """The results of a module in another language: decisions for numbers one by one, and for their values in the
    agent's numbers in a batch; how many wrong inputs it was given, and which of them it did not refuse.
    """

    single: Any
    batch: Any
    misused: int = 0
    accepted: Sequence[str] = ()


def javascript_act(text: str, model: Model, rows: Mapping[str, Float64], asked: Asked) -> tuple[dict[str, Ran], Told]:
    """Runs each agent's functions and collects the module's other answers. MissingToolError without Node.js."""
    node = _tool("node", "install Node.js, or leave the target javascript out")
    with tempfile.TemporaryDirectory(prefix="maviper-") as name:
        folder = Path(name)
        (folder / f"{model.prefix}.mjs").write_text(text)
        (folder / "harness.mjs").write_text(harness(model, "javascript"))
        _ask(folder, model, asked)
        for agent in model.agents:
            (folder / f"{agent.lower}.rows").write_bytes(rows[agent.name].astype("<f8").tobytes())
        _run([node, "harness.mjs"], folder, "the generated JavaScript does not run")
        runs: dict[str, Ran] = {}
        for agent in model.agents:
            single, batch = np.split(_answers(agent, folder / f"{agent.lower}.actions"), 2)
            misused = cast(dict[str, Any], json.loads((folder / f"{agent.lower}.json").read_text()))
            runs[agent.name] = Ran(single, batch, misused["asked"], misused["accepted"])
        return runs, _read_entries(folder, model)


def rust_act(
    text: str, model: Model, rows: Mapping[str, Floats], asked: Asked, optimised: bool = True
) -> tuple[dict[str, Ran], Told]:
    """Per agent its decisions, and what else the module answers. MissingToolError without rustc."""
    rustc = _tool("rustc", "install Rust, or leave the target rust out")
    with tempfile.TemporaryDirectory(prefix="maviper-") as name:
        folder = Path(name)
        (folder / f"{model.prefix}.rs").write_text(text)
        (folder / "main.rs").write_text(harness(model, "rust"))
        (folder / "alone.rs").write_text(f"#![no_std]\n#![deny(warnings)]\npub mod {model.prefix};\n")
        _ask(folder, model, asked)
        failed = "the generated Rust does not compile"
        _run([rustc, "--edition=2021", "--crate-type=lib", "--emit=metadata", "alone.rs"], folder, failed)
        _run([rustc, "--edition=2021", *(["-O"] if optimised else []), "main.rs", "-o", "run"], folder, failed)
        for agent in model.agents:
            (folder / f"{agent.lower}.rows").write_bytes(_bytes(agent, rows[agent.name]))
        _run([str(folder / "run")], folder, "the generated Rust does not run")
        acted = {agent.name: _answers(agent, folder / f"{agent.lower}.actions") for agent in model.agents}
        halves = {name: np.split(both, 2) for name, both in acted.items()}
        return {name: Ran(single, batch) for name, (single, batch) in halves.items()}, _read_entries(folder, model)


def _ask(folder: Path, model: Model, asked: Asked) -> None:
    """Writes what a harness reads: observations of each agent, and world states."""
    for agent in model.agents:
        (folder / f"{agent.lower}.asked").write_bytes(_bytes(agent, asked.rows[agent.name]))
    for agent, questions in asked.sequences.items():
        (folder / f"{identifier(agent)}.steps").write_bytes(questions.rows.astype("<f8").tobytes())
    for name, states in (("states", asked.states), ("bordering", asked.bordering)):
        (folder / name).write_bytes(states.astype("<f8").tobytes())


def _bytes(agent: Agent, rows: Floats) -> bytes:
    """Observations as a harness reads them."""
    return rows.astype("<f4" if agent.single else "<f8").tobytes()


def _read_entries(folder: Path, model: Model) -> Told:
    """Reads the answers that a harness left behind."""
    said = cast(dict[str, Any], json.loads((folder / "entries.json").read_text()))
    located = model.agents if model.located else ()
    together = model.located and model.acting
    team = _integers(folder / "team").reshape(-1, len(model.agents)) if together else None
    seen = [(agent, (folder / f"{agent.lower}.seen").read_bytes()) for agent in located]
    return Told(
        checks={agent.name: _integers(folder / f"{agent.lower}.checks") for agent in model.agents},
        # JSON knows no NaN, for which null stands, and may write 5 for 5.0
        constants=[x if isinstance(x, str) else np.nan if x is None else float(x) for x in said["constants"]],
        observed={a.name: np.frombuffer(raw, "<f8").reshape(-1, len(a.features)) for a, raw in seen},
        acted={agent.name: _answers(agent, folder / f"{agent.lower}.acted") for agent in located},
        team=team,
        within=_integers(folder / "within") if model.region else None,
        remembered={
            agent.name: _integers(folder / f"{agent.lower}.told").reshape(-1, 1 + len(agent.machine.memory))
            for agent in model.agents
            if agent.machine
        },
        misused=said.get("asked", 0),
        accepted=tuple(said.get("accepted", ())),
    )


def onnx_act(model: bytes, agent: str, rows: Floats) -> Any:
    """Decisions of a model in a batch, or numbers given. MissingToolError without onnxruntime."""
    return onnx_session(model).run(None, {"x": rows})[0]


def onnx_act_singly(model: bytes, agent: str, rows: Floats) -> Any:
    """Decisions of a model row by row, which a runtime makes in another way than those of a batch."""
    session = onnx_session(model)
    return np.array([session.run(None, {"x": row[None]})[0][0] for row in rows])


def onnx_session(model: bytes) -> Any:
    """A session of onnxruntime, in one thread. MissingToolError without it."""
    try:
        runtime: Any = import_module("onnxruntime")
    except ImportError:
        advice = "pip install onnxruntime, or leave the target onnx out"
        raise MissingToolError("onnxruntime is not installed", "", advice) from None
    options = runtime.SessionOptions()
    options.intra_op_num_threads = 1
    return runtime.InferenceSession(model, options, providers=["CPUExecutionProvider"])


def jax_act(text: str, agent: str, rows: Floats) -> Any:
    """Decisions of a batch under JAX."""
    module = _array_module(text, "jax")
    with with_doubles(module):
        return np.asarray(module["ACT"][agent](rows))


def jax_compiled_act(text: str, agent: str, rows: Floats) -> Any:
    """Decisions row by row, mapped over a batch and compiled."""
    module, jax = _array_module(text, "jax"), import_module("jax")
    with with_doubles(module):
        return np.asarray(jax.jit(jax.vmap(module["ACT"][agent]))(rows))


def with_doubles(module: Mapping[str, Any]) -> AbstractContextManager[None]:
    """JAX with float64, where a module's sums ask for it."""
    if "_doubles" not in module:
        return nullcontext()
    jax: Any = import_module("jax")
    return jax.enable_x64(True) if hasattr(jax, "enable_x64") else import_module("jax.experimental").enable_x64()


def torch_act(text: str, agent: str, rows: Floats) -> Any:
    """Decisions of a batch under PyTorch."""
    module, torch = _array_module(text, "torch"), import_module("torch")
    return module["ACT"][agent](torch.tensor(rows)).numpy()


def torch_mapped_act(text: str, agent: str, rows: Floats) -> Any:
    """Decisions row by row, mapped over a batch."""
    act, torch = _array_module(text, "torch")["ACT"][agent], import_module("torch")
    return torch.func.vmap(act)(torch.tensor(rows)).numpy()


def _array_module(text: str, library: str) -> Mapping[str, Any]:
    """The namespace of a module for an array library. MissingToolError without the library."""
    try:
        import_module(library)
    except ImportError:
        advice = f"pip install {library}, or leave the target {library} out"
        raise MissingToolError(f"{library} is not installed", "", advice) from None
    return load_python(text)


READERS = [
    Reader("json", ("{prefix}.json",), json_act),
    Reader("json reader", ("{prefix}_reader.py", "{prefix}.json"), reader_act, every=3),
    Reader("svg", ("{prefix}_{agent}.svg",), svg_act, every=7),
    Reader("st", ("{prefix}_{agent}.st",), st_act),
    Reader("onnx", ("{prefix}_{agent}.onnx",), onnx_act),
    Reader("onnx one by one", ("{prefix}_{agent}.onnx",), onnx_act_singly, every=5),
    Reader("onnx-old", ("{prefix}_{agent}.old.onnx",), onnx_act),
    Reader("onnx-old one by one", ("{prefix}_{agent}.old.onnx",), onnx_act_singly, every=5),
    Reader("jax", ("{prefix}_jax.py",), jax_act),
    Reader("jax, jit of vmap", ("{prefix}_jax.py",), jax_compiled_act),
    Reader("torch", ("{prefix}_torch.py",), torch_act),
    Reader("torch, vmap", ("{prefix}_torch.py",), torch_mapped_act),
]


def _tool(name: str, advice: str) -> str:
    found = shutil.which(name)
    if found is None:
        raise MissingToolError(f"{name} is not installed", "", advice)
    return found


def _run(command: list[str], folder: Path, failed: str) -> None:
    ran = run(command, folder)
    if ran.returncode != 0:
        lines = "\n".join(ran.stderr.strip().splitlines()[:5])
        raise DisagreementError(failed, lines, "this is a bug; nothing was written")


def _answers(agent: Agent, path: Path) -> Any:
    """Actions [n], or numbers given [n, n_outputs]."""
    return np.fromfile(path, "<f8").reshape(-1, *agent.answer_shape) if agent.answer_shape else _integers(path)


def _integers(path: Path) -> Int32:
    return np.frombuffer(path.read_bytes(), dtype="<i4").astype(np.int32)
