"""Names of generated code: public names, local names, labels of actions; legal in every language, and different.

Does: makes the names of a profile and of its agents; refuses words that a language keeps; writes the labels that an
  imported source returns as literals of each language.
Assumes: identifiers and labels that check.py accepts.
Does not: write code.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from keyword import iskeyword

from codegen.errors import InputError
from codegen.floats import short_hex
from codegen.numbers import decimal_literal

FUNCTIONS = ("act", "finite", "in_range", "act_rows", "act_columns", "observe", "act_world", "state", "init", "step")
TABLES = ("threshold", "feature", "child", "action")
# what Python and JavaScript name after an agent, and for all
MODULE_NAMES = (
    *("act_{}", "act_{}_batch", "act_{}_rows", "observe_{}", "act_world_{}", "finite_{}", "in_range_{}"),
    *("Action_{}", "Machine_{}"),
)
TEAM_FUNCTIONS = ("act_team", "act_all", "in_region")
ARITHMETIC = ("bits", "direct", "sum", "wide_sum", "single", "wide_single", "double_constants")
OF_SUMS = ("kept", "single_kept", "at_least", "at_most", "single_at_least", "single_at_most")
# what no module of Rust is called: its keywords, those it reserves, and the type that the module above uses
RUST = frozenset(
    """
    abstract as async await become box break const continue crate do dyn else enum extern false final fn for gen if impl
    in let loop macro match mod move mut override priv pub ref return self static str struct super trait true try type
    typeof unsafe unsized use virtual where while yield
    """.split()  # noqa: SIM905
)
# what no member of C, C++ or JavaScript is called, beside these, and what machines in generated code have themselves
MEMBERS = frozenset(
    """
    auto bool case catch char class constructor default delete double export float goto int long namespace new operator
    private protected public register reset short signed step switch template this throw union unsigned using var void
    volatile
    """.split()  # noqa: SIM905
)
# files and names that the generated text itself uses, and what standard headers define
USED = frozenset(
    """
    array dbl enum f32 float flt i32 int32 jax ldbl math numpy std stdint stdio string struct sys torch typing u32 u8
    uint32 usize vec
    """.split()  # noqa: SIM905
)


@dataclass(frozen=True)
class AgentNames:
    """The C names of one agent; `features`, `actions` and `outputs` in the agent's order."""

    act: str
    finite: str
    in_range: str
    act_rows: str
    act_columns: str
    observe: str
    act_world: str
    state: str  # of an agent that remembers
    init: str
    step: str
    tables: Mapping[str, str]
    force: str
    label: str
    features: tuple[str, ...]
    actions: tuple[str, ...]
    n_features: str
    n_actions: str
    exported_rows: str  # of the shared library, by which the header is replayed, too; the others of the latter alone
    exported_batch: str
    exported_observe: str
    exported_steps: str
    module: str  # of Rust
    outputs: tuple[str, ...]
    n_outputs: str


@dataclass(frozen=True)
class Names:
    """The C names of the whole profile. `coordinates`: world coordinate in upper case -> constant."""

    act_team: str
    act_all: str
    in_region: str
    bits: str
    direct: str
    sum: str
    wide_sum: str
    single: str
    wide_single: str
    double_constants: str
    kept: str
    single_kept: str
    at_least: str
    at_most: str
    single_at_least: str
    single_at_most: str
    coordinates: Mapping[str, str]
    n_coordinates: str
    profile: str
    dt: str
    damping: str
    guard: str
    table: str  # the storage of tables
    shared_tables: str
    own_tables: str
    exported_team: str = "team_rows"
    exported_all: str = "all_rows"
    exported_region: str = "in_region_rows"
    exported_constants: str = "all_constants"


def of_agent(
    prefix: str, agent: str, features: Iterable[str], actions: Iterable[str], outputs: Iterable[str]
) -> AgentNames:
    """The names of an agent; `agent` in lower case, `features`, `actions` and `outputs` in upper case."""
    own = f"{prefix}_{agent}"
    functions = {name: f"{own}_{name}" for name in FUNCTIONS}
    upper = own.upper()
    return AgentNames(
        **functions,
        tables={name: f"{own}_{name}" for name in TABLES},
        force=f"{upper}_FORCE",
        label=f"{own}_label",
        features=tuple(f"{upper}_X_{feature}" for feature in features),
        actions=tuple(f"{upper}_{action}" for action in actions),
        n_features=f"{upper}_N_FEATURES",
        n_actions=f"{upper}_N_ACTIONS",
        exported_rows=f"{own}_decide",
        exported_batch=f"{agent}_batch",
        exported_observe=f"{agent}_observe",
        exported_steps=f"{agent}_steps",
        module=f"{agent}_" if agent in RUST else agent,
        outputs=tuple(f"{upper}_Y_{output}" for output in outputs),
        n_outputs=f"{upper}_N_OUTPUTS",
    )


def of_profile(prefix: str, digest: str, coordinates: Iterable[str]) -> Names:
    """The names of a profile with the content hash `digest`; `coordinates` in upper case."""
    functions = {name: f"{prefix}_{name}" for name in (*TEAM_FUNCTIONS, *ARITHMETIC, *OF_SUMS)}
    upper = prefix.upper()
    return Names(
        **functions,
        coordinates={name: f"{upper}_W_{name}" for name in coordinates},
        n_coordinates=f"{upper}_N_COORDINATES",
        profile=f"{upper}_PROFILE",
        dt=f"{upper}_DT",
        damping=f"{upper}_DAMPING",
        guard=f"{upper}_{digest[:16].upper()}_H",
        table=f"{upper}_TABLE",
        shared_tables=f"{upper}_SHARED_TABLES",
        own_tables=f"{upper}_OWN_TABLES",
    )


def of_modules(agents: Iterable[str]) -> list[str]:
    """Lists the names that Python and JavaScript give to agents' code; agents are given in lower case."""
    return [name.format(agent) for agent in agents for name in MODULE_NAMES]


def is_reserved(prefix: str) -> bool:
    """Returns True if a word cannot begin names and be the files' name: of Rust or Python, or one that the text has."""
    return prefix in RUST or prefix in USED or iskeyword(prefix)


def name_member(name: str) -> str:
    """The name of a member of a machine's state."""
    return f"{name}_" if name in MEMBERS or is_reserved(name) else name


def ensure_distinct(names: Names, agents: Mapping[str, AgentNames]) -> None:
    """Names that are legal one by one may meet once they are joined: InputError then. `agents`: by lower-case name."""
    in_c = [*_iterate_names(names), *(name for each in agents.values() for name in _iterate_names(each))]
    in_modules = [*of_modules(agents), *TEAM_FUNCTIONS]
    in_rust = [each.module for each in agents.values()]
    for group in (in_c, in_modules, in_rust):
        twice = sorted(name for name, count in Counter(group).items() if count > 1)
        if twice:
            what = f"two names of the profile become the same name in code: {twice[0]}"
            raise InputError(what, "", "rename one of them")


def _iterate_names(names: Names | AgentNames) -> Iterator[str]:
    for kind, value in vars(names).items():
        if kind == "module":
            continue  # of another language
        if isinstance(value, str):
            yield value
        else:
            yield from value.values() if isinstance(value, Mapping) else value


INT, LONG = 2**31, 2**53  # below which C's int, and every program's 64-bit numbers, hold whole numbers
PLAIN = {*map(chr, range(0x20, 0x7F))} - {*'"\\?*/'}
Label = int | float | str


@dataclass(frozen=True)
class Labels:
    """The labels that the imported source returns for each action, as languages write them, and the types of these."""

    c: tuple[str, ...]
    c_type: str
    python: tuple[str, ...]
    javascript: tuple[str, ...]
    rust: tuple[str, ...]
    rust_type: str
    json: str


def labels_of(given: Sequence[Label | None]) -> Labels | None:
    """The labels of an agent's actions; None where it has none."""
    labels = [each for each in given if each is not None]
    if not labels:
        return None
    texts, numbers = [each for each in labels if isinstance(each, str)], [e for e in labels if not isinstance(e, str)]
    if texts:

        def quote(escape: Callable[[str], str]) -> tuple[str, ...]:
            return tuple(f'"{"".join(x if x in PLAIN else escape(x) for x in text)}"' for text in texts)

        c = quote(lambda letter: "".join(f"\\{byte:03o}" for byte in letter.encode()))
        python = quote(lambda letter: f"\\U{ord(letter):08x}")
        other = quote(lambda letter: f"\\u{{{ord(letter):x}}}")
        return Labels(c, "char *const", python, other, other, "&str", json.dumps(texts))
    if all(isinstance(each, int) and abs(each) <= LONG for each in numbers):
        plain = tuple(map(str, numbers))
        kind = "int" if all(abs(each) < INT for each in numbers) else "long long"
        return Labels(plain, kind, plain, plain, plain, "i64", json.dumps(numbers))
    doubles = [float(each) for each in numbers]
    written, decimal = tuple(map(short_hex, doubles)), tuple(map(decimal_literal, doubles))
    return Labels(written, "double", decimal, decimal, decimal, "f64", json.dumps(doubles))
