"""Names in generated code: the one list that templates take them from, and that no two of them meet.

Does: joins prefix, agent, feature and action to the names of C, and of the functions of Python and JavaScript; keeps
  the words of Rust, and what a file cannot be called, out of names.
Assumes: parts that are legal names.
Does not: make a name legal (check.py) or write code.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from keyword import iskeyword

from codegen.errors import InputError

FUNCTIONS = ("act", "finite", "in_range", "act_rows", "act_columns", "observe", "act_world")
# what Python and JavaScript name after an agent, and for all
MODULE_NAMES = (
    "act_{}",
    "act_{}_batch",
    "act_{}_rows",
    "observe_{}",
    "act_world_{}",
    "finite_{}",
    "in_range_{}",
    "Action_{}",
)
MODULE_TEAM_NAMES = ("act_team", "act_all", "in_region")
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
# files and names that the generated text itself uses, and what standard headers define
USED = frozenset(
    """
    array dbl enum f32 float flt i32 int32 jax ldbl math numpy std stdint stdio string struct sys torch typing u32 u8
    uint32 usize vec
    """.split()  # noqa: SIM905
)


@dataclass(frozen=True)
class AgentNames:
    """The C names of one agent; `features` and `actions` in the agent's order."""

    act: str
    finite: str
    in_range: str
    act_rows: str
    act_columns: str
    observe: str
    act_world: str
    force: str
    label: str
    features: tuple[str, ...]
    actions: tuple[str, ...]
    n_features: str
    n_actions: str
    exported_rows: str  # of the library that replays the header
    exported_batch: str
    exported_observe: str
    module: str  # of Rust
    outputs: tuple[str, ...] = ()  # in the agent's order
    n_outputs: str = ""


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
    exported_team: str = "team_rows"
    exported_all: str = "all_rows"
    exported_region: str = "in_region_rows"
    exported_constants: str = "all_constants"


def of_agent(
    prefix: str, agent: str, features: Iterable[str], actions: Iterable[str], outputs: Iterable[str] = ()
) -> AgentNames:
    """The names of an agent; `agent` in lower case, `features`, `actions` and `outputs` in upper case."""
    own = f"{prefix}_{agent}"
    functions = {name: f"{own}_{name}" for name in FUNCTIONS}
    upper = own.upper()
    return AgentNames(
        **functions,
        force=f"{upper}_FORCE",
        label=f"{own}_label",
        features=tuple(f"{upper}_X_{feature}" for feature in features),
        actions=tuple(f"{upper}_{action}" for action in actions),
        n_features=f"{upper}_N_FEATURES",
        n_actions=f"{upper}_N_ACTIONS",
        exported_rows=f"{agent}_rows",
        exported_batch=f"{agent}_batch",
        exported_observe=f"{agent}_observe",
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
    )


def of_modules(agents: Iterable[str]) -> list[str]:
    """Lists the names that Python and JavaScript give to agents' code; agents are given in lower case."""
    return [name.format(agent) for agent in agents for name in MODULE_NAMES]


def is_reserved(prefix: str) -> bool:
    """Returns True if a word cannot begin names and be the files' name: of Rust or Python, or one that the text has."""
    return prefix in RUST or prefix in USED or iskeyword(prefix)


def ensure_distinct(names: Names, agents: Mapping[str, AgentNames]) -> None:
    """Names that are legal one by one may meet once they are joined: InputError then. `agents`: by lower-case name."""
    in_c = [*_iterate_names(names), *(name for each in agents.values() for name in _iterate_names(each))]
    in_modules = [*of_modules(agents), *MODULE_TEAM_NAMES]
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
