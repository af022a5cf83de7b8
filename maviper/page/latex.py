r"""Trees in LaTeX, by the package forest, for papers.

Does: writes one `forest` environment for each agent; the left branch is where a test holds.
Assumes: a document with `\usepackage{forest}`; trees that are looked at (`codegen.targets.svg` has the limit).
Does not: write a document.
"""

import re

from codegen import ir
from codegen.lowering.lower import lower
from codegen.lowering.model import Agent
from codegen.targets.svg import Box, picture

SPECIAL = {each: f"\\{each}" for each in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "…": r"\dots{}",
    "<": r"\(<\)",
    ">": r"\(>\)",
}
SIGNS = {"-": r"\(-\)", "<=": r"\(\le\)", ">=": r"\(\ge\)"}
STYLE = """for tree={draw, font=\\small, inner sep=3pt, l sep=16pt, s sep=5pt, edge={->}, align=center},
  yes/.style={edge label={node[midway, left, font=\\scriptsize]{yes}}},
  no/.style={edge label={node[midway, right, font=\\scriptsize]{no}}},
  leaf/.style={rounded corners=5pt}"""


def draw_forest(profile: ir.PolicyProfile) -> str:
    """The trees of all agents. InputError for a tree of thousands of nodes."""
    trees = map(_draw_tree, lower(profile).agents)
    return "\n\n".join(["% \\usepackage{forest}", *trees]) + "\n"  # a paragraph each: on one line they overlap


def _draw_tree(agent: Agent) -> str:
    drawn = picture(agent)
    lines: list[str] = []

    def write(box: Box, indent: str, branch: str) -> None:
        if not box.split:
            lines.append(f"{indent}[{{{escape(box.words)}}}, leaf{branch}]")
            return
        lines.append(f"{indent}[{{{escape(f'{box.words} {box.test}')}}}{branch}")
        write(drawn.boxes[box.node.left], indent + "  ", ", yes")
        write(drawn.boxes[box.node.right], indent + "  ", ", no")
        lines.append(f"{indent}]")

    write(drawn.boxes[0], "", "")
    body = "\n".join(lines)
    return f"% {drawn.title}\n\\begin{{forest}}\n{STYLE}\n{body}\n\\end{{forest}}"


def escape(text: str) -> str:
    """A text as LaTeX prints it."""
    found = r"<=|>=|(?<!\w)-(?=[.\d])|[\\~^…&%$#_{}<>]"  # a minus before a number, which a hyphen is not
    return re.sub(found, lambda each: SIGNS.get(each[0]) or SPECIAL[each[0]], text)
