"""Compiling a profile: text, then the proof by replay that text, profile and learned tree decide alike; with all that
can be asked for, passes before it, test vectors, proofs, contracts and monitors after it.

Does: emits the targets and joins codegen's self-check with on-policy observations and whole episodes.
Assumes: the profile's world is one of ours; for others there is no replay of episodes, which is said.
Does not: write files, unless it is told where.
"""

import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cached_property, partial, reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from codegen import ir
from codegen.agreement import selfcheck, vectors
from codegen.agreement.compiled import Build, build
from codegen.agreement.selfcheck import Agreement, Report
from codegen.deciding import ensure_floats, ensure_plain, shape_decided, sums_in, take_actions
from codegen.equivalence.contracts import contracts_of
from codegen.errors import DisagreementError, InputError
from codegen.floats import FLOAT32
from codegen.form import layout
from codegen.lowering.lower import AUTO, FREESTANDING
from codegen.profiles import ensure
from codegen.rows import Shown
from codegen.targets import USUAL
from codegen.targets.rendered import LANGUAGES, facts
from maviper.episodes.play import Episodes, Policies
from maviper.episodes.trees import in_parts, on_policy
from maviper.evaluation.comparison import Fidelity, fidelity
from maviper.files import runs
from maviper.importing.edits import BEFORE as BEFORE_EDIT
from maviper.options import CompileOptions, make_request
from maviper.worlds import World
from maviper.worlds.matching import NO_WORLD, matching_world, not_ours
from verify.claims.parameters import Number

if TYPE_CHECKING:
    from maviper.compilation.monitors import Proved
    from maviper.compilation.proofs import Proofs, Proven

SOLVER_ROWS = 1_000  # an agent; a solver takes milliseconds each
MONITOR = "monitor"  # the target
BEFORE_REPAIR = "profile before repair"  # in the provenance of a repaired profile


@dataclass(frozen=True, repr=False)
class Compiled(Shown):
    """Holds the files of a compilation, and what was compared before they were handed out.

    For example:

        maviper.compile(team, "c").write("firmware/")
    """

    build: Build
    report: Report
    faithful: tuple[Fidelity, ...] = ()  #: how far each tree acts as the expert; nothing where nobody has the expert
    elsewhere: str = ""  #: why no episode was replayed, where the game is none of ours: nothing that failed
    notes: tuple[str, ...] = ()  #: what each pass did before
    proofs: "Proofs | None" = None  #: the answers of Z3 on the code; None: not asked
    proven: "Proven | None" = None  #: the answers of Frama-C; None: not asked
    #: test vectors, proofs, contracts
    beside: Mapping[str, str | bytes] = field(default_factory=dict[str, str | bytes])

    @cached_property
    def files(self) -> Mapping[str, str | bytes]:
        """All files by name, the evidence included: texts; of ONNX bytes."""
        evidence_file = f"{self.build.model.prefix}.agreement.json"
        return {**self.build.files, evidence_file: evidence(self), **self.beside}

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each file: its name and size in bytes, with what was compared of its target."""
        sizes = ((name, len(text.encode() if isinstance(text, str) else text)) for name, text in self.files.items())
        return [{"file": name, "bytes": size} for name, size in sizes]

    def write(self, folder: str | Path) -> Path:
        """Writes all files into a folder, which is made where it is missing; returns it."""
        place = runs.folder(Path(folder))
        runs.write_all(place, self.files)
        return place

    @property
    def complete(self) -> bool:
        """True if nothing had to be skipped, and every proof that was asked for was found."""
        asked = (each for each in (self.proofs, self.proven) if each is not None)
        return not self.report.skipped and all(each.complete for each in asked)


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
    proved_region: Proved | None = None  # what a monitor watches, with room for noise
    if asked.certificate is not None:
        from maviper.compilation import monitors  # here, so that compiling alone loads no checker

        proved_region = monitors.noisy(monitors.load_proof(asked.certificate, profile), asked.noise)
    code = compile_profile(profile, targets, asked.prefix, asked.style)
    more = vectors.files(code.build, targets) if asked.test_vectors else {}
    if watched:
        from maviper.compilation import monitors

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


def _ensure_contracts(targets: tuple[str, ...], proved: bool) -> None:
    """InputError where there is no C to have a contract, MissingToolError where what proves them is not there."""
    if "c" not in targets:
        what = "contracts are of the C, and the target c is not asked for"
        raise InputError(what, "--target", "write --target c,contracts")
    if proved:
        from maviper.compilation import proofs

        proofs.ensure_installed()


def compile_profile(
    profile: ir.PolicyProfile, targets: Iterable[str] = USUAL, prefix: str | None = None, style: str = AUTO
) -> Compiled:
    """Emits `targets` and replays them, tolerance zero. On any difference DisagreementError, and no files."""
    ensure(profile)
    with build(profile, targets, prefix, style) as made:
        return check_build(made)


def check_build(made: Build) -> Compiled:
    """A build, replayed with tolerance zero. DisagreementError on any difference."""
    profile, report = made.profile, selfcheck.check(made)
    agreements, skipped = list(report.agreements), list(report.skipped)
    faithful: tuple[Fidelity, ...] = ()
    # trees that were changed after they were grown, by a repair, by hand or for a region, have no such form any more
    changed = profile.region is not None or {BEFORE_REPAIR, BEFORE_EDIT} & {*profile.provenance.training}
    summing = sums_in(profile)
    single = (each for each in profile.agents if each.numbers == FLOAT32 and not each.whole)
    rounded = [each for each in single if each not in summing]  # others stay
    missing = [policy.agent for policy in rounded if policy.grown is None and not changed]
    if missing:
        skipped.append(f"the tree as grown: the profile does not hold it for {', '.join(missing)}")
    world = matching_world(profile)
    elsewhere = not_ours(profile.world)
    if world is None and not elsewhere:
        skipped.append(f"on-policy observations and episodes: {NO_WORLD}")
    if world is not None:
        played, faithful = _play_episodes(made, world)
        agreements += played
    agreements += ask_solver(made)
    return Compiled(made, Report(tuple(agreements), tuple(skipped), report.compiler).ensure(), faithful, elsewhere)


def ask_solver(made: Build) -> list[Agreement]:
    """Checks with Z3 the SMT-LIB functions, where there are any, at boundaries and special values."""
    definitions = made.text("smt2")
    if definitions is None:
        return []
    from verify.solver.solve import false_facts

    model = made.model
    agreements: list[Agreement] = []
    for policy, agent in zip(made.profile.agents, model.agents, strict=True):
        rows = selfcheck.observations(policy, random=1_000)
        rows = rows[:: 1 + len(rows) // SOLVER_ROWS]
        wanted = ir.act(policy, rows)
        wrong = false_facts(definitions, facts(model, agent, rows, wanted))
        first = f"Z3 denies {facts(model, agent, rows, wanted)[wrong[0]]}" if wrong else ""
        agreements.append(Agreement("smt", policy.agent, len(rows), len(wrong), first))
    return agreements


def _play_episodes(made: Build, world: World) -> tuple[list[Agreement], tuple[Fidelity, ...]]:
    """Compares the trees in on-policy episodes, part by part, with the trees as grown, the C, and the expert."""
    agreements: list[list[Agreement]] = []
    faithful: list[tuple[Fidelity, ...]] = []
    for seeds in in_parts(made.profile):
        episodes = on_policy(made.profile, world, seeds=seeds)
        faithful.append(fidelity(made.profile, world, episodes))
        grown = [  # boundaries once
            selfcheck.check_grown(policy, seen.reshape(-1, seen.shape[-1]), boundaries=not agreements)
            for policy, seen in zip(made.profile.agents, episodes.observations, strict=True)
            if policy.grown is not None
        ]
        agreements.append(grown + (_drive_episodes(made, world, episodes, seeds) if made.compilable else []))
        del episodes  # before the next ones are played
    joined = [reduce(selfcheck.merge_agreements, each) for each in zip(*agreements, strict=True)]
    return joined, tuple(reduce(operator.add, each) for each in zip(*faithful, strict=True))


def _drive_episodes(made: Build, world: World, episodes: Episodes, seeds: range) -> list[Agreement]:
    """The same episodes, driven by the compiled C: every action and world state must be the same."""
    profile = made.profile

    def drive(policy: ir.AgentPolicy, rows: ir.Floats) -> Any:  # memory is among the observations
        return take_actions(policy, made.library.act(policy.agent, rows))

    driver = Policies([partial(drive, policy) for policy in profile.agents])
    again = on_policy(profile, world, driver, keep=False, seeds=seeds)
    if any(_bytes(a) != _bytes(b) for a, b in zip(again.states, episodes.states, strict=True)):
        raise DisagreementError(
            "episodes driven by the compiled C differ from those of the profile",
            "",
            "this is a bug; nothing was written",
        )
    agreements: list[Agreement] = []
    for agent, policy in enumerate(profile.agents):
        rows = episodes.observations[agent].reshape(-1, len(policy.features))
        shape = shape_decided(policy)  # its actions in all steps, or the numbers that it gave
        wanted, given = (each.actions[..., agent, *map(slice, shape)].reshape(-1, *shape) for each in (episodes, again))
        agreements.append(selfcheck.compare("episodes driven by c", policy, rows, wanted, given))
    return agreements


def _bytes(state: Any) -> list[bytes]:
    """All that a batch of world states holds."""
    held = [getattr(state, part.name) for part in fields(state)]
    return [piece for each in held for piece in (_bytes(each) if is_dataclass(each) else [each.tobytes()])]


def evidence(compiled: Compiled) -> str:
    """Returns what was compared, and how far the trees act as their expert, as JSON text to keep beside the code."""
    rows: list[dict[str, Any]] = [
        {"target": item.target, "agent": item.agent, "observations": item.observations, "differences": item.differences}
        for item in compiled.report.agreements
    ]
    skipped = [*compiled.report.skipped, *filter(None, [compiled.elsewhere])]
    document = {"profile": compiled.build.model.content_hash, "agreement": rows, "skipped": skipped}
    return layout(document | {"expert": [item.document() for item in compiled.faithful]}) + "\n"
