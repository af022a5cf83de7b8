"""What an algorithm's name stands for: settings that can be changed one by one, and the ladder from IVIPER to MAVIPER.

Does: names the values of these settings, the bundle of each algorithm, the rungs, and the agents that a setting groups.
Assumes: nothing.
Does not: hold what a user asked for (settings.py), or act on it.
"""

from collections.abc import Sequence
from typing import Any

from maviper.worlds import World

MAVIPER, IVIPER, VIPER, IMITATION, FITTED_Q = "maviper", "iviper", "viper", "imitation", "fitted-q"
NO_PREDICTION, IVIPER_RESAMPLING = "maviper-no-prediction", "maviper-iviper-resampling"
ALGORITHMS = (MAVIPER, IVIPER, VIPER, IMITATION, FITTED_Q, NO_PREDICTION, IVIPER_RESAMPLING)
RGMDT = "rgmdt"  # not of the paper; what is known of it is its description
BEST_RESPONSE = "best-response"  # ours
KNOWN = (*ALGORITHMS, BEST_RESPONSE, RGMDT)
DESCRIBED = {RGMDT: "after the description in arXiv 2410.16517"}
JOINT = (MAVIPER, NO_PREDICTION, IVIPER_RESAMPLING)  # the trees of all agents come from the same episodes

AGENT, TEAM, ALL = "agent", "team", "all"  # who plays, or is chosen, together
MEMBER = "member"  # each member of a team has a round of its own, judged by how the team plays
NOTHING, SHARES = "", ("", TEAM)  # for whom there is one tree
EXPERTS = "experts"  # no tree plays while data are collected
ROLLOUTS_BY, SELECTION_BY = (EXPERTS, AGENT, TEAM, ALL), (AGENT, MEMBER, TEAM, ALL)
EXPERT, RESPONSE = "expert", "response"  # what a tree is taught: the expert's action, or the best reply to its mates
LABELS = (EXPERT, RESPONSE)
OWN, AVERAGED, EQUAL = "own", "averaged", "equal"
REGRET = "regret"  # no weights: trees are grown on what each action costs in a state
WEIGHTS = (OWN, AVERAGED, EQUAL, REGRET)
N_LESS_1, NO_VOTES = "N-1", "0"
UNIFORM, RETURN, RACE = "uniform", "return", "race"
CHOSEN_BY = {UNIFORM: ALL, RETURN: TEAM, RACE: TEAM}  # unless an algorithm says otherwise

_JOINT: dict[str, str] = {"rollouts_by": ALL, "weights": AVERAGED, "least_right": N_LESS_1}
_ALONE: dict[str, str] = {"rollouts_by": AGENT, "weights": OWN, "least_right": NO_VOTES, "selection_by": AGENT}
_EXPERTS: dict[str, str] = {"rollouts_by": EXPERTS, "weights": EQUAL, "least_right": NO_VOTES}
BUNDLES: dict[str, dict[str, str]] = {
    MAVIPER: _JOINT,
    NO_PREDICTION: {**_JOINT, "least_right": NO_VOTES},
    IVIPER_RESAMPLING: {**_JOINT, "weights": OWN},
    IVIPER: _ALONE,
    VIPER: _ALONE,
    IMITATION: _EXPERTS,
    FITTED_Q: _EXPERTS,
    RGMDT: {"rollouts_by": ALL, "weights": EQUAL, "least_right": NO_VOTES},
    BEST_RESPONSE: {"labels": RESPONSE, "rollouts_by": ALL, "weights": OWN, "least_right": NO_VOTES},
}
PARTS = ("labels", "rollouts_by", "weights", "least_right", "selection_by")

# What the released code does besides its text, each of which can be undone alone: leaves that stand still, a collector
# that starts a new episode at every step, and 500 expert episodes ahead of all. Who does which:
LEAVES, RESTARTS, WARM_UP = "leaves", "restarts", "warm-up"
ACCIDENTS: dict[str, tuple[str, ...]] = {
    IVIPER: (LEAVES, WARM_UP),
    VIPER: (LEAVES, WARM_UP),
    IMITATION: (LEAVES, RESTARTS),
    **dict.fromkeys(JOINT, (WARM_UP,)),
}

# From IVIPER to MAVIPER and one step beyond: each rung is one difference from the one before it.
RUNGS: dict[str, dict[str, str]] = {
    "iviper": {"algorithm": IVIPER},
    "joint-rollouts": {"algorithm": MAVIPER, "weights": OWN, "least_right": NO_VOTES, "selection_by": AGENT},
    "joint-selection": {"algorithm": MAVIPER, "weights": OWN, "least_right": NO_VOTES},
    "averaged-weights": {"algorithm": NO_PREDICTION},
    "vote-N-1": {"algorithm": MAVIPER},
    "vote-N": {"algorithm": MAVIPER, "least_right": "N"},
}
# Fitted Q that sees other actions than its expert's while it collects, so that its trees are no constant.
EXPLORING = "fitted-q-exploring"
VARIANTS: dict[str, dict[str, Any]] = {**RUNGS, EXPLORING: {"algorithm": FITTED_Q, "explore": 0.3}}
# From joint selection to best responses, where rounds are chosen by races.
OUR_RUNGS: dict[str, dict[str, str]] = {
    "joint-selection": RUNGS["joint-selection"],
    "member-selection": {"algorithm": BEST_RESPONSE, "labels": EXPERT},
    "best-response": {"algorithm": BEST_RESPONSE},
}


def bundle(algorithm: str, selection: str, share: str = NOTHING) -> dict[str, str]:
    """The settings that an algorithm's name stands for. `selection`: how an iterate is chosen; `share`: members of a
    team that share a tree play and choose together, where each would do so alone.
    """
    settings = {"labels": EXPERT, "selection_by": CHOSEN_BY[selection], **BUNDLES[algorithm]}
    if algorithm == BEST_RESPONSE and selection == RACE and not share:
        settings["selection_by"] = MEMBER
    if share == TEAM:
        settings |= {name: TEAM for name in ("rollouts_by", "selection_by") if settings[name] == AGENT}
    return settings


def group_agents(world: World, by: str, agents: Sequence[int]) -> list[list[int]]:
    """Some agents in the groups that a setting makes of them, in the world's order."""
    if by == AGENT:
        return [[agent] for agent in agents]
    if by in (TEAM, MEMBER):
        mine = [[agent for agent in world.members(team) if agent in agents] for team in world.teams]
        return [members for members in mine if members]
    return [list(agents)]


def wider(one: str, other: str) -> str:
    """That of two groupings whose groups hold the other's."""
    return max(one, other, key=(AGENT, MEMBER, TEAM, ALL, EXPERTS).index)
