"""The algorithms by name.

Does: runs the one that the settings ask for.
Assumes: checked settings.
Does not: know how any of them works.
"""

from codegen import ir
from maviper.experts.expert import Expert
from maviper.extract import fitted_q, imitation, iviper, maviper
from maviper.extract.outcome import OnIteration
from maviper.extract.settings import Settings
from maviper.worlds import World


def extract(
    world: World,
    expert: Expert,
    settings: Settings,
    on_iteration: OnIteration = lambda progress: None,
    jobs: int = 1,
) -> ir.PolicyProfile:
    """The policy profile that an algorithm extracts. `jobs` changes how long it takes, never what comes out."""
    settings.checked()
    match settings.algorithm:
        case "viper":
            return iviper.viper(world, expert, settings, on_iteration)
        case "iviper":
            return iviper.iviper(world, expert, settings, on_iteration, jobs)
        case "imitation":
            return imitation.imitation(world, expert, settings, on_iteration)
        case "fitted-q":
            return fitted_q.fitted_q(world, expert, settings, on_iteration)
        case _:
            return maviper.extract(world, expert, settings, on_iteration)
