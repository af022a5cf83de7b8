"""Agreement: generated code, compiled strictly and replayed against the reference, tolerance zero.

Does: asks the compiled C, the Python module, the JSON and what else was emitted, and compares every decision.
Assumes: compiled.py builds the C where there is a compiler.
Does not: trust the emitters: each target is read back from its text by means that the emitter does not use.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial, reduce
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.agreement import entries, probes, readback
from codegen.agreement.compiled import Build, CompiledC, ensure_strict
from codegen.agreement.entries import (
    CONSTANTS,
    OBSERVE,
    SEED,
    Agreement,
    Asked,
    Told,
    ask_sequences,
    differing,
    expected_answers,
)
from codegen.agreement.probes import Kept, iterate_rows
from codegen.boxes import is_inside
from codegen.deciding import decide
from codegen.equivalence import structure
from codegen.errors import DisagreementError, MissingToolError
from codegen.ir import Floats
from codegen.lowering.lower import AUTO, lower
from codegen.lowering.model import Model
from codegen.memory import initial_memory

INPUT_CHECK = "c input check"
STRUCTURE = "c structure"
MAX_PARSED = 20_000  # nodes of all trees; parsing more, here or by every compiler, takes minutes
ALL = "c all agents"
TEAM = f"c {entries.TEAM}"
NO_DECISIONS = ("input check", STRUCTURE, CONSTANTS, OBSERVE)  # what targets end with that count none
RANDOM_OBSERVATIONS = 100_000
RANDOM_NUMBERS = 1 << 23  # in all of an agent's random observations: agents that observe much are asked fewer


@dataclass(frozen=True)
class Report:
    """Everything that was compared, and what could not be."""

    agreements: tuple[Agreement, ...]
    skipped: tuple[str, ...]
    compiler: str  # "" when there is none

    @property
    def observations(self) -> int:
        """The number of decisions compared (answers of input checks and nodes of syntax trees are not decisions)."""
        return sum(item.observations for item in self.agreements if not item.target.endswith(NO_DECISIONS))

    def ensure(self) -> "Report":
        """The report itself; DisagreementError when any decision differs."""
        wrong = [agreement for agreement in self.agreements if agreement.differences]
        if wrong:
            where = "\n".join(
                f"{item.target}, {item.agent}: {item.differences} of {item.observations} decisions differ; {item.first}"
                for item in wrong
            )
            raise DisagreementError(
                "generated code disagrees with the profile", where, "this is a bug; nothing was written"
            )
        return self


def observations(policy: ir.AgentPolicy, random: int = RANDOM_OBSERVATIONS) -> Floats:
    """Returns every target's questions: boundaries of the deployed and the grown tree, special values, random ones."""
    return np.concatenate(list(_parts(policy, random)))


def _parts(policy: ir.AgentPolicy, random: int) -> Iterator[Floats]:
    def draw() -> Iterator[Floats]:
        rng = np.random.default_rng(SEED)
        yield from probes.telling(policy, rng)
        yield probes.special(policy.features, rng, policy.numbers)
        count = min(random, RANDOM_NUMBERS // max(1, len(policy.features)))
        yield from probes.random_parts(policy.features, count, rng, policy.numbers)
        if policy.grown is not None:
            yield probes.boundary(policy.grown, policy.features, rng)

    return (probes.in_type(rows, policy) for rows in draw())


def compare(target: str, policy: ir.AgentPolicy, rows: Any, wanted: Any, answers: Any) -> Agreement:
    """Counts the differences between wanted and found answers, actions or numbers, for the observations `rows`."""
    answers = np.asarray(answers)
    wrong = np.flatnonzero(differing(wanted, answers))
    first = ""
    if wrong.size:
        row = int(wrong[0])
        says, does = (_format_answer(policy, each[row]) for each in (wanted, answers))
        values = ", ".join(repr(float(value)) for value in rows[row])
        first = f"for x = ({values}) the profile says {says}, the code {does}"
    return Agreement(target, policy.agent, len(wanted), int(wrong.size), first)


def _format_answer(policy: ir.AgentPolicy, answer: Any) -> str:
    if np.ndim(answer):
        return f"({', '.join(repr(float(value)) for value in answer)})"
    return policy.actions[int(answer)].name if 0 <= int(answer) < len(policy.actions) else str(int(answer))


def check_files(
    profile: ir.PolicyProfile,
    files: Mapping[str, str | bytes],
    prefix: str | None = None,
    random: int = RANDOM_OBSERVATIONS,
    style: str = AUTO,
) -> Report:
    """Replays files (name -> content) against the reference, as `check`."""
    with Build(profile, lower(profile, prefix, style), files) as build:
        return check(build, random)


def check(build: Build, random: int = RANDOM_OBSERVATIONS) -> Report:
    """Replays every file of a build against the reference; the report holds differences too.

    `random`: random observations per agent, beside all boundary and special ones.
    """
    profile, model = build.profile, build.model
    agreements: list[Agreement] = []
    skipped: list[str] = []
    entry = Asked(profile)
    with Kept() as asked:
        wanted: dict[str, Any] = {}
        for policy in profile.agents:
            acted: list[Any] = []
            for rows in _parts(policy, random):
                acted.append(decide(policy, rows))
                asked.keep(policy.agent, rows)
            wanted[policy.agent] = np.concatenate(acted)
        header, module = (build.text(ending) for ending in ("h", "py"))
        if header is not None and build.compiler is None:
            skipped.append("C: no compiler found (cc, gcc, clang or $CC)")
        if header is not None and sum(len(policy.tree.feature) for policy in profile.agents) > MAX_PARSED:
            skipped.append(f"the structural proof of the C: more than {MAX_PARSED} nodes")
        elif header is not None:
            ensure_strict(header, model)
            for agent, faults in structure.faults(header, profile, model).items():
                nodes = len(profile.policy(agent).tree.feature)
                agreements.append(Agreement(STRUCTURE, agent, nodes, len(faults), *faults[:1]))
        if build.compilable:
            for policy in profile.agents:
                agreements += _in_parts(policy, asked, wanted, partial(_c_replayed, build.library, model))
            agreements += _check_c_all(build, asked, min(map(len, wanted.values()))) if model.acting else []
            agreements += _check_c_entries(build, entry, skipped)
        if module is not None:
            agreements += _check_python(module, model, asked, wanted, entry)
        agreements += _read(build, asked, wanted, skipped)
        agreements += _check_reader(build, entry)
        for suffix, replay in (("mjs", _check_javascript), ("rs", _check_rust)):
            text = build.text(suffix)
            if text is not None:
                try:
                    agreements += replay(build, text, asked, wanted, entry)
                except MissingToolError as error:
                    skipped.append(f"{suffix}: {error.what}")
    return Report(tuple(agreements), tuple(skipped), " ".join(build.compiler or []))


def _c_replayed(
    compiled: CompiledC, model: Model, policy: ir.AgentPolicy, rows: Floats, expected: Any
) -> Iterator[Agreement]:
    # by its contract, what a style that compares bits does with NaN counts for nothing
    held = ~np.isnan(rows).any(axis=1) if model.by_bits else slice(None)
    actions, checks = compiled.act_and_check(policy.agent, rows)
    yield compare("c", policy, rows[held], expected[held], actions[held])
    batches = () if model.bare else zip(("c rows", "c columns"), compiled.batch(policy.agent, rows), strict=True)
    for name, actions in batches:
        yield compare(name, policy, rows, expected, actions)
    wrong = int((checks != entries.checks(policy, rows)).sum())
    yield Agreement(INPUT_CHECK, policy.agent, len(rows), wrong, "a check is wrong" if wrong else "")


def _check_c_all(build: Build, asked: Kept, count: int) -> list[Agreement]:
    """Checks the call for all agents on the first observations of each."""
    agents, model = build.profile.agents, build.model
    agreements: list[list[Agreement]] = []
    for seen in asked.together([policy.agent for policy in agents], count):
        if model.bare or (model.by_bits and not model.side_by_side):  # the functions of that style, one after the other
            seen = [np.nan_to_num(rows) for rows in seen]
        acted = build.library.all(seen).T
        each = zip(agents, seen, acted, strict=True)
        agreements.append([compare(ALL, policy, rows, ir.act(policy, rows), actions) for policy, rows, actions in each])
    return [reduce(merge_agreements, parts) for parts in zip(*agreements, strict=True)]


Replayed = Callable[[ir.AgentPolicy, Floats, Any], Iterable[Agreement]]


def _in_parts(policy: ir.AgentPolicy, asked: Kept, wanted: Mapping[str, Any], replayed: Replayed) -> list[Agreement]:
    """Collects what `replayed` finds in an agent's observations, given to it in parts of bounded memory."""
    expected = wanted[policy.agent]
    parts = [replayed(policy, rows, expected[low : low + len(rows)]) for low, rows in asked.parts(policy.agent)]
    return [reduce(merge_agreements, each) for each in zip(*parts, strict=True)]


def merge_agreements(one: Agreement, other: Agreement) -> Agreement:
    """Two parts of one comparison."""
    asked, wrong = one.observations + other.observations, one.differences + other.differences
    return Agreement(one.target, one.agent, asked, wrong, one.first or other.first)


def _check_c_entries(build: Build, asked: Asked, skipped: list[str]) -> list[Agreement]:
    """Checks what the C says of world states and of the region, and its constants."""
    profile, model, compiled = build.profile, build.model, build.library
    if model.by_bits:  # by its contract, it takes finite coordinates only
        asked = Asked(profile, finite=True)
    told = Told({policy.agent: compiled.checks(policy.agent, asked.rows[policy.agent]) for policy in profile.agents})
    if model.bare:
        return entries.compare_entries("c", asked, told)
    force = {entity.name: entity.force for entity in profile.world.agents}
    constants = [profile.world.dt, profile.world.damping, *(force[policy.agent] for policy in profile.agents)]
    agents = [policy.agent for policy in profile.agents]
    worlds = {agent: compiled.worlds(agent, asked.states) for agent in agents if model.located}
    told = replace(
        told,
        observed={agent: seen.astype(np.float64) for agent, (seen, _) in worlds.items()},
        acted={agent: actions for agent, (_, actions) in worlds.items()},
        team=compiled.team(asked.states) if model.located and model.acting else None,
        within=compiled.region(asked.bordering) if model.region else None,
        remembered={agent: compiled.steps(agent, each.rows) for agent, each in asked.sequences.items()},
    )
    if profile.region and not is_inside(profile.region, asked.bordering, profile.world.coordinates()).any():
        skipped.append("the check of the region: no state was drawn that lies in it")
    return [entries.constants("c", constants, compiled.constants()), *entries.compare_entries("c", asked, told)]


def _read(build: Build, asked: Kept, wanted: Mapping[str, Any], skipped: list[str]) -> list[Agreement]:
    """Runs the readers of `readback`; a reader whose tool is missing is named in `skipped`, each tool once."""
    agreements: list[Agreement] = []
    for policy, agent in zip(build.profile.agents, build.model.agents, strict=True):
        for reader in readback.READERS:
            names = [name.format(prefix=build.model.prefix, agent=agent.lower) for name in reader.files]
            if not all(name in build.files for name in names):
                continue
            contents = [build.files[name] for name in names]
            if reader.act is readback.st_act and policy.memory:  # whose memory takes whole numbers alone
                agreements += _check_block(str(contents[0]), policy)
                continue
            parts: list[Agreement] = []
            try:
                for low, rows in asked.parts(policy.agent):
                    chosen = slice(-low % reader.every, None, reader.every)  # so many rows of the whole array
                    expected = wanted[policy.agent][low : low + len(rows)][chosen]
                    answers = reader.act(*contents, policy.agent, rows[chosen])
                    parts.append(compare(reader.target, policy, rows[chosen], expected, answers))
            except MissingToolError as error:
                reason = f"{Path(names[0]).suffix[1:]}: {error.what}"
                skipped += [reason] if reason not in skipped else []
            else:
                agreements.append(reduce(merge_agreements, parts))
    return agreements


def _check_block(text: str, policy: ir.AgentPolicy) -> Iterator[Agreement]:
    """Compares the steps of a function block that remembers, also where it is reset first, with the reference."""
    asked = ask_sequences(policy)
    rows: Any = np.concatenate([asked.rows[:, : -asked.known.shape[1]], asked.known], axis=1)
    begun = np.broadcast_to(initial_memory(policy), asked.known.shape)
    for name, known in (("st machine", asked.known), ("st reset", begun)):
        expected = expected_answers(policy, asked._replace(known=known))
        told = readback.st_steps(text, rows, reset=known is begun)
        yield compare(name, policy, np.concatenate([rows[:1], rows]), expected, told)


def _check_reader(build: Build, entry: Asked) -> list[Agreement]:
    """Checks that the reference reader refuses what is no observation, and makes doubles of numbers of every type."""
    profile, document = build.profile, build.text("json")
    reader = build.files.get(f"{build.model.prefix}_reader.py")
    if document is None or not isinstance(reader, str):
        return []
    agreements: list[Agreement] = []
    for policy in profile.agents:
        read = readback.load_reader(reader, document, policy.agent)
        if policy.memory:
            questions = entry.sequences[policy.agent]
            expected, told = expected_answers(policy, questions), readback.drive_reader(read, questions.rows)
            agreements.append(compare("json reader machine", policy, questions.shown, expected, told))
        wrong = [each for each in entries.single(len(policy.features), asks=True) if not isinstance(each, bytes)]
        let = entries.find_accepted(read.act, wrong)
        agreements.append(Agreement("json reader input check", policy.agent, len(wrong), len(let), *let[:1]))
        rows = [row for part in entry.typed[policy.agent] for row in part]
        if rows:
            expected = decide(policy, [[float(value) for value in row] for row in rows])
            agreements.append(
                compare("json reader other types", policy, rows, expected, [read.act(row) for row in rows])
            )
    return agreements


def _check_python(module: str, model: Model, asked: Kept, wanted: Mapping[str, Any], entry: Asked) -> list[Agreement]:
    namespace, profile = readback.load_python(module), entry.profile
    agreements = entries.compare_entries("python", entry, readback.python_told(namespace, entry))
    for policy, agent in zip(profile.agents, model.agents, strict=True):
        act, batch = namespace["ACT"][agent.name], namespace["ACT_BATCH"][agent.name]
        agreements += _in_parts(policy, asked, wanted, partial(_python_replayed, act, batch))
        near, typed = entry.near[policy.agent], entry.typed[policy.agent]
        if len(near):
            acted = [act(row) for row in iterate_rows(near)]
            agreements.append(compare("python doubles", policy, near, decide(policy, near), acted))
            rows = [row for part in typed for row in part]
            expected = decide(policy, [[float(value) for value in row] for row in rows])
            agreements.append(compare("python other types", policy, rows, expected, [act(list(row)) for row in rows]))
            agreements.append(compare("python other arrays", policy, rows, expected, [act(row) for row in rows]))
            batches = np.concatenate([batch(part) for part in typed])
            agreements.append(compare("python other batches", policy, rows, expected, batches))
        n = len(policy.features)
        wrong, many = entries.single(n, asks=agent.asks), entries.many(n)
        let = entries.find_accepted(act, wrong) + entries.find_accepted(batch, many)
        agreements.append(Agreement("python input check", policy.agent, len(wrong) + len(many), len(let), *let[:1]))
    return agreements


def _python_replayed(
    act: Callable[[Any], Any], batch: Callable[[Any], Any], policy: ir.AgentPolicy, rows: Floats, expected: Any
) -> Iterator[Agreement]:
    yield compare("python", policy, rows, expected, list(map(act, iterate_rows(rows))))
    yield compare("python arrays", policy, rows, expected, list(map(act, rows)))
    yield compare("python batch", policy, rows, expected, batch(rows))


def _check_javascript(
    build: Build, module: str, asked: Mapping[str, Floats], wanted: Mapping[str, Any], entry: Asked
) -> list[Agreement]:
    profile, model, near = build.profile, build.model, entry.near
    rows = {name: np.concatenate([seen.astype(np.float64), near[name]]) for name, seen in asked.items()}
    ran, told = readback.javascript_act(module, model, rows, entry)
    agreements = entries.compare_entries("javascript", entry, told)
    for policy in profile.agents:
        expected = np.concatenate([wanted[policy.agent], decide(policy, near[policy.agent])])
        acted = ran[policy.agent]
        agreements.append(compare("javascript", policy, rows[policy.agent], expected, acted.single))
        agreements.append(compare("javascript rows", policy, rows[policy.agent], expected, acted.batch))
        let = acted.accepted
        agreements.append(Agreement("javascript input check", policy.agent, acted.misused, len(let), *let[:1]))
    return agreements


def _check_rust(
    build: Build, module: str, asked: Mapping[str, Floats], wanted: Mapping[str, Any], entry: Asked
) -> list[Agreement]:
    profile, model = build.profile, build.model
    ran, told = readback.rust_act(module, model, asked, entry, build.optimised)
    agreements = entries.compare_entries("rust", entry, told)
    for name, acted in ran.items():
        policy, rows = profile.policy(name), asked[name]
        agreements.append(compare("rust", policy, rows, wanted[name], acted.single))
        agreements.append(compare("rust rows", policy, rows, wanted[name], acted.batch))
    return agreements


def check_grown(policy: ir.AgentPolicy, on_policy: Floats, boundaries: bool = True) -> Agreement:
    """The deployed tree against the tree as it was grown, on the given and, if asked, on all boundary observations."""
    grown = policy.grown
    assert grown is not None, "a profile without the grown tree has nothing to compare with"
    rng = np.random.default_rng(SEED)
    trees = (grown, policy.tree) if boundaries else ()
    rows = np.concatenate([on_policy, *(probes.boundary(tree, policy.features, rng) for tree in trees)])
    learned = grown.action[ir.apply(grown, rows)]
    return compare("tree as grown", policy, rows, learned, ir.act(policy, rows))
