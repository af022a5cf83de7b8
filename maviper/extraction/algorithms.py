"""The algorithms by name, and what follows all of them.

Does: runs the one that the settings ask for, chooses among its iterates, refines the choice, makes the profile.
Assumes: checked settings.
Does not: know how any of them works.
"""

from dataclasses import replace

from codegen import ir
from codegen.errors import InputError
from codegen.ir import GrownTree
from maviper.episodes.trees import agent_policies
from maviper.experts.expert import Expert
from maviper.extraction import fitted_q, imitation, iviper, maviper
from maviper.extraction.examples import NO_EXAMPLES, Examples
from maviper.extraction.extraction import QUIETLY, Extraction, Running
from maviper.extraction.journal import NOTHING_KEPT, Journal
from maviper.extraction.outcome import profile_of
from maviper.extraction.released import released
from maviper.extraction.selection import refine
from maviper.extraction.selection.race import KINDS
from maviper.extraction.settings import FITTED_Q, IVIPER, VIPER, Settings
from maviper.worlds import World


def extract(
    world: World,
    expert: Expert,
    settings: Settings,
    running: Running = QUIETLY,
    journal: Journal = NOTHING_KEPT,
    examples: Examples = NO_EXAMPLES,
) -> ir.PolicyProfile:
    """The policy profile that an algorithm extracts. `journal` keeps what is done, and a later call with the same
    arguments goes on from there. `examples`: states whose labels every iteration learns from as well; refinement
    keeps them.
    """
    settings = settings.checked().resolved(world)
    world, settings = settings.judged(world), replace(settings, measure=settings.measure_in(world))
    refine.check(settings)
    check(world, settings, examples)
    agents = [iviper.agent_of(world, settings)] if settings.algorithm == VIPER else list(range(len(world.agents)))
    asked = Extraction(world, expert, settings, journal, examples)
    chosen, facts = _iterates(asked, agents, running)
    trees, spent = refine.refined(asked, agents, chosen, running)
    facts = {**facts, **spent, **examples.facts}
    return profile_of(world, expert, settings, agent_policies(world, trees, agents), facts)


def check(world: World, settings: Settings, examples: Examples) -> None:
    """InputError where the algorithm cannot learn from examples, or the preset's weight is beyond computing."""
    released.check(world, settings)
    if len(examples) and settings.algorithm == FITTED_Q:
        what = "fitted-q learns from rewards, not from labelled states"
        raise InputError(what, "--counterexamples", "choose another --algorithm, or leave them out")


def _iterates(asked: Extraction, agents: list[int], running: Running) -> tuple[list[list[GrownTree]], dict[str, int]]:
    """The best trees of each agent, the chosen one first, and what the provenance says of them."""
    world, expert, settings = asked.world, asked.expert, asked.settings
    journal, examples = asked.journal, asked.examples
    if settings.algorithm == VIPER:
        found, facts = iviper.best_trees(asked, agents[0], running.on_progress)
        return [found], facts
    if settings.algorithm == IVIPER:
        return iviper.iviper(asked, running)
    selection = KINDS[settings.selection](world, expert, settings, journal, running.on_progress)
    match settings.algorithm, settings.preset:
        case "imitation", "released":
            points = released.imitation(world, expert, settings, selection, journal, examples)
        case "imitation", _:
            points = imitation.imitation(world, expert, settings, selection, journal, examples)
        case "fitted-q", _:
            points = fitted_q.fitted_q(world, expert, settings, selection)
        case _, "released":
            points = released.maviper(world, expert, settings, selection, journal, examples)
        case _:
            points = maviper.maviper(world, expert, settings, selection, journal, examples)
    return selection.chosen(), {**selection.facts, "points": points}
