"""MAVIPER: neural multi-agent policies as small decision trees, compiled exactly and proved.

Does: every command as a function, with its options as parameters; teams from trees of other programs.
Assumes: heavy libraries are imported by the functions that need them.
Does not: import anything heavy itself, or print.

    team = maviper.load("team.json")
    found = maviper.verify(team, maviper.claims.DistinctTargets())
    code = maviper.compile(team, "c")

Wherever a function takes a team, it takes the path of its file too.

Errors that a caller can mend are `maviper.errors.MaviperError`: they say what happened, where, and what to do next.
InputError is a wrong file, name or number; UnknownNameError, one of them, carries the closest match. Classes of what
functions take and return are in `maviper.profiles` and `maviper.answers`.
"""

from __future__ import annotations

from maviper import starting as starting  # first: what follows takes time, in which somebody may press Ctrl-C

# isort: split
from typing import TYPE_CHECKING

from maviper import siblings as siblings  # it says what is in the way of the imports below

# isort: split
from codegen import process
from maviper import errors as errors
from maviper import options
from maviper.importing.verbs import from_file, from_onnx, from_sklearn
from maviper.options.verbs import TARGETS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from contextlib import AbstractContextManager
    from pathlib import Path
    from typing import Any, Unpack

    from codegen.ir import PolicyProfile
    from maviper import claims as claims
    from maviper.compilation.compile import Compiled
    from maviper.evaluation.exploitability import Exploitability
    from maviper.evaluation.run import Evaluation
    from maviper.reproduction.compared import AlgorithmsCompared
    from maviper.reproduction.run import Reproduced
    from maviper.team import Team
    from maviper.verification.compared import OutputsCompared
    from maviper.verification.diff import Compared
    from maviper.verification.files.certificates import Checked
    from maviper.verification.files.counterexamples import Replayed
    from maviper.verification.guarding import Guarded
    from maviper.verification.repair import Repaired
    from maviper.verification.robust import Changes, Radii
    from maviper.verification.run import Verified
    from verify.result import AnyResult

    TeamOrFile = PolicyProfile | str | Path  # a team, or the path of its file
    Progress = bool | Callable[[str, float, int, str], None]  # whether steps are shown, or what is told of them

__all__ = [
    "check",
    "compare",
    "compile",
    "diff",
    "evaluate",
    "exploit",
    "extract",
    "from_file",
    "from_onnx",
    "from_sklearn",
    "load",
    "repair",
    "replay",
    "reproduce",
    "robust",
    "train",
    "verify",
    "verify_file",
    "verify_system",
]


LATER = {"Team": "maviper.team", "__version__": "maviper.files.profiles"}  # what is imported when it is asked for
MODULES = ("answers", "claims", "errors", "profiles")


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name in LATER:
        return getattr(import_module(LATER[name]), {"__version__": "VERSION"}.get(name, name))
    if name in MODULES:
        return import_module(f"maviper.{name}")
    raise AttributeError(f"module 'maviper' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*__all__, *LATER, *MODULES])


def _team(given: TeamOrFile) -> Team:
    """A profile, or the one in a file, as a team."""
    from pathlib import Path

    from maviper.files.profiles import find_profile
    from maviper.team import Team

    return given if isinstance(given, Team) else Team.of(find_profile(given, beside=Path(), sums=True))


def _returns_team(verb: Callable[..., Any]) -> Callable[..., Team]:
    """The function, with the profile that it returns as a team."""
    from functools import wraps

    @process.defaults
    @wraps(verb)
    def run(*given: Any, **named: Any) -> Team:
        return _team(verb(*given, **named))

    return run


from_file, from_onnx, from_sklearn = map(_returns_team, (from_file, from_onnx, from_sklearn))


@process.defaults
@options.speak_python
def load(path: str | Path, world: str | Callable[..., Any] | None = None) -> Team:
    """Loads the team in a profile's JSON file, and checks it.

        team = maviper.load("team.json")
        actions = team.act({"agent_0": [0.1] * 10})

    Args:
        path: The file.
        world: The team's environment, as a name or a function that makes it; `Team.act` needs it where observations
            are dictionaries or actions have a shape.

    Raises:
        ProfileError: The file breaks the schema, or an invariant; the error has the path to the fault.
    """
    from maviper.files.profiles import load as loaded
    from maviper.team import Team

    return Team.of(loaded(path, sums=True), _played(world))


def _told(progress: Progress, doing: str, once: str) -> AbstractContextManager[None]:
    from maviper.console import telling
    from verify.spending import listening

    return telling(progress, doing, once, listening)


def _played(world: str | Callable[..., Any] | None) -> Callable[[], Any] | None:
    """What finds a team's world when it is needed."""

    def find() -> Any:
        from maviper import worlds

        return worlds.find(world, giving=True)  # type: ignore[arg-type]

    return None if world is None else find


@process.defaults
@options.spell_out(options.TrainOptions)
def train(
    world: str, output: str | Path, *, progress: Progress = False, **asked: Unpack[options.TrainOptions]
) -> dict[str, Any]:
    """Trains an expert for a world, and writes it into a run folder.

        maviper.train("physical-deception", "runs/expert", steps=2_000_000)

    Sources: MADDPG (Lowe et al. 2017), MAPPO (Yu et al. 2022), VDN (Sunehag et al. 2018).

    Args:
        world: A game, with options after commas, or module:function for your own environment.
        output: The run folder.
        progress: As for `extract`.

    Returns:
        The expert's card: how it learned, and what was measured. It has `stopped` where training ended early.

    Raises:
        MissingToolError: torch, of the extra maviper[train], is not installed.
        InputError: A name or a number cannot be used.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.experts.training.train import train_expert

    return train_expert(world, Path(output), Console.showing(progress), **asked)


@process.defaults
@process.one_thread
@options.spell_out(options.ExtractOptions)
def extract(
    expert: str | Path | Callable[..., Any],
    output: str | Path | None = None,
    *,
    progress: Progress = False,
    **asked: Unpack[options.ExtractOptions],
) -> Team:
    """Extracts decision trees from an expert, as a team.

        def act(agent, observations):  # [n, n_features] -> [n], as the environment counts actions
            logits = forward(weights[agent], observations)
            return logits.argmax(axis=1)

        team = maviper.extract(act, world=make_env, max_depth=3)

    Source: Milani et al. 2022, for MAVIPER and IVIPER; `maviper guide extraction` has the others.

    Args:
        expert: A function as above, which gives [n, n_outputs] where agents give numbers; an object with the members
            of an expert; or the name of a world, an expert file, a run folder, or module:function.
        output: The profile's .json file, or a run folder, which several seeds and `resume` need. None: nothing is
            written.
        progress: True shows what the command shows, on standard error; in a notebook, bars. A function is told of each
            step: (stage, done, total, words).

    An option that is None is as the preset says.

    Raises:
        InputError: A name or a value cannot be used.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.extraction.run import extract_named, request
    from maviper.team import Team
    from maviper.worlds.outside.sources import is_named_by_user
    from maviper.worlds.world import world_name

    named = str(expert) if isinstance(expert, str | Path) else expert
    place = None if output is None else Path(output)
    profile = extract_named(named, place, request(asked), Console.showing(progress))
    reference = world_name(profile.world).replace(profile.world.name, profile.world.reference, 1)
    played = asked.get("world") or (reference if is_named_by_user(reference) else None)
    return Team.of(profile, _played(played))


@process.defaults
@process.one_thread
@options.spell_out(options.EvaluateOptions)
def evaluate(
    subject: TeamOrFile | Callable[..., Any], *, progress: Progress = False, **asked: Unpack[options.EvaluateOptions]
) -> Evaluation:
    """Measures a team, an expert or a mix in play, on held-out episodes that are the same for everybody.

        measured = maviper.evaluate(team, episodes=1000, expert=act)
        value, interval, expert, ratio, _ = measured["defenders", "success"]

    Args:
        subject: A team or its file, whose name ends in .json; or an expert as `extract` takes it.
        progress: As for `extract`.

    Raises:
        InputError: Something cannot be used.
        UnknownNameError: There is no such name.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.evaluation.run import evaluate_live, request

    wanted = request(str(subject) if isinstance(subject, Path) else subject, **asked)
    return evaluate_live(wanted, Console.showing(progress))


@process.defaults
@process.one_thread
@options.spell_out(options.ExploitOptions)
def exploit(
    subject: TeamOrFile | Callable[..., Any],
    team: str,
    *,
    progress: Progress = False,
    **asked: Unpack[options.ExploitOptions],
) -> Exploitability:
    """Finds a lower bound on what the opponents of a team gain by answering its policies.

        maviper.exploit("profile.json", "defenders", episodes=100).bound

    Args:
        subject: As for `evaluate`.
        team: The team whose policies stay as they are.
        progress: As for `extract`.

    Raises:
        InputError: Something cannot be used.
        MissingToolError: `networks` names a folder, and torch is not installed.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.extraction.exploiting import exploit_team

    named = str(subject) if isinstance(subject, Path) else subject
    with _told(progress, "answering", "team"):
        return exploit_team(named, team, Console.showing(progress), **asked)


@process.defaults
@options.spell_out(options.CompileOptions)
def compile(
    profile: TeamOrFile, targets: str | Iterable[str] = TARGETS, **asked: Unpack[options.CompileOptions]
) -> Compiled:
    """Compiles a team to code, and replays the code against the team with tolerance zero before returning it.

        maviper.compile(team, "c").write("firmware")

    Args:
        profile: The team, or its file.
        targets: One or several of c, shared, python, json, javascript, rust, smt, svg, st, onnx, onnx-old, jax, torch,
            monitor.

    Raises:
        DisagreementError: Code and team decide differently for some observation.
        InputError: Something cannot be asked of this team.
    """
    from maviper.compilation.compile import compile_and_prove

    return compile_and_prove(_team(profile), [targets] if isinstance(targets, str) else targets, **asked)


@process.defaults
@options.spell_out(options.VerifyOptions)
def verify(
    profile: TeamOrFile,
    claim: str | claims.Claim = "distinct_targets",
    region: str | Path = "start",
    *,
    progress: Progress = False,
    **asked: Unpack[options.VerifyOptions],
) -> AnyResult:
    """Decides whether a built-in claim holds in every state of a region.

        found = maviper.verify(team, maviper.claims.DistinctTargets(), region="start")
        assert found.proved or found.verdict == "VIOLATED"

    Args:
        profile: The team, or its file.
        claim: One of `maviper.claims`, such as `claims.Reaches(steps=25)`, which has its parameters and its team; or
            a name, with the parameters as options.
        region: `start`, or a region file; over observations also `seen`, which `start` means there, and `ranges`.
        progress: As for `extract`.

    `margin` and `radius` are lengths of the world, `kappa` is a ratio, `eps` is in the features' units. With `where`,
    the evidence says where a claim about single decisions holds and fails. `shared`: ["all"] for all features. None: as
    `maviper verify --list` says.

    Raises:
        InputError: There is no such name, or the claim does not read a parameter.
    """
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import results

    about = VerifyOptions.about(claim, str(region), asked)
    with _told(progress, "deciding", "claim"):
        (found,) = results(_team(profile), about)
    return found


@process.defaults
@options.spell_out(options.FileOptions)
def verify_file(
    profile: TeamOrFile,
    file: str | Path,
    region: str | Path = "start",
    *,
    progress: Progress = False,
    **asked: Unpack[options.FileOptions],
) -> Verified:
    """Decides the claims of a property file, in its order.

        found = maviper.verify_file(team, "claims.toml")
        found.to_csv("claims.csv")

    Args:
        profile: The team, or its file.
        file: The property file.
        region: Where claims hold that name no region: `start`, or a region file.
        progress: As for `extract`.

    Raises:
        InputError: A claim cannot be read, by line and column; or nothing reads a limit.
    """
    from pathlib import Path

    from codegen.profiles import ensure
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import verify_world

    given = options.complete_options(options.FileOptions, asked)
    with _told(progress, "deciding", "file"):
        return verify_world(ensure(_team(profile)), VerifyOptions(file=Path(file), region=str(region), **given))


@process.defaults
@options.speak_python
def check(
    certificate: str | Path,
    profile: TeamOrFile | None = None,
    against: TeamOrFile | None = None,
    world: str | Path | None = None,
) -> Checked:
    """Checks the certificate in a file; says what it proves.

        maviper.check("found/certificate-1-distinct_targets.json").subject

    Args:
        certificate: The file.
        profile: The team, or its file; default: profile.json beside the certificate.
        against: The other team of a certificate by `diff`; default: against.json beside it.
        world: The world file of a certificate by `verify_system`; default: world.toml beside it.

    Raises:
        RefusedError: The proof does not hold.
        InputError: The certificate cannot be read, or is about another team.
    """
    from pathlib import Path

    from maviper.verification.files.certificates import check_file

    first, second = (Path(one) if isinstance(one, str) else one for one in (profile, against))
    return check_file(Path(certificate), first, second, None if world is None else Path(world))


@process.defaults
@options.speak_python
def replay(counterexample: str | Path, profile: TeamOrFile | None = None, world: str | Path | None = None) -> Replayed:
    """Replays the counterexample in a file; says whether the claim fails in it.

        maviper.replay("found/counterexample-1-distinct_targets.json", team).violated

    Args:
        counterexample: The file.
        profile: The team, or its file; default: profile.json beside the counterexample.
        world: The world file of a counterexample by `verify_system`; default: world.toml beside it.

    Raises:
        InputError: The file is damaged, or about another world.
        DisagreementError: Reference, compiled C and environment act differently.
    """
    from pathlib import Path

    from maviper.files.profiles import find_profile
    from maviper.verification.files.counterexamples import replay as replayed

    about = find_profile(profile, beside=Path(counterexample), sums=True)
    return replayed(Path(counterexample), about, None if world is None else Path(world))


@process.defaults
@options.spell_out(options.RepairOptions)
def repair(
    profile: TeamOrFile,
    claim: str | Path | claims.Claim = "distinct_targets",
    region: str | Path = "start",
    *,
    progress: Progress = False,
    **asked: Unpack[options.RepairOptions],
) -> Repaired | Guarded:
    """Changes the leaves from which a claim can fail, until both engines prove it.

        repaired = maviper.repair(team, maviper.claims.DistinctTargets()).after

    Args:
        profile: The team, or its file.
        claim: distinct_targets or own_target, by name or as an object, such as
            `claims.OwnTarget(landmarks=["landmark_1", "landmark_0"])`; or a file of claims, all of which are to
            hold; or a world file, by all of whose claims guards are put above trees.
        region: `start`, or a region file.
        progress: As for `extract`.

    Returns:
        The repair. `Repaired.after` is the team, None where no repair was found; `Repaired.cost` has the measures
        before and after.

    Raises:
        InputError: Something cannot be asked.
    """
    from pathlib import Path

    from codegen.profiles import ensure
    from maviper.verification.ask import DEFAULT
    from maviper.verification.repair import find_claims, repair_profile, request

    with _told(progress, "repairing", "claim"):
        file = find_claims(claim)
        if file is not None:
            return repair_profile(ensure(_team(profile)), file, str(region), request(DEFAULT, asked))
        if isinstance(claim, Path) or (isinstance(claim, str) and claim.endswith(".toml")):
            from maviper.verification.guarding import ensure_unasked, repair_stated

            ensure_unasked(region, asked)
            return repair_stated(ensure(_team(profile)), Path(claim))
        return repair_profile(ensure(_team(profile)), claim, str(region), request(claim, asked))


@process.defaults
@options.speak_python
def robust(
    profile: TeamOrFile,
    observations: str | Path,
    agent: str | None = None,
    *,
    certify: bool = False,
    error: str | None = None,
) -> Radii | Changes:
    """Finds for each observation of a file the largest radius within which an agent acts the same, exactly.

        maviper.robust(team, "observations.csv", "agent_0").least

    Args:
        profile: The team, or its file.
        observations: A CSV or JSON file, [n, n_features].
        agent: The agent; default: the only one.
        certify: Each radius is proved, and its certificate checked.
        error: For an agent that gives numbers, how far features are off: "0.01", or "x=0.01,v=0.2". Returned is how
            far each output may change.

    Raises:
        InputError: The file is no table of finite observations of that agent.
    """
    from pathlib import Path

    from maviper.files.profiles import find_profile
    from maviper.verification.robust import robust as radii

    given = find_profile(profile, beside=Path(observations), sums=True)
    return radii(given, Path(observations), agent, certify, error)


@process.defaults
@options.spell_out(options.DiffOptions)
def diff(
    first: TeamOrFile,
    second: TeamOrFile,
    region: str | Path = "start",
    *,
    progress: Progress = False,
    **asked: Unpack[options.DiffOptions],
) -> Compared | OutputsCompared:
    """Finds every state of a region in which two teams act differently, or proves that there is none.

        maviper.diff("before.json", "after.json").verdict

    Args:
        first: A team, or its file.
        second: The other one.
        region: `start`, or a region file.
        progress: As for `extract`.

    Returns:
        What was compared. `Compared.facts` has shares, zones and examples, `Compared.found` the certificate. Of agents
        that test sums or give numbers, `OutputsCompared.facts` has the largest difference of each output, and where.

    Raises:
        InputError: The teams' worlds, agents, features or actions differ.
    """
    from maviper.verification.diff import compare_profiles, request

    with _told(progress, "comparing", "pair"):
        return compare_profiles(_team(first), _team(second), str(region), request(**asked))


@process.defaults
@options.spell_out(options.SystemOptions)
def verify_system(
    profile: TeamOrFile,
    world: str | Path,
    properties: str | Path | None = None,
    *,
    progress: Progress = False,
    **asked: Unpack[options.SystemOptions],
) -> Verified:
    """Decides the claims about the system that a world file states.

        found = maviper.verify_system(team, "corridor.toml")

    Args:
        profile: The team, or its file.
        world: The world file.
        properties: A property file, whose claims are asked instead of the world file's.
        progress: As for `extract`.

    Returns:
        All questions with their results. `Verified.results` has verdicts and evidence, `Verified.document` the report.

    Raises:
        InputError: A file cannot be used, the team is of another world, or the statement is further from its reference
            than it says.
    """
    from pathlib import Path

    from codegen.profiles import ensure
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import verify_world

    file = None if properties is None else Path(properties)
    about = VerifyOptions(world=Path(world), file=file, **options.complete_options(options.SystemOptions, asked))
    with _told(progress, "deciding", "system"):
        return verify_world(ensure(_team(profile)), about)


@process.defaults
@process.one_thread
@options.spell_out(options.CompareOptions)
def compare(
    expert: str | Path | Callable[..., Any],
    output: str | Path | None = None,
    *,
    progress: Progress = False,
    **asked: Unpack[options.CompareOptions],
) -> AlgorithmsCompared:
    """Compares algorithms, depths and seeds on an expert, at equal numbers of episodes.

        table = maviper.compare(act, world=make_env, algorithms=["maviper", "imitation"], depths=[2, 3], seeds=5)
        table.best.save("best.json")

    Args:
        expert: As for `extract`; so are `experts`.
        output: A folder, in which an interrupted call goes on when it is repeated. None: nothing is kept.
        progress: As for `extract`.

    Returns:
        The comparison. `rows`, `to_csv()` and `to_latex()` of it are the table, `best` is a team.

    Raises:
        InputError: Something cannot be used.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.reproduction.compare import compare_algorithms, request
    from maviper.team import Team

    named = str(expert) if isinstance(expert, Path) else expert
    found = compare_algorithms(named, output, request(asked), Console.showing(progress))
    found.best = Team.of(found.best, _played(asked.get("world")))
    return found


@process.defaults
@options.spell_out(options.ReproduceOptions)
def reproduce(
    output: str | Path, *, progress: Progress = False, **asked: Unpack[options.ReproduceOptions]
) -> Reproduced:
    """Runs the experiments of the MAVIPER paper, as cells in a folder, with their table and report.

        maviper.reproduce("cells", quick=True)

    Source: Milani et al. 2022. Finished cells are not made again. An option that is None is as quick, default or full
    says.

    Args:
        output: The folder.
        progress: As for `extract`.

    Returns:
        What was done. `Reproduced.failed` has the cells that failed, with their messages; `Reproduced.lines` is the
        report, or with `plan` the plan.

    Raises:
        InputError: Something cannot be used.
        MissingToolError: There is no room on the disk, no Dask, or its scheduler went away.
    """
    from maviper.console import Console
    from maviper.reproduction.run import reproduce_paper, request

    return reproduce_paper(output, request(asked), Console.showing(progress))
