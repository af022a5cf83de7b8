"""Scratch files and folders, in which something is written before it gets its name; none of them stays.

Does: makes one beside its target, locked while its process lives; removes it afterwards, and those of killed processes.
Assumes: a lock ends with its process. Where nothing can be locked, what a killed process left stays.
Does not: give anything its name (runs.py does).
"""

import contextlib
import itertools
import os
import re
import shutil
from collections.abc import Generator
from pathlib import Path
from typing import BinaryIO

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
