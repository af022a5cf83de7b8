"""The algorithms by name, and what follows all of them.

Does: runs the one that the settings ask for, chooses among its iterates, refines the choice, makes the profile.
Assumes: checked settings.
Does not: know how any of them works.
"""

from codegen import ir
from codegen.ir import GrownTree
from maviper.experts.expert import Expert
from maviper.extract import fitted_q, imitation, iviper, maviper, refine, released
from maviper.extract.journal import NOTHING_KEPT, Journal
from maviper.extract.outcome import agent_policies, profile_of
from maviper.extract.selection import KINDS, OnProgress
from maviper.extract.settings import IVIPER, VIPER, Settings
from maviper.worlds import World


def extract(
    world: World,
    expert: Expert,
    settings: Settings,
    on_progress: OnProgress = lambda progress: None,
    jobs: int = 1,
    journal: Journal = NOTHING_KEPT,
) -> ir.PolicyProfile:
    """The policy profile that an algorithm extracts. `jobs` changes how long it takes, never what comes out; `journal`
    keeps what is done, and a later call with the same arguments goes on from there.
    """
    settings = settings.checked().resolved(world)
    refine.check(settings)
    agents = [iviper.agent_of(world, settings)] if settings.algorithm == VIPER else list(range(len(world.agents)))
    chosen, facts = _iterates(world, expert, settings, agents, on_progress, jobs, journal)
    trees, spent = refine.refined(world, expert, settings, agents, chosen, on_progress, jobs, journal)
    return profile_of(world, expert, settings, agent_policies(world, trees, agents), {**facts, **spent})


def _iterates(
    world: World,
    expert: Expert,
    settings: Settings,
    agents: list[int],
    on_progress: OnProgress,
    jobs: int,
    journal: Journal,
) -> tuple[list[list[GrownTree]], dict[str, int]]:
    """The best trees of each agent, the chosen one first, and what the provenance says of them."""
    if settings.algorithm == VIPER:
        found, facts = iviper.best_trees(world, expert, settings, agents[0], journal, on_progress)
        return [found], facts
    if settings.algorithm == IVIPER:
        return iviper.iviper(world, expert, settings, journal, on_progress, jobs)
    selection = KINDS[settings.selection](world, expert, settings, journal, on_progress)
    match settings.algorithm, settings.preset:
        case "imitation", "released":
            points = released.imitation(world, expert, settings, selection, journal)
        case "imitation", _:
            points = imitation.imitation(world, expert, settings, selection, journal)
        case "fitted-q", _:
            points = fitted_q.fitted_q(world, expert, settings, selection)
        case _, "released":
            points = released.maviper(world, expert, settings, selection, journal)
        case _:
            points = maviper.maviper(world, expert, settings, selection, journal)
    return selection.chosen(), {**selection.facts, "points": points}
