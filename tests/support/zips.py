"""Zips of stable-baselines3 with parts of them replaced."""

import json
import zipfile


def changed(file, to, **parts):
    """A copy of a zip with some of its files replaced."""
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(to, "w") as new:
        for name in old.namelist():
            new.writestr(name, parts.get(name.replace(".", "_"), old.read(name)))
    return to


def data_of(file):
    with zipfile.ZipFile(file) as archive:
        return json.loads(archive.read("data"))
