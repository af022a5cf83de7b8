"""Help: one whole line a command, headings for options, an example that parses; options that had another name."""

import shlex

import click
import pytest

from codegen.errors import ExitCode
from maviper import manual
from maviper.cli import main
from maviper.cli.options import Verb, Verbs
from maviper.options.extraction import SETTINGS
from tests.support.verifying import every_command

WIDTH = 80
UNLISTED = {"train", "reproduce"}


COMMANDS = dict(every_command())
NAMED = pytest.mark.parametrize("path", COMMANDS, ids=" ".join)


def help_of(path, capsys):
    assert main.run([*path, "--help"]) == 0
    return capsys.readouterr().out


@NAMED
def test_every_command_has_one_whole_line_in_its_group(path, capsys):
    command = COMMANDS[path]
    assert isinstance(command, Verb) and command.one_line
    assert all(len(line) <= WIDTH for line in help_of(path, capsys).splitlines())
    if path:
        if path[0] in UNLISTED:
            return
        lines = help_of(path[:-1], capsys).splitlines()
        (line,) = [line for line in lines if line.split()[:1] == [path[-1]] and line.startswith("  ")]
        assert line.endswith(f"  {command.one_line}") and "..." not in line and not line.endswith(".")


@NAMED
@pytest.mark.smoke
def test_every_help_has_an_example_that_parses(path, capsys):
    command = COMMANDS[path]
    assert command.example and all(f"  {line}\n" in help_of(path, capsys) for line in command.example.splitlines())
    for line in command.example.splitlines():
        words = shlex.split(line.partition(">")[0])
        assert words[: 1 + len(path)] == ["maviper", *path]
        named, rest = main.cli, words[1:]
        while isinstance(named, click.Group):
            named, rest = named.commands[rest[0]], rest[1:]
        named.make_context(line, rest)


@pytest.mark.smoke
def test_the_chapters_hold_every_command():
    named = [name for names in main.cli.chapters.values() for name in names]
    assert sorted([*named, *UNLISTED]) == sorted(main.cli.commands) and len(named) == 16
    assert {str(command.name) for command in main.MORE} == UNLISTED


@pytest.mark.parametrize("name", ["verify", "extract", "compile", "evaluate", "train", "repair"])
def test_long_helps_have_headings(name, capsys):
    text = help_of((name,), capsys)
    sections = {
        getattr(each, "section", "Options")
        for each in main.cli.commands[name].params
        if each.param_type_name == "option" and not each.hidden
    }
    assert len(sections) > 2 - (name == "evaluate") and all(f"\n{section}:\n" in text for section in sections)


def test_there_are_few_options():
    shown = [command for path, command in COMMANDS.items() if not {*path[:1]} & UNLISTED]
    every_option = [each for command in shown for each in command.params if isinstance(each, click.Option)]
    assert sum(not each.hidden for each in every_option) <= 120


def test_general_flags_stand_before_or_after_a_command(capsys):
    for words in (["--json", "verify", "--list"], ["verify", "--json", "--list"], ["verify", "--list", "--json"]):
        assert main.run(words) == ExitCode.DONE
        assert capsys.readouterr().out.startswith("{")
    assert main.run(["guide", "--json"]) == ExitCode.DONE
    assert capsys.readouterr().out.startswith("{")


def test_settings_are_listed_read_and_refused(capsys):
    assert main.run(["extract", "--set", "help"]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert tuple(listed) == SETTINGS and len(listed) <= 25
    given = ["e", "-o", "x", "--set", "patience=7", "--set=weights=own"]
    context = main.cli.commands["extract"].make_context("extract", given)
    assert (context.params["patience"], context.params["weights"]) == (7, "own")
    assert capsys.readouterr().err == ""
    for words, told in (
        (["patiense=7"], "did you mean 'patience'?"),
        (["patience"], "patience has no value"),
        ([], ""),
    ):
        assert main.run(["extract", "e", "-o", "x", "--set", *words]) == ExitCode.INPUT
        assert told in capsys.readouterr().err


def test_the_guide_lists_topics_and_prints_pages(capsys):
    assert main.run(["guide"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed if line.startswith(" ")] == list(manual.TOPICS)
    assert [line for line in listed if not line.startswith(" ")] == [f"{kind}:" for kind in manual.KINDS]
    for topic, title in manual.topics().items():
        assert main.run(["guide", topic]) == 0
        assert capsys.readouterr().out == manual.page(topic) and any(title in line for line in listed)


def test_the_guide_names_the_closest_topic(capsys):
    assert main.run(["guide", "claim"]) == ExitCode.INPUT
    assert "did you mean 'claims'?" in capsys.readouterr().err


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_the_guide_lays_a_page_out_on_a_terminal_and_pages_it(columns, monkeypatch):
    import sys

    paged = []
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr(click, "echo_via_pager", paged.append)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    assert main.run(["guide", "words"]) == 0
    (shown,) = paged
    lines = click.unstyle(shown).splitlines()
    assert max(map(len, lines)) <= min(columns, 100) and not any("|" in line or "`" in line for line in lines)
    assert "profile" in shown and "\x1b[" in shown


def test_a_group_is_no_end(capsys):
    assert isinstance(main.cli.commands["worlds"], Verbs)
    assert main.run(["worlds", "lst"]) == ExitCode.INPUT
    assert "did you mean 'list'?" in capsys.readouterr().err
