"""The manual's site: it is built without a warning, every page is reached, nothing is cut off (extra: docs)."""

import re
import shutil
import subprocess
import sys
from html import unescape
from pathlib import Path

import click
import pytest

import maviper
from maviper import answers, claims, errors, manual, profiles
from maviper.cli.main import cli
from tests.maviper.page.browsers import overhang

for extra in ("furo", "myst_parser", "sphinx"):
    pytest.importorskip(extra, reason="the extra maviper[docs] is not installed")
pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
MANUAL = ROOT / "maviper" / "manual"


def built(source, place, builder="html"):
    """What Sphinx says of a build, with its exit code. It warns of pages that no other one lists, and of links and
    anchors that lead nowhere.
    """
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", builder, "-c", MANUAL / "site"]
    folders = ["-d", place / "trees", source, place / "site"]
    done = subprocess.run([*command, *folders], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    place = tmp_path_factory.mktemp("built")
    code, said = built(MANUAL, place)
    assert (code, said) == (0, "")
    return place / "site"


def text_of(page):
    return page.read_text(encoding="utf-8")


def test_the_first_page_is_the_readme_and_leads_to_every_page(site):
    first = text_of(site / "index.html")
    assert (ROOT / "README.md").read_text().partition("\n\n")[2].partition(",")[0] in " ".join(first.split())
    (tree,) = re.findall(r'<div class="sidebar-tree">(.*?)</div>', first, re.DOTALL)
    parts = re.split(r'<p class="caption"[^>]*><span class="caption-text">', tree)[1:]
    for part, (kind, topics) in zip(parts, manual.KINDS.items(), strict=True):
        linked = re.findall(r'href="([^"#]+)"', part)
        assert unescape(part).startswith(kind) and linked[: len(topics)] == [f"{topic}.html" for topic in topics]
        assert all((site / page).is_file() for page in linked)
    assert 'href="site/play.html"' in first.partition('role="main"')[2]


def test_pages_play(site):
    played = re.findall(r'(?:src|href)="\.\./(playing/\w+\.html)"', text_of(site / "site" / "play.html"))
    verdicts = {page: text_of(site / page) for page in played}
    assert len(verdicts) == 2 and "VIOLATED" in verdicts["playing/extracted.html"]
    assert "PROVED" in verdicts["playing/repaired.html"]


def commands(command, path):
    """Every command that is shown, with the words that name it."""
    yield path, command
    for name, below in getattr(command, "commands", {}).items():
        if not below.hidden:
            yield from commands(below, f"{path} {name}")


def test_the_command_line_has_every_option(site):
    text, seen = text_of(site / "site" / "commands.html"), 0
    for path, command in commands(cli, "maviper"):
        for parameter in command.params:
            if isinstance(parameter, click.Option) and not parameter.hidden:
                flag = f"cmdoption-{path.replace(' ', '-')}-{parameter.opts[-1].strip('-')}"
                assert f'id="{flag}"' in text and (parameter.help or "").split("`")[0] in unescape(text), flag
                seen += 1
    assert seen > 80


def classes(module):
    """The public classes that a module defines, or else those that it hands on."""
    shown = [each for name, each in vars(module).items() if isinstance(each, type) and not name.startswith("_")]
    return [each for each in shown if each.__module__ == module.__name__] or shown


def test_every_public_name_is_described(site):
    text = "".join(text_of(page) for page in (site / "site").glob("*.html"))
    names = [f"maviper.{name}" for name in (*maviper.__all__, "Team")]
    names += [f"maviper.claims.{each.__name__}" for each in classes(claims) if issubclass(each, claims.Claim)]
    for module in (answers, profiles, errors):
        names += [f"{module.__name__}.{each.__name__}" for each in classes(module) if each is not answers.Team]
    assert len(names) > 60 and not [name for name in names if f'id="{name}"' not in text]


@pytest.mark.parametrize("width", [400, 1400])
def test_nothing_is_cut_off(site, tmp_path, width):
    pages = sorted([*site.glob("*.html"), *site.glob("site/*.html")])
    assert dict(zip(pages, overhang(pages, tmp_path, width), strict=True)) == dict.fromkeys(pages, 0)


def test_a_link_that_leads_nowhere_would_be_found(tmp_path):
    source = tmp_path / "manual"
    shutil.copytree(MANUAL, source)
    with (source / "tour.md").open("a", encoding="utf-8") as page:
        page.write("\n[nobody](nobody.md) [nowhere](claims.md#nowhere)\n")
    (source / "words.md").rename(source / "worda.md")
    code, said = built(source, tmp_path, "dummy")
    assert code != 0 and "nobody" in said and "'nowhere'" in said and "worda.md: WARNING" in said, said
