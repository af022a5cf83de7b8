"""Compilation with everything that can be asked for: passes before it, test vectors and proofs after it.

Does: joins passes, `compile`, test vectors, proofs, contracts and monitors.
Assumes: a profile; options that a user gave.
Does not: emit or compare anything itself, print or write files.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from codegen import ir
from codegen.agreement import vectors
from codegen.deciding import ensure_floats, ensure_plain, sums_in
from codegen.equivalence.contracts import contracts_of
from codegen.errors import InputError
from codegen.lowering.lower import FREESTANDING
from codegen.targets.rendered import LANGUAGES
from maviper.compilation.compile import Compiled, compile_profile
from maviper.options import CompileOptions, make_request
from verify.claims.parameters import Number

if TYPE_CHECKING:
    from maviper.compilation.monitors import Proved

MONITOR = "monitor"  # the target


def compile_and_prove(profile: ir.PolicyProfile, targets: Iterable[str], **options: Unpack[CompileOptions]) -> Compiled:
    """Code for a profile. DisagreementError when any decision differs; InputError for options that cannot be used."""
    asked, targets = make_request(CompileOptions, options), tuple(targets)
    watched, targets = split_targets(targets, asked.certificate, asked.noise, sums=bool(sums_in(profile)))
    for option, given in (
        ("--prove", asked.prove),
        ("--pass", asked.passes),
        ("--region", asked.region is not None),
        ("--test-vectors", asked.test_vectors),
    ):
        if given:
            ensure_plain(profile, option)
        if given and option == "--prove":
            ensure_floats(profile, option)
    if watched and "c" in targets and asked.style == FREESTANDING:
        what = f"monitors calculate with floats, and the style {FREESTANDING} has none"
        raise InputError(what, "--style", "use another style, or leave the target monitor out")
    if asked.prove:
        from maviper.compilation import proofs  # here, so that compiling alone loads no solver

        proofs.ensure_askable(targets, asked.solver_units)
    if asked.contracts or asked.frama_c:
        _ensure_contracts(targets, asked.frama_c)
    notes: tuple[str, ...] = ()
    if asked.passes or asked.region is not None:
        from maviper.compilation.passes import run_passes  # here, since most are compiled as they are

        better = run_passes(profile, asked.passes, None if asked.region is None else str(asked.region))
        profile, notes = better.profile, better.notes
    proved_region = _load_proof(asked.certificate, asked.noise, profile)
    code = compile_profile(profile, targets, asked.prefix, asked.style)
    more = vectors.files(code.build, targets) if asked.test_vectors else {}
    if watched:
        from maviper.compilation import monitors  # here, so that compiling alone loads no checker

        more = {**more, **monitors.files_of(code.build, proved_region, targets)}
    proved = proven = None
    if asked.prove:
        from maviper.compilation import proofs

        proved = proofs.prove(code.build, asked.solver_units, asked.effort)
        more = {**more, **proofs.files_of(proved, code.build.model)}
    if asked.contracts or asked.frama_c:
        contracts = contracts_of(code.build.profile, code.build.model)
        more = {**more, **contracts.files}
        if asked.frama_c:
            from maviper.compilation import proofs

            proven = proofs.prove_contracts(code.build, contracts)
            more = {**more, **proofs.record_of(proven, contracts, code.build)}
    return replace(code, notes=notes, proofs=proved, proven=proven, beside=more)


def split_targets(
    targets: Sequence[str], certificate: Path | None, noise: Number | None = None, *, sums: bool = False
) -> tuple[bool, tuple[str, ...]]:
    """Returns whether a monitor is asked for, and the other targets, with C where a monitor can be written for none.

    InputError for a monitor without a certificate, and for a certificate or noise without one. Trees with `sums` have
    monitors without a certificate too, of their inputs and outputs.
    """
    asked = MONITOR in targets
    if noise is not None and not asked:
        raise InputError("noise is only for the target monitor", "--noise", "leave it out, or add --target monitor")
    if asked != (certificate is not None) and not (sums and asked):
        what = "a monitor is made from a certificate" if asked else "a certificate is only for the target monitor"
        raise InputError(what, "--certificate", "give --target monitor and --certificate FILE together")
    others = tuple(target for target in targets if target != MONITOR)
    return asked, others if not asked or set(others) & set(LANGUAGES) else (*others, "c")


def _load_proof(certificate: Path | None, noise: Number | None, profile: ir.PolicyProfile) -> "Proved | None":
    """Returns what a monitor watches, with room for noise; None without a certificate."""
    if certificate is None:
        return None
    from maviper.compilation import monitors

    return monitors.noisy(monitors.load_proof(certificate, profile), noise)


def _ensure_contracts(targets: tuple[str, ...], proved: bool) -> None:
    """InputError where there is no C to have a contract, MissingToolError where what proves them is not there."""
    if "c" not in targets:
        what = "contracts are of the C, and the target c is not asked for"
        raise InputError(what, "--target", "write --target c,contracts")
    if proved:
        from maviper.compilation import proofs

        proofs.ensure_installed()
