"""The manual: Markdown pages, one a topic, in the order in which they are read.

Does: names the topics by kind, with their titles, and returns the text of a page.
Assumes: the pages lie beside this file, in a checkout and in a wheel; each begins with a line `# Title`.
Does not: print, format or import anything heavy.
"""

from pathlib import Path

from codegen.errors import UnknownNameError

KINDS = {
    "Start": ("tour", "team", "playing", "words", "limits"),
    "Do": (
        "experts",
        "extraction",
        "environments",
        "own",
        "importing",
        "measuring",
        "compare",
        "claims",
        "repair",
        "diff",
        "compiling",
        "embedding",
        "plc",
        "firmware",
        "flight",
        "flows",
        "systems",
        "signals",
    ),
    "Look up": ("python", "verdicts", "games", "files", "reproduce"),
    "Contribute": ("architecture",),
}
TOPICS = tuple(topic for topics_of_kind in KINDS.values() for topic in topics_of_kind)


def topics() -> dict[str, str]:
    """Topic -> title, the first line of its page, in reading order."""
    return {topic: page(topic).partition("\n")[0].removeprefix("# ") for topic in TOPICS}


def page(topic: str) -> str:
    """The Markdown text of a topic's page. UnknownNameError (an InputError) with the closest match otherwise."""
    if topic not in TOPICS:
        raise UnknownNameError("topic", topic, TOPICS)
    return (Path(__file__).parent / f"{topic}.md").read_text(encoding="utf-8")
