"""The command compile.

Does: has a profile compiled, writes the files, and says how much was compared.
Assumes: `maviper.compilation.run` compiles and proves.
Does not: emit or compare anything itself.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from codegen.errors import ExitCode
from maviper.cli.options import PROFILE, Verb, console_of, names, option, options_of, output
from maviper.options import CompileOptions
from maviper.options.verbs import TARGETS, WRITTEN

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile


@click.command(
    "compile", cls=Verb, renamed={"--budget": "--solver-units"}, example="maviper compile demo/profile.json -o code"
)
@PROFILE
@option(
    "--target",
    "targets",
    default=",".join(TARGETS),
    show_default=True,
    metavar="NAMES",
    callback=names,
    section=WRITTEN,
    help="Any of c, python, json, javascript, rust, smt, svg, onnx, onnx-old, jax, torch, monitor.",
)
@options_of(CompileOptions)
@output("The folder for the code.")
@click.pass_context
def compile_verb(
    context: click.Context, profile: Path, targets: tuple[str, ...], output: Path, **options: Unpack[CompileOptions]
) -> int:
    """Compile a profile to code that decides the same.

    The code is written only after a replay: the code, PROFILE and the tree as learned must decide the same on every
    observation compared.

    With --prove, Z3 searches for an observation on which the text of ..._act and the tree decide differently. It covers
    all float32 numbers for C and all doubles for Python. Queries (SMT-LIB) and answers are written next to the code.

    With --contracts, the trees are also written as contracts in ACSL. --frama-c has Frama-C prove that the C keeps
    them: right actions, reads within bounds, nothing written, no undefined behaviour. Both need style nested or
    ordered.

    The target monitor adds code that says, at run time, whether a state is one for which the claim of --certificate is
    proved. Trees with sums or outputs may have one without a certificate, which watches ranges.

    Passes make the trees smaller or faster. Each pass is proved to change no decision. For drop, this holds within the
    region.

    \b
      merge    removes splits that decide nothing
      reorder  reorders tests, so that decisions in play need fewer of them
      drop     removes leaves that no state of --region reaches; the region
               becomes part of the code's contract
    """
    from codegen.policy_json import content_hash
    from maviper.cli.results import say_agreement, say_contracts, say_proofs
    from maviper.compilation.run import compile_and_prove
    from maviper.files import outputs, runs
    from maviper.files.profiles import load

    console = console_of(context)
    loaded = load(profile, sums=True)
    runs.room(output)
    _ensure_free(output, profile, loaded, targets, options)
    code = compile_and_prove(loaded, targets, **options)
    for note in code.notes:
        console.line("pass", note)
    verb = outputs.of_code(code.build.model.prefix, content_hash(code.build.profile))
    outputs.write_set(output, code.files, verb, keep=_list_given(profile, options))
    for name in code.files:
        console.line("wrote", str(output / name))
    say_agreement(code, console)
    if code.proofs:
        say_proofs(code.proofs, console)
    if code.proven:
        say_contracts(code.proven, console)
    return ExitCode.DONE if code.complete else ExitCode.INCONCLUSIVE


def _list_given(profile: Path, options: CompileOptions) -> list[Path]:
    """The files that a compilation reads."""
    named = (options.get("region"), options.get("certificate"))
    return [profile, *(Path(each) for each in named if each is not None)]


def _ensure_free(
    folder: Path, path: Path, profile: "PolicyProfile", targets: tuple[str, ...], options: CompileOptions
) -> None:
    """InputError, before the work, where code would be written over a file that was given."""
    from codegen.check import identifier
    from codegen.policy_json import content_hash, dumps
    from maviper.files import outputs

    prefix = options.get("prefix") or identifier(profile.world.name)
    own, given = f"{prefix}.json", _list_given(path, options)
    changed = bool(options.get("passes")) or options.get("region") is not None
    known = {own: dumps(profile)} if "json" in targets and not changed else {}
    if "json" not in targets:
        given = [each for each in given if each.name != own]
    outputs.ensure_free(folder, outputs.of_code(prefix, content_hash(profile)), known, given)
