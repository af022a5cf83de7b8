"""Monitors in Rust: clippy has nothing to say about them, and they need nothing of std, as they say."""

import shutil
from pathlib import Path

import pytest

from codegen.lowering.lower import lower
from codegen.targets import monitor
from maviper import load
from maviper.compilation.monitors import load_proof, lower_monitor
from tests.support.monitors import lint_rust

GENERATED = Path(__file__).parents[3] / "generated"
PROOFS = {
    "turned boxes": "arch/tora_reach/certificate-1-reaches_and_stays.json",
    "boxes": "worlds/crossing/certificate-1-stays_in.json",
    "many boxes": "worlds/cart_pole/certificate-1-stays_in.json",
    "decisions of a game": "verdicts/physical_deception/certificate-1-distinct_targets.json",
    "episodes of a game": "verdicts/physical_deception/certificate-8-reaches.json",
}


@pytest.mark.skipif(shutil.which("clippy-driver") is None, reason="no clippy")
@pytest.mark.parametrize("name", [*[*PROOFS][:-1], pytest.param("episodes of a game", marks=pytest.mark.slow)])
def test_clippy_has_nothing_to_say(name, tmp_path):
    """Neither does a linter that would say nothing of anything: an operation without effect is seen."""
    certificate = GENERATED / PROOFS[name]
    profile = load(certificate.parent / "profile.json")
    (text,) = monitor.emit(lower_monitor(profile, lower(profile), load_proof(certificate, profile)), ["rust"]).values()
    quiet, said = lint_rust(text, tmp_path)
    assert quiet, said
    quiet, said = lint_rust(f"{text}\npub fn planted(step: usize) -> usize {{\n    step * 1\n}}\n", tmp_path)
    assert not quiet and "identity_op" in said
