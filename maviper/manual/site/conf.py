"""The site: the manual's own files, the README as its first page, and pages that are made when it is built.

    sphinx-build -W -c maviper/manual/site maviper/manual build/site

Does: configures Sphinx; makes the navigation from `manual.KINDS`, links that lead out of the manual into downloads,
  indented blocks of docstrings into code, and the pages that play.
Assumes: the extra maviper[docs]; a checkout, with what `generated/` holds.
Does not: belong to the wheel, or hold text that another page has.
"""

import os
import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

MANUAL, ROOT = Path(__file__).parents[1], Path(__file__).parents[3]
sys.path[:0] = [str(ROOT), str(MANUAL / "site")]

from maviper import load, manual, verify  # noqa: E402 - the checkout's own
from maviper.files import runs  # noqa: E402
from maviper.page.page import page_of  # noqa: E402

project = "MAVIPER"
copyright = "The MAVIPER developers"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "commands"]
root_doc = "index"
myst_heading_anchors = 4
highlight_language = "none"  # of commands; a program says its language
default_role = "py:obj"  # `name` in a docstring is a link where there is such a name, else code
source_suffix = {".rst": "restructuredtext", ".md": "markdown", ".markdown": "markdown"}
smartquotes = False  # -- begins an option
html_theme = "furo"
html_title = project
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"  # beside the parameters: a signature of thirty options is read by nobody
autodoc_typehints_description_target = "documented_params"
autodoc_default_options = {"members": True, "undoc-members": True}

ELSEWHERE = {  # page of the site -> the file that it shows
    "index": "README.md",
    "site/report": "generated/reproduction/README.md",
    "site/theory": "generated/reproduction/theory.md",
}
MADE = {  # pages of the site alone, at the end of a kind
    "Start": ("site/play", "site/gallery"),
    "Look up": ("site/commands", "site/api", "site/report", "site/theory"),
}
TEAM = "generated/physical_deception"
PLAYED = {"extracted": f"{TEAM}/extracted/profile.json", "repaired": f"{TEAM}/profile.json"}  # pages that play
DRAG = "**[Drag these agents in your browser](/site/play)**, before you install anything.\n\n## Install"


def point_links(text: str, folder: Path, page: str) -> str:
    """The text of a file in `folder`, with links as they lead from `page`: to a page, or to a file to be downloaded."""
    shown = {ROOT / file: f"{name}.md" for name, file in ELSEWHERE.items()}
    shown |= {ROOT / "README.md": root_doc, MANUAL: root_doc}

    def point(found: re.Match[str]) -> str:
        target, hash_, anchor = found[1].partition("#")
        path = (folder / target).resolve()
        if path in shown:
            return f"](/{shown[path]}{hash_}{anchor})"
        inside = os.path.relpath(path, (MANUAL / page).parent)
        return f"]({inside}{hash_}{anchor})" if path.is_relative_to(MANUAL) else f"](path:{inside})"

    return re.sub(r"\]\((?!https?:|#)([^)\s]+)\)", point, text)


def read_page(_app: Sphinx, name: str, content: list[str]) -> None:
    """Points the links of Markdown; the first page is the README with the navigation, and a way to what plays."""
    if name in ELSEWHERE:
        file = ROOT / ELSEWHERE[name]
        content[0] = point_links(file.read_text(encoding="utf-8"), file.parent, name)
    elif name in manual.TOPICS:
        content[0] = point_links(content[0], MANUAL, name)
    if name == root_doc:
        content[0] = content[0].replace("## Install", DRAG, 1)
        for kind, topics in manual.KINDS.items():
            entries = "\n".join((*topics, *MADE.get(kind, ())))
            content[0] += f"\n```{{toctree}}\n:caption: {kind}\n:hidden:\n\n{entries}\n```\n"


def read_docstring(_app: Sphinx, what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Says to Sphinx what a docstring says to a reader: an indented block is code, a name and a colon a parameter."""
    text = "\n".join(lines).replace("\nOptions:\n", "\nArgs:\n")
    text = re.sub(r"^Alias for field number \d+", "", text)  # Python's own words on a field
    text = re.sub(r"(?m)^( {4})`(\w+)`: ", r"\1\2: ", text)
    text = re.sub(r"(?m)^((?! {4}).*\n)\n(?= {4})", r"\1\n.. code-block:: python\n\n", text)
    text = re.sub(r"\nDoes: (.|\n)*?(\n\n|$)", "\n", text)  # which a module says to whoever changes it
    # napoleon takes what is before a colon in the first line of an attribute for a type: a comment goes before
    lines[:] = ["..", "", *text.split("\n")] if what in ("attribute", "property") else text.split("\n")


def name_parameters(_app: Sphinx, tree: nodes.document) -> None:
    """Writes a colon between a parameter and its text, as docstrings do."""
    for dash in [each for each in tree.findall(nodes.Text) if each == " -- "]:
        dash.parent.replace(dash, nodes.Text(": "))


def make_players(app: Sphinx) -> None:
    """Writes the pages that play, with verdict and counterexample, as `maviper demo` does."""
    for name, file in PLAYED.items():
        team = load(ROOT / file)
        runs.write(Path(app.outdir) / "playing" / f"{name}.html", page_of(team, [verify(team)]))


def setup(app: Sphinx) -> None:
    """Connects the functions above."""
    app.connect("builder-inited", make_players)
    app.connect("source-read", read_page)
    app.connect("autodoc-process-docstring", read_docstring, priority=400)  # before napoleon
    app.connect("doctree-read", name_parameters)
