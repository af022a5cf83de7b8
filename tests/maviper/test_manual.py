"""The manual and the README: what their tables, commands, options, code and pictures say is what the code does."""

import contextlib
import re
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import click
import pytest

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.errors import InputError, UnknownNameError
from codegen.form import SCHEMA_VERSION
from codegen.profiles import loads
from codegen.targets import TARGETS, emit
from maviper import manual
from maviper.cli import main, options
from maviper.extraction.settings import BUNDLES, KNOWN, PARTS
from maviper.verification.starters import list_properties
from maviper.worlds import WORLDS, ParticleWorld, find, options_of
from maviper.worlds.games.features import GROUPS
from maviper.worlds.remembering import LAST_ACTION, SINCE_CHANGE
from tests.benchmarks import compact, trusted
from tests.support import pictures
from tests.support.verifying import every_command
from verify.claims import decisions
from verify.claims.formula import holds
from verify.question import EFFORTS, LIMITS, Budgets
from verify.result import Verdict

ROOT = Path(__file__).parents[2]
FOLDER = "maviper/manual"
README = ROOT / "README.md"
PAGES = [*manual.TOPICS]
TOP = ("README", "CONTRIBUTING")  # at the top of the repository
TEAM = ROOT / "generated" / "physical_deception"  # what `maviper demo -o demo` writes
MAX_COLUMNS, MAX_TABLE_COLUMNS, MAX_README_LINES = 100, 120, 110


def text_of(name):
    return (ROOT / f"{name}.md").read_text() if name in TOP else manual.page(name)


def padded(header, rows):
    """A Markdown table with columns of one width, so that it reads in a terminal too."""
    table = [list(map(str, row)) for row in (header, *rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    filled = [[f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)] for row in table]
    lines = [f"| {' | '.join(row)} |" for row in filled]
    return [lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]]


def table_under(page, heading):
    """The lines of the first table under a heading."""
    lines = f"\n{page}".split(f"\n{heading}\n")[1].splitlines()
    start = next(place for place, line in enumerate(lines) if line.startswith("|"))
    assert not any(line.startswith("#") for line in lines[:start]), f"{heading}: no table"
    end = next((place for place in range(start, len(lines)) if not lines[place].startswith("|")), len(lines))
    return lines[start:end]


def rows_of(lines):
    """The cells of a table's rows, without its head."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


# --- the package


def test_every_page_is_a_topic_and_has_a_title():
    assert sorted(manual.TOPICS) == sorted(path.stem for path in (ROOT / FOLDER).glob("*.md"))
    titles = manual.topics()
    assert list(titles) == PAGES and len(set(titles.values())) == len(PAGES)
    for topic, title in titles.items():
        assert manual.page(topic).startswith(f"# {title}\n") and title and not title.startswith("#")


@pytest.mark.parametrize(("topic", "advice"), [("claim", "did you mean 'claims'?"), ("../cli", ""), ("", "")])
def test_a_wrong_topic_is_told_with_the_closest_match(topic, advice):
    with pytest.raises(UnknownNameError) as error:
        manual.page(topic)
    assert isinstance(error.value, InputError) and advice in error.value.next_step and topic in error.value.what


def test_the_manual_loads_nothing_heavy():
    code = (
        "import sys; from maviper import manual; manual.topics();"
        "print(sorted({'numpy', 'click', 'jinja2', 'msgspec', 'rich', 'z3'} & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


# --- the games


PLACES = [game for game in WORLDS if isinstance(find(game), ParticleWorld)]


def test_the_games_actions_are_those_of_the_worlds():
    actions = [(k, a.name, "({:g}, {:g})".format(*a.effect)) for k, a in enumerate(find("predator-prey").actions[0])]
    assert table_under(manual.page("games"), "### Actions") == padded(["index", "action", "direction (x, y)"], actions)


def test_every_action_is_the_same_in_every_game():
    assert len({choices for game in PLACES for choices in find(game).actions}) == 1


@pytest.mark.parametrize("game", WORLDS)
def test_worlds_show_explains_every_option_and_measure(game, capsys):
    assert main.run(["worlds", "show", game]) == 0
    measures, _, told = capsys.readouterr().out.partition("\nmeasures\n")[2].partition("\noptions\n")
    assert len(measures.splitlines()) == len(find(game).measures)
    assert [line.split()[0] for line in told.splitlines()] == [*options_of(game)]
    for name, least, most in re.findall(r"^  (\w+) +(\d+) to (\d+) ", told, flags=re.M):
        for value in (least, most):
            assert find(f"{game},{name}={value}", giving=True)
        for beyond in (int(least) - 1, int(most) + 1):
            with pytest.raises(InputError):
                find(f"{game},{name}={beyond}")


def test_velocity_adds_what_the_page_says():
    wide, plain = find("physical-deception,velocity=1"), find("physical-deception")
    for more, fewer in zip(wide.features, plain.features, strict=True):
        assert [feature.name for feature in more] == [*(feature.name for feature in fewer), "vx", "vy"]


# --- experts, extraction, claims, verdicts, files


def first_column(page, heading):
    return [row[0].strip("`") for row in rows_of(table_under(page, heading))]


def test_algorithms_features_targets_and_verdicts_are_all_there():
    assert sorted(first_column(manual.page("extraction"), "## Algorithms")) == sorted(KNOWN)
    remembered = [LAST_ACTION, SINCE_CHANGE]
    assert sorted(first_column(manual.page("extraction"), "## Features")) == sorted([*GROUPS, *remembered])
    targets = manual.page("compiling").partition("\n## Targets\n")[2].partition("\n## ")[0]
    assert set(TARGETS) <= set(re.findall(r"`([\w-]+)`", targets))
    assert first_column(manual.page("verdicts"), "# " + manual.topics()["verdicts"]) == [each.value for each in Verdict]


def test_the_ladder_is_the_one_of_the_code():
    ladder = manual.page("extraction").partition("\n## The ladder from IVIPER to MAVIPER\n")[2].partition("\n## ")[0]
    said = {}
    for names, settings in re.findall(r"^- ((?:`[\w-]+`(?:, )?)+): (.*)", ladder, flags=re.M):
        for name in re.findall(r"[\w-]+", names):
            said[name] = said.get("maviper", {}) | dict(re.findall(r"`(\w+)=([\w-]+)`", settings))
    for name, settings in said.items():
        assert BUNDLES[name].items() <= settings.items() and set(settings) <= set(PARTS), name
    assert len(said) == 7


def test_every_claim_is_there():
    items = re.findall(r"^- ((?:`\w+`(?:, )?)+):", manual.page("claims"), flags=re.M)
    named = {name for item in items for name in re.findall(r"\w+", item)}
    assert {claim["name"] for claim in list_properties()} <= named


def test_the_limits_are_the_defaults():
    rows = rows_of(table_under(manual.page("verdicts"), "`--effort` says how much is tried:"))
    spent = [Budgets.of_effort(effort) for effort in EFFORTS]
    assert [row[1:] for row in rows] == [[f"{getattr(one, name):,}" for one in spent] for name in LIMITS]
    assert Budgets.of_effort("normal") == Budgets()


def pictured():
    """The rows of the claims page: landmark, offset, closes, at, engaged."""
    rows = rows_of(table_under(manual.page("claims"), "With a margin of 0 and a radius of 0.1:"))
    return [
        (name, tuple(map(float, offset.strip("()").split(","))), *(each == "yes" for each in said))
        for name, offset, *said in rows
    ]


def test_closes_at_and_engaged_are_as_the_page_shows_them():
    from fractions import Fraction

    policy = loads((TEAM / "profile.json").read_bytes()).policy("agent_0")
    actions = {action.name: number for number, action in enumerate(policy.actions)}
    closing = decisions.closing(policy, "landmark_0", Fraction(0))
    near = decisions.at("agent_0", "landmark_0", Fraction(1, 10))
    found = pictured()
    assert len({row[2:] for row in found}) == 3
    for _, (x, y), *said in found:
        place = {"agent_0.x": Fraction(0), "agent_0.y": Fraction(0)}
        place |= {"landmark_0.x": Fraction(str(x)), "landmark_0.y": Fraction(str(y))}
        ahead, there = (holds(each, place, {"agent_0": actions["right"]}) for each in (closing, near))
        assert said == [ahead, there, ahead or there]
        assert not holds(closing, place, {"agent_0": actions["stay"]})


def test_the_files_page_names_every_form():
    page = manual.page("files")
    sources = [path.read_text() for folder in ("maviper", "verify") for path in (ROOT / folder).rglob("*.py")]
    forms = {form for text in sources for form in re.findall(r"\"(maviper-[a-z-]+-[0-9]+)\"", text)}
    forms |= {compact.FORM}  # of committed records, which the benchmarks write
    assert forms == set(re.findall(r"`(maviper-[a-z-]+-[0-9]+)`", page))
    assert f"`schema_version`: {SCHEMA_VERSION} " in page


# --- pictures: what the code renders


def counterexample_picture():
    """The drawing in the committed report, as a file of its own."""
    found = re.search(r"<svg.*?</svg>\n", (TEAM / "extracted" / "report.html").read_text(), flags=re.S)[0]
    found = found.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" ', 1)
    return found.replace("</defs>\n", '</defs>\n<rect width="100%" height="100%" fill="#fbfcfd"/>\n', 1)


def test_the_pictures_are_what_the_code_renders(golden):
    team = loads((TEAM / "profile.json").read_bytes())
    tree = emit(team, ["svg"])["physical_deception_agent_0.svg"]
    golden(FOLDER, {"tree.svg": tree, "counterexample.svg": counterexample_picture()})
    drawn = (ROOT / FOLDER / "claims.svg").read_text()
    for name, _, closes, near, _ in pictured():
        assert f">{name}: {'closes' if closes else 'at' if near else 'neither'}</text>" in drawn
    shown = {
        name
        for page in ("README", *PAGES)
        for name in re.findall(r"!\[[^]]*\]\((?!generated/)(?:[^)]*/)?([^)]*)\)", text_of(page))
    }
    assert shown == {path.name for ending in ("svg", "png") for path in (ROOT / FOLDER).glob(f"*.{ending}")}


def test_the_readmes_picture_is_a_small_photograph_of_the_page():
    data = pictures.PICTURE.read_bytes()
    size = [int.from_bytes(data[start : start + 4], "big") for start in (16, 20)]
    assert data.startswith(b"\x89PNG\r\n") and len(data) <= pictures.MAX_BYTES
    assert size == [round(side * pictures.SCALE) for side in (pictures.WIDTH, pictures.HEIGHT)]
    assert pictures.PAGE.is_file()


# --- commands


def commands_of(name):
    """Every command line of a page, without what a shell says of it."""
    found = []
    for line in text_of(name).splitlines():
        match = re.match(r" {4}(?:\$ )?(maviper [a-z].*)", line)
        if match:
            found.append(match[1])
    return found


def words_of(line):
    """The words of a command after `maviper`."""
    return shlex.split(line, comments=True)[1:]


def command_of(words):
    """The command that words name, and what is left of them."""
    command = main.cli
    words = list(words)
    while isinstance(command, click.Group) and words and words[0] in command.commands:
        command = command.commands[words.pop(0)]
    return command, words


@pytest.mark.parametrize("name", [*TOP, *PAGES])
def test_every_command_of_a_page_parses(name):
    for line in commands_of(name):
        command, rest = command_of(words_of(line))
        assert not isinstance(command, click.Group), line
        with contextlib.suppress(click.exceptions.Exit):  # of what lists something at once
            command.make_context(line, [word for word in rest if word not in GENERAL])


def test_a_command_that_does_not_parse_would_be_found():
    for words in (["verify", "p.json", "--zone", "3"], ["extract", "x"], ["compile", "p.json", "-o"]):
        command, rest = command_of(words)
        with pytest.raises(click.UsageError):
            command.make_context("maviper", rest)


@pytest.mark.parametrize("name", [*TOP, *PAGES])
def test_commands_and_options_in_the_text_exist(name):
    known = {option for _, command in every_command() for each in command.params for option in each.opts} | GENERAL
    for code in re.findall(r"`([^`\n]+)`", text_of(name)):
        if code.startswith("maviper "):
            words = words_of(code)
            command, rest = command_of(words)
            assert words[0] in {"--help", "COMMAND"} or command is not main.cli, code
            mine = {*GENERAL, *(option for each in command.params for option in each.opts)}
            assert {word for word in rest if word.startswith("-")} <= mine, code
        for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", code):
            assert option in known or code.startswith(("pytest", "python ")), f"{name}: {code}"


GENERAL = {"--help", *options.GENERAL}


def test_every_command_is_in_some_page():
    text = "\n".join(text_of(name) for name in ("README", *PAGES))
    for path, command in every_command():
        assert command.hidden or isinstance(command, click.Group) or f"maviper {' '.join(path)}" in text, path


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder in which the demo was run."""
    shutil.copytree(TEAM, tmp_path / "demo", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def steps(text):
    """What a page has its reader do, in order: ("file", name, text), ("change", name, diff), ("python", program) or
    ("run", line, output).

    A block belongs to the file that the line before it names last, if that ends with a colon. Other blocks of Python
    are programs. Of indented lines, those that begin with a program are commands, and so is what a workflow runs; the
    line before may say what one prints.
    """
    fence, block, before = None, [], ""
    for line in text.splitlines():
        if line.startswith("```") and fence is None:
            fence, block = line[3:], []
        elif line.startswith("```"):
            if named := re.search(r"`([\w.]+\.\w+)`[^`]*:$", before):
                yield "change" if fence == "diff" else "file", named[1], "\n".join([*block, ""])
            elif fence == "python":
                yield "python", "\n".join(block)
            elif fence == "yaml":
                yield from (("run", line.partition("run: ")[2], "") for line in block if "run: maviper " in line)
            fence, before = None, ""
        elif fence is not None:
            block.append(line)
        else:
            if match := re.match(r" {4}(?:\$ )?((?:maviper|cc|python|node) \S.*)", line):
                printed = re.search(r"prints `(.*)`:$", before)
                yield "run", match[1], printed[1] if printed else ""
            before = line or before


def printed_by(program):
    """What the comments of a program say that it prints, or "" if some say nothing."""
    said = re.findall(r"(?:print|console\.log)\(.*(?:#|//) (.*)", program)
    return ", ".join(said) if len(said) == len(re.findall(r"(?:print|console\.log)\(", program)) else ""


TRIED = "\n## Policies of other libraries\n"  # from here on, by experts/test_libraries.py
THEIRS = "\n### Normalised observations\n"  # goes on with a reader's own training
NEEDS = {  # what a page goes on with only where it is installed
    "maviper train ": ("torch", "matplotlib"),
    "stable_baselines3": ("stable_baselines3",),
    "supersuit": ("supersuit",),
    "vmas:": ("vmas",),
    "main.c": ("cc",),
    "node ": ("node",),
    "signals:": ("libsumo", "sumo_rl"),
}
SHORT = ["--steps", "51200", "--set", "checkpoint_steps=25600"]  # of training, which takes minutes as it stands there


def is_read_later(line, text):
    """Whether the folder that a line of training writes is named below; of others it is enough that they parse."""
    return f" {line.partition(' -o ')[2]}" in text.partition(line)[2]


def missing(step):
    """The packages and programs that are not there and that a step takes."""
    wanted = [need for words, needs in NEEDS.items() if any(words in each for each in step) for need in needs]
    return [need for need in wanted if find_spec(need) is None and shutil.which(need) is None]


@pytest.mark.slow
@pytest.mark.compile
@pytest.mark.solver
@pytest.mark.parametrize("name", ["README", *(name for name in PAGES if name not in manual.KINDS["Contribute"])])
def test_everything_on_a_page_runs_in_its_order(name, place, monkeypatch, capsys):
    """From an empty folder, but for what the demo writes, up to what needs a package that is not installed."""
    monkeypatch.setattr("webbrowser.open", lambda _: True)
    known, files = {"__name__": "__main__"}, {}
    given = [step for step in steps(manual.page("team")) if step[0] == "file"] if name == "environments" else []
    if name == "signals":
        given = [("file", path.name, path.read_text()) for path in (ROOT / "generated" / name).glob("*.py")]
    begun = text_of(name).partition(TRIED)[0].partition(THEIRS)[0]
    for step in [*given, *steps(begun)]:
        if lacks := missing(step):
            pytest.skip(f"not installed: {', '.join(lacks)}; all before it has run")
        match step:
            case "run", line, _ if line.startswith("maviper train ") and not is_read_later(line, text_of(name)):
                pass
            case "file", file, text:
                files[file] = text
                (place / file).write_text(text)
                monkeypatch.delitem(sys.modules, Path(file).stem, raising=False)
                if name == "team" and file.endswith(".py"):  # the first part of one program
                    exec(compile(text, f"{name}.md", "exec"), known)
            case "change", file, change:
                old, new = ("".join(re.findall(rf"^\{sign}(.*\n)", change, flags=re.M)) for sign in "-+")
                assert files[file].count(old) == 1
                files[file] = files[file].replace(old, new)
                (place / file).write_text(files[file])
            case "python", program:
                capsys.readouterr()
                exec(compile(program, f"{name}.md", "exec"), known)
                out = ", ".join(capsys.readouterr().out.splitlines())
                assert out == (printed_by(program) or out)
            case "run", line, _ if line.startswith("maviper "):
                wanted = re.search(r"# exits with (\d)", line)
                words = [*words_of(line), *(SHORT if line.startswith("maviper train ") else [])]
                assert main.run(words) == int(wanted[1] if wanted else 0), (line, *capsys.readouterr())
            case "run", line, out:
                said = out or printed_by(files.get(line.split()[-1], ""))
                command = line.replace("python ", f"{sys.executable} ", 1)
                ran = subprocess.run(["bash", "-ec", command], check=True, capture_output=True, text=True)
                assert not said or ", ".join(ran.stdout.splitlines()) == said


def test_other_output_than_a_page_says_would_be_found():
    said = [step for step in steps("It prints `2`:\n\n    python two.py\n") if step[0] == "run"]
    assert said == [("run", "python two.py", "2")] and printed_by("print(1)  # 1\nprint(2)  # 2\n") == "1, 2"
    assert not printed_by("print(1)  # 1\nprint(2)\n")


# --- code


def blocks(name, language):
    return re.findall(rf"```{language}\n(.*?)```", text_of(name), flags=re.S)


@pytest.mark.compile
def test_the_c_of_the_embedding_page_compiles_without_a_warning(tmp_path):
    program, function = blocks("embedding", "c")
    (tmp_path / "main.c").write_text(program)
    (tmp_path / "decide.c").write_text(f"int decide(const float *x);\n{function}")
    flags = [*STRICT, f"-I{TEAM}"]
    subprocess.run([*find_compiler(), *flags, "-c", "decide.c", "-o", "decide.o"], cwd=tmp_path, check=True)
    subprocess.run([*find_compiler(), *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    names = re.findall(
        r"`PREFIX_([a-zA-Z_]+)`", "\n".join(table_under(manual.page("embedding"), "### Functions of the header"))
    )
    header = (TEAM / "physical_deception.h").read_text()
    for name in names:
        assert f" physical_deception_{name.replace('A_', 'agent_0_')}(" in header or name == "in_region", name


# --- the README

CHECKED = {  # what is trusted of each kind of proof, by the row of the README's table
    "decisions": "single decisions",
    "episodes": "episodes of games",
    "systems, all": "stated systems",
}


def test_the_readme_is_short_links_pages_and_keeps_its_two_lines():
    text = README.read_text()
    assert len(text.splitlines()) <= MAX_README_LINES
    assert all(map(printed_by, (*blocks("README", "python"), *blocks("python", "python")[:2])))
    linked = re.findall(r"\[([^\]]+)\]\(maviper/manual/(\w+)\.md\)", text)
    assert {topic for _, topic in linked} <= set(PAGES) and len(linked) <= 16
    for word in ("maviper demo", "pytest"):
        assert len(re.findall(rf"^    python3 -m venv \.venv .*{word}", text, flags=re.M)) == 1
    profile = loads((TEAM / "profile.json").read_bytes())
    ours, theirs = (profile.provenance.evaluation[f"defenders {who}success r=0.316"] for who in ("", "expert "))
    assert f"{100 * ours / theirs:.0f} %" in text
    pictured = loads((TEAM / "extracted" / "profile.json").read_bytes())
    assert f"{sum((policy.tree.feature < 0).sum() for policy in pictured.agents)} leaves" in text


def test_readme_and_verdicts_say_how_many_lines_check_a_proof():
    """To the hundred, and within a tenth: the README of the checker has the modules."""
    lines = {kind: trusted.count_lines(trusted.imported(trusted.PATHS[kind])) for kind in CHECKED}
    table = {row[0]: row[2] for row in rows_of(table_under(README.read_text(), "## What a verdict means"))}
    said = [int(re.search(r"[\d,]+$", table[row])[0].replace(",", "")) for row in CHECKED.values()]
    for told, counted in zip(said, lines.values(), strict=True):
        assert abs(told - counted) <= counted / 10 and f"{told:,}" in manual.page("verdicts")


def test_the_citation_names_the_project_and_the_papers_authors():
    text = (ROOT / "CITATION.cff").read_text()
    project = (ROOT / "pyproject.toml").read_text()
    version = re.search(r'^version = "(.*)"', project, flags=re.M)[1]
    assert f"\nversion: {version}\n" in text and "\nlicense: MIT\n" in text and text.startswith("cff-version: 1.2.0\n")
    authors = ["Milani", "Zhang", "Topin", "Shi", "Kamhoua", "Papalexakis", "Fang"]
    assert re.findall(r"family-names: (\w+)", text) == authors


# --- the text


BANNED = (
    "of which",
    "all else as it is",
    "what it is worth",
    "an agent a landmark",
    "a leaf each",
    "course",
    "start box",
)


@pytest.mark.parametrize("name", [*TOP, *PAGES])
def test_the_text_is_plain_and_fits(name):
    inside, lines = False, []
    for line in text_of(name).splitlines():
        inside ^= line.startswith("```")
        if inside or line.startswith((" " * 4, "```", "![")):
            continue
        assert len(line) <= (MAX_TABLE_COLUMNS if line.startswith("|") else MAX_COLUMNS), line
        lines.append(line)
    text = " ".join(lines).lower()
    for phrase in BANNED:
        assert phrase not in text, phrase
    assert text.isascii()


@pytest.mark.parametrize("name", [*TOP, *PAGES])
def test_links_and_paths_lead_somewhere(name):
    here = ROOT if name in TOP else ROOT / FOLDER
    text = text_of(name)
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert target.startswith("https://") or (here / target).exists(), target
    for path in re.findall(r"`((?:generated|maviper|codegen|verify|templates|tests)/[\w./-]*)`", text):
        assert (ROOT / path).exists() or path.endswith("table.py") or "tree.csv" in path, path
    for module in re.findall(r"python -m (tests\.[a-z._]*[a-z])", text):
        assert (ROOT / module.replace(".", "/")).with_suffix(".py").exists(), module


@pytest.mark.parametrize("name", PAGES)
def test_pages_for_users_name_no_script_that_an_installation_lacks(name):
    assert not re.search(r"\btests[./]\w", text_of(name))


def test_the_benchmarks_page_names_every_one():
    named = set(re.findall(r"`(\w+\.py)`", text_of("CONTRIBUTING")))
    assert {path.name for path in (ROOT / "tests/benchmarks").glob("*.py")} - named == set()
