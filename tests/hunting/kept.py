"""Certificates about the hunt's questions, kept in a folder: what was accepted and refused yesterday is so today.

    python -m tests.hunting.kept FOLDER --write [--each 40]     proves questions, and keeps their certificates
    python -m tests.hunting.kept FOLDER                         reads and checks them again; 1 where a word differs

Does: proves the hunt's questions of four kinds; keeps each certificate as bytes, what the checker says of it, and what
  it says of changed ones; asks all of that again, and whether the same bytes are written.
Assumes: that a seed gives the same question.
Does not: judge whether a claim holds (asking.py, episodes.py, systems.py).
"""

import argparse
import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import MaviperError
from tests.hunting import episodes, forging, questions, systems
from tests.support.altered import read_game
from verify.certificates.games import to_json as game_text
from verify.certificates.systems import to_json as system_text
from verify.checker import decisions as decision_certificates
from verify.checker.accept import accept
from verify.checker.episodes import certificates as episode_certificates
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.checker.systems.proofs import from_json as read_system
from verify.systems.observing import as_played
from verify.verdicts.opinions import by_zones

CHANGES = 6  # of each certificate
STRANGE = ("1/3", "", "1/0", ["x"], [], {}, {"x": "1"}, None, True, -1, 10**30, 0.5)
Case = tuple[Callable[[], Any], Callable[[Any], int]]  # what proves a question; what checks a certificate of it


def decisions(seed: int) -> Case:
    """A question about single decisions."""
    question = questions.drawn(seed).question
    return (
        lambda: by_zones(question).certificate,
        lambda read: decision_certificates.check_certificate(read, question.origin),
    )


def games(seed: int) -> Case:
    """A question about the episodes of a game, every other one with contacts."""
    asked = episodes.drawn(seed, episodes.PUSHING) if seed % 2 else episodes.drawn(seed)
    question = asked.question
    return (
        lambda: episodes.few_samples(question).evidence.certificate,
        lambda read: episode_certificates.check_certificate(read, question.profile),
    )


def stated(seed: int) -> Case:
    """A question about a stated system, two in five of them for ever."""
    rng = np.random.default_rng([seed, 33])
    case = systems.drawn(rng)
    claim = systems.for_ever(rng, case) if rng.random() < 0.4 else case.claim

    def check(read: Any) -> int:
        if case.statement is None:
            return accept(read, case.profile, case.system)
        statement, profile = as_played(case.statement, case.profile)
        ensure_enclosed(statement, lambda done, most: None)
        return accept(read, profile, statement.system)

    return lambda: systems.answered(case, claim).evidence.certificate, check


KINDS: dict[str, tuple[Callable[[int], Case], Callable[[Any], str], Callable[[str], Any]]] = {
    "decisions": (decisions, game_text, read_game),
    "games": (games, game_text, read_game),
    "stated": (stated, system_text, read_system),
}


def members(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of each member of a document."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        if key != "content_hash":
            yield (*path, key)
            yield from members(item, (*path, key))


def changed(text: str, rng: np.random.Generator) -> str:
    """A certificate with a member that is another one or is missing, or with other bytes of proof, and its hash."""
    document = copy.deepcopy(json.loads(text))
    if "proofs" in document and "edges" not in document and rng.random() < 0.5:
        return forging.forged(text, rng)[2]
    paths = list(members(document))
    *path, last = paths[int(rng.integers(len(paths)))]
    here = document
    for key in path:
        here = here[key]
    strange = STRANGE[int(rng.integers(len(STRANGE)))]
    if rng.random() < 0.2:
        del here[last]
    else:
        here[last] = strange
    return forging.sealed(document)


def word(kind: str, text: str, check: Callable[[Any], int]) -> str:
    """What the checker says of a text."""
    _, to_json, from_json = KINDS[kind]
    try:
        read = from_json(text)
        closed = check(read)
    except MaviperError as error:
        return f"{type(error).__name__}: {error}"
    except RejectedError as error:
        return f"refused: {error}"
    return f"accepted: {closed}{'' if to_json(read) == text else ', written otherwise'}"


def words(kind: str, seed: int, text: str) -> list[str]:
    """What the checker says of a certificate, and of changed ones."""
    check, rng = KINDS[kind][0](seed)[1], np.random.default_rng([seed, 52])
    return [word(kind, each, check) for each in (text, *(changed(text, rng) for _ in range(CHANGES)))]


def write(folder: Path, each: int) -> None:
    """Proves questions until there are `each` certificates of each kind."""
    for kind, (case, to_json, _) in KINDS.items():
        seed, left = -1, each - len(list(folder.glob(f"{kind}-*.json")))
        while left > 0:
            seed += 1
            file = folder / f"{kind}-{seed}.json"
            try:
                certificate = None if file.exists() else case(seed)[0]()
            except MaviperError:  # a question that is none
                continue
            if certificate is None or len(text := to_json(certificate)) > 1 << 17:
                continue
            file.write_text(text)
            file.with_suffix(".said").write_text(json.dumps(words(kind, seed, text), indent=1))
            left -= 1


def differing(folder: Path, again: bool) -> Iterator[str]:
    """Where a word differs from the one that was kept; `again`: or the bytes of a certificate that is made again."""
    for file in sorted(folder.glob("*.json")):
        kind, _, seed = file.stem.partition("-")
        text, said = file.read_text(), json.loads(file.with_suffix(".said").read_text())
        for number, (before, now) in enumerate(zip(said, words(kind, int(seed), text), strict=True)):
            if before != now:
                yield f"{file.stem}, change {number}:\n  {before}\n  {now}"
        if again and KINDS[kind][1](KINDS[kind][0](int(seed))[0]()) != text:
            yield f"{file.stem} is written otherwise"


def main() -> int:
    """The command; 1 where a word differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true", help="prove questions, and keep their certificates")
    parser.add_argument("--each", type=int, default=70, help="certificates of each kind")
    parser.add_argument("--again", action="store_true", help="prove all questions again, for the same bytes")
    given = parser.parse_args()
    if given.write:
        write(given.folder, given.each)
    found = 0
    for line in differing(given.folder, given.again):
        found += 1
        print(line)
    kept = [json.loads(file.read_text())[0] for file in given.folder.glob("*.said")]
    accepted = sum(said.startswith("accepted") for said in kept)
    print(f"{len(kept)} certificates, {accepted} accepted; {found} words differ")
    return int(bool(found))


if __name__ == "__main__":
    raise SystemExit(main())
