"""What Frama-C proves of the C: goals and processor time of each committed policy, and of an agent with 64 leaves.

    python -m tests.benchmarks.contracts [--json] [--record] [--new]

Each policy is proved alone in both styles (`nested` only where it compares float64), one after the other. Times are
seconds of processor time, of Frama-C and Z3 together, so that other work on the machine does not count. `--record`
renews the table of generated/contracts; with `--new`, contracts that it has keep their rows.
Policies with more than 64 leaves in an agent are named and left out.
"""

import argparse
import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.agreement.build import build
from codegen.equivalence.contracts import contracts_of
from codegen.lowering.lower import lower
from codegen.policy_json import content_hash
from maviper import load
from maviper.compilation.proofs import prove_contracts

GENERATED = Path(__file__).parents[2] / "generated"
RECORD = GENERATED / "contracts"
STYLES = ("nested", "ordered")
LEAVES = 64  # of an agent, up to which every goal is to be proved
REACH = {"nested": 60.0, "ordered": 60.0}  # seconds, at so many leaves
HEAD = (
    "| policy | style | agents | leaves | goals | proved | axioms | proved | processor time, s |\n" + "|---" * 9 + "|\n"
)
INTRO = """# The C of the committed policies, proved by Frama-C

Each row is a policy, compiled in a style: the goals that Frama-C's WP made of its contracts, how many it proved, the
axioms about floats that it used, and how many of them Z3 proved by SMT-LIB's theory of IEEE 754. What a contract says
and assumes: `maviper guide compiling`. Frama-C 25.0, Why3 1.5.1, Z3 4.8.12.

`table.json` holds the rows with the hash of each contract. `python -m tests.benchmarks.contracts --record` renews both;
only the times change with the machine.

"""


def shipped() -> dict[str, ir.PolicyProfile]:
    """The committed profiles by folder, equal ones once, but for those that have no contracts."""
    found: dict[str, ir.PolicyProfile] = {}
    hashes: set[str] = set()
    for path in sorted(GENERATED.rglob("profile.json")):
        profile = load(path)
        if content_hash(profile) not in hashes and not summing(profile):
            hashes.add(content_hash(profile))
            found[path.parent.relative_to(GENERATED).as_posix()] = profile
    return found


def too_large(profile: ir.PolicyProfile) -> bool:
    """Whether an agent has more leaves than are proved here."""
    return max(len(ir.leaves(policy.tree)) for policy in profile.agents) > LEAVES


def summing(profile: ir.PolicyProfile) -> bool:
    """Whether an agent tests sums of features or gives numbers, for which there are no contracts."""
    return any(policy.tree.arithmetic for policy in profile.agents)


def styles_of(profile: ir.PolicyProfile) -> tuple[str, ...]:
    """The styles that a policy compiles in: `ordered` compares the bits of float32 alone."""
    return STYLES[:1] if any(policy.numbers == "float64" for policy in profile.agents) else STYLES


def full() -> ir.PolicyProfile:
    """One agent with 64 leaves, six tests deep, over ten features."""
    profile = load(GENERATED / "proved_defenders" / "profile.json")
    policy, rng = profile.agents[1], np.random.default_rng(1)
    rows: list[list[float]] = []

    def grow(level: int, box: dict[int, tuple[float, float]]) -> int:
        me = len(rows)
        rows.append([-1, 0.0, -1, -1, -1])
        if level == 0:
            rows[me][4] = int(rng.integers(len(policy.actions)))
            return me
        feature = int(rng.integers(len(policy.features)))
        low, high = box.get(feature, (-2.0, 2.0))
        middle = float(np.float32(rng.uniform(low, high)))
        sides = [grow(level - 1, box | {feature: half}) for half in ((low, middle), (middle, high))]
        rows[me][:4] = [feature, middle, *sides]
        return me

    grow(6, {})
    tree = ir.Tree(*(np.array(column) for column in zip(*rows, strict=True)))
    return replace(profile, agents=(replace(policy, tree=tree, grown=None, seen=()),))


def contract_hash(profile: ir.PolicyProfile, style: str) -> str:
    """Of what is to be proved, whatever else the profile says: its provenance, or how often a leaf is visited."""
    contracts = contracts_of(profile, lower(profile, style=style))
    text = contracts.files[contracts.source].replace(content_hash(profile), "")
    return hashlib.sha256(text.encode()).hexdigest()


def row_of(name: str, profile: ir.PolicyProfile, style: str) -> dict[str, Any]:
    """What the tools say of a policy in a style."""
    with build(profile, ["c"], style=style) as made:
        contracts = contracts_of(profile, made.model)
        found = prove_contracts(made, contracts)
    return {
        "policy": name,
        "contract": contract_hash(profile, style),
        "style": style,
        "agents": len(contracts.functions),
        "leaves": contracts.leaves,
        "goals": found.goals,
        "proved": found.goals - len(found.open_goals),
        "axioms": found.axioms,
        "axioms proved": found.axioms - found.open_axioms,
        "cpu_s": round(found.cpu_s, 1),
    }


def line(row: dict[str, Any]) -> str:
    """A row of the table in Markdown."""
    return "| " + " | ".join(str(value) for name, value in row.items() if name != "contract") + " |\n"


def main() -> None:
    """Prints the table, and records it where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--record", action="store_true", help="renew generated/contracts")
    parser.add_argument("--new", action="store_true", help="prove only contracts that the record does not have")
    given = parser.parse_args()
    recorded = json.loads((RECORD / "table.json").read_text()) if given.new else []
    known = {(row["contract"], row["style"]): row for row in recorded}
    policies = {f"random, {LEAVES} leaves": full()} | shipped()
    rows, left_out = list[dict[str, Any]](), [name for name, each in policies.items() if too_large(each)]
    if not given.json:
        print(HEAD, end="", flush=True)
    for name, profile in policies.items():
        if name in left_out:
            continue
        for style in styles_of(profile):
            kept = known.get((contract_hash(profile, style), style))
            rows.append(kept | {"policy": name} if kept else row_of(name, profile, style))
            if not given.json:
                print(line(rows[-1]), end="", flush=True)
    leaves = {name: max(len(ir.leaves(one.tree)) for one in policies[name].agents) for name in left_out}
    sizes = ", ".join(f"{name} ({count})" for name, count in leaves.items()) or "none"
    closing = f"\nAsked of agents of up to {LEAVES} leaves, in {REACH['nested']:.0f} s. Left out, with more: {sizes}.\n"
    if given.json:
        figures = [
            {"name": f"seconds at {LEAVES} leaves, {row['style']}", "value": row["cpu_s"], "reach": REACH[row["style"]],
             "stretch": 30.0, "better": "lower"}
            for row in rows[: len(STYLES)]
        ]  # fmt: skip
        still = sum(row["goals"] + row["axioms"] - row["proved"] - row["axioms proved"] for row in rows)
        figures.append({"name": "open goals", "value": still, "reach": 0, "stretch": 0, "better": "lower"})
        print(json.dumps({"figures": figures}))
    else:
        print(closing)
    if given.record:
        RECORD.mkdir(exist_ok=True)
        (RECORD / "README.md").write_text(INTRO + HEAD + "".join(map(line, rows)) + closing)
        (RECORD / "table.json").write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
