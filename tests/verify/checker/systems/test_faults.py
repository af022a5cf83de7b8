"""Every planted fault in a reading of stated systems is caught by its guard; without a fault no guard speaks."""

import ast
import json
from pathlib import Path

import pytest

from tests.support.sources import parsed
from tests.support.system_faults import ALL
from tests.support.system_guards import (
    ANSWERED,
    BROKEN,
    FORGED,
    HELD,
    JUDGED,
    OPINED,
    POINTS,
    asked,
    find_case,
    forgeries,
    opinions,
)
from verify.checker.systems import branch_proofs, reading
from verify.result import SETTLED, Verdict
from verify.solver import unrolled

pytestmark = pytest.mark.solver
SEEN = Path(__file__).parent / "seen.json"  # fault -> the number of its guard's case that saw it
CONSTRUCTING = ("__init__", "sum")
NO_READING = ("Answers",)  # what somebody who answers must have
ELSEWHERE = {  # caught by what calls them, or in what they are imported into
    "reading.decisions": "branch_proofs.decisions",
    "reading.alternatives": "branch_proofs.alternatives",
    "Proof.visit": "does nothing",
    "Proof.hull": "SystemQuestions.ensure_within",
    "Proof.asks_fulfilled": "SystemQuestions._iterate_unfulfilled",
    "Proof._times": "Proof.side",
    "Proof._number": "Proof.side",
    "unrolled.opinion": "unrolled.encode_claim",
    "unrolled.size": "says only what is not asked",
    "branch_proofs._is_mode": "in test_modes.py",
    "unrolled._is_mode": "in test_modes.py",
    **dict.fromkeys(
        (
            "branch_proofs.acting",
            "branch_proofs.close_branches",
            "branch_proofs.depends_on",
            "branch_proofs.ensure_asked",
            "branch_proofs.needs_stated",
            "branch_proofs._check_premise",
            "branch_proofs._ensure_known",
        ),
        "branch_proofs.check_certificate",
    ),
}.keys()


@pytest.fixture(scope="module", autouse=True)
def known():
    """Questions and forgeries, as they are without a fault."""
    verdicts = [verdict for _, verdict in asked()]
    assert verdicts.count(Verdict.PROVED) > 60 and verdicts.count(Verdict.VIOLATED) > 60 and None not in verdicts
    assert len(forgeries()) > 300
    said = list(zip(verdicts, opinions(), strict=True))
    assert all(second is first for first, second in said if first in SETTLED and second is not Verdict.UNKNOWN)
    assert {first for first, second in said if second is Verdict.VIOLATED} == {Verdict.VIOLATED, Verdict.UNKNOWN}


@pytest.fixture(scope="module")
def seen(request):
    """Which case saw each fault, and is asked first: a fault is the sooner seen, and others are asked all the same."""
    cases = json.loads(SEEN.read_text())
    yield cases
    if request.config.getoption("--update-golden"):
        SEEN.write_text(json.dumps(cases, indent=1, sort_keys=True) + "\n")


@pytest.mark.parametrize("fault", ALL, ids=lambda fault: f"{fault.place}: {fault.name}")
def test_the_fault_is_caught(fault, monkeypatch, seen):
    named = f"{fault.place}: {fault.name}"
    fault.plant(monkeypatch)
    seen[named] = find_case(fault.guard, seen.get(named))
    assert seen[named] is not None, f"{named}: went unnoticed, though {fault.guard}"


@pytest.mark.parametrize("guard", [BROKEN, HELD, FORGED, ANSWERED, POINTS, JUDGED, OPINED])
def test_without_a_fault_no_guard_speaks(guard):
    assert find_case(guard) is None


def functions(module):
    """(place, name) of each function of a module, as faults name their places."""
    for node in parsed(Path(module.__file__)).body:
        owner, inner = (node.name, node.body) if isinstance(node, ast.ClassDef) else (module.__name__, [node])
        for each in inner:
            if isinstance(each, ast.FunctionDef) and each.name not in CONSTRUCTING and owner not in NO_READING:
                yield f"{owner.rpartition('.')[2]}.{each.name}"


@pytest.mark.parametrize("module", [reading, branch_proofs, unrolled])
def test_every_part_of_checker_and_second_engine_has_a_fault(module):
    assert len({(fault.place, fault.name) for fault in ALL}) == len(ALL) > 100
    assert not set(functions(module)) - {fault.place for fault in ALL} - ELSEWHERE
