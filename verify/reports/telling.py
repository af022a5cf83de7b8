"""How a report tells of one kind of claim, as functions; what it says of several kinds, and what verdicts rest on.

Does: names these functions; counts the sets of a proof, and says what they show; says what a proof with a certificate,
  one without, and a counterexample rest on: modules, engines, and the meanings of features.
Assumes: a module that has them for each kind; a test that holds the lists of verify/checker/README.md against what the
  checker imports.
Does not: know the kinds (report.py), or import what it names.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codegen.ir import PolicyProfile
from codegen.wording import format_count

POSITIONS = "Positions are finite float64. Agents may leave the region during an episode (see the on-policy states)."
SHARES = (
    "Shares are estimated from uniform samples, with 95 % Wilson intervals. The verdict does not depend on them.",
)
NOWHERE = "no state within the ranges lies in what it avoids"
WEAK = ", so it says little about these trees"  # where most shuffled leaves fulfil the claim too

SETS = {  # by what the checker counts: one of them, and what they do
    "boxes": ("box", "cover all episodes"),
    "forms": ("form", "cover all episodes"),
    "sets": ("set", "hold all states at all times"),
    "cells": ("cell", "hold what they become"),
}


@dataclass(frozen=True)
class Telling:
    """The way in which a report tells of one kind of claim."""

    facts: Callable[[PolicyProfile, Any, str], dict[str, Any]]  # of a result, with the command that repeats it
    limits: Callable[[PolicyProfile, Sequence[Any]], list[str]]  # what the verdicts do not say
    trusted: tuple[str, ...]  # what proofs rest on
    lines: Callable[[Any], tuple[str, list[str]]] | None = None  # what was asked, and lines under it; None: of a game
    words: Callable[[Any, Mapping[str, Any]], list[str]] = lambda result, told: []  # first lines under it, of a game


def sets(told: Mapping[str, Any]) -> str:
    """Counts the sets of a result's proof, in words; "" where it is none by sets."""
    proof = told.get("certificate", {})
    return next((format_count(proof[kind], noun) for kind, (noun, _) in SETS.items() if kind in proof), "")


def describe_sets(told: Mapping[str, Any]) -> str:
    """The same with what they show."""
    proof = told.get("certificate", {})
    return next((f"{sets(told)} {does}" for kind, (_, does) in SETS.items() if kind in proof), "")


LISTED = "and the modules that verify/checker/README.md lists for it"
WITH_CERTIFICATE = (
    f"for a proof about single decisions with a certificate: its checker (verify/checker/decisions), {LISTED}"
)
WITHOUT_CERTIFICATE = (
    "for a proof about single decisions without a certificate: the solver, and the encoder of trees, roundings and "
    "claim (verify/solver/encode.py)"
)
EPISODES_WITH_CERTIFICATE = (
    f"for a proof about episodes with a certificate: its checker (verify/checker/episodes), {LISTED}; and the dynamics "
    "in the profile's world spec"
)
EPISODES_WITHOUT_CERTIFICATE = (
    "for a proof about episodes without a certificate: one reading, which nothing checks, by the zones and their steps "
    "(verify/episodes: composition, contacts, unroll, zones), and the dynamics in the profile's world spec"
)
SYSTEMS_WITH_CERTIFICATE = (
    f"for a proof about a stated system: its checker (verify/checker/systems), {LISTED}; and that the statement is "
    "true of what it is about"
)
SYSTEMS_WITH_COVER = (
    f"for a proof about a stated system by boxes or affine forms: its checker (verify/checker/covers), {LISTED}; "
    "that the processor rounds float64 to nearest, of which the checker asks samples; and that the statement is true "
    "of what it is about"
)
SYSTEMS_WITH_SETS = (
    f"for a proof about continuous time: its checker (verify/checker/flows), {LISTED}; that the processor rounds "
    "float64 to nearest, of which the checker asks samples; and that the statement is true of what it is about"
)
SYSTEM_READ = "that the world file was read as it is meant: verify/systems (files, and what it imports)"
SYSTEM_ENCLOSED = (
    "for rules that are not affine: the checker's own arithmetic (verify/checker/systems/enclosures.py), which showed "
    "their enclosures (verify/systems/enclosures.py) again, and does so at every `maviper check`"
)
SYSTEM_REPLAYED = (
    "for a counterexample: no engine, but the exact replay (verify/reach/replay.py, verify/systems/observing.py), "
    "which `maviper replay` runs again"
)
FLOW_REPLAYED = (
    "for a counterexample: the checker's steps, which follow its start alone (verify/flows/episodes.py); `maviper "
    "replay` runs them again"
)
REPLAYED = "for a counterexample: none of this, since it can be replayed"
REFEREED = (
    "for a counterexample in real arithmetic: the referee (verify/states/state.py, and what it imports); `maviper "
    "replay` asks it again"
)
MEANINGS = "the meanings of the features in the profile"
UNCHECKED = f"{MEANINGS} (not checked: this version cannot play the profile's world)"
CHECKED = f"{MEANINGS} (the same as those of this version's world)"
OBSERVED = "that an agent is given the numbers that its features name, in their units (not checked)"
EXACT_WORLD = "that world's steps equal the reference environment's bit by bit"


def texts(checked: bool | None, proofs: Sequence[str], replayed: Sequence[str]) -> list[str]:
    """All lines of a report. `checked`: the features have the meanings of a world that this version plays; None: claims
    are over observations, of which no meaning is asked. `proofs`: what those of each kind rest on.
    """
    lines = [f"{CHECKED}; {EXACT_WORLD}" if checked else UNCHECKED]
    lines = [OBSERVED] if checked is None else lines
    return [*lines, *proofs, *replayed]


def readers(profile: PolicyProfile) -> list[str]:
    """A line for each imported agent whose source was compared with nothing: its reader must be right."""
    from codegen.importers.reading import find_uncompared  # here, as only whole reports tell of readers

    facts = profile.provenance.training
    return [
        f"that {agent} was read as its language means it (the reader of {facts.get(f'{agent} from', 'its file')}): its "
        "source was not compared"
        for agent in find_uncompared(profile)
    ]


def rests_on(enclosed: bool, counted: Collection[str], flowing: bool = False) -> list[str]:
    """All lines of a report about a stated system. `enclosed`: some of its rules are not affine; `counted`: what the
    checker counts in its certificates; `flowing`: it moves in continuous time.
    """
    if flowing:
        return [SYSTEMS_WITH_SETS, SYSTEM_READ, FLOW_REPLAYED]
    covers = [SYSTEMS_WITH_COVER] if set(counted) - {"branches"} else []
    walked = [SYSTEMS_WITH_CERTIFICATE] if "branches" in counted or not covers else []
    return [*walked, *covers, SYSTEM_READ, *([SYSTEM_ENCLOSED] if enclosed else []), SYSTEM_REPLAYED]
