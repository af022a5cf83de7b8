"""The command check.

Does: has a certificate checked, and says what it proves.
Assumes: `maviper.verification.files.certificates` checks.
Does not: prove.
"""

from pathlib import Path

import click

from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.cli.group import Verb
from maviper.cli.options import PATH, console_of, option


@click.command(cls=Verb, example="maviper check generated/proved_defenders/certificate-1-distinct_targets.json")
@click.argument("certificate", type=PATH)
@option(
    "--profile",
    type=PATH,
    default=None,
    help="The profile that the certificate is about (default: profile.json beside it).",
)
@option(
    "--against",
    type=PATH,
    default=None,
    help="The second profile of a certificate by `maviper diff` (default: against.json beside it).",
)
@option(
    "--world",
    type=PATH,
    default=None,
    help="The world file of a certificate about a stated system (default: world.toml beside it).",
)
@click.pass_context
def check(
    context: click.Context, certificate: Path, profile: Path | None, against: Path | None, world: Path | None
) -> int:
    """Check that a certificate proves its claim.

    `maviper verify -o` writes a CERTIFICATE for each claim that it proves, unless Z3 alone proves it. The checker
    closes every branch of the proof again with exact numbers, from the profile, the region and the claim. It shares
    only the arithmetic of thresholds with the engine that found the proof.

    `maviper diff -o` writes a CERTIFICATE if agents act alike in two profiles. Both are needed to check it.

    `maviper verify --world -o` writes a CERTIFICATE about a stated system. The world file is needed to check it; what
    that says of dynamics that are not affine is shown again first.

    A CERTIFICATE may be packed with xz (`.json.xz`).

    A proof about episodes is about starts at rest. The agents in the proof follow their trees; all others may do
    anything.

    \b
    Exits with 0 if the proof holds, with 1 if it does not, and with 2 if the
    file cannot be read or is about another profile.
    """
    from maviper.console import say
    from maviper.verification.files.certificates import check_file
    from verify.progress import listening

    with console_of(context).following("checking") as listener, listening(listener):
        proof = check_file(certificate, profile, against, world)
    closed = f"{format_count(proof.closed, proof.unit)}{' closed' if proof.unit == 'branch' else ''}"
    say(f"accepted  {proof.subject}: {closed}, {format_count(proof.size, 'byte')} of proof")
    return ExitCode.DONE
