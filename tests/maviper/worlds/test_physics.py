"""The physics of the authors' fork: bit for bit those of a plain referee, and refused where they do not count."""

import math

import numpy as np
import pytest

from codegen import policy_json, profiles
from codegen.errors import InputError, UnknownNameError
from maviper.cli import main
from maviper.evaluation import held_out
from maviper.evaluation.players import find_player, find_shipped
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.page.page import unplayable
from maviper.worlds import find
from maviper.worlds.matching import matching_world
from tests.support.games import crowded
from verify.claims.claim import verifiable

MOVES = ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))
TIME_STEP, DAMPING, STIFFNESS, SOFTNESS = 0.1, 0.25, 100.0, 1e-3
SENSITIVITY = 5.0  # of an agent without an acceleration


class Body:
    """A disc. `accel`: None where a game states none."""

    def __init__(self, size, movable, collides, accel=None, limit=None):
        self.size, self.movable, self.collides, self.accel, self.limit = size, movable, collides, accel, limit
        self.x = self.y = self.vx = self.vy = 0.0


def tag(predators=2, prey=2, obstacles=2):
    """The bodies of predator-prey."""
    hunters = [Body(0.075, True, True, 3.0, 1.0) for _ in range(predators)]
    return [*hunters, *(Body(0.05, True, True, 4.0, 1.3) for _ in range(prey))] + [
        Body(0.2, False, True) for _ in range(obstacles)
    ]


def spread(agents=3):
    """The bodies of cooperative navigation."""
    return [Body(0.15, True, True) for _ in range(agents)] + [Body(0.05, False, False) for _ in range(agents)]


def adversary(defenders=2):
    """The bodies of physical deception."""
    return [Body(0.15, True, False) for _ in range(defenders + 1)] + [
        Body(0.08, False, False) for _ in range(defenders)
    ]


class ForkEnv:
    """A game of the fork. `velocity_first` and `twice` can be switched off, to see what each of them does."""

    def __init__(self, bodies, velocity_first=True, twice=True):
        self.bodies, self.velocity_first, self.twice = bodies, velocity_first, twice

    def reset(self, positions, velocities):
        """[n_bodies, 2] and [n_agents, 2]."""
        for body, (x, y) in zip(self.bodies, positions, strict=True):
            body.x, body.y = float(x), float(y)
        for body, (vx, vy) in zip(self.bodies, velocities, strict=False):
            body.vx, body.vy = float(vx), float(vy)
        return self.state()

    def state(self):
        """Positions of all bodies, velocities of those that move."""
        moving = [body for body in self.bodies if body.movable]
        return np.array([(each.x, each.y) for each in self.bodies]), np.array([(each.vx, each.vy) for each in moving])

    def step(self, actions):
        """One step; `actions`: the index of each agent's."""
        forces = [[0.0, 0.0] for _ in self.bodies]
        for force, body, action in zip(forces, self.bodies, actions, strict=False):
            often = 2 if self.twice else 1
            strength = SENSITIVITY if body.accel is None else body.accel**often
            force[0], force[1] = (part * strength for part in MOVES[int(action)])
        for one, first in enumerate(self.bodies):
            for other in range(one + 1, len(self.bodies)):
                self.push(forces, one, other, first, self.bodies[other])
        for force, body in zip(forces, self.bodies, strict=True):
            if body.movable:
                self.move(body, *force)
        return self.state()

    @staticmethod
    def push(forces, one, other, first, second):
        """Both are pushed apart, where both collide and one of them moves."""
        if not (first.collides and second.collides and (first.movable or second.movable)):
            return
        dx, dy = first.x - second.x, first.y - second.y
        apart = math.sqrt(dx * dx + dy * dy)
        depth = float(np.logaddexp(0, -(apart - (first.size + second.size)) / SOFTNESS)) * SOFTNESS
        for axis, gap in enumerate((dx, dy)):
            push = STIFFNESS * gap / apart * depth
            forces[one][axis] += push
            forces[other][axis] -= push

    def move(self, body, fx, fy):
        """Velocity, its limit, position."""
        old = body.vx, body.vy
        body.vx = body.vx * (1 - DAMPING) + fx * TIME_STEP
        body.vy = body.vy * (1 - DAMPING) + fy * TIME_STEP
        speed = math.sqrt(body.vx * body.vx + body.vy * body.vy)
        if body.limit is not None and speed > body.limit:
            body.vx, body.vy = body.vx / speed * body.limit, body.vy / speed * body.limit
        vx, vy = (body.vx, body.vy) if self.velocity_first else old
        body.x, body.y = body.x + vx * TIME_STEP, body.y + vy * TIME_STEP


FORK = "physics=released"
GAMES = {
    f"physical-deception,{FORK}": adversary,
    f"physical-deception,defenders=3,{FORK}": lambda: adversary(3),
    f"cooperative-navigation,{FORK}": spread,
    f"cooperative-navigation,agents=5,{FORK}": lambda: spread(5),
    f"predator-prey,{FORK}": tag,
    f"predator-prey,prey=1,predators=3,{FORK}": lambda: tag(3, 1),
}


def played(world, bodies, state, steps, rng, **changes):
    """Whether the simulator's states are the referee's after each step of each game, bit for bit."""
    alike = []
    for row in range(len(state)):
        env = ForkEnv(bodies(), **changes)
        env.reset(state.position[row], state.velocity[row])
        now = state[row : row + 1]
        for _ in range(steps):
            actions = rng.integers(5, size=(1, len(world.agents)))
            now = world.step(now, actions, exact=True)
            position, velocity = env.step(actions[0])
            alike.append((now.position[0] == position).all() and (now.velocity[0] == velocity).all())
    return alike


@pytest.mark.parametrize("name", GAMES)
def test_episodes_are_the_referees_bit_for_bit(name):
    world, rng = find(name), np.random.default_rng(1)
    assert all(played(world, GAMES[name], world.start_from_seeds(range(8)), 25, rng))


@pytest.mark.parametrize("name", GAMES)
def test_steps_in_crowds_and_at_speed_are_the_referees(name):
    """Also through contacts, from states that touch and move faster than allowed."""
    world = find(name)
    state = crowded(world, 60, 3)
    assert all(played(world, GAMES[name], state, 2, np.random.default_rng(2)))


@pytest.mark.parametrize("changes", [{"velocity_first": False}, {"twice": False}])
def test_a_referee_without_one_of_the_two_disagrees(changes):
    name = f"predator-prey,{FORK}"
    world = find(name)
    assert not any(played(world, tag, world.start_from_seeds(range(4)), 3, np.random.default_rng(1), **changes)[1::3])


def test_accelerations_that_no_game_states_count_once():
    assert [entity.force for entity in find(f"predator-prey,{FORK}").spec.agents] == [9.0, 9.0, 16.0, 16.0]
    for name in ("physical-deception", "cooperative-navigation"):
        moved, plain = find(f"{name},{FORK}"), find(name)
        assert {entity.force for entity in moved.spec.agents} == {5.0} and moved.features == plain.features


def test_its_spec_states_no_motion():
    """So nobody who reads a spec steps it as mpe2 does."""
    spec = find(f"physical-deception,{FORK}").spec
    assert (spec.dt, spec.damping) == (0.0, 0.0) and "fork" in spec.reference
    assert find("physical-deception,physics=mpe2").spec == find("physical-deception").spec


@pytest.mark.parametrize(
    ("name", "error", "said"),
    [
        ("predator-prey,physics=relased", UnknownNameError, "did you mean 'released'"),
        (f"cooperative-navigation,features=coasting,{FORK}", InputError, "comes to rest by mpe2's physics"),
        (f"coordination,{FORK}", UnknownNameError, "option"),
    ],
)
def test_what_there_is_not(name, error, said):
    with pytest.raises(error, match=said):
        find(name)


@pytest.mark.parametrize("text", ["predator-prey,physics=released@maddpg", "predator-prey,physics=released"])
def test_experts_of_the_plain_game_play_there(text):
    expert, world = find_expert(text)
    plain, _ = find_expert(text.replace(f",{FORK}", ""))
    assert world.name == f"predator-prey,{FORK}" and expert.hash == plain.hash
    player = find_shipped(expert.hash, world)
    assert player is not None and player.id == expert.hash
    assert find_player("predator-prey@maddpg", "--against", world)[1] is world


@pytest.fixture(scope="module")
def profile():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(held_out, "EVALUATION_EPISODES", 8)
        expert, world = find_expert("physical-deception,physics=released@maddpg")
        small = {"algorithm": "imitation", "preset": "paper", "iterations": 1, "rollouts": 4, "max_depth": 2}
        return extract(world, expert, Settings.of({**small, "selection_episodes": 4}, world))


def test_a_profile_finds_its_world_again(profile):
    again = profiles.loads(policy_json.dumps(profile))
    world = matching_world(again)
    assert (
        again.world.options == {"physics": "released"}
        and world is not None
        and world.name == find(f"physical-deception,{FORK}").name
    )


def test_claims_and_pages_are_refused_by_name(profile, tmp_path, capsys):
    with pytest.raises(InputError, match=r"claims cover mpe2's motion.*physics=released"):
        verifiable(profile, "defenders")
    assert "physics=released" in unplayable(profile)
    place = tmp_path / "trees.json"
    place.write_text(policy_json.dumps(profile))
    for command in (["verify", str(place)], ["play", str(place), "-o", str(tmp_path / "page.html")]):
        assert main.run(command) == 2, command
        assert "physics=released" in capsys.readouterr().err
    assert main.run(["evaluate", str(place), "--episodes", "20"]) == 0
    assert "defenders" in capsys.readouterr().out


def test_claims_over_observations_are_asked(profile, tmp_path):
    """They say nothing of motion."""
    place = tmp_path / "trees.json"
    place.write_text(policy_json.dumps(profile))
    (tmp_path / "claims.toml").write_text('[[property]]\nformula = "acts(agent_0) in [stay, left, right, down, up]"\n')
    words = ["verify", str(place), "--observations", "--claims", str(tmp_path / "claims.toml")]
    assert main.run([*words, "--region", "ranges", "--verdict-only"]) == 0
