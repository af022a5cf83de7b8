"""The files of one run in an output folder, without those that an earlier run of the same verb left there.

Does: puts the files of a run in the place of those that an earlier run of the verb left there, all or none; refuses to
  write over a profile, a world file or any other file of a common name that no earlier run wrote.
Assumes: each verb writes names of its own form, and one file (its mark) in every run.
Does not: touch folders without the mark, other names, folders inside, or files that are asked to be kept.
"""

import contextlib
import json
import os
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from codegen.errors import InputError
from maviper.files import runs

NUMBERED = r"(certificate|counterexample|zones|states)-\d+-[\w-]+\.json|test_counterexample_\d+_\w+\.py|play\.html"
RECORD = ".maviper.json"  # files of common names that runs wrote: mark of the verb -> name -> SHA-256
MAX_RECORD_BYTES = 2**16
FOUND = "# Found by maviper verify --where:"  # what the file of a region found begins with


@dataclass(frozen=True)
class Verb:
    """The names that a verb writes, and how its mark begins."""

    mark: str
    begins: str  # a pattern, within the first bytes of the mark
    names: str  # a pattern
    code: bool = False  # generated code, which is made again over what is there


VERIFY = Verb("report.json", r'"report": "maviper-', rf"{NUMBERED}|region-\d+-[\w-]+\.toml|report\.(html|txt)")
REPAIR = Verb("repair.json", r'"command": "maviper repair ', rf"{NUMBERED}|report\.(html|txt|json)")
DIFF = Verb("difference.json", r'"difference": "maviper-', r"certificate\.json|play\.html")
ROBUST = Verb("radii.csv", r"row,action,leaf,radius,", r"certificate-\d+-robust\.json")
NOTHING = r"(?!)"  # a pattern of no name
CHANGES = Verb("changes.csv", r"row,output,value,", NOTHING)  # of `robust` for outputs
QUESTION, QUESTION_BEGINS = r"\d\d-\w+-[\w-]+\.smt2", r"\A; Profile [0-9a-f]{64}\n; Claim   "


def write_set(folder: Path, files: Mapping[str, str | bytes], verb: Verb, keep: Collection[Path] = ()) -> None:
    """Writes a run's files, name -> content, all or none, and removes what an earlier run of the verb left there.

    `keep`: files that this run was given, which stay whatever their names: InputError where one would be written over
    by another content, and as `runs.write` and `ensure_own`.
    """
    ensure_own(folder, files, verb)
    _ensure_spared(folder, files, keep)
    kept, written, stale = {path.resolve() for path in keep}, _read_record(folder, verb.mark), list[Path]()
    common = {name for name in files if not verb.code and not is_named(name, verb)}
    recorded = {name: _digest(files[name]) for name in common if name in written or not (folder / name).exists()}
    if _holds_pattern(folder / verb.mark, verb.begins):
        named = [path for path in folder.iterdir() if is_named(path.name, verb) or path.name in written.keys() - common]
        stale = [path for path in named if path.resolve() not in kept]
    recorded |= {name: digest for name, digest in written.items() if folder / name not in stale and name not in files}
    others = {one.mark: _read_record(folder, one.mark) for one in (VERIFY, REPAIR, DIFF) if one is not verb}
    all_ = {mark: digests for mark, digests in {**others, verb.mark: recorded}.items() if digests}
    record = {RECORD: runs.as_json(all_)} if all_ else {}
    if files or stale:
        _write(folder, {**files, **record}, [*stale, *([] if record else [folder / RECORD])])


def ensure_free(
    folder: Path, verb: Verb, known: Mapping[str, str | bytes], given: Iterable[Path], written: str | None = None
) -> None:
    """InputError, before the work, where a run of the verb would write over a file that it is given, or over one that
    no earlier run wrote.

    `known`: what the run will write and is known already, name -> content: a file that it leaves as it is may be given.
    `written`: a pattern of the other names that this run may write, beside its mark (default: the verb's).
    """
    _ensure_spared(folder, known, given)
    names = rf"{re.escape(verb.mark)}|{verb.names if written is None else written}"
    for path in given:
        if path.resolve().parent == folder.resolve() and path.name not in known and re.fullmatch(names, path.name):
            raise _overwritten(path)
    ensure_own(folder, known, verb)
    mark = folder / verb.mark
    if not verb.code and mark.exists() and not _holds_pattern(mark, verb.begins):
        raise _foreign(mark)


def ensure_own(folder: Path, files: Mapping[str, str | bytes], verb: Verb) -> None:
    """InputError where a file would be written over another that no earlier run wrote, or that was changed since."""
    if verb.code:
        return
    written = _read_record(folder, verb.mark)
    for name, content in files.items():
        path, of_form = folder / name, is_named(name, verb)
        foreign = (name == verb.mark and not _holds_pattern(path, verb.begins)) or not (of_form or name in written)
        if foreign and path.exists() and _digest_of(path) != _digest(content):
            raise _foreign(path)


def _ensure_spared(folder: Path, files: Mapping[str, str | bytes], given: Iterable[Path]) -> None:
    """InputError where a file that a run was given would be written over by another content."""
    known = {path.resolve(): path for path in given}
    for name, content in files.items():
        path = known.get((folder / name).resolve())
        if path is not None and path.exists() and _digest_of(path) != _digest(content):
            raise _overwritten(path)


def without_given(folder: Path, files: Mapping[str, str | bytes], given: Mapping[str, Path]) -> dict[str, str | bytes]:
    """The files without those that are in the folder already, since the run was given them from there.

    `given`: name -> the file that the run read, whose content this is.
    """
    there = {name for name, path in given.items() if _is_there(folder / name, path)}
    return {name: content for name, content in files.items() if name not in there}


def list_elsewhere(folder: Path, given: Mapping[str, Path]) -> list[Path]:
    """The files given, as for `without_given`, that are not in the folder under that name."""
    return [path for name, path in given.items() if not _is_there(folder / name, path)]


def _is_there(place: Path, path: Path) -> bool:
    return place.resolve() == path.resolve()


def is_named(name: str, verb: Verb) -> bool:
    """Returns True if a file of that name is one of the verb's own."""
    return name == verb.mark or re.fullmatch(verb.names, name) is not None


def _digest(content: str | bytes) -> str:
    return sha256(content.encode() if isinstance(content, str) else content).hexdigest()


def _digest_of(path: Path) -> str:
    """The SHA-256 of a file; nothing where it cannot be read."""
    with contextlib.suppress(OSError):
        return _digest(path.read_bytes())
    return ""


def _read_record(folder: Path, mark: str) -> dict[str, str]:
    """Returns the files that runs of a verb wrote into a folder under common names, if unchanged: name -> SHA-256."""
    with contextlib.suppress(OSError, ValueError, KeyError, AttributeError, RecursionError):
        with (folder / RECORD).open("rb") as file:
            listed: dict[str, str] = json.loads(file.read(MAX_RECORD_BYTES))[mark]
        return {name: digest for name, digest in listed.items() if _digest_of(folder / Path(name).name) == digest}
    return {}


def _write(folder: Path, files: Mapping[str, str | bytes], stale: Iterable[Path]) -> None:
    gone = [path.relative_to(folder).as_posix() for path in stale if _removable(path)]
    runs.write_all(folder, files, [name for name in gone if name not in files])


def clear(folder: Path, verb: Verb, given: Iterable[Path]) -> bool:
    """Removes what an earlier run of the verb left, unless a file given is in the folder too; whether it did."""
    if any(path.resolve().parent == folder.resolve() for path in given) or not _holds_pattern(
        folder / verb.mark, verb.begins
    ):
        return False
    write_set(folder, {}, verb)
    return True


def of_code(prefix: str, profile: str) -> Verb:
    """Code of that prefix, where it is of another profile than the one with this hash."""
    own = rf"{re.escape(prefix)}(\.(h|json|mjs|py|rs|smt2|vectors\.txt|proofs\.json)|_(reader|jax|torch)\.py"
    names = rf"{own}|_test\.(c|py|mjs|rs)|_\w+\.(svg|onnx|c\.smt2|python\.smt2))"
    return Verb(f"{prefix}.agreement.json", rf'"profile": "(?!{profile})', names, code=True)


def write_listed(folder: Path, files: Mapping[str, str | bytes], manifest: str) -> None:
    """Writes like `write_set`; removes the files that an earlier run's manifest lists and that are as it wrote them."""
    ensure_listed(folder, files, manifest)
    _write(folder, files, [folder / name for name in _as_listed(folder, manifest) if name not in files])


def ensure_listed(folder: Path, files: Mapping[str, str | bytes], manifest: str) -> None:
    """InputError where a file would be written over another that the manifest of an earlier run does not list, or that
    was changed since.
    """
    listed = _as_listed(folder, manifest)
    for name, content in files.items():
        if (
            name not in [*listed, *([manifest] if listed else [])]
            and (folder / name).exists()
            and _digest_of(folder / name) != _digest(content)
        ):
            raise _foreign(folder / name)


def _as_listed(folder: Path, manifest: str) -> list[str]:
    """The names of the files within a folder that are as its manifest lists them."""
    with contextlib.suppress(OSError, ValueError, KeyError, AttributeError):
        listed: dict[str, str] = json.loads((folder / manifest).read_text(encoding="utf-8"))["sha256"]
        inside = [name for name in listed if folder.resolve() in (folder / name).resolve().parents]
        return [name for name in inside if _digest_of(folder / name) == listed[name]]
    return []


def _overwritten(path: Path) -> InputError:
    """Returns the error for a file that the run was given, and would write over."""
    return InputError("the result would overwrite the file given", str(path), "choose another folder with -o")


def _foreign(path: Path) -> InputError:
    """Returns the error for a file that no earlier run wrote."""
    what = f"the folder holds another {path.name}, which no earlier run wrote there"
    return InputError(what, str(path), "choose another folder with -o, or move the file away")


def write_questions(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Writes questions to other solvers as `write_set` writes files, and removes those of an earlier run."""
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    stale = [each for each in paths if re.fullmatch(QUESTION, each.name) and _holds_pattern(each, QUESTION_BEGINS)]
    _write(folder, files, stale)


def _removable(path: Path) -> bool:
    """Returns True if a file of a name of ours is one: of a region, only where it says that it was found."""
    if os.path.islink(path) or not os.path.isfile(path):  # noqa: PTH114, PTH113 - False, too, for a name that is too long
        return False
    return path.suffix != ".toml" or _holds_pattern(path, re.escape(FOUND))


def _holds_pattern(path: Path, begins: str) -> bool:
    """Returns True if a file is there, and its first bytes hold a pattern."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        return re.search(begins, file.read(4_096).decode(errors="replace")) is not None
    return False
