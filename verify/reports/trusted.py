"""What the verdicts of a report rest on, in words: modules, engines, and the meanings of features.

Does: says what a proof with a certificate, one without, and a counterexample rest on.
Assumes: a test that holds the lists of verify/checker/README.md against what the checker imports.
Does not: import them.
"""

from collections.abc import Collection, Sequence

from codegen.importers.reading import find_uncompared
from codegen.ir import PolicyProfile

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
    facts = profile.provenance.training
    return [
        f"that {agent} was read as its language means it (the reader of {facts.get(f'{agent} from', 'its file')}): its "
        "source was not compared"
        for agent in find_uncompared(profile)
    ]


def systems(enclosed: bool, counted: Collection[str], flowing: bool = False) -> list[str]:
    """All lines of a report about a stated system. `enclosed`: some of its rules are not affine; `counted`: what the
    checker counts in its certificates; `flowing`: it moves in continuous time.
    """
    if flowing:
        return [SYSTEMS_WITH_SETS, SYSTEM_READ, FLOW_REPLAYED]
    covers = [SYSTEMS_WITH_COVER] if set(counted) - {"branches"} else []
    walked = [SYSTEMS_WITH_CERTIFICATE] if "branches" in counted or not covers else []
    return [*walked, *covers, SYSTEM_READ, *([SYSTEM_ENCLOSED] if enclosed else []), SYSTEM_REPLAYED]
