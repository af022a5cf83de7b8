"""MAVIPER: neural multi-agent policies as small decision trees, compiled exactly and proved.

Does: every command as a function, with its options as parameters; profiles from trees of other programs.
Assumes: heavy libraries are imported by the functions that need them.
Does not: import anything heavy itself, or print.

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
    from collections.abc import Iterable
    from pathlib import Path
    from typing import Any, Unpack

    from codegen.ir import PolicyProfile
    from maviper.compilation.compile import Compiled
    from maviper.evaluation.exploitability import Exploitability
    from maviper.evaluation.run import Evaluation
    from maviper.reproduction.run import Reproduced
    from maviper.verification.compared import OutputsCompared
    from maviper.verification.diff import Compared
    from maviper.verification.files.certificates import Checked
    from maviper.verification.files.counterexamples import Replayed
    from maviper.verification.repair import Repaired
    from maviper.verification.robust import Changes, Radii
    from maviper.verification.run import Verified
    from verify.result import AnyResult

__all__ = [
    "check",
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


def version() -> str:
    """The version of the package."""
    from maviper.files.profiles import version as installed

    return installed()


@process.defaults
def load(path: str | Path) -> PolicyProfile:
    """The policy profile in a JSON file, checked. ProfileError (an InputError) with the path of the fault otherwise."""
    from maviper.files.profiles import load as loaded

    return loaded(path, sums=True)


@process.defaults
@options.spell_out(options.TrainOptions)
def train(world: str, output: str | Path, **asked: Unpack[options.TrainOptions]) -> dict[str, Any]:
    """Trains an expert for a world into the run folder `output`; returns its card, with what was measured.

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
    expert: str | Path, output: str | Path | None = None, **asked: Unpack[options.ExtractOptions]
) -> PolicyProfile:
    """Decision trees from an expert, as a profile; each option is one of `maviper extract`.

    `expert`: a world's name, an expert file, a run folder, or module:function. `output`: the profile's .json file, or a
    run folder, which several seeds and `resume` need; None: nothing is written. None elsewhere: as the preset says.
    InputError: a wrong name or value.
    """
    from pathlib import Path

    from maviper.console import Console
    from maviper.extraction.run import extract_named, request

    return extract_named(str(expert), None if output is None else Path(output), request(asked), Console(quiet=True))


@process.defaults
@options.spell_out(options.EvaluateOptions)
def evaluate(subject: str | Path, **asked: Unpack[options.EvaluateOptions]) -> Evaluation:
    """A profile, an expert or a mix measured in play, on held-out episodes that are the same for everybody.

    `subject`: a profile's file (its name ends in .json), or an expert as `extract` takes it. InputError for what cannot
    be used, UnknownNameError for a name that there is not.
    """
    from maviper.evaluation.run import evaluate_named, request

    return evaluate_named(request(str(subject), **asked))


@process.defaults
@options.spell_out(options.ExploitOptions)
def exploit(subject: str | Path, team: str, **asked: Unpack[options.ExploitOptions]) -> Exploitability:
    """A lower bound on what the opponents of `team` gain by answering its policies.

    InputError for what cannot be used, MissingToolError where `networks` names a folder and torch is missing.
    """
    from maviper.console import Console
    from maviper.extraction.exploiting import exploit_team

    return exploit_team(str(subject), team, Console(quiet=True), **asked)


@process.defaults
@options.spell_out(options.CompileOptions)
def compile(
    profile: PolicyProfile, targets: Iterable[str] = TARGETS, **asked: Unpack[options.CompileOptions]
) -> Compiled:
    """Code for a profile, replayed against it with tolerance zero before it is returned.

    `Compiled.files` maps file names to texts (of ONNX: bytes), `Compiled.proofs` has the answers of `prove`. `targets`:
    some of c, python, json, javascript, rust, smt, svg, onnx, onnx-old, jax, torch and monitor. DisagreementError when
    any decision differs; InputError for what cannot be asked.
    """
    from maviper.compilation.run import compile_and_prove

    return compile_and_prove(profile, targets, **asked)


@process.defaults
@options.spell_out(options.VerifyOptions)
def verify(
    profile: PolicyProfile,
    claim: str | claims.Claim = "distinct_targets",
    region: str | Path = "start",
    **asked: Unpack[options.VerifyOptions],
) -> AnyResult:
    """The verdict on a built-in claim for every state of a region: `start`, or a region file.

    `claim`: one of `maviper.claims`, such as `claims.Reaches(steps=25)`, which has its parameters and its team; or a
    name, with the parameters as options. `margin` and `radius` are lengths of the world, `kappa` is a ratio, `eps` is
    in the features' units. `where` also answers where a claim about single decisions holds and fails (`where` of
    `Result.evidence`) and from what share of the starts one about episodes fails (`starts` of it). `shared`: ["all"]
    for all features. None: as `maviper properties list` says. InputError for a name that there is not, or a parameter
    that the claim does not read.
    """
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import results

    return results(profile, VerifyOptions.about(claim, str(region), asked))[0]


@process.defaults
@options.spell_out(options.FileOptions)
def verify_file(
    profile: PolicyProfile, file: str | Path, region: str | Path = "start", **asked: Unpack[options.FileOptions]
) -> list[AnyResult]:
    """The verdicts on the claims of a property file, in its order; `region` is for those that name none.

    InputError with line and column for a claim that cannot be read, and for a limit that nothing reads.
    """
    from pathlib import Path

    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import results

    given = options.complete_options(options.FileOptions, asked)
    return results(profile, VerifyOptions(file=Path(file), region=str(region), **given))


@process.defaults
def check(
    certificate: str | Path,
    profile: PolicyProfile | str | Path | None = None,
    against: PolicyProfile | str | Path | None = None,
    world: str | Path | None = None,
) -> Checked:
    """What the certificate in a file proves of a profile (default: profile.json beside it), of a second one where it is
    by `diff` (default: against.json beside it), in a world file if it is by `verify_system` (world.toml beside it).

    RefusedError when its proof does not hold; InputError when it cannot be read or is about another profile.
    """
    from pathlib import Path

    from maviper.verification.files.certificates import check_file

    first, second = (Path(one) if isinstance(one, str) else one for one in (profile, against))
    return check_file(Path(certificate), first, second, None if world is None else Path(world))


@process.defaults
def replay(
    counterexample: str | Path, profile: PolicyProfile | str | Path | None = None, world: str | Path | None = None
) -> Replayed:
    """The counterexample in a file, replayed with a profile (default: profile.json beside it): does the claim fail?

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
    profile: PolicyProfile,
    claim: str | claims.Claim = "distinct_targets",
    region: str | Path = "start",
    **asked: Unpack[options.RepairOptions],
) -> Repaired:
    """The leaves from which a claim can fail are changed until both engines prove it; `Repaired.after` is the profile.

    It is None where no repair was found. `claim`: distinct_targets or own_target, by name or as an object, such as
    `claims.OwnTarget(landmarks=["landmark_1", "landmark_0"])`; `region`: `start`, or a region file.
    `Repaired.cost` has the measures before and after. InputError for what cannot be asked.
    """
    from codegen.profiles import ensure
    from maviper.verification.repair import repair_profile, request

    return repair_profile(ensure(profile), claim, str(region), request(claim, asked))


@process.defaults
def robust(
    profile: PolicyProfile | str | Path,
    observations: str | Path,
    agent: str | None = None,
    *,
    certify: bool = False,
    error: str | None = None,
) -> Radii | Changes:
    """For each observation of a CSV or JSON file the largest radius within which an agent acts the same, exactly; of an
    agent that gives numbers, how far each output may change where features are off by up to `error`.

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
    first: PolicyProfile, second: PolicyProfile, region: str | Path = "start", **asked: Unpack[options.DiffOptions]
) -> Compared | OutputsCompared:
    """Every state of a region in which two profiles act differently, or the proof that there is none.

    `Compared.facts` has shares, zones and examples, `Compared.found` the certificate. Of agents that test sums or give
    numbers, `OutputsCompared.facts` has the largest difference of each output, and where. InputError for profiles whose
    worlds, agents, features or actions differ.
    """
    from maviper.verification.diff import compare_profiles, request

    return compare_profiles(first, second, str(region), request(**asked))


@process.defaults
@options.spell_out(options.SystemOptions)
def verify_system(
    profile: PolicyProfile,
    world: str | Path,
    properties: str | Path | None = None,
    **asked: Unpack[options.SystemOptions],
) -> Verified:
    """The verdicts on the claims of a world file, or of a property file, about the system that the file states.

    `Verified.results` has verdicts and evidence, `document` the report. InputError for files that cannot be used, a
    profile of another world, and a statement that is further from its reference than it says.
    """
    from pathlib import Path

    from codegen.profiles import ensure
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import verify_world

    file = None if properties is None else Path(properties)
    about = VerifyOptions(world=Path(world), file=file, **options.complete_options(options.SystemOptions, asked))
    return verify_world(ensure(profile), about)


@process.defaults
@options.spell_out(options.ReproduceOptions)
def reproduce(output: str | Path, **asked: Unpack[options.ReproduceOptions]) -> Reproduced:
    """The experiments of the MAVIPER paper, as cells in the folder `output`, with their table and report.

    None: as quick, default or full says. With `plan`, `lines` of what is returned are the plan. `failed` of it: cells
    that failed, with their messages. Finished cells are not made again. InputError for what cannot be used,
    MissingToolError without room on the disk, without Dask, or when its scheduler goes away.
    """
    from maviper.reproduction.run import reproduce_paper, request

    return reproduce_paper(output, request(asked))
