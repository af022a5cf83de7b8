"""Extraction as a command: find the expert, extract with a live line, write the profile.

Does: joins expert store, algorithm, console and file.
Assumes: settings come from the command line or the demo.
Does not: know how trees are grown.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from codegen import ir, policy_json
from maviper import runs
from maviper.console import Console
from maviper.evaluate.metrics import shown
from maviper.experts import store
from maviper.experts.network import Expert
from maviper.extract import maviper as algorithm
from maviper.worlds import ParticleWorld


def extract_to_file(expert: str, settings: Mapping[str, Any], output: Path, console: Console) -> ir.PolicyProfile:
    """Extracts from the named expert and writes the profile to `output`."""
    checked = algorithm.Settings(**settings).checked()
    found, world = store.load(expert)
    runs.target(output)  # before the work, not after it
    profile = extract_live(world, found, checked, console)
    runs.write(output, policy_json.dumps(profile))
    console.line("wrote", f"{output}  id {policy_json.content_hash(profile)[:16]}")
    return profile


def extract_live(
    world: ParticleWorld, expert: Expert, settings: algorithm.Settings, console: Console
) -> ir.PolicyProfile:
    """Extracts with a live line, then says what the trees reach."""
    console.line("expert", f"{expert.card.get('algorithm', 'unknown')} for {world.name}, id {expert.hash[:16]}")
    with console.live("extracting", settings.iterations) as live:

        def show(progress: algorithm.Progress) -> None:
            best = ", ".join(f"{team} {shown(won)}" for team, won in progress.best_success.items())
            live.update(progress.iteration + 1, f"best {best}  {progress.leaves} leaves")

        profile = algorithm.extract(world, expert, settings, show)
    say_success(profile, world, console)
    return profile


def say_success(profile: ir.PolicyProfile, world: ParticleWorld, console: Console) -> None:
    """Each team's success against expert opponents beside the expert's own, at both radii, on held-out episodes."""
    measured = profile.provenance.evaluation
    for squared in world.squared_radii:
        label = f"r={squared**0.5:.3g}"
        parts = []
        for team in world.teams:
            ours, theirs = algorithm.success_of(measured, team, squared)
            ratio = f"ratio {ours / theirs:.2f}" if theirs else "no ratio"
            parts.append(f"{team} {ours:.3f} (expert {theirs:.3f}, {ratio})")
        console.line("success", f"{label}: {'; '.join(parts)}, {measured['episodes']} held-out episodes")
