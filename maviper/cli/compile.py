"""The command compile.

Does: has a profile compiled, writes the files, and says how much was compared.
Assumes: `maviper.compilation.run` compiles and proves.
Does not: emit or compare anything itself.
"""

from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import PROFILE, console_of, option, output

WHAT, HOW, CHECKS = "What is written", "The trees", "What is proved"


def _listed(_context: click.Context, _parameter: click.Parameter, value: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in value.split(",") if name.strip())


def _targets(_context: click.Context, _parameter: click.Parameter, value: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in value.split(","))


@click.command(
    "compile", cls=Verb, renamed={"--budget": "--solver-units"}, example="maviper compile demo/profile.json -o code"
)
@PROFILE
@option(
    "--target",
    "targets",
    default="c,python,json",
    show_default=True,
    metavar="NAMES",
    callback=_targets,
    section=WHAT,
    help="Any of c, python, json, javascript, rust, smt, svg, onnx, jax, torch.",
)
@option(
    "--prefix",
    default=None,
    metavar="NAME",
    section=WHAT,
    help="Prefix of every public name (default: the world's name).",
)
@option(
    "--style",
    default="auto",
    show_default=True,
    metavar="NAME",
    section=WHAT,
    help="Style of the C code: nested, ordered, walk or auto.",
)
@option("--test-vectors", is_flag=True, section=WHAT, help="Also write observations with expected actions, and a test.")
@option(
    "--pass",
    "passes",
    default="",
    metavar="NAMES",
    callback=_listed,
    section=HOW,
    help="Passes to run on the trees first: any of drop,merge,reorder.",
)
@option("--region", default=None, metavar="REGION", section=HOW, help="For the pass drop: `start` or a region file.")
@option(
    "--prove",
    is_flag=True,
    section=CHECKS,
    help="Prove with Z3 that C and Python equal the trees for all observations.",
)
@option(
    "--solver-units",
    default=None,
    type=int,
    section=CHECKS,
    help="Limit per proof, in Z3's resource units (default: 200000000).",
)
@output("The folder for the code.")
@click.pass_context
def compile_verb(context: click.Context, profile: Path, output: Path, **options: Any) -> int:
    """Compile a profile to code that decides the same.

    The code is written only after a replay: the code, PROFILE and the tree as learned must decide the same on every
    observation compared.

    With --prove, Z3 searches for an observation on which the text of ..._act and the tree decide differently. It covers
    all float32 numbers for C and all doubles for Python. Queries (SMT-LIB) and answers are written next to the code.

    Passes make the trees smaller or faster. Each pass is proved to change no decision. For drop, this holds within the
    region.

    \b
      merge    removes splits that decide nothing
      reorder  reorders tests, so that decisions in play need fewer of them
      drop     removes leaves that no state of --region reaches; the region
               becomes part of the code's contract
    """
    from codegen.policy_json import content_hash
    from maviper.cli.agreement import say_agreement, say_proofs
    from maviper.compilation.run import CompileOptions, compiled
    from maviper.files import outputs
    from maviper.files.profiles import load

    console = console_of(context)
    found = compiled(load(profile), CompileOptions(**options))
    for note in found.notes:
        console.line("pass", note)
    verb = outputs.of_code(found.build.model.prefix, content_hash(found.build.profile))
    outputs.write_set(output, found.files, verb)
    for name in found.files:
        console.line("wrote", str(output / name))
    say_agreement(found, console)
    if found.proofs:
        say_proofs(found.proofs, console)
    return ExitCode.DONE if found.complete else ExitCode.INCONCLUSIVE
