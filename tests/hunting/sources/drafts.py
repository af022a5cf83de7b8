"""What random programs of both languages share: a draft that counts the places where a step out of the subset may go.

Does: draws numbers and names as controllers have them; says where a constant, a condition or a statement stands.
Assumes: the same seed draws the same program, whatever step is taken in it.
Does not: know a language.
"""

import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

NAMES = (
    *("speed", "gap", "level", "temp", "angle", "spin", "height", "flow"),
    *("load", "offset", "range_m", "drift", "wind", "charge", "depth_m", "slope"),
)
TEXTS = (
    *("left", "right", "stay", "go", "brake", "coast", "up", "down"),
    *("hold", "open", "close", "idle", "heat", "cool", "alarm"),
)
INDENT = "    "
WHOLE = (0, 1, 2, 3, 5, 7, 10, 30, 60, 100, 255, 1000)
DECIMAL = (0.1, 0.2, 0.3, 0.5, 0.05, 0.01, 1e-3, 1.0, 1.5, 2.0, 0.25, 3.6, 9.81, 0.45, 12.5, 99.9, 1e-6, 1e6, 0.7, 4.35)
AGENTS = ("act", "decide", "steer", "policy", "control", "choose", "step_once", "governor")


@dataclass(frozen=True)
class Feature:
    """A number that a program is given: its name, its type, and what the source calls it."""

    name: str
    type: str
    text: str


@dataclass(frozen=True)
class Program:
    """A source, and how it is asked."""

    seed: int
    source: str
    agent: str  # the function, class or object that decides
    entry: str  # what is called
    form: str  # "row", "names", "attributes" or "columns"; C has its own
    features: tuple[Feature, ...]
    options: dict[str, Any] = field(default_factory=dict)  # of `maviper.from_file`
    step: str = ""  # the one out of the subset, where there is one
    labels: tuple[str, ...] = ()  # enumerators of C


@dataclass(frozen=True)
class Step:
    """One step out of the subset: what stands instead of a constant, a condition or a statement.

    `{c}` is the constant, `{cond}` the condition, `{other}` another one, `{f}` and `{g}` are features, `{t}` is a
    number, `{x}` the observation, `{label}` an action, `{fn}` the function that decides, `{end}` the end
    of the file's names.
    """

    name: str
    kind: str  # "constant", "condition" or "statement"
    text: str
    before: str = ""  # what stands before the function that decides
    after: str = ""  # what stands at the end of the file
    rewrite: Callable[[str], str] | None = None  # of the whole text


def put(template: str, values: dict[str, str]) -> str:
    """A template with what it names."""
    for key, value in values.items():
        template = template.replace(f"{{{key}}}", value)
    return template


class Draft:
    """Draws from a seed; at the place that a step names, what the step says."""

    def __init__(self, seed: int, language: str, step: Step | None = None, place: int = -1) -> None:
        self.seed, self.rng = seed, random.Random(f"{language} {seed}")
        self.beside = random.Random(f"{language} beside {seed}")  # what a step draws
        self.step, self.place = step, place
        self.places: Counter[str] = Counter()
        self.taken = False
        self.replaced = ""
        self.last = ""
        self.counted = 0
        self.conditions: list[str] = []  # variables
        self.scaled: list[str] = []
        self.quiet = 0  # above 0 while a step is drawn, which has no places of its own

    def spot(self, kind: str, text: str) -> str:
        """The text, or what the step has instead of it."""
        if self.quiet:
            return text
        number = self.places[kind]
        self.places[kind] += 1
        if self.step is None or self.step.kind != kind or number != self.place:
            return text
        self.taken = True
        self.replaced = text if "self." not in text else "0.5"  # outside of a method
        return self.fill(self.step.text, text)

    def fill(self, template: str, text: str) -> str:
        """A step's text with what it names."""
        names = {key: f"{{{key}}}" in template for key in ("other", "f", "g", "t", "label")}
        own, self.rng = self.rng, self.beside
        self.quiet += 1
        values = {"c": text, "cond": text, "fn": self.agent, "x": self.given, "end": self.end}
        values |= {"other": self.compare()} if names["other"] else {}
        chosen = self.beside.sample(self.features, min(2, len(self.features)))
        values |= {"f": chosen[0].text, "g": chosen[-1].text, "t": self.literal()}
        values |= {"label": self.action()} if names["label"] else {}
        self.quiet -= 1
        self.rng = own
        return put(template, values)

    # what a language draws

    agent = ""
    given = ""
    end = ""  # of names of the file
    features: tuple[Feature, ...] = ()
    statements: tuple[str, ...] = ()  # names of their methods
    shares: tuple[int, ...] = ()  # how often each is drawn
    joint = ""  # between the stem of a name and its number
    leaving = ""  # what returns an action
    idle = ""  # a statement that does nothing: where a step may stand

    def text(self) -> str:
        """The whole source."""
        raise NotImplementedError

    def compare(self) -> str:
        """A comparison of features."""
        raise NotImplementedError

    def literal(self) -> str:
        """A number as text."""
        raise NotImplementedError

    def action(self) -> str:
        """What a path returns."""
        raise NotImplementedError

    def another(self, actions: list[str]) -> str:
        """An action that is not the last one drawn: neighbouring leaves that are alike say nothing."""
        self.last = self.rng.choice([each for each in actions if each != self.last] or actions)
        return self.last

    def fresh(self, stem: str) -> str:
        """A name that nothing else has."""
        self.counted += 1
        return f"{stem}{self.joint}{self.counted}"

    def returning(self, depth: int) -> list[str]:
        """Statements that return on every path."""
        if depth <= 0:
            return [self.leaving.format(self.action())]
        kind = self.rng.choices(self.statements, self.shares)[0]
        before = self.spot("statement", self.idle).split("\n") if self.chance(0.15) else []
        return [*before, *getattr(self, f"_{kind}")(depth)]

    def within(self, depth: int) -> list[str]:
        """Such statements in a block, whose variables end with it."""
        kept = list(self.conditions), list(self.scaled)
        lines = [INDENT + line for line in self.returning(depth)]
        self.conditions, self.scaled = kept
        return lines

    def source(self) -> str:
        """The text, written anew where its step says so."""
        text, step = self.text(), self.step
        return step.rewrite(text) if step is not None and step.rewrite is not None and self.taken else text

    def chance(self, share: float) -> bool:
        """True in that share of cases."""
        return self.rng.random() < share


def take(make: Callable[[int, Step | None, int], tuple[Draft, Program]], seed: int, steps: tuple[Step, ...]) -> Program:
    """The program of a seed with one step out of the subset."""
    draft = make(seed, None, -1)[0]
    places, rng = draft.places, random.Random(f"step {seed}")
    known = [each for each in steps if places[each.kind]]
    step = rng.choice(known)
    while "{x}[" in step.text and len(draft.features) < 2:  # which looks for a second number
        step = rng.choice(known)
    return make(seed, step, rng.randrange(places[step.kind]))[1]
