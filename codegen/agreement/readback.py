"""Decisions read back from the text of targets, each by means that its emitter does not use.

Does: runs JavaScript under Node.js and Rust by rustc, ONNX under onnxruntime, walks JSON and SVG as a
  stranger would.
Assumes: programs on the path; a scratch folder.
Does not: compare (selfcheck.py).
"""

import json
import runpy
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, cast
from xml.etree import ElementTree

import numpy as np

from codegen.errors import DisagreementError, MissingToolError
from codegen.ir import Float32, Float64, Int32
from codegen.lowering.lower import Agent, Model
from codegen.targets import javascript, rust

LIMIT_S = 120
_SVG = "{http://www.w3.org/2000/svg}"


class Reader(NamedTuple):
    """How a target that is read agent by agent is read back: `act(*contents, agent, rows)` gives the actions."""

    target: str
    files: tuple[str, ...]  # the names of what it reads, of {prefix} and {agent}
    act: Callable[..., Any]
    every: int = 1  # asked about one observation in so many, where reading is slow


def json_act(text: str, agent: str, rows: Any) -> list[int]:
    """Decisions read from the JSON alone, as a stranger's program would make them."""
    document = cast(dict[str, Any], json.loads(text))
    policy = next(item for item in document["agents"] if item["agent"] == agent)
    index: dict[str, int] = {feature["name"]: place for place, feature in enumerate(policy["features"])}
    number: dict[str, int] = {action["name"]: place for place, action in enumerate(policy["actions"])}
    nodes = cast(list[dict[str, Any]], policy["tree"])
    decisions: list[int] = []
    for row in cast(list[list[float]], rows.tolist()):
        place = 0
        while "feature" in nodes[place]:
            node = nodes[place]
            place = int(node["left"] if row[index[node["feature"]]] <= node["threshold"] else node["right"])
        decisions.append(number[nodes[place]["action"]])
    return decisions


def shipped_reader(reader: str, text: str, agent: str) -> Callable[[Any], int]:
    """How the reference reader that is handed out with the JSON `text` decides for an observation."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        path = Path(folder) / "profile.json"
        path.write_text(text)
        return load_python(reader)["load"](path)[agent].act


def shipped_reader_act(reader: str, text: str, agent: str, rows: Any) -> list[int]:
    """Decisions of the reference reader."""
    act = shipped_reader(reader, text, agent)
    return [act(row) for row in rows.tolist()]


def load_python(text: str) -> Mapping[str, Any]:
    """The namespace of a generated module, run from a file as its user would import it."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        path = Path(folder) / "generated_policy.py"
        path.write_text(text)
        return runpy.run_path(str(path))


class Ran(NamedTuple):
    """What a JavaScript module did: decisions for doubles one by one, and for their float32 values in a batch; how many
    wrong inputs it was given, and which of them it did not refuse.
    """

    single: Int32
    batch: Int32
    misused: int
    accepted: list[str]


def javascript_act(text: str, model: Model, rows: Mapping[str, Float64]) -> dict[str, Ran]:
    """What each agent's functions do. MissingToolError without Node.js."""
    node = _tool("node", "install Node.js, or leave the target javascript out")
    with tempfile.TemporaryDirectory(prefix="maviper-") as name:
        folder = Path(name)
        (folder / f"{model.prefix}.mjs").write_text(text)
        (folder / "harness.mjs").write_text(javascript.harness(model))
        for agent in model.agents:
            (folder / f"{agent.lower}.rows").write_bytes(rows[agent.name].astype("<f8").tobytes())
        _run([node, "harness.mjs"], folder, "the generated JavaScript does not run")
        found: dict[str, Ran] = {}
        for agent in model.agents:
            single, batch = np.split(_actions(folder, agent), 2)
            misuse = cast(dict[str, Any], json.loads((folder / f"{agent.lower}.json").read_text()))
            found[agent.name] = Ran(single, batch, misuse["asked"], misuse["accepted"])
    return found


def rust_act(text: str, model: Model, rows: Mapping[str, Float32]) -> dict[str, tuple[Int32, Int32]]:
    """Per agent, decisions and input checks. MissingToolError without rustc."""
    rustc = _tool("rustc", "install Rust, or leave the target rust out")
    with tempfile.TemporaryDirectory(prefix="maviper-") as name:
        folder = Path(name)
        (folder / f"{model.prefix}.rs").write_text(text)
        (folder / "main.rs").write_text(rust.harness(model))
        (folder / "alone.rs").write_text(f"#![no_std]\n#![deny(warnings)]\npub mod {model.prefix};\n")
        failed = "the generated Rust does not compile"
        _run([rustc, "--edition=2021", "--crate-type=lib", "--emit=metadata", "alone.rs"], folder, failed)
        _run([rustc, "--edition=2021", "-O", "main.rs", "-o", "run"], folder, failed)
        for agent in model.agents:
            (folder / f"{agent.lower}.rows").write_bytes(rows[agent.name].astype("<f4").tobytes())
        _run([str(folder / "run")], folder, "the generated Rust does not run")
        found = {agent.name: _actions(folder, agent).reshape(-1, 2) for agent in model.agents}
    return {name: (both[:, 0], both[:, 1]) for name, both in found.items()}


def onnx_act(model: bytes, agent: str, rows: Float32) -> Int32:
    """Decisions of a model in a batch. MissingToolError without onnxruntime."""
    return onnx_session(model).run(["action"], {"x": rows})[0]


def onnx_act_singly(model: bytes, agent: str, rows: Float32) -> Int32:
    """Decisions of a model row by row, which a runtime makes in another way than those of a batch."""
    session = onnx_session(model)
    return np.array([session.run(["action"], {"x": row[None]})[0][0] for row in rows], dtype=np.int32)


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


def svg_act(text: str, agent: str, rows: Float32) -> Int32:
    """Decisions read from the attributes of a picture's elements. `agent`: whose picture it is."""
    nodes = {int(group.attrib["data-node"]): group.attrib for group in ElementTree.fromstring(text).iter(f"{_SVG}g")}
    found = np.empty(len(rows), dtype=np.int32)
    for place, row in enumerate(rows):
        node = nodes[0]
        while "data-feature" in node:
            threshold = float.fromhex(node["data-threshold"].rstrip("f"))
            goes_left = float(row[int(node["data-feature"])]) <= threshold
            node = nodes[int(node["data-left" if goes_left else "data-right"])]
        found[place] = int(node["data-action"])
    return found


READERS = [
    Reader("json", ("{prefix}.json",), json_act),
    Reader("json reader", ("{prefix}_reader.py", "{prefix}.json"), shipped_reader_act, every=3),
    Reader("svg", ("{prefix}_{agent}.svg",), svg_act, every=7),
    Reader("onnx", ("{prefix}_{agent}.onnx",), onnx_act),
    Reader("onnx one by one", ("{prefix}_{agent}.onnx",), onnx_act_singly, every=5),
]


def _tool(name: str, advice: str) -> str:
    found = shutil.which(name)
    if found is None:
        raise MissingToolError(f"{name} is not installed", "", advice)
    return found


def _run(command: list[str], folder: Path, failed: str) -> None:
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=LIMIT_S)
    if ran.returncode != 0:
        lines = "\n".join(ran.stderr.strip().splitlines()[:5])
        raise DisagreementError(failed, lines, "this is a bug; nothing was written")


def _actions(folder: Path, agent: Agent) -> Int32:
    return np.frombuffer((folder / f"{agent.lower}.actions").read_bytes(), dtype="<i4").astype(np.int32)
