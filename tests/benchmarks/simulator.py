"""Joint steps per second of our simulators against mpe2, VMAS and JaxMARL: one process, one core, interleaved rounds.

    python -m tests.benchmarks.simulator [--rounds 5 | --full] [--game predator-prey] [--json]

A step is the dynamics, float32 observations of all agents and their rewards; everybody resets after 25 steps, and the
resets count. Actions are uniform and drawn before the clock starts; compilation is not counted. What counts is CPU time
on one core, and the median over rounds of the ratio within a round. Ours computes positions in float64, mpe2 too, the
other two in float32. A peer's fastest way is taken: JaxMARL is jitted and mapped over games, step by step and as one
scan, without its automatic resets; VMAS runs on the CPU. Peers: the extra maviper[bench]; who is missing is said.
"""

import contextlib
import os
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tests.benchmarks.common import figure, reader, tell, turns

STEPS = 25
OVER_MPE2, OVER_PEERS = 300, 1.0  # what the figures are to reach
OUR_GAMES = (1_024, 4_096)
MPE2_EPISODES, VMAS_GAMES, JAX_GAMES = 40, 8_192, 4_096
TAG = {"num_good_agents": 2, "num_adversaries": 2}


@dataclass(frozen=True)
class Game:
    """One game under its names here and elsewhere; `ours` may be several observations of the same game."""

    name: str
    ours: tuple[str, ...]
    vmas: tuple[str, dict]
    jax: tuple[str, dict]


GAMES = (
    Game("physical-deception", ("physical-deception",), ("simple_adversary", {}), ("MPE_simple_adversary_v3", {})),
    Game("cooperative-navigation", ("cooperative-navigation",), ("simple_spread", {}), ("MPE_simple_spread_v3", {})),
    Game(
        "predator-prey",
        ("predator-prey", "predator-prey,observation=mpe2"),
        ("simple_tag", TAG | {"num_landmarks": 2}),
        ("MPE_simple_tag_v3", TAG | {"num_obs": 2}),
    ),
)


@dataclass
class Player:
    """Somebody's simulator of a game: `draw` makes what `play` needs for some episodes, `play` is timed."""

    who: str
    way: str
    steps: int  # joint steps of one `play`
    draw: Callable[[np.random.Generator], object]
    play: Callable[[object], object]
    rates: list[float] = field(default_factory=list)  # joint steps per second of CPU time, one rate per round

    def turn(self, seed: int) -> None:
        """One round."""
        drawn = self.draw(np.random.default_rng(seed))
        started = time.process_time()
        self.play(drawn)
        self.rates.append(self.steps / (time.process_time() - started))

    @property
    def rate(self) -> float:
        """The median over rounds."""
        return float(np.median(self.rates))


def pin() -> None:
    """One core and one thread, for whatever is imported after this."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    os.environ["JAX_PLATFORMS"] = "cpu"
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"


@contextlib.contextmanager
def stdout_aside():
    """Sends to stderr what others write to stdout, which is ours alone; they get hold of the file itself."""
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def ours(name: str, games: int) -> Player:
    from maviper.worlds import find

    world = find(name)
    episodes = max(OUR_GAMES) * 2 // games

    def draw(rng):
        return rng, rng.integers(5, size=(episodes, STEPS, games, len(world.agents)))

    def play(drawn):
        rng, actions = drawn
        for episode in actions:
            state = world.start(games, rng)
            world.observe(state)
            for acted in episode:
                state = world.step(state, acted)
                world.observe(state)
                world.rewards(state)

    return Player(name, f"{games:,} games", episodes * games * STEPS, draw, play)


def mpe2(name: str) -> Player:
    from maviper.worlds import find

    world = find(name)
    env = world.reference_env()

    def draw(rng):
        actions = rng.integers(5, size=(MPE2_EPISODES, STEPS, len(world.agents))).tolist()
        return [[dict(zip(world.agents, acted, strict=True)) for acted in episode] for episode in actions]

    def play(drawn):
        for seed, episode in enumerate(drawn):
            env.reset(seed=seed)
            for acted in episode:
                env.step(acted)

    return Player("mpe2", "1 game", MPE2_EPISODES * STEPS, draw, play)


def vmas(scenario: str, options: dict) -> Player:
    import torch
    import vmas as library

    torch.set_num_threads(1)
    env = library.make_env(scenario, num_envs=VMAS_GAMES, device="cpu", continuous_actions=False, seed=0, **options)

    def draw(rng):
        shape = (STEPS, len(env.agents), VMAS_GAMES, 1)
        return [list(acted) for acted in torch.from_numpy(rng.integers(5, size=shape).astype(np.float32))]

    def play(drawn):
        env.reset()
        for acted in drawn:
            env.step(acted)

    return Player("VMAS", f"{VMAS_GAMES:,} games", VMAS_GAMES * STEPS, draw, play)


def jaxmarl(scenario: str, options: dict) -> list[Player]:
    with stdout_aside():  # it greets on import
        import jax
        import jaxmarl as library

        env = library.make(scenario, **options)

    def begin(seed):
        return jax.vmap(env.reset)(jax.random.split(jax.random.PRNGKey(seed), JAX_GAMES))

    def step(keys, state, acted):
        actions = {agent: acted[:, index] for index, agent in enumerate(env.agents)}
        seen, state, rewards, *_ = jax.vmap(env.step_env)(keys, state, actions)
        return state, (seen, rewards)

    def scan(seed, actions):
        keys = jax.random.split(jax.random.PRNGKey(seed), JAX_GAMES)
        seen, state = begin(seed)
        return seen, jax.lax.scan(lambda state, acted: step(keys, state, acted), state, actions)

    one_begin, one_step, whole = jax.jit(begin), jax.jit(step), jax.jit(scan)

    def draw(rng):
        actions = jax.numpy.asarray(rng.integers(5, size=(STEPS, JAX_GAMES, len(env.agents))))
        keys = jax.random.split(jax.random.PRNGKey(0), JAX_GAMES)
        return jax.block_until_ready((int(rng.integers(2**31)), keys, actions, list(actions)))

    def play_steps(drawn):
        seed, keys, _, actions = drawn
        found = one_begin(seed)
        state = found[1]
        for acted in actions:
            state, found = one_step(keys, state, acted)
        return jax.block_until_ready((state, found))

    def play_scan(drawn):
        return jax.block_until_ready(whole(drawn[0], drawn[2]))

    ways = {"step by step": play_steps, "one scan": play_scan}
    size = JAX_GAMES * STEPS
    return [Player("JaxMARL", f"{JAX_GAMES:,} games, {way}", size, draw, play) for way, play in ways.items()]


def players(game: Game) -> tuple[list[Player], list[str]]:
    """Everybody who can play, and who cannot and why."""
    found = [ours(name, games) for name in game.ours for games in OUR_GAMES]
    found.append(mpe2(game.name))
    missing = []
    for who, make in (("VMAS", lambda: [vmas(*game.vmas)]), ("JaxMARL", lambda: jaxmarl(*game.jax))):
        try:
            found += make()
        except ImportError as error:
            missing.append(f"{game.name}: {who} is not here ({error})")
    return found, missing


def compared(game: Game, rounds: int) -> tuple[list[Player], list[str]]:
    """Plays all rounds, everybody once in each, beginning with another one each time."""
    everybody, missing = players(game)
    for player in everybody:  # compiles, and warms up
        player.turn(0)
        player.rates.clear()
    for seed, order in enumerate(turns(everybody, rounds), 1):
        for player in order:
            player.turn(seed)
    return everybody, missing


def ratios(mine: Player, other: Player) -> np.ndarray:
    """Ours over theirs in each round."""
    return np.array(mine.rates) / np.array(other.rates)


def figures(game: Game, everybody: list[Player]) -> list[dict]:
    """For each observation of ours, its better size against mpe2 and against the better peer."""
    rows = []
    for name in game.ours:
        mine = max((player for player in everybody if player.who == name), key=lambda player: player.rate)
        peers = [player for player in everybody if player.who in ("VMAS", "JaxMARL")]
        others = [("mpe2", player, OVER_MPE2) for player in everybody if player.who == "mpe2"]
        if peers:
            best = max(peers, key=lambda player: player.rate)
            others.append((f"the better peer ({best.who})", best, OVER_PEERS))
        for label, other, reach in others:
            value = float(np.median(ratios(mine, other)))
            rows.append(figure(f"{name}: steps/s over {label}", value, reach, better="higher"))
    return rows


def show(game: Game, everybody: list[Player]) -> None:
    for name in game.ours:
        mine = max((player for player in everybody if player.who == name), key=lambda player: player.rate)
        print(f"\n{name:<40}{'steps/s':>12}  ours ({mine.way}) over it, from the least to the most")
        for player in everybody:
            if player.who not in game.ours or player.who == name:
                over = ratios(mine, player)
                label = f"{'ours' if player.who == name else player.who}, {player.way}"
                span = f"{np.median(over):10.2f}  ({over.min():.2f} to {over.max():.2f})"
                print(f"  {label:<38}{player.rate:>12,.0f}{span if player is not mine else '':>34}")


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--game", choices=[game.name for game in GAMES], help="only this one")
    parser.add_argument("--full", action="store_true", help="25 rounds")
    options = parser.parse_args()
    pin()
    warnings.filterwarnings("ignore", module="gym|jax|vmas|torch|pygame")
    found: list[dict] = []
    for game in GAMES:
        if options.game in (None, game.name):
            everybody, missing = compared(game, 25 if options.full else options.rounds)
            found += figures(game, everybody)
            for line in missing:
                print(line, file=sys.stderr)
            if not options.json:
                show(game, everybody)
    tell(found, options.json)


if __name__ == "__main__":
    main()
