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
from maviper.evaluate.metrics import ratio, shown
from maviper.experts.expert import Expert
from maviper.experts.finding import LEARNED, find_expert
from maviper.experts.measured import Measured
from maviper.extract.algorithms import extract
from maviper.extract.outcome import Progress, measured_of
from maviper.extract.settings import Settings
from maviper.worlds import World


def extract_to_file(expert: str, settings: Mapping[str, Any], output: Path, console: Console) -> ir.PolicyProfile:
    """Extracts from the named expert and writes the profile to `output`."""
    chosen = dict(settings)
    critic, named, jobs = chosen.pop("critic", LEARNED), chosen.pop("world", None), chosen.pop("jobs", 1)
    checked = Settings.of(chosen)
    found, world = find_expert(expert, critic, named)
    runs.target(output)  # before the work, not after it
    profile = extract_live(world, found, checked, console, jobs)
    runs.write(output, policy_json.dumps(profile))
    console.line("wrote", f"{output}  id {policy_json.content_hash(profile)[:16]}")
    return profile


def extract_live(world: World, expert: Expert, settings: Settings, console: Console, jobs: int = 1) -> ir.PolicyProfile:
    """Extracts with a live line, then says what the trees reach."""
    made = expert.card.get("algorithm", "unknown")
    critic = ", measured critic" if isinstance(expert, Measured) else ""
    console.line("expert", f"{made} for {world.name}{critic}{f', id {expert.hash[:16]}' if expert.hash else ''}")
    with console.live("extracting", settings.iterations) as live:

        def show(progress: Progress) -> None:
            best = ", ".join(f"{team} {shown(found)}" for team, found in progress.best_measured.items())
            live.update(progress.iteration + 1, f"best {best}  {progress.leaves} leaves")

        profile = extract(world, expert, settings, show, jobs)
    say_measured(profile, world, console)
    return profile


def say_measured(profile: ir.PolicyProfile, world: World, console: Console) -> None:
    """Each team's measures against expert opponents beside the expert's own, on held-out episodes."""
    measured = profile.provenance.evaluation
    for name in dict.fromkeys(measure.name for measure in world.measures):
        parts = []
        for measure in world.measures:
            if measure.name == name:
                ours, theirs = measured_of(measured, measure)
                found = ratio(measure, ours, theirs)
                text = "no ratio" if found is None else f"ratio {found:.2f}"
                parts.append(f"{measure.team} {ours:.3f} (expert {theirs:.3f}, {text})")
        console.line("measured", f"{name}: {'; '.join(parts)}, {measured['episodes']} held-out episodes")
