"""What several tests use of `maviper.page.test_page`."""

from pathlib import Path

from codegen import profiles

GENERATED = Path(__file__).parents[2] / "generated"
STATE = """
  const stateIn = (game) => (at, goal) => ({
    position: game.entities.map((one) => [at[`${one.name}.x`], at[`${one.name}.y`]]),
    velocity: game.world.agents.map((one) => [at[`${one.name}.vx`] || 0, at[`${one.name}.vy`] || 0]),
    goal: game.world.goals.length ? game.world.landmarks.findIndex((one) => one.name === goal) : null,
  });
"""


def committed(name):
    return profiles.loads((GENERATED / name / "profile.json").read_text(encoding="utf-8"))


def starts(world, count):
    """(coordinates by name, goal's name) of random starts, as the environment's reset draws them."""
    states = world.start_from_seeds(range(count))
    names = world.spec.coordinates()
    marks = [mark.name for mark in world.spec.landmarks]
    for row, goal in zip(world.coordinates(states).tolist(), states.goal.tolist(), strict=True):
        yield dict(zip(names, row, strict=True)), marks[goal] if world.spec.goals else None
