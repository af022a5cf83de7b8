"""Certificates mutated and forged, and what each then claims, in the judge's words.

Does: changes a certificate's document (names, bounds, parameters, proofs), makes its hash again, reads back what it
  says as a question for the judge.
Assumes: documents as `maviper verify -o` writes them.
Does not: check certificates.
"""

import base64
import copy
import json
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from tests.hunting.places import Case
from tests.hunting.reading import Profile
from tests.support.altered import sealed

Document = dict[str, Any]
SAME = "\u200b"  # a name with it looks like the name
STRANGE = ("nobody", "defenders" + SAME, "аgents", "defenders\r", "agents ", "predators\x1b[31m")
TRUE: dict[str, Any] = {"all": []}


# --- what a document says


def number(text: str) -> Fraction:
    """An exact number as files have it."""
    return Fraction(text.strip('"'))


def formula_of(node: Mapping[str, Any]) -> Any:
    """A formula as the judge has it."""
    if "sum" in node:
        terms = [("*", number(weight), name) for weight, name in node["sum"]]
        total = terms[0]
        for term in terms[1:]:
            total = ("+", total, term)
        return ("<=", total, number(node["most"])) if "most" in node else ("<", total, number(node["below"]))
    if "takes" in node:
        return ("takes", node["agent"], node["takes"])
    if "goal" in node:
        return ("goal", node["goal"])
    if "not" in node:
        return ("not", formula_of(node["not"]))
    return ("and" if "all" in node else "or", *map(formula_of, node.get("all", node.get("any"))))


def region_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """A region as the judge has it."""

    def pair(bounds: Sequence[str]) -> tuple[Fraction, Fraction]:
        low, high = map(number, bounds)
        return low, high

    return {
        "box": {name: pair(bounds) for name, bounds in document["box"].items()},
        "goals": document["goals"],
        "differences": [(*text.split(" - "), pair(bounds)) for text, bounds in document["difference"].items()],
        "apart": [(*text.split(" - "), number(least)) for text, least in document["apart"].items()],
    }


def case_of(document: Mapping[str, Any], profile: Profile) -> Case:
    """The question that a certificate says it answers."""
    stated, eps = document["property"], number(document.get("eps", "0"))
    claim: dict[str, Any] = {"of": "", "assume": None, "landmarks": (), "margin": Fraction(0), "mixed": True}
    if stated is None:
        teams = {profile.agent(name).team for name in _acting(document["formula"])}
        claim |= {"name": "formula", "formula": formula_of(document["formula"]), "team": min(teams, default="")}
        claim |= {"radius": Fraction(0), "eps": eps}
    else:
        claim |= {"name": stated["name"], "team": stated["team"], "of": stated.get("of", ""), "eps": eps}
        claim |= {key: number(stated[key]) for key in ("margin", "radius", "kappa") if key in stated}
        claim["landmarks"] = tuple(stated.get("landmarks", ()))
    return Case(profile, claim, region_of(document["region"]), document["semantics"])


def _acting(node: Any) -> set[str]:
    if isinstance(node, Mapping):
        own = {node["agent"]} if "takes" in node else set()
        return own.union(*map(_acting, node.values()))
    return set().union(*map(_acting, node)) if isinstance(node, list) else set()


# --- changes


def _proof(document: Document, rng: np.random.Generator) -> tuple[str, bytearray]:
    goal = str(rng.choice(list(document["proofs"])))
    return goal, bytearray(base64.b64decode("".join(document["proofs"][goal])))


def _set(document: Document, goal: str, proof: bytes) -> None:
    document["proofs"][goal] = [base64.b64encode(bytes(proof)).decode()]


def emptied(document: Document, rng: np.random.Generator) -> None:
    """No proof at all, or nothing but zeros."""
    for goal in document["proofs"]:
        _set(document, goal, bytes(int(rng.integers(0, 4))))


def flipped(document: Document, rng: np.random.Generator) -> None:
    """A few bytes of a proof are others."""
    goal, proof = _proof(document, rng)
    for _ in range(int(rng.integers(1, 4)) if proof else 0):
        proof[int(rng.integers(len(proof)))] = int(rng.integers(0, 12))
    _set(document, goal, proof)


def cut(document: Document, rng: np.random.Generator) -> None:
    """A proof ends early, or goes on."""
    goal, proof = _proof(document, rng)
    place = int(rng.integers(0, len(proof) + 1))
    _set(document, goal, proof[:place] if rng.random() < 0.5 else proof[:place] + proof[place + 1 :])


def nobody(document: Document, rng: np.random.Generator) -> None:
    """About a team that there is not: true of all of nobody."""
    if document["property"] is None:
        document["property"] = {"name": "distinct_targets", "margin": "0", "radius": "1/10", "kappa": "1/2"}
        document["property"]["landmarks"] = []
    team = STRANGE[int(rng.integers(len(STRANGE)))]
    document["property"]["team"] = team
    document["formula"] = TRUE
    for goal in document["proofs"]:
        _set(document, goal, b"")


def claimed(document: Document, rng: np.random.Generator) -> None:
    """Another parameter, with the formula as it was."""
    stated = document["property"]
    if stated is not None:
        key, value = [("margin", "1/2"), ("radius", "0"), ("team", "adversaries")][int(rng.integers(3))]
        stated[key] = value


def wider(document: Document, rng: np.random.Generator) -> None:
    """A region with a bound moved outwards, or without a difference or distance."""
    region = document["region"]
    for key in ("difference", "apart"):
        if region[key] and rng.random() < 0.6:
            region[key].pop(next(iter(region[key])))
            return
    name = str(rng.choice(list(region["box"])))
    low, high = map(number, region["box"][name])
    more = Fraction(int(rng.integers(1, 5)), 4)
    region["box"][name] = [f"{low - more}", f"{high + more}"]


def goals(document: Document, rng: np.random.Generator) -> None:
    """The proof of one goal stands for another."""
    known = list(document["region"]["goals"])
    if known:
        other = "landmark_1" if known[0] == "landmark_0" else "landmark_0"
        document["region"]["goals"] = [other]
        document["proofs"] = {other: document["proofs"][known[0]]}


def swapped(document: Document, rng: np.random.Generator) -> None:
    """The other arithmetic."""
    document["semantics"] = "real" if document["semantics"] == "machine" else "machine"


def noisier(document: Document, rng: np.random.Generator) -> None:
    """Errors allowed, or larger ones."""
    document["eps"] = str(2 * number(document.get("eps", "1/200")))
    if document["property"] is not None and "eps" in document["property"]:
        document["property"]["eps"] = document["eps"]


def strengthened(document: Document, rng: np.random.Generator) -> None:
    """A formula without a name, one of its bounds another."""
    document["property"] = None
    text = json.dumps(document["formula"])
    found = json.loads(text)
    atoms = list(_atoms(found))
    if atoms:
        atom = atoms[int(rng.integers(len(atoms)))]
        key = "most" if "most" in atom else "below"
        atom[key] = str(number(atom[key]) - Fraction(int(rng.integers(1, 9)), 8))
    document["formula"] = found


def renamed(document: Document, rng: np.random.Generator) -> None:
    """A formula without a name, about the other agents or landmarks."""
    document["property"] = None
    text = json.dumps(document["formula"])
    a, b = [("landmark_0", "landmark_1"), ("agent_0", "agent_1")][int(rng.integers(2))]
    document["formula"] = json.loads(text.replace(a, "@").replace(b, a).replace("@", b))


def _atoms(node: Any) -> Sequence[dict[str, Any]]:
    if isinstance(node, dict):
        return [node] if "sum" in node else [atom for value in node.values() for atom in _atoms(value)]
    return [atom for part in node for atom in _atoms(part)] if isinstance(node, list) else []


FORGERIES: tuple[Callable[[Document, np.random.Generator], None], ...] = (
    emptied, flipped, cut, nobody, claimed, wider, goals, swapped, noisier, strengthened, renamed,
)  # fmt: skip


def forged(text: str, rng: np.random.Generator) -> tuple[str, Document, str]:
    """(how, document, text) of a changed certificate."""
    document = copy.deepcopy(json.loads(text))
    forgery = FORGERIES[int(rng.integers(len(FORGERIES)))]
    forgery(document, rng)
    return forgery.__name__, document, sealed(document)
