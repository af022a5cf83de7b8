"""What several tests use of commands: all that there are, how one ends, and what is said of a damaged file."""

import json

import pytest

import maviper
from codegen.errors import InputError
from maviper.cli import main


def every_command(group=main.cli, path=()):
    """(words, command) of all commands and groups, each after the group that it is in."""
    yield path, group
    for name, command in sorted(getattr(group, "commands", {}).items()):
        yield from every_command(command, (*path, name))


def run(capsys, *arguments):
    code = main.run([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def ensure_told(file, profile, tmp_path, change, said):
    """A file with changes (member or member/member -> value) ends in exit code 2 with the file's path."""
    document = json.loads(file.read_text())
    for place, value in change.items():
        outer, _, inner = place.partition("/")
        if inner:
            document[outer][inner] = value
        else:
            document[outer] = value
    (tmp_path / "damaged.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=said) as caught:
        maviper.replay(tmp_path / "damaged.json", profile)
    assert caught.value.exit_code == 2 and "damaged.json" in caught.value.where
