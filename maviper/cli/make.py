"""The commands extract, train, import and compile.

Does: has trees extracted from an expert, an expert trained, trees of other programs read and replayed, or a profile
  compiled, and says what came out; notes the command line that repeats an extraction.
Assumes: `maviper.extraction.run` extracts, shows progress and writes; `maviper.importing.trees` reads trees;
  `maviper.compilation.compile` compiles and proves; training needs the extra `maviper[train]`.
Does not: know how trees are grown or algorithms learn; read, emit or compare anything itself.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, cast

import click

from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.cli.options import PATH, PROFILE, SETTING, FolderPath, Verb, names, option, options_of, output
from maviper.options import CompileOptions, ExtractOptions, ImportOptions, TrainOptions
from maviper.options.extraction import SETTINGS
from maviper.options.table import table_of
from maviper.options.verbs import IMPORTED, TARGETS, WRITTEN

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from maviper.console import Console


CONTRACTS = "contracts"  # a target beside those of code
SAID_OTHERWISE = (CONTRACTS, "solver_units")  # by the target, and by --effort
CODE_OPTIONS = tuple(name for name in table_of(CompileOptions) if name not in SAID_OTHERWISE)


@click.command(
    cls=Verb,
    settings=SETTINGS,
    example="maviper extract physical-deception -o small.json --max-episodes 500\n"
    "maviper extract physical-deception -o run --max-depth 5 --seeds 4",
)
@click.argument("expert")
@options_of(ExtractOptions)
@SETTING
@output("The profile's JSON file, or a run folder.", FolderPath(".json"))
def extract(console: "Console", expert: str, output: Path, **options: Unpack[ExtractOptions]) -> int:
    """Extract decision trees from an expert.

    EXPERT is the name of a world, an expert file, a run folder, sb3:FILE.zip of stable-baselines3 (maviper guide own),
    or module:function for your own expert. The name of a world stands for its shipped expert. A world without one uses
    its scripted expert (cooperative-navigation,agents=12).

    -o is a JSON file for the profile, or a folder for the whole run: config, metrics, finished steps and profile. In a
    folder, --resume continues an interrupted run and ends with the same profile.

    With --counterexamples, every round also learns from states in which a team violated a claim. The label of such a
    state is what the expert does there, changed for as few agents as the claim needs. The command then reports how
    often the claim fails before and after, which actions changed, and what the change costs in play. It also writes
    these figures to refit.json.
    """
    console.line("extracting", expert)
    from maviper.extraction.run import extract_named, request
    from maviper.files.runs import PROFILE_FILE

    # the command line that asks for the same, without what only says how it runs on
    context = click.get_current_context()
    said = [
        f"--set {name}={value}" if name in SETTINGS else f"--{name.replace('_', '-')} {value}"
        for name, values in sorted(options.items())
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
        for value in (cast("tuple[object, ...]", values) if isinstance(values, tuple) else (values,))
        if name != "resume"
    ]
    asked = request(options, " ".join(["maviper extract", expert, *said]))
    profile = extract_named(expert, output, asked, console)
    file = output if output.suffix == ".json" else output / PROFILE_FILE
    console.line("next", f"maviper verify {file} -o report")
    console.give({"wrote": str(file), **_describe(profile), "evaluation": dict(profile.provenance.evaluation)})
    return ExitCode.DONE


def _describe(profile: "PolicyProfile") -> dict[str, Any]:
    """The id of a profile, and how large the trees are."""
    from codegen import ir
    from codegen.policy_json import content_hash

    sizes = {policy.agent: len(ir.leaves(policy.tree)) for policy in profile.agents}
    return {"id": content_hash(profile), "leaves": sizes}


@click.command(cls=Verb, example="maviper train predator-prey,prey=1 --seeds 4 --jobs 2 -o run")
@click.argument("world")
@options_of(TrainOptions)
@output("The run folder.")
def train(console: "Console", world: str, output: Path, **options: Unpack[TrainOptions]) -> int:
    """Train an expert for WORLD into a run folder.

    Training needs the extra maviper[train]. WORLD is a game, with options after commas (predator-prey,prey=1), or
    module:function for your own environment.

    The folder always holds the best checkpoint so far. --resume continues an interrupted run and ends with the same
    expert.
    """
    from maviper.experts.cards import how_learned
    from maviper.experts.training.train import EXPERT_FILE, train_expert

    card = train_expert(world, output, console, **options)
    for label, value in card["measured"].items():
        if isinstance(value, list):
            console.line("measured", f"{label}: {value[0]:.3f} [{value[1]:.3f}, {value[2]:.3f}]")
    played = ", ".join(f"{steps:,} steps for the {what}" for what, steps in card["played"].items())
    console.line("played", f"{played}; the expert is the checkpoint after {card['steps']:,}; {card['seconds']:.0f} s")
    console.line("learned", f"by {how_learned(card)}; the critic's reward is {card['critic_reward']}")
    if "stopped" in card:
        console.line("stopped", f"{card['stopped']}; the last good checkpoints were kept")
    console.line("wrote", str(output / EXPERT_FILE))
    console.give({"wrote": str(output / EXPERT_FILE), **card})
    return ExitCode.VIOLATED if "stopped" in card else ExitCode.DONE


def _agents(_context: click.Context, parameter: click.Parameter, value: str | None) -> dict[str, Path] | None:
    """Reads agent=file,agent=file."""
    if value is None:
        return None
    pairs = [part.strip().partition("=") for part in value.split(",")]
    if any(not agent.strip() or not file for agent, _, file in pairs):
        raise click.BadParameter("give agent=file, with commas in between", param=parameter)
    files = {agent.strip(): Path(file) for agent, _, file in pairs}
    if len(files) < len(pairs):
        raise click.BadParameter("an agent appears twice", param=parameter)
    return files


@click.command("import", cls=Verb, example="maviper import policy.py -o profile.json")
@click.argument("file", type=PATH, required=False)
@option(
    "--agents",
    default=None,
    metavar="NAME=FILE,...",
    callback=_agents,
    section=IMPORTED,
    help="A team: one file for each agent, instead of FILE.",
)
@options_of(ImportOptions)
@output("The profile's file, a .json.", PATH)
def import_verb(
    console: "Console",
    file: Path | None,
    agents: dict[str, Path] | None,
    output: Path,
    **options: Unpack[ImportOptions],
) -> int:
    """Import decision trees of other programs: exact, or refused.

    FILE is if/else Python or C (one function per agent), an ONNX model, a tree or a small sum of trees of XGBoost
    (JSON) or LightGBM (text), a tree of treelite (JSON) or dtControl (JSON), or a C header of `maviper compile`. Its
    kind is detected. The only code that is run is if/else Python, behind a gate, and compiled C, each in a process of
    its own, to compare its answers with the tree; `--no-run` runs neither.

    The profile decides as FILE does for every observation of the numbers that it observes, floats or whole ones. It is
    written only after a comparison: both must decide the same at every threshold, at its neighbours, at random
    observations, and for Python at every number of the source. A file that is not understood in full is refused.
    `maviper guide importing` says what can come in.
    """
    console.line("importing", "" if file is None else str(file))
    from codegen import policy_json
    from maviper.files import runs
    from maviper.importing.trees import import_trees

    runs.target(runs.ensure_other(output, [*(agents or {}).values(), *([] if file is None else [file])]))
    profile = import_trees(file, agents, **options)
    for policy in profile.agents:
        _say(policy, profile.provenance.training, console)
    runs.write(output, policy_json.dumps(profile))
    console.line("wrote", str(output))
    console.give({"wrote": str(output), **_describe(profile), "facts": dict(profile.provenance.training)})
    return ExitCode.DONE


def _say(policy: Any, facts: Mapping[str, Any], console: Any) -> None:
    """What an agent's tree is, and what it was compared with."""
    from codegen.deciding import kind_decided, list_decided

    leaves = int((policy.tree.feature < 0).sum())
    size = ", ".join(
        [
            format_count(leaves, "leaf"),
            format_count(len(policy.features) - len(policy.memory), "feature"),
            format_count(len(list_decided(policy)), kind_decided(policy).removesuffix("s")),
            policy.whole or policy.numbers,
            *([f"sums {facts[sums]}"] if (sums := f"{policy.agent} sums") in facts else []),
        ]
    )
    console.line(policy.agent, f"{facts[f'{policy.agent} from']}: {size}")
    count, by = facts[f"{policy.agent} replayed"], facts[f"{policy.agent} replayed by"]
    if count:
        console.line("replayed", f"{format_count(count, 'observation')}, by {by}: no difference")
    else:
        console.line("compared", f"none, {by}")
    for kind in ("features", kind_decided(policy)):
        console.line(kind, str(facts[f"{policy.agent} {kind}"]))
    if policy.memory:
        spelled = (f"{each.name} {each.low:g} to {each.high:g}, {each.initial} first" for each in policy.memory)
        console.line("remembers", "; ".join(spelled))
    if f"{policy.agent} notes" in facts:
        console.line("notes", str(facts[f"{policy.agent} notes"]))
    if policy.seen:
        from codegen.importers.names import format_first

        ends = zip(policy.features, policy.seen, strict=True)
        console.line("seen", format_first([f"{one.name} {low:.3g} to {high:.3g}" for one, (low, *_, high) in ends]))
    if f"{policy.agent} permits" in facts:
        console.line("permits", str(facts[f"{policy.agent} permits"]))
    console.line("given", str(facts[f"{policy.agent} given"]))
    console.line("NaN", str(facts[f"{policy.agent} NaN"]))


@click.command(cls=Verb, example="maviper edit demo/profile.json agent_0/3=0.3 -o edited.json")
@PROFILE
@click.argument("changes", nargs=-1, required=True, metavar="AGENT/NODE=NUMBER...")
@option("-o", "--output", type=PATH, default=None, help="The file (default: PROFILE itself).")
def edit(console: "Console", profile: Path, changes: tuple[str, ...], output: Path | None) -> int:
    """Change thresholds in PROFILE.

    The tree compares with the largest number of its type that is not above NUMBER. The file records each change, and
    drops what was measured before. `maviper show` names agents and nodes.
    """
    from codegen import policy_json
    from maviper.files import runs
    from maviper.files.profiles import load
    from maviper.importing.edits import change_threshold, parse_change

    file, edited = runs.target(output or profile), load(profile, sums=True)
    for text in changes:
        agent, node, value = parse_change(text, edited)
        edited = change_threshold(edited, agent, node, value)
    written = runs.write(file, policy_json.dumps(edited))
    console.line("wrote", f"{written}  id {policy_json.content_hash(edited)[:16]}")
    console.give({"wrote": str(written), **_describe(edited)})
    return ExitCode.DONE


@click.command("compile", cls=Verb, example="maviper compile demo/profile.json -o code")
@PROFILE
@option(
    "--target",
    "targets",
    default=",".join(TARGETS),
    show_default=True,
    metavar="NAMES",
    callback=names,
    section=WRITTEN,
    help="Any of c, shared, contracts, python, json, javascript, rust, smt, svg, st, onnx, onnx-old, jax, torch, "
    "monitor.",
)
@options_of(CompileOptions, *CODE_OPTIONS)
@output("The folder for the code.")
def compile_verb(
    console: "Console", profile: Path, targets: tuple[str, ...], output: Path, **options: Unpack[CompileOptions]
) -> int:
    """Compile trees to code that decides the same.

    The code is written only after a replay: the code, PROFILE and the tree as learned must decide the same on every
    observation compared.

    With --prove, Z3 searches for an observation on which the text of ..._act and the tree decide differently. It covers
    all float32 numbers for C and all doubles for Python. Queries (SMT-LIB) and answers are written next to the code.

    The target contracts also writes the trees as contracts in ACSL. --frama-c has Frama-C prove that the C keeps
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
    console.line("compiling", str(profile))
    from codegen.policy_json import content_hash
    from maviper.cli.results import say_agreement, say_contracts, say_proofs
    from maviper.compilation.compile import compile_and_prove
    from maviper.files import outputs, runs
    from maviper.files.profiles import load

    loaded = load(profile, sums=True)
    if CONTRACTS in targets:
        targets, options = tuple(each for each in targets if each != CONTRACTS), {**options, "contracts": True}
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
    told = {"observations": code.report.observations, "differ": 0, "skipped": list(code.report.skipped)}
    proofs = [str(proof) for proof in code.proofs.proofs] if code.proofs else []
    contracts = str(code.proven) if code.proven else ""
    wrote = [str(output / name) for name in code.files]
    console.give({"wrote": wrote, **told, "proofs": proofs, "contracts": contracts, "complete": code.complete})
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
