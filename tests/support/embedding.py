"""What several tests use of `test_embedding`."""

from maviper.episodes.play import play, tree_policies
from maviper.worlds.games.particle import SUCCESS
from maviper.worlds.matching import matching_world
from tests.support.generated import FOLDER

EMBEDDING = FOLDER.parent / "embedding"
SEED, EPISODES, FEW = 9_600_000, 4_000, 200


def ours(team, starts, ends=True):
    """What our simulator says of episodes from these starts, in the lines of the programs; C's say where they end."""
    world = matching_world(team)
    episodes = play(world, [tree_policies(team.agents)] * len(team.agents), starts)
    rows = [world.measures.index(measure) for measure in world.measures if measure.name == SUCCESS[0]]
    assert [world.measures[row].team for row in rows] == ["adversaries", "defenders"] and len(starts) > 0
    successes = episodes.values[rows].astype(int)
    actions = episodes.actions.transpose(1, 0, 2).tolist()
    last = episodes.states[-1].position[:, : len(team.agents)].reshape(len(starts), -1).tolist()
    lines = []
    for wins, steps, end in zip(successes.T.tolist(), actions, last, strict=True):
        words = [*map(str, wins), *("".join(map(str, step)) for step in steps)]
        lines.append(" ".join([*words, *(f"{value:.17g}" for value in end)] if ends else words))
    assert all(0 < row.sum() < len(starts) for row in successes), "nothing to tell apart"
    return [*lines, *summary(successes)]


def summary(successes):
    n = successes.shape[1]
    teams = zip(("adversaries", "defenders"), successes.sum(axis=1).tolist(), strict=True)
    return [f"{team} success r=0.316: {wins} of {n} episodes, {wins / n:.3f}" for team, wins in teams]
