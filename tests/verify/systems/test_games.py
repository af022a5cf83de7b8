"""Particle games without contacts as world files: the same verdicts as by the engine for games."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import permutations

import pytest

from codegen.errors import InputError
from tests.support.episode_cases import arriving
from tests.support.game_files import world_file
from tests.support.system_cases import decided
from tests.support.teams import STAY, team, tree
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region_files import everywhere
from verify.episodes.composition import decide as decided_by_zones
from verify.question import Budgets, Question
from verify.reach.unbounded import Approach, RegionSearch
from verify.result import Verdict
from verify.subjects import Game
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.files import statement_of
from verify.systems.system import Affine, HalfSpace

RADIUS = F(2, 5)


def near(pairs, radius=RADIUS):
    """Each agent at a landmark, on both axes."""
    found = []
    for agent, mark in pairs:
        for axis in "xy":
            gap = {f"{agent}.{axis}": F(1), f"{mark}.{axis}": F(-1)}
            found.append(HalfSpace(Affine.of(gap, -radius)))
            found.append(HalfSpace(Affine().plus(Affine.of(gap), F(-1)).plus(Affine((), -radius))))
    return tuple(found)


def claims_of(name, steps):
    """What `reaches` and `covers` say of the two defenders: for reaches a claim for each of them."""
    agents, marks = ("agent_0", "agent_1"), ("landmark_0", "landmark_1")
    if name == "reaches":
        return [SystemClaim(Pattern.REACHES, (near([pair]),), steps) for pair in zip(agents, marks, strict=True)]
    regions = tuple(near(zip(agents, order, strict=True)) for order in permutations(marks))
    return [SystemClaim(Pattern.REACHES_AND_STAYS, regions, steps, by=steps)]


def joined(verdicts):
    for worst in (Verdict.VIOLATED, Verdict.UNKNOWN):
        if worst in verdicts:
            return worst
    return Verdict.PROVED


def by_file(profile, name, region, steps):
    system = statement_of(world_file(profile, region, "landmark_0"), "game.toml").system
    return joined([result.verdict for result in decided(profile, system, claims_of(name, steps))])


def by_zones(profile, name, region, steps):
    claim = find_claim(name, profile, steps=steps)
    return decided_by_zones(Question(Game(profile), claim, region, budgets=Budgets(max_zones=200_000))).verdict


def placed(profile, half, **middles):
    """A region of boxes around places; everything else at 0."""
    start = everywhere(profile)
    box = {name: (F(0), F(0)) for name in start.box}
    for name, middle in middles.items():
        entity, axis = name.rsplit("_", 1)
        box[f"{entity}.{axis}"] = (F(middle) - half, F(middle) + half)
    return replace(start, box=box, goals=("landmark_0",))


CASES = [
    ("still", "reaches", F(1, 20), {"landmark_0_x": F(3, 10)}, 3, Verdict.PROVED),
    ("still", "covers", F(1, 20), {"landmark_0_x": F(3, 10)}, 3, Verdict.PROVED),
    ("still", "covers", F(1, 20), {"landmark_0_x": F(2, 5)}, 3, Verdict.VIOLATED),
    ("arrivers", "reaches", F(1, 10), {"landmark_0_x": F(1), "landmark_1_y": F(-1)}, 12, Verdict.PROVED),
    ("arrivers", "reaches", F(1, 10), {"landmark_0_x": F(1), "landmark_1_y": F(-1)}, 4, Verdict.VIOLATED),
    ("arrivers", "covers", F(1, 20), {"landmark_0_x": F(1, 2), "landmark_1_y": F(-1, 2)}, 6, None),
]


@pytest.mark.parametrize(("who", "name", "half", "middles", "steps", "known"), CASES)
def test_the_same_verdicts(profile, who, name, half, middles, steps, known):
    trees = [arriving(0), arriving(1)] if who == "arrivers" else [tree(STAY), tree(STAY)]
    one = team(profile, *trees)
    region = placed(one, half, **middles)
    zones = by_zones(one, name, region, steps)
    assert by_file(one, name, region, steps) == zones and known in (None, zones)


def test_an_extracted_team(profile):
    """Trees that were learned, in small regions: what one engine decides the other one does too."""
    for seed, steps in ((0, 3), (1, 5)):
        middles = {f"agent_{k}_{axis}": F((seed + k + 1) * (-1) ** k, 4) for k in range(2) for axis in "xy"}
        region = placed(profile, F(1, 50), **middles, landmark_0_x=F(1, 2), landmark_1_x=F(-1, 2))
        for name in ("reaches", "covers"):
            assert by_file(profile, name, region, steps) == by_zones(profile, name, region, steps)


def test_what_is_no_such_file(profile):
    region = everywhere(profile)
    with pytest.raises(InputError, match="not convex"):
        world_file(profile, replace(region, apart=(("agent_0", "agent_1", F(1, 2)),)), "landmark_0")
    fast = [replace(agent, max_speed=1.0) for agent in profile.world.agents]
    with pytest.raises(InputError, match="speed limit"):
        world_file(replace(profile, world=replace(profile.world, agents=tuple(fast))), region, "landmark_0")
    hard = [replace(agent, collides=True) for agent in profile.world.agents]
    with pytest.raises(InputError, match="contacts"):
        world_file(
            replace(profile, world=replace(profile.world, agents=tuple(hard), contact_force=100.0)),
            region,
            "landmark_0",
        )


# --- for ever

ARENA = F(3)
FASTEST, COASTING = F(2), F(2, 5)  # the top speed, and how far an agent coasts for each unit of speed


def between(low, high, **terms):
    """The half spaces of a sum between two numbers."""
    total = Affine.of({name.replace("__", "."): F(factor) for name, factor in terms.items()})
    return (HalfSpace(total.plus(Affine((), -high))), HalfSpace(Affine().plus(total, F(-1)).plus(Affine((), low))))


def in_the_arena(agent, axis, edge):
    """That an agent stays in the arena for ever, and why: where it would come to rest lies within an edge."""
    place, speed = f"{agent}__{axis}", f"{agent}__v{axis}"
    far = edge + COASTING * FASTEST
    invariant = [*between(-edge, edge, **{place: 1, speed: COASTING}), *between(-FASTEST, FASTEST, **{speed: 1})]
    invariant += between(-far, far, **{place: 1})
    for mark in ("landmark_0", "landmark_1"):
        invariant += between(F(-1), F(1), **{f"{mark}__{axis}": 1})
    region = between(-ARENA, ARENA, **{place: 1})
    return SystemClaim(Pattern.ALWAYS, (region,), 60, invariant=(tuple(invariant),))


def system_of(profile, goal="landmark_0"):
    return statement_of(world_file(profile, everywhere(profile), goal), "game.toml").system


def test_an_extracted_team_stays_in_the_arena_for_ever(profile):
    """Whatever all others do, from everywhere: beyond the landmarks the trees never push outwards."""
    walks = ("landmark_0", "agent_0", "x", (6, 12)), ("landmark_1", "agent_1", "y", (5, 10))
    for goal, agent, axis, walked in walks:
        claim = in_the_arena(agent, axis, F(11, 5))
        (found,) = decided(profile, system_of(profile, goal), [claim], Budgets(max_boxes=40_000))  # 15,616 are played
        assert found.verdict is Verdict.PROVED
        assert (found.states, found.programs) == walked and found.boxes < 10  # of the walk, in the budget of the file
        (part,) = found.certificate.proof.parts
        assert part.regions[0].walk is not None and accept(found.certificate, profile, system_of(profile, goal)) > 0


def test_a_walk_ends_where_the_budget_does(profile):
    """One step by exact rows takes no more than is left, but for the question at hand."""
    claim = in_the_arena("agent_0", "x", F(11, 5))
    search = RegionSearch(profile, system_of(profile), claim, claim.invariant, 400)
    with pytest.raises(RejectedError, match="too many symbolic states"):
        search.part(1, [Approach()], 2_000)
    assert 2_000 <= search.walking.total + search.spent < 4_000 and search.walking.left == 0


def test_a_team_that_leaves_the_arena(profile):
    """Pushed to the right for ever, nobody stays; an edge that is too near is no invariant."""
    right = [action.name for action in profile.policy("agent_0").actions].index("right")
    runaway = team(profile, tree(right), tree(STAY))
    (found,) = decided(runaway, system_of(runaway), [in_the_arena("agent_0", "x", F(11, 5))])
    assert found.verdict is Verdict.VIOLATED and abs(found.counterexample.states[-1]["agent_0.x"]) > ARENA
    near = in_the_arena("agent_0", "x", F(11, 10))
    with pytest.raises(RejectedError, match="may leave"):
        RegionSearch(profile, system_of(profile), near, near.invariant, 400).part(1, [Approach()], 10**6)
