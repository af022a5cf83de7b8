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
from maviper import claims, options
from maviper import errors as errors
from maviper.importing.verbs import from_file, from_onnx, from_sklearn
from maviper.options.verbs import TARGETS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path
    from typing import Any, Unpack

    from codegen.ir import PolicyProfile
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
    from maviper.verification.repair import Repaired
    from maviper.verification.robust import Changes, Radii
    from maviper.verification.run import Verified
    from verify.result import AnyResult

    Given = PolicyProfile | str | Path  # a team, or the path of its file

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
    "version",
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


def version() -> str:
    """The version of the package: `maviper.__version__`, which is to be used instead."""
    import warnings

    from maviper.files.profiles import version as installed

    warnings.warn("maviper.version() goes with the next release: use maviper.__version__", DeprecationWarning, 2)
    return installed()


def _team(given: Given) -> Team:
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
    """The team in a profile's JSON file, checked. ProfileError (an InputError) with the path of the fault otherwise.

    `world`: its environment, as a name or a function that makes it; `team.act` needs it where observations are
    dictionaries or actions have a shape.

        team = maviper.load("team.json")
        actions = team.act({"agent_0": [0.1] * 10})
    """
    from maviper.files.profiles import load as loaded
    from maviper.team import Team

    return Team.of(loaded(path, sums=True), _played(world))


def _played(world: str | Callable[..., Any] | None) -> Callable[[], Any] | None:
    """What finds a team's world when it is needed."""

    def find() -> Any:
        from maviper import worlds

        return worlds.find(world, giving=True)  # type: ignore[arg-type]

    return None if world is None else find


@process.defaults
@options.spell_out(options.TrainOptions)
def train(world: str, output: str | Path, **asked: Unpack[options.TrainOptions]) -> dict[str, Any]:
    """Trains an expert for a world into the run folder `output`; returns its card, with what was measured.

        maviper.train("physical-deception", "runs/expert", steps=2_000_000)

    The card says `stopped` where training ended early. MissingToolError without torch; InputError for a name or number
    that cannot be used.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.experts.training.train import train_expert

    return train_expert(world, Path(output), Console(quiet=True), **asked)


@process.defaults
@options.spell_out(options.ExtractOptions)
def extract(
    expert: str | Path | Callable[..., Any],
    output: str | Path | None = None,
    **asked: Unpack[options.ExtractOptions],
) -> Team:
    """Decision trees from an expert, as a team; each option is one of `maviper extract`.

        def act(agent, observations):            # [n, n_features] -> [n], as the environment counts actions
            logits = forward(weights[agent], observations)
            return logits.argmax(axis=1)

        team = maviper.extract(act, world=make_env, max_depth=3)

    `expert`: a function as above, an object with the members of an expert, a world's name, an expert file, a run
    folder, or module:function. `world`: a name, or a function that makes the environment, from a notebook too.
    `output`: the profile's .json file, or a run folder, which several seeds and `resume` need; None: nothing is
    written. None elsewhere: as the preset says. InputError: a wrong name or value.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.extraction.run import extract_named, request
    from maviper.team import Team
    from maviper.worlds.outside.sources import is_named_by_user
    from maviper.worlds.world import world_name

    named = str(expert) if isinstance(expert, str | Path) else expert
    profile = extract_named(named, None if output is None else Path(output), request(asked), Console(quiet=True))
    reference = world_name(profile.world).replace(profile.world.name, profile.world.reference, 1)
    played = asked.get("world") or (reference if is_named_by_user(reference) else None)
    return Team.of(profile, _played(played))


@process.defaults
@options.spell_out(options.EvaluateOptions)
def evaluate(subject: Given | Callable[..., Any], **asked: Unpack[options.EvaluateOptions]) -> Evaluation:
    """A team, an expert or a mix measured in play, on held-out episodes that are the same for everybody.

        measured = maviper.evaluate(team, episodes=1000, expert=act)
        value, interval, expert, ratio, _ = measured["defenders", "success"]

    `subject`: a team or its file (its name ends in .json), or an expert as `extract` takes it. InputError for what
    cannot be used, UnknownNameError for a name that there is not.
    """
    from pathlib import Path

    from maviper.evaluation.run import evaluate_named, request

    return evaluate_named(request(str(subject) if isinstance(subject, Path) else subject, **asked))


@process.defaults
@options.spell_out(options.ExploitOptions)
def exploit(subject: Given | Callable[..., Any], team: str, **asked: Unpack[options.ExploitOptions]) -> Exploitability:
    """A lower bound on what the opponents of `team` gain by answering its policies.

        found = maviper.exploit("profile.json", "defenders", episodes=100)

    `subject`: as for `evaluate`. InputError for what cannot be used, MissingToolError where `networks` names a folder
    and torch is missing.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.extraction.exploiting import exploit_team

    return exploit_team(str(subject) if isinstance(subject, Path) else subject, team, Console(quiet=True), **asked)


@process.defaults
@options.spell_out(options.CompileOptions)
def compile(
    profile: Given, targets: str | Iterable[str] = TARGETS, **asked: Unpack[options.CompileOptions]
) -> Compiled:
    """Code for a team, replayed against it with tolerance zero before it is returned.

        maviper.compile(team, "c").write("firmware")

    `targets`: one or several of c, python, json, javascript, rust, smt, svg, onnx, onnx-old, jax, torch and monitor.
    `Compiled.files` maps file names to texts (of ONNX: bytes), `Compiled.proofs` has the answers of `prove`.
    DisagreementError when any decision differs; InputError for what cannot be asked.
    """
    from maviper.compilation.run import compile_and_prove

    return compile_and_prove(_team(profile), [targets] if isinstance(targets, str) else targets, **asked)


@process.defaults
@options.spell_out(options.VerifyOptions)
def verify(
    profile: Given,
    claim: str | claims.Claim = "distinct_targets",
    region: str | Path = "start",
    **asked: Unpack[options.VerifyOptions],
) -> AnyResult:
    """The verdict on a built-in claim for every state of a region: `start`, or a region file.

        found = maviper.verify(team, maviper.claims.DistinctTargets(), region="start")
        assert found.proved or found.verdict == "VIOLATED"

    `claim`: one of `maviper.claims`, such as `claims.Reaches(steps=25)`, which has its parameters and its team; or a
    name, with the parameters as options. `margin` and `radius` are lengths of the world, `kappa` is a ratio, `eps` is
    in the features' units. `where` also answers where a claim about single decisions holds and fails (`where` of
    `Result.evidence`) and from what share of the starts one about episodes fails (`starts` of it). `shared`: ["all"]
    for all features. None: as `maviper properties list` says. InputError for a name that there is not, or a parameter
    that the claim does not read.
    """
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import results

    return results(_team(profile), VerifyOptions.about(claim, str(region), asked))[0]


@process.defaults
@options.spell_out(options.FileOptions)
def verify_file(
    profile: Given, file: str | Path, region: str | Path = "start", **asked: Unpack[options.FileOptions]
) -> list[AnyResult]:
    """The verdicts on the claims of a property file, in its order; `region` is for those that name none.

        for found in maviper.verify_file(team, "claims.toml"):
            print(found)

    InputError with line and column for a claim that cannot be read, and for a limit that nothing reads.
    """
    from pathlib import Path

    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import results

    given = options.complete_options(options.FileOptions, asked)
    return results(_team(profile), VerifyOptions(file=Path(file), region=str(region), **given))


@process.defaults
@options.speak_python
def check(
    certificate: str | Path,
    profile: Given | None = None,
    against: Given | None = None,
    world: str | Path | None = None,
) -> Checked:
    """What the certificate in a file proves of a profile (default: profile.json beside it), of a second one where it is
    by `diff` (default: against.json beside it), in a world file if it is by `verify_system` (world.toml beside it).

        maviper.check("found/certificate-1-distinct_targets.json").subject

    RefusedError when its proof does not hold; InputError when it cannot be read or is about another profile.
    """
    from pathlib import Path

    from maviper.verification.files.certificates import check_file

    first, second = (Path(one) if isinstance(one, str) else one for one in (profile, against))
    return check_file(Path(certificate), first, second, None if world is None else Path(world))


@process.defaults
@options.speak_python
def replay(counterexample: str | Path, profile: Given | None = None, world: str | Path | None = None) -> Replayed:
    """The counterexample in a file, replayed with a profile (default: profile.json beside it): does the claim fail?

        maviper.replay("found/counterexample-1-distinct_targets.json", team).violated

    `world`: the world file of one by `verify_system` (default: world.toml beside it).

    InputError when the file is damaged or about another world; DisagreementError when reference, compiled C and
    environment act differently.
    """
    from pathlib import Path

    from maviper.files.profiles import find_profile
    from maviper.verification.files.counterexamples import replay as replayed

    about = find_profile(profile, beside=Path(counterexample), sums=True)
    return replayed(Path(counterexample), about, None if world is None else Path(world))


@process.defaults
@options.spell_out(options.RepairOptions)
def repair(
    profile: Given,
    claim: str | claims.Claim = "distinct_targets",
    region: str | Path = "start",
    **asked: Unpack[options.RepairOptions],
) -> Repaired:
    """The leaves from which a claim can fail are changed until both engines prove it; `Repaired.after` is the team.

        repaired = maviper.repair(team, maviper.claims.DistinctTargets()).after

    It is None where no repair was found. `claim`: distinct_targets or own_target, by name or as an object, such as
    `claims.OwnTarget(landmarks=["landmark_1", "landmark_0"])`; `region`: `start`, or a region file.
    `Repaired.cost` has the measures before and after. InputError for what cannot be asked.
    """
    from codegen.profiles import ensure
    from maviper.verification.repair import repair_profile, request

    return repair_profile(ensure(_team(profile)), claim, str(region), request(claim, asked))


@process.defaults
@options.speak_python
def robust(
    profile: Given,
    observations: str | Path,
    agent: str | None = None,
    *,
    certify: bool = False,
    error: str | None = None,
) -> Radii | Changes:
    """For each observation of a CSV or JSON file the largest radius within which an agent acts the same, exactly; of an
    agent that gives numbers, how far each output may change where features are off by up to `error`.

        maviper.robust(team, "observations.csv", "agent_0").least

    `agent`: default, the only one; `certify`: each radius is proved, and its certificate checked; `error`: "0.01", or
    "x=0.01,v=0.2". InputError for a file that is no table of finite observations of that agent.
    """
    from pathlib import Path

    from maviper.files.profiles import find_profile
    from maviper.verification.robust import robust as radii

    given = find_profile(profile, beside=Path(observations), sums=True)
    return radii(given, Path(observations), agent, certify, error)


@process.defaults
@options.spell_out(options.DiffOptions)
def diff(
    first: Given, second: Given, region: str | Path = "start", **asked: Unpack[options.DiffOptions]
) -> Compared | OutputsCompared:
    """Every state of a region in which two teams act differently, or the proof that there is none.

        maviper.diff("before.json", "after.json").verdict

    `Compared.facts` has shares, zones and examples, `Compared.found` the certificate. Of agents that test sums or give
    numbers, `OutputsCompared.facts` has the largest difference of each output, and where. InputError for profiles whose
    worlds, agents, features or actions differ.
    """
    from maviper.verification.diff import compare_profiles, request

    return compare_profiles(_team(first), _team(second), str(region), request(**asked))


@process.defaults
@options.spell_out(options.SystemOptions)
def verify_system(
    profile: Given,
    world: str | Path,
    properties: str | Path | None = None,
    **asked: Unpack[options.SystemOptions],
) -> Verified:
    """The verdicts on the claims of a world file, or of a property file, about the system that the file states.

        found = maviper.verify_system(team, "corridor.toml")

    `Verified.results` has verdicts and evidence, `document` the report. InputError for files that cannot be used, a
    profile of another world, and a statement that is further from its reference than it says.
    """
    from pathlib import Path

    from codegen.profiles import ensure
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import verify_world

    file = None if properties is None else Path(properties)
    about = VerifyOptions(world=Path(world), file=file, **options.complete_options(options.SystemOptions, asked))
    return verify_world(ensure(_team(profile)), about)


@process.defaults
@options.spell_out(options.CompareOptions)
def compare(
    expert: str | Path | Callable[..., Any],
    output: str | Path | None = None,
    **asked: Unpack[options.CompareOptions],
) -> AlgorithmsCompared:
    """Algorithms, depths and seeds compared on an expert, at equal numbers of episodes.

        table = maviper.compare(act, world=make_env, algorithms=["maviper", "imitation"], depths=[2, 3], seeds=5)
        table.best.save("best.json")

    `expert` and `experts`: as for `extract`. `output`: a folder, in which an interrupted call goes on when it is
    repeated; None: nothing is kept. `rows`, `to_csv()` and `to_latex()` of what is returned are the table, `best` is a
    team. InputError for what cannot be used.
    """
    from pathlib import Path

    from maviper.reproduction.compare import compare_algorithms, request
    from maviper.team import Team

    named = str(expert) if isinstance(expert, Path) else expert
    found = compare_algorithms(named, output, request(asked))
    found.best = Team.of(found.best, _played(asked.get("world")))
    return found


@process.defaults
@options.spell_out(options.ReproduceOptions)
def reproduce(output: str | Path, **asked: Unpack[options.ReproduceOptions]) -> Reproduced:
    """The experiments of the MAVIPER paper, as cells in the folder `output`, with their table and report.

        maviper.reproduce("cells", quick=True)

    None: as quick, default or full says. With `plan`, `lines` of what is returned are the plan. `failed` of it: cells
    that failed, with their messages. Finished cells are not made again. InputError for what cannot be used,
    MissingToolError without room on the disk, without Dask, or when its scheduler goes away.
    """
    from maviper.reproduction.run import reproduce_paper, request

    return reproduce_paper(output, request(asked))
