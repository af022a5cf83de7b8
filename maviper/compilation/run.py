"""Compilation with everything that can be asked for: passes before it, test vectors and proofs after it.

Does: joins passes, `compile`, test vectors and proofs.
Assumes: a profile; options that a user gave.
Does not: emit or compare anything itself, print or write files.
"""

from dataclasses import dataclass, replace

from codegen import ir
from codegen.agreement import vectors
from codegen.lowering.lower import AUTO
from codegen.targets import USUAL
from maviper.compilation.compile import Compiled, compile_profile
from maviper.compilation.passes import transformed


@dataclass(frozen=True)
class CompileOptions:
    """What a compilation is asked for."""

    targets: tuple[str, ...] = tuple(USUAL)
    prefix: str | None = None  # of every public name; None: the world's name
    style: str = AUTO  # how the C decides
    test_vectors: bool = False
    passes: tuple[str, ...] = ()  # over the trees first
    region: str | None = None  # of the pass drop
    prove: bool = False  # equal to the trees for all observations
    solver_units: int | None = None  # for each proof; None: as usual


def compiled(profile: ir.PolicyProfile, options: CompileOptions) -> Compiled:
    """Code for a profile. DisagreementError when any decision differs; InputError for options that cannot be used."""
    targets, prefix, style = options.targets, options.prefix, options.style
    if options.prove:
        from maviper.compilation import proofs  # here, so that compiling alone loads no solver

        proofs.ensure_askable(targets, options.solver_units)
    notes: tuple[str, ...] = ()
    if options.passes or options.region is not None:
        better = transformed(profile, options.passes, options.region)
        profile, notes = better.profile, better.notes
    found = compile_profile(profile, targets, prefix, style)
    more = vectors.files(found.build, targets) if options.test_vectors else {}
    proved = proofs.prove(found.build, options.solver_units) if options.prove else None
    more |= proofs.files_of(proved, found.build.model) if proved else {}
    return replace(found, notes=notes, proofs=proved, beside=more)
