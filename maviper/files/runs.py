"""Files that are never half written, and folders of runs that can go on.

Does: writes a file under its final name only when it is complete, several files all or none, from scratch files that
  are locked while their process lives; makes output folders and claims run folders, with errors a user understands;
  holds a run's folder while the run works in it, and refuses a second run.
Assumes: the folder's file system can rename atomically; a lock ends with its process, however that ends. Where nothing
  can be locked, nobody is refused, and what a killed process left stays.
Does not: know what is in the files.
"""

import contextlib
import errno
import itertools
import json
import lzma
import os
import re
import shutil
import tempfile
from collections.abc import Generator, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import msgspec

from codegen.errors import InputError, MaviperError, MissingToolError, escape_text, steers

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

OURS = re.compile(r"\..+\.[0-9]+-[0-9]+\.maviper\.part", re.DOTALL)
_serial = itertools.count()
_swept: set[str] = set()  # folders that this process has looked through


@contextlib.contextmanager
def scratch_file(target: Path) -> Generator[tuple[Path, BinaryIO]]:
    """An empty file beside `target`, open for writing; what is left of it at the end is removed. OSError."""
    place = _name_scratch(target)  # before it is made, so that an interruption at any point knows what to remove
    lock = None
    try:
        while True:
            file = place.open("xb")
            lock = _lock_file(file.fileno())
            if place.exists():  # nobody has swept it away between its making and its lock
                break
            _release_lock(lock)
            file.close()
        with file:
            yield place, file
    finally:
        with contextlib.suppress(OSError):
            place.unlink()
        _release_lock(lock)


@contextlib.contextmanager
def scratch_folder(target: Path) -> Generator[Path]:
    """Makes a folder beside `target`, which is removed at the end; see `scratch_file`."""
    place = _name_scratch(target)
    lock = None
    try:
        while True:
            place.mkdir()
            lock = _lock_path(place)
            if place.exists():
                break
            _release_lock(lock)
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)
        _release_lock(lock)


def _name_scratch(target: Path) -> Path:
    _sweep(target.parent)
    return target.parent / f".{target.name}.{os.getpid()}-{next(_serial)}.maviper.part"


def _sweep(folder: Path) -> None:
    """Removes what killed processes left in a folder; once, since only processes before this one can have."""
    whole = str(folder.absolute())
    if whole in _swept or fcntl is None:
        return
    _swept.add(whole)
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if OURS.fullmatch(entry.name) and not entry.is_symlink():
                _remove_unheld(Path(entry.path), entry.is_dir())


def _remove_unheld(place: Path, folder: bool) -> None:
    """Removes scratch whose process is gone."""
    lock = _lock_path(place)
    if lock is None:
        return
    with contextlib.suppress(OSError):
        shutil.rmtree(place) if folder else place.unlink()
    _release_lock(lock)


def _lock_path(place: Path) -> int | None:
    """A lock on what is there; None where it is another's, or there are no locks."""
    try:
        opened = os.open(place, os.O_RDONLY)
    except OSError:
        return None
    try:
        return _lock_file(opened)
    finally:
        os.close(opened)


def _lock_file(opened: int) -> int | None:
    """A lock on an open file that outlives its closing, until it is released."""
    if fcntl is None:
        return None
    lock = os.dup(opened)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        return None
    return lock


def _release_lock(lock: int | None) -> None:
    if lock is not None:
        os.close(lock)


CONFIG_FILE = "config.json"
MAX_CONFIG_BYTES = 2**20
NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
Form = TypeVar("Form")

PACKED = ".xz"  # how a file ends that holds another one, packed
MAX_UNPACKED_BYTES, PACKED_MEMORY = 2**27, 2**27  # `xz -9` asks for half of that memory
PROFILE_FILE = "profile.json"  # wherever a policy lies among other files


def write(path: Path, content: str | bytes) -> Path:
    """Writes a file atomically: a reader sees the old file or the new one, an interruption leaves the old one."""
    folder(ensure_visible(path).parent)
    try:
        _ensure_no_device(path)
        with scratch_file(path) as (place, file):
            _fill(file, content)
            place.replace(path)
    except OSError as error:
        raise unwritten(path, error) from None
    return path


def _ensure_no_device(path: Path) -> None:
    """InputError for a device or a pipe: run by root, a rename would put a file in the place of /dev/null."""
    if path.exists() and not path.is_file() and not path.is_dir():
        raise InputError(f"cannot write {path.name}", f"{path} is no file, but a device or a pipe", "choose a file")


def _fill(file: BinaryIO, content: str | bytes) -> None:
    file.write(content.encode() if isinstance(content, str) else content)
    file.flush()
    os.fsync(file.fileno())
    file.close()


def create(path: Path, content: str | bytes) -> bool:
    """Writes like `write` where there is no file yet, else returns False: of several that try at once, one succeeds."""
    folder(ensure_visible(path).parent)
    try:
        with scratch_file(path) as (place, file):
            _fill(file, content)
            try:
                path.hardlink_to(place)
            except FileExistsError:
                return False
            except OSError:  # a file system without links
                with path.open("xb") as alone:
                    _fill(alone, content)
    except FileExistsError:
        return False
    except OSError as error:
        raise unwritten(path, error) from None
    return True


def write_all(folder_: Path, files: Mapping[str, str | bytes], gone: Sequence[str] = ()) -> None:
    """Writes several files into a folder: all of them, or none where one cannot be written, and the old ones stay.

    A folder that was not there appears with all its files at once. In one that was there the files change one after
    another once all are written, so that only a process killed within that moment can leave old ones among new ones.
    `gone`: names of files that are removed with that.
    """
    fresh = not os.path.exists(ensure_visible(folder_))  # noqa: PTH110 - False, too, for a name that is too long
    folder(folder_.parent if fresh else folder_)
    path = folder_
    try:
        with scratch_folder(folder_ if fresh else folder_ / "files") as place:
            for name, content in files.items():
                path = folder_ / name
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                with (place / name).open("xb") as file:
                    _fill(file, content)
            if fresh:
                with contextlib.suppress(OSError):  # somebody else made the folder meanwhile
                    place.rename(folder_)
                    return
                folder(folder_)
            for name in files:
                folder((folder_ / name).parent)
            _exchange(place, folder_, list(files), gone)
    except OSError as error:
        raise unwritten(path, error) from None


def _exchange(place: Path, folder_: Path, names: Sequence[str], gone: Sequence[str]) -> None:
    """Moves the files in `place` into the folder; where one cannot be moved, all are as they were. OSError."""
    with scratch_folder(folder_ / "old") as old:
        for name in (*names, *gone):
            (old / name).parent.mkdir(parents=True, exist_ok=True)
            with contextlib.suppress(FileNotFoundError):
                try:
                    (old / name).hardlink_to(folder_ / name)
                except FileNotFoundError:
                    raise
                except OSError:  # a file system without links
                    shutil.copy2(folder_ / name, old / name)
        moved: list[str] = []
        try:
            for name in names:
                moved.append(name)
                (place / name).replace(folder_ / name)
            for name in gone:
                moved.append(name)
                (folder_ / name).unlink(missing_ok=True)
        except BaseException:
            for name in moved:
                if (old / name).exists():
                    (old / name).replace(folder_ / name)
                elif name in names and not (place / name).exists():
                    (folder_ / name).unlink(missing_ok=True)
            raise


def room(path: Path) -> None:
    """Makes sure, before the work, that a folder can be made and written into later; nothing is left of that."""
    with folder_while_filled(path):
        pass


@contextlib.contextmanager
def folder_while_filled(path: Path) -> Generator[None]:
    """Makes an output folder; at the end, folders that were made and hold nothing are taken away again."""
    try:
        missing = [each for each in (ensure_visible(path), *path.parents) if not each.exists()]
    except OSError:  # folder says what is wrong
        missing = []
    folder(path)
    try:
        yield
    finally:
        for each in missing:
            with contextlib.suppress(OSError):
                each.rmdir()


def unwritten(path: Path, error: OSError, other: str = "folder") -> MaviperError:
    """Returns the error for a file that cannot be written: MissingToolError where there is no room for it, else
    InputError that advises another folder, or file.
    """
    what, where = f"cannot write {path.name}", f"{path}: {error.strerror}"
    if error.errno in NO_ROOM:
        return MissingToolError(what, where, "make room, then run the command again")
    return InputError(what, where, f"choose another {other} with -o")


def ensure_visible(path: Path) -> Path:
    """The path, unless it holds what nobody sees, such as the end of a line: errors, reports and commands show it."""
    if steers(str(path)):
        raise InputError("the name of a file holds an invisible character", escape_text(path), "rename it")
    return path


def ensure_other(path: Path, given: Iterable[Path]) -> Path:
    """The path of an output. InputError where it is one of the files that the command was `given`."""
    if any(path.resolve() == each.resolve() for each in given):
        raise InputError("the output would be written over the input", str(path), "choose another file with -o")
    return path


def target(path: Path, usual: str = PROFILE_FILE) -> Path:
    """Makes sure that a file can be written at `path` later: its folder exists and is writable, and it is no folder
    or device.

    `usual`: a name that such a file may have, for the advice.
    """
    try:
        if ensure_visible(path).is_dir():
            raise InputError("the output is a folder, but a file is needed", str(path), f"-o {path / usual}")
        _ensure_no_device(path)
        folder(path.parent)
        with tempfile.TemporaryFile(dir=path.parent):  # some folders, such as /proc, take no files
            pass
    except OSError as error:
        raise unwritten(path, error, "file") from None
    return path


def folder(path: Path) -> Path:
    """Makes an output folder, with its parents."""
    try:
        ensure_visible(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        if error.errno in NO_ROOM:
            raise unwritten(path, error) from None
        raise InputError(
            "cannot make the output folder", f"{path}: {error.strerror}", "choose another with -o"
        ) from None
    if not os.access(path, os.W_OK):
        raise InputError("cannot write into the output folder", str(path), "choose another with -o")
    return path


def read(path: Path, limit: int) -> bytes:
    """The bytes of an input file of at most `limit` bytes."""
    try:
        if ensure_visible(path).stat().st_size > limit:
            raise InputError("the file is too large", f"{path}: more than {limit} bytes", "is this the right file?")
        return path.read_bytes()
    except OSError as error:
        raise InputError("cannot read the file", f"{path}: {error.strerror}", "check the path") from None


def read_unpacked(path: Path, limit: int) -> bytes:
    """Reads like `read`; of a file `*.xz` what it packs, of which no more than that and 128 MiB are made."""
    data = read(path, limit)
    if path.suffix != PACKED:
        return data
    most = min(limit, MAX_UNPACKED_BYTES)
    unpacking = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=PACKED_MEMORY)
    try:
        content = unpacking.decompress(data, most + 1)
    except lzma.LZMAError as error:
        raise InputError("cannot unpack the file", f"{path}: {error}", "pack it again with xz") from None
    if len(content) > most:
        raise InputError("the file is too large", f"{path}: unpacks to more than {most} bytes", "unpack it with xz")
    if not unpacking.eof or unpacking.unused_data:
        where = f"{path}: {'something follows it' if unpacking.eof else 'its end is missing'}"
        raise InputError("cannot unpack the file", where, "pack it again with xz")
    return content


def decode_file(path: Path, limit: int, form: type[Form], what: str, advice: str) -> Form:
    """A JSON input file of at most `limit` bytes as a msgspec struct. InputError that says `what` it is not."""
    data = read(path, limit)
    try:
        return msgspec.json.decode(data, type=form)
    except (msgspec.ValidationError, msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(what, f"{path}: {escape_text(error)}", advice) from None


def as_json(content: Any) -> str:
    """JSON as our files hold it."""
    return json.dumps(content, indent=2, sort_keys=True) + "\n"


def holds_run(folder_: Path) -> bool:
    """Returns True if a folder holds a run, of one or several seeds: then `claim` lets nobody in without `resume`."""
    try:
        return any(place.exists() for place in (folder_ / CONFIG_FILE, *folder_.glob(f"seed-*/{CONFIG_FILE}")))
    except OSError:
        return False


def ensure_vacant(folder_: Path, result: str, resume: bool) -> None:
    """Makes sure, before the work, that a run can be kept in a folder. InputError where its `result`, a name, would be
    written over a file, and for a folder that cannot be made or, as `claim`, is to be resumed although none is there.
    """
    room(folder_)
    if resume:
        if not holds_run(folder_):
            raise _no_run(folder_ / CONFIG_FILE)
    elif (folder_ / result).exists() or (folder_ / CONFIG_FILE).exists():
        if holds_run(folder_):
            raise _run_there(folder_)
        what = f"the folder holds another {result}, which no run wrote there"
        raise InputError(what, str(folder_ / result), "choose another folder with -o, or move the file away")


def _no_run(place: Path) -> InputError:
    return InputError("there is no run to resume", str(place), "leave --resume out, or check the folder")


def _run_there(folder_: Path) -> InputError:
    advice = "continue it with --resume, or choose another folder with -o"
    return InputError("the folder already holds a run", str(folder_), advice)


def claim(folder_: Path, config: Mapping[str, Any], same: Sequence[str], resume: bool) -> bool:
    """Makes a folder a run's, or makes sure that it is this run's already; returns whether there was one to go on with.

    `config`: what the run is started with: `settings`, the entries named in `same`, which a later call must repeat, and
    the `command`. InputError for a folder that holds a run unless `resume`, another run, or none with `resume`.
    """
    folder(folder_)
    place = folder_ / CONFIG_FILE
    if resume and not place.exists():
        raise _no_run(place)
    if not resume:
        if create(place, as_json(config)):
            return False
        raise _run_there(folder_)
    try:
        stored = json.loads(read(place, MAX_CONFIG_BYTES))
        differing = [key for key in same if stored.get(key) != config[key]]
        names = sorted({*config["settings"], *stored["settings"]})
        differing += [name for name in names if stored["settings"].get(name) != config["settings"].get(name)]
        command = str(stored["command"])
    except (ValueError, LookupError, TypeError, AttributeError):
        raise InputError("not a readable run folder", str(place), "start again in another folder") from None
    if "format" in differing:
        where = f"{place}: '{escape_text(str(stored.get('format'))[:40])}', not {config['format']}"
        raise InputError("the run in the folder is of another version", where, "start again in another folder")
    if differing:
        where = f"{place}: {', '.join(differing)} differ"
        raise InputError("the folder holds another run", where, f"it was started with: {command}")
    return True


@contextlib.contextmanager
def working_alone(folder: Path) -> Generator[None]:
    """Holds the folder of a run that was claimed. InputError while another process, or thread, holds it."""
    with contextlib.ExitStack() as stack:
        opened = None
        try:
            if fcntl is not None:
                opened = stack.enter_context((folder / CONFIG_FILE).open("rb"))
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:  # of a folder where nothing can be locked nobody is refused
            if opened is not None and error.errno in (errno.EAGAIN, errno.EACCES):
                advice = "wait for its end, or stop it and go on with --resume"
                raise InputError("another process works on the run in the folder", str(folder), advice) from None
        yield
