"""Names of before: commands and options that are others now, read for one release with a word each.

Does: holds them in one table; writes a line of old words in those of today.
Assumes: an option of one line of the table keeps its value; parameters of claims go into the claim.
Does not: read values. An old word that a command still knows is hidden, and read as it is.
"""

import json
from collections.abc import Callable, Sequence
from typing import NamedTuple

from verify.claims.parameters import NAMES, Form, of_form

CLAIM, PROPERTY, DEFAULT = "--claim", "--property", "distinct_targets"
IN_CLAIMS = (*NAMES, "team")
SWITCHES = ("certify",)  # parameters of `robust` that had no value
OF_ROBUST = ("agent", "error", "least", "most", *SWITCHES)


class Old(NamedTuple):
    """A name that was another one: the command ("": the group), the old words, those of today."""

    command: str
    old: str
    new: str


OLD = (
    Old("", "properties list", "verify --list"),
    Old("", "properties new", "verify --new"),
    Old("", "schema", "show --schema"),
    Old("", "exploit", "evaluate SUBJECT --exploit TEAM"),
    Old("", "robust", 'verify PROFILE --claim "robust(observations=FILE)"'),
    Old("verify", "--properties", "--claims"),
    *(Old(command, "--world", "--system") for command in ("verify", "check", "replay")),
    Old("verify", PROPERTY, f'{CLAIM} "NAME"'),
    Old("repair", PROPERTY, f'{CLAIM} "NAME"'),
    *(Old("verify", f"--{each}", f'{CLAIM} "NAME({each}=...)"') for each in IN_CLAIMS),
    *(
        Old("repair", f"--{each}", f'{CLAIM} "own_target({each}=...)"')
        for each in ("team", "margin", "radius", "landmarks")
    ),
    Old("extract", "--budget", "--max-episodes"),
    Old("extract", "--refinement", "--refinement-episodes"),
    Old("show", "--world", "maviper play --world"),
    Old("compile", "--contracts", "--target c,contracts"),
    Old("compile", "--solver-units", "--effort low|normal|high"),
)


def renamed(command: str) -> dict[str, str]:
    """The old options of a command, with the words of today."""
    return {each.old: each.new for each in OLD if each.command == command}


def rewrite_command(words: Sequence[str], tell: Callable[[str, str], None]) -> list[str]:
    """A command line in today's words, and `tell` told of an old command. Its arguments come before its options."""
    words = [*words]
    for _, old, new in (each for each in OLD if not each.command):
        named = old.split()
        if words[: len(named)] != named:
            continue
        tell(old, new)
        rest = words[len(named) :]
        count = next((at for at, word in enumerate(rest) if word.startswith("-")), len(rest))
        if old == "exploit" and count > 1:
            return ["evaluate", rest[0], "--exploit", *rest[1:]]
        if old == "robust" and count > 1:
            given, rest = _take(rest, OF_ROBUST)
            said = "".join(f", {key}={json.dumps(value)}" for key, value in given)
            return ["verify", rest[0], CLAIM, f"robust(observations={json.dumps(rest[1])}{said})", *rest[2:]]
        return [*new.split(), *rest]
    return words


def rewrite_claims(words: Sequence[str], command: str) -> list[str]:
    """A line of verify or repair, old names and parameters of claims written as `--claim`. A parameter goes into the
    claims that read it; into all where none does, so that each says what it has.
    """
    old = renamed(command)
    if PROPERTY not in old:
        return [*words]
    given, rest = _take(words, [each for each in IN_CLAIMS if f"--{each}" in old])
    named, rest = _take(rest, (PROPERTY.removeprefix("--"),))
    if not given and not named:
        return rest
    if not named and not {"--claims", "--properties", "--system", "--world"}.isdisjoint(rest):
        return [*words]  # nothing that they are parameters of
    from verify.claims.catalogue import NAMES as CLAIMS
    from verify.claims.catalogue import readable

    if given and not named:
        named, rest = _take(rest, (CLAIM.removeprefix("--"),))
    claims = [name for _, name in named] or [DEFAULT]
    of = dict(given).get("of", "")
    reads = {name: (*readable(name, of), "team") if name in CLAIMS else IN_CLAIMS for name in claims}
    unread = [key for key, _ in given if not any(key in each for each in reads.values())]
    for name in claims:
        mine = [(key, value) for key, value in given if key in (*reads[name], *unread)]
        said = ", ".join(f"{key}={_spell(key, value)}" for key, value in mine)
        rest += [CLAIM, f"{name}({said})" if mine else name]
    return rest


def _spell(key: str, value: str) -> str:
    """A value of an option as a claim has it."""
    if key in of_form(Form.NAMES):
        return f"[{', '.join(json.dumps(each.strip()) for each in value.split(','))}]"
    return value if value.removeprefix("-").isdigit() else json.dumps(value)


def _take(words: Sequence[str], names: Sequence[str]) -> tuple[list[tuple[str, str]], list[str]]:
    """The options of these names with their values, and what else was written."""
    given, rest, after = list[tuple[str, str]](), list[str](), iter(words)
    for word in after:
        flag, equals, value = word.partition("=")
        name = flag.removeprefix("--")
        if not flag.startswith("--") or name not in names:
            rest.append(word)
        elif name in SWITCHES:
            given.append((name, "true"))
        else:
            given.append((name, value if equals else next(after, "")))
    return given, rest
