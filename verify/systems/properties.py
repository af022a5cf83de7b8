"""Claims about a system, from the `[[claim]]` tables of a world file or of a file of their own.

Does: reads names, regions, steps and formulas; spells a claim from its data alone; numbers beside a feature as the
  agents compare them; `out(AGENT).OUTPUT` as the input that it is, and each comparison with an input as one for each
  action; `robust`, that an output changes little where observations are a little off, as a formula about an agent and
  its copy, which observes with errors.
Assumes: the names of a statement, and the profile whose actions formulas speak of; a copy acts like its agent and
  observes each feature as it is plus a variable of its own, `COPY.FEATURE`.
Does not: decide. Formulas are parsed, never evaluated.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import inf

import numpy as np

from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import NO_CHILD, NO_FEATURE, ActionSpec, AgentPolicy, PolicyProfile, Tree
from codegen.numbers import nearest_number, neighbour
from verify.claims.catalogue import read_call
from verify.claims.files import CLAIMS, Table, properties, read_each
from verify.claims.formula import (
    Acts,
    And,
    Formula,
    Goal,
    Linear,
    Not,
    Or,
    below,
    conjunction,
    coordinates,
    disjunction,
    negate,
)
from verify.claims.region_files import is_list, is_table
from verify.claims.terms import Compared, read_as_compared
from verify.claims.views import UNLIKE
from verify.claims.written import StatedFormula, Vocabulary, read_statement
from verify.decimals import MAX_PLACES, number, plain
from verify.language.units import Typed
from verify.systems.claims import MAX_STEPS, SAYS, CurvedClaim, Denied, Pattern, SystemClaim, atom
from verify.systems.curves import Curves, name_next_values, without_curves, without_next
from verify.systems.enclosures import list_curved
from verify.systems.expressions import Affine, Interval, Number, affine, names
from verify.systems.files import region_of, region_parts
from verify.systems.statement import Agent, Statement
from verify.systems.system import HalfSpace, Measure, Polytope, box_of, is_empty
from verify.systems.values import ADVICE, as_list, as_table, count, flat, only, text
from verify.systems.values import table as table_of
from verify.toml_places import Place, parse

PATTERNS = {pattern.value: pattern for pattern in Pattern}
PLAYED = 200  # steps in which counterexamples of `always` are looked for
ROBUST, OF_ROBUST = "robust", ("agent", "output", "eps", "most")
KEYS = (
    "name",
    "label",
    "region",
    "steps",
    "by",
    "formula",
    "at_samples",
    "cuts",
    "assuming",
    "invariant",
    *OF_ROBUST,
)
FOR_EVER = ("assuming", "invariant")  # parameters of claims for ever
MAX_CUTS = 1_000  # of a range
OFF = "_off"  # ends the name of a copy that observes with errors


def ensure_claims(statement: Statement, where: str) -> int:
    """Counts the claims of a world file. InputError with the place of the first fault."""
    place = replace(statement.place, name=where)
    return len(_ClaimReader.of_file(statement).read(statement.properties, place)) if statement.properties else 0


def claims_of(statement: Statement, profile: PolicyProfile, where: str) -> tuple[SystemClaim, ...]:
    """The claims of a world file. InputError with the places of all that is wrong."""
    return _ClaimReader.of(statement, profile).read(statement.properties, replace(statement.place, name=where))


def claims_in(source: str, statement: Statement, profile: PolicyProfile, where: str) -> tuple[SystemClaim, ...]:
    """The claims of a file of claims, likewise."""
    document, place = parse(source, where, "not a readable file of claims", ADVICE)
    only(document, CLAIMS, place)
    return _ClaimReader.of(statement, profile).read(document, place)


def claims_said(calls: Iterable[str], statement: Statement, profile: PolicyProfile) -> tuple[SystemClaim, ...]:
    """The claims of calls such as `avoids(region={box={x=[1, 2]}}, steps=25)`, as if a file had them."""
    reader = _ClaimReader.of(statement, profile)
    return tuple(reader.claim(read_call(each), Place(f"--claim {escape_text(each)}", "")) for each in calls)


def parse_written(claim: SystemClaim, statement: Statement, profile: PolicyProfile) -> Formula | None:
    """The formula of a claim about decisions as it was written, over variables, outputs and actions; None where it has
    curves or next values.
    """
    reader = _ClaimReader.of(statement, profile)
    curves = Curves(statement.names)
    found = read_observed(name_inputs(claim.written), reader.vocabulary(curves), lambda at: f"column {at + 1}").formula
    return None if curves.found or coordinates(found) & reader.following.keys() else found


class _ClaimReader:
    """Reads claims about a system and agents that act in it."""

    def __init__(self, statement: Statement, acting: Mapping[str, AgentPolicy]) -> None:
        self._statement, self._acting = statement, acting
        known = statement.names.known  # without the roundings of agents, which nobody names
        stated = [each for each in statement.system.variables if each.name in known]
        self.following = name_next_values(stated) if statement.rules else {}  # whose next value each name of one is

    @staticmethod
    def of(statement: Statement, profile: PolicyProfile) -> "_ClaimReader":
        """The reader of claims about the agents of a profile."""
        return _ClaimReader(statement, {policy.agent: policy for policy in profile.agents})

    @staticmethod
    def of_file(statement: Statement) -> "_ClaimReader":
        """The reader of claims about the agents of a file, with all of their actions and a tree that nobody asks."""
        leaf = Tree(*(np.array([number]) for number in (NO_FEATURE, 0, NO_CHILD, NO_CHILD, 0)))
        actions = {agent.name: tuple(ActionSpec(name, None) for name in agent.actions) for agent in statement.agents}
        acting = {
            agent.name: AgentPolicy(agent.name, agent.team, (), actions[agent.name], leaf) for agent in statement.agents
        }
        return _ClaimReader(statement, acting)

    def read(self, document: Table, file: Place) -> tuple[SystemClaim, ...]:
        """The claims of a document. InputError with the places of all that is wrong."""
        return tuple(read_each(properties(document, file), self.claim))

    def claim(self, table: Table, where: Place) -> SystemClaim:
        """The claim of one table."""
        only(table, KEYS, where)
        label = text(table.get("label", ""), where / "label")
        place = where / "region"
        stated, regions = self._regions(table, "region", where)
        words = " or ".join(_words(each, place) for each in stated)
        name = text(table.get("name", Pattern.DECIDES.value), where / "name")
        only({name: None}, (*PATTERNS, ROBUST), where, "claim")
        if name == ROBUST:
            return self._robust(table, SystemClaim(Pattern.DECIDES, regions, label=label, region=words), where)
        pattern = PATTERNS[name]
        strange = ("formula", "cuts") if pattern is not Pattern.DECIDES else ("steps", "by", "at_samples", *FOR_EVER)
        for key in (*strange, *OF_ROBUST):
            if key in table:
                raise InputError(f"{name} has no {key}", where / key, "remove it")
        if pattern is Pattern.DECIDES:
            words = " or ".join(_words(each, place, self._beyond(each, where)) for each in stated)
            region = f"with {words}" if words else ""
            return self._decides(table, SystemClaim(pattern, regions, label=label, region=region), where)
        if not regions:
            raise InputError(f"{name} needs a region", where, "write region = { box = { x = [0, 1] } }")
        if not self._statement.moves:
            what = f"{name} is about episodes, and the file does not say how the state moves"
            raise InputError(what, where, "add [dynamics.next], or write a formula")
        steps, by = self._steps(table, pattern, where)
        claim = SystemClaim(
            pattern, regions, steps, by, at_samples=self._times(table, where), label=label, region=words
        )
        if not claim.says.ever:
            for key in FOR_EVER:
                if key in table:
                    raise InputError(f"{claim.name} has no {key}", where / key, "remove it, or ask for always")
            return claim
        stated, assuming = self._regions(table, "assuming", where)
        assumed = " or ".join(_words(each, where / "assuming") for each in stated)
        invariant = self._regions(table, "invariant", where)[1]
        for index, region in enumerate(invariant):
            if is_empty(region):
                at = where / "invariant" / index
                raise InputError("no state lies in this region", at, "remove it, or widen it")
        lowered = self._statement.acting.values()
        roundings = box_of({each.variable: each.range for one in lowered for each in one.roundings})
        held = tuple((*region, *roundings) for region in invariant)  # an invariant bounds all that moves what it names
        return replace(claim, assuming=assuming, assumed=assumed, invariant=held)

    # --- claims about episodes

    def _regions(self, table: Table, key: str, where: Place) -> tuple[Sequence[object], tuple[Polytope, ...]]:
        """One region or a list of them, as they are written and as data; none where the key is not there."""
        given, place = table.get(key, []), where / key
        stated = [given] if is_table(given) else as_list(given, place)
        places = [place / index for index in range(len(stated))] if is_list(given) else [place]
        names = self._statement.names
        return stated, tuple(region_of(each, names, at) for each, at in zip(stated, places, strict=True))

    def _steps(self, table: Table, pattern: Pattern, where: Place) -> tuple[int, int]:
        """The steps of a claim about episodes, of one for ever those in which counterexamples are looked for; `by`."""
        usual, says = self._statement.system.steps, SAYS[pattern]
        if pattern is Pattern.REACHES_AND_STAYS and "by" not in table:
            raise InputError(f"{pattern.value} needs the step by which the region is reached", where, "write by = 20")
        if says.first != "by" and "by" in table:
            what, advice = f"{pattern.value} has no by", "remove it, or ask for reaches_and_stays or always"
            raise InputError(what, where / "by", advice)
        if pattern is Pattern.ALWAYS:
            if self._statement.system.flow is not None:
                what = "always is about steps, and the system moves in continuous time"
                raise InputError(what, where, "ask for stays_in with a number of steps")
            later = count(table["by"], where / "by", MAX_STEPS) if "by" in table else 0
            usual = min(MAX_STEPS, later + max(usual, PLAYED))
        steps = count(table.get("steps", usual), where / "steps", MAX_STEPS)
        return steps, count(table["by"], where / "by", steps) if "by" in table else 0

    def _times(self, table: Table, where: Place) -> bool | None:
        """Returns True if a claim is about samples only; None where the system moves in steps."""
        given = table.get("at_samples", False)
        if self._statement.system.flow is None:
            if "at_samples" in table:
                raise InputError("the system moves in steps, so it has no samples", where / "at_samples", "remove it")
            return None
        if not isinstance(given, bool):
            raise InputError("not true or false", where / "at_samples", "write at_samples = true, or leave it out")
        return given

    # --- claims about decisions

    def _robust(self, table: Table, begun: SystemClaim, where: Place) -> SystemClaim:
        """The claim |out(x + e) - out(x)| <= most, wherever each |e| is at most its `eps`: an output changes little
        where observations are a little off. It is a formula about two agents.
        """
        only(table, ("name", "label", "region", *OF_ROBUST), where)
        statement, agent = self._statement, text(table.get("agent", ""), where / "agent")
        copy = copy_called(agent)
        agents = {each.name: each for each in statement.agents}
        doubled = [each.like for each in statement.agents if each.name == copy_called(each.like)]
        if agent not in doubled:
            raise UnknownNameError("agent with a copy", agent, doubled, where / "agent")
        output = text(table.get("output", ""), where / "output")
        if output not in agents[agent].outputs:
            raise UnknownNameError("output", output, agents[agent].outputs, where / "output")
        if "most" not in table:
            raise InputError(f"{ROBUST} needs the largest change of the output", where, "write most = 0.2")
        most = number(table["most"], where / "most")
        added = set(statement.acting[agent].features) if agent in statement.acting else set[str]()
        features = {name: each for name, each in statement.system.features[agent].items() if name not in added}
        errors = errors_of(table, features, where)
        _ensure_copied(statement, agent, features, errors, where)
        bounds = {f"{copy}.{name}": (-size, size) for name, size in errors.items()}
        for name in statement.names.known:
            if name.startswith(f"{copy}."):
                bounds.setdefault(name, (Fraction(0), Fraction(0)))
        off = box_of(bounds)
        regions = tuple((*each, *off) for each in begun.regions) or (off,)
        told = ", ".join(f"{name} off by up to {plain(size)}" for name, size in errors.items())
        words = f"with {begun.region and f'{begun.region} and '}{told}"
        formula = f"|out({copy}).{output} - out({agent}).{output}| <= {plain(most)}"
        begun = replace(begun, regions=regions, region=words, label=begun.label or f"robust: {formula}")
        return self._decides({"formula": formula}, begun, where)

    def vocabulary(self, curves: Curves) -> Vocabulary:
        """The names that formulas may use."""
        statement, names = self._statement, self._statement.names
        constants = {
            name: Typed(number.value.value, number.unit)
            for name, number in names.meant.items()
            if isinstance(number.value, Number)
        }
        following = {name: names.known[whose] for name, whose in self.following.items()}
        units = {**names.known, **statement.inputs, **following}
        giving = {each.name for each in statement.agents if each.outputs}  # what they do is `out(A)`, and no action
        return Vocabulary(
            tuple(units),
            {name: policy for name, policy in self._acting.items() if name not in giving},
            units=units,
            constants=constants,
            modes=names.modes,
            curves=curves,
            observed=find_numbers(statement, self._acting.values()) if statement.observed else {},
        )

    def _decides(self, table: Table, begun: SystemClaim, where: Place) -> SystemClaim:
        """A claim about decisions with its formula; one with next values or curves becomes one without, which implies
        it.
        """
        if "formula" not in table:
            raise InputError("a claim needs a name or a formula", where, f"names: {', '.join((*PATTERNS, ROBUST))}")
        place, curves = where / "formula", Curves(self._statement.names)
        written = text(table["formula"], place)
        vocabulary = self.vocabulary(curves)
        ensure_choosing(written, self._statement, place)
        named = name_inputs(written)
        try:
            stated = read_observed(named, vocabulary, lambda offset: place.of_offset(written, offset))
        except InputError as error:  # the text as the user wrote it, above the same mark
            error.where = error.where.replace(named, written)
            raise
        bent = frozenset[str]().union(*map(names, curves.found.values()))
        cuts: dict[str, int] = {}
        for name, value in flat(table_of(table, "cuts", where), where / "cuts").items():
            only({name: None}, sorted(bent), where / "cuts", "variable of a product or function")
            cuts[name] = count(value, where / "cuts" / name, MAX_CUTS)

        def decides(formula: Formula, words: str) -> SystemClaim:
            claim = of_actions(formula, self._statement, self._acting, place)
            return self._straighten(replace(begun, written=words), claim, curves, cuts, place)

        conditions = tuple(
            Denied(spell_inputs(each.words, self._statement), decides(negate(each.formula), f"not ({each.words})"))
            for each in stated.conditions
        )
        return replace(decides(stated.formula, written), conditions=conditions, rounded=tuple(stated.rounded.items()))

    def _straighten(
        self, begun: SystemClaim, claim: Formula, curves: Curves, cuts: Mapping[str, int], where: Place
    ) -> SystemClaim:
        """The claim of a formula over variables, next values and curves, by formulas without the latter two."""
        system, stronger, weaker = self._statement.system, claim, claim
        if any(name in self.following for name in coordinates(claim)):
            exact = not any(map(list_curved, self._statement.rules))
            stronger, weaker = without_next(claim, system.pieces, self.following, self._acting, exact, where)
        enclosures = ()
        if curves.found:
            bending = curves.found, system.variables, cuts, where
            stronger, _, enclosures = without_curves(stronger, *bending)
            _, weaker, _ = without_curves(weaker, *bending)
        if stronger == weaker and not enclosures:  # else the checker shows what made them equal
            return replace(begun, formula=stronger)
        return replace(begun, formula=stronger, curved=CurvedClaim(replace(begun, formula=weaker), enclosures))

    def _beyond(self, region: object, where: Place) -> dict[str, str]:
        """Returns words for bounds that leave a range, as a claim about decisions is about states of the ranges."""
        bounds, _ = region_parts(as_table(region, where), self._statement.names, where)
        words: dict[str, str] = {}
        for one in self._statement.system.variables:
            low, high = bounds.get(one.name, one.range)
            least, most = max(low, one.range[0]), min(high, one.range[1])
            if least > most:
                words[one.name] = " (no state of the ranges)"
            elif (least, most) != (low, high):
                words[one.name] = f" (of the ranges [{plain(least)}, {plain(most)}])"
        return words


def _words(region: object, place: Place, beyond: Mapping[str, str] | None = None) -> str:
    """A region that was read, in words. `beyond`: what is said of variables whose bounds leave their range."""
    document = as_table(region, place)
    bounds = flat(table_of(document, "box", place), place).items()
    said = [
        (f"{name} in [{', '.join(map(str, ends))}]" if is_list(ends) else f"{name} = {ends}")
        + (beyond or {}).get(name, "")
        for name, ends in bounds
    ]
    return " and ".join([*said, *map(str, as_list(document.get("where", []), place))]) or "any state"


# --- an output that changes little


def copy_called(agent: str) -> str:
    """Returns the name of the copy of an agent that observes with errors."""
    return agent + OFF


def errors_of(table: Mapping[str, object], features: Mapping[str, object], where: Place) -> dict[str, Fraction]:
    """The largest error of each feature that `eps` allows: one number for all of `features`, or a table."""
    if "eps" not in table:
        raise InputError(f"{ROBUST} needs the largest error of a feature", where, "write eps = 0.01")
    given, place = table["eps"], where / "eps"
    if is_table(given):
        stated = as_table(given, place)
        only(stated, features, place, "feature")
        errors = {name: number(value, place / name) for name, value in stated.items()}
    else:
        errors = dict.fromkeys(features, number(given, place))
    for name, most in errors.items():
        if most < 0:
            raise InputError(f"the error of {name} is below 0", place, "write the largest absolute value")
    return errors


def _ensure_copied(
    statement: Statement, agent: str, names: Iterable[str], errors: Mapping[str, Fraction], where: Place
) -> None:
    """InputError where a copy observes anything but the features `names` of its own, those of `errors` with them."""
    features, copy = statement.system.features, copy_called(agent)
    known = {each.name: each.range for each in statement.system.variables}
    for name in names:
        variable, size = f"{copy}.{name}", errors.get(name)
        own, off = features[agent][name], features[copy][name]
        erring = [own.form.plus(Affine.of({variable: Fraction(1)}))] if variable in known else []
        allowed = erring if size is not None else [own.form, *erring]  # an error that is not named is bounded to 0
        if off.form not in allowed or off.measure is not own.measure or off.bounds != own.bounds:
            if size is None:
                advice = "observe the same, or name it in eps"
                raise InputError(f"{copy} does not observe {name} as {agent} does", where, advice)
            advice = f'state it: {name} = "... + {variable}", with {variable} among the variables'
            raise InputError(f"{copy} does not observe {name} with an error {variable}", where, advice)
        if size is not None and not known[variable][0] <= -size <= size <= known[variable][1]:
            raise InputError(f"errors up to {plain(size)} are not within the range of {variable}", where / "eps")


# --- what agents compare and give


def find_numbers(statement: Statement, policies: Iterable[AgentPolicy]) -> dict[str, str]:
    """Returns what the agents that observe a variable compare: float32 or float64; UNLIKE where some compare either."""
    by_variable: dict[str, str] = {}
    for policy in policies:
        read = statement.acting.get(policy.agent)
        numbers = policy.numbers if read is None else read.real.numbers
        for feature in statement.system.features[policy.agent].values():
            name = next((name for name, _ in feature.form.terms), "")
            if feature.measure is Measure.VALUE and feature.form == Affine.of({name: Fraction(1)}):
                by_variable[name] = UNLIKE if by_variable.get(name, numbers) != numbers else numbers
    return by_variable


def read_observed(text: str, vocabulary: Vocabulary, where: Callable[[int], str]) -> StatedFormula:
    """Reads a text of which the vocabulary knows the features. InputError as of `read_statement`."""
    known = {
        name: compare_variable(name, numbers) for name, numbers in vocabulary.observed.items() if numbers != UNLIKE
    }
    stated = read_statement(text, vocabulary, where)
    return stated.read_by(partial(read_as_compared, known=known)) if known else stated


def compare_variable(name: str, numbers: str) -> Compared:
    """Returns the comparison of a variable by agents, whose exact value is rounded once, to the nearest float."""

    def cut(threshold: float) -> tuple[Formula, Formula]:
        end = (Fraction(threshold) + Fraction(float(neighbour(threshold, inf, numbers)))) / 2
        at_most = Linear(((Fraction(1), name),), end, nearest_number(end, numbers) > threshold)
        return at_most, negate(at_most)

    return Compared(numbers, cut)


GIVEN = re.compile(r"\bout\(\s*([A-Za-z][A-Za-z0-9_]*)\s*\)\s*\.\s*([A-Za-z_][A-Za-z0-9_]*)")

CHOSEN = re.compile(r"\bacts\(\s*'?([A-Za-z][A-Za-z0-9_-]*)'?\s*\)")


def name_inputs(text: str) -> str:
    """The text with `out(AGENT).OUTPUT` as `AGENT.OUTPUT`, of the same length, so that places in it stay."""
    return GIVEN.sub(lambda match: f"{match[1]}.{match[2]}".ljust(len(match[0])), text)


def spell_inputs(text: str, statement: Statement) -> str:
    """The text with `AGENT.OUTPUT` as `out(AGENT).OUTPUT`."""
    for agent in statement.agents:
        for output in agent.outputs:
            text = re.sub(rf"\b{re.escape(agent.name)}\.{re.escape(output)}\b", f"out({agent.name}).{output}", text)
    return text


def ensure_choosing(text: str, statement: Statement, where: Place) -> None:
    """InputError where a text asks for the action of an agent that gives numbers."""
    giving = {each.name: each.outputs for each in statement.agents if each.outputs}
    for match in CHOSEN.finditer(text):
        if match[1] in giving:
            what = f"{match[1]} gives numbers, and takes no action"
            advice = " or ".join(f"out({match[1]}).{output}" for output in giving[match[1]])
            raise InputError(what, where.of_offset(text, match.start()), f"compare {advice}")


def of_actions(formula: Formula, statement: Statement, acting: Mapping[str, AgentPolicy], where: Place) -> Formula:
    """The formula without inputs. InputError for an input that some action sets to what is not affine."""
    if isinstance(formula, Linear):
        return _put_settings(formula, statement, acting, where)
    if isinstance(formula, And):
        return conjunction(*(of_actions(part, statement, acting, where) for part in formula.parts))
    if isinstance(formula, Or):
        return disjunction(*(of_actions(part, statement, acting, where) for part in formula.parts))
    return Not(of_actions(formula.part, statement, acting, where)) if isinstance(formula, Not) else formula


def _put_settings(formula: Linear, statement: Statement, acting: Mapping[str, AgentPolicy], where: Place) -> Formula:
    """One comparison: whatever the action is, the comparison of what it sets."""
    agent = next((each for _, name in formula.terms for each in statement.agents if name in each.inputs), None)
    if agent is None:
        return formula
    own = {name: weight for weight, name in formula.terms if name in agent.inputs}
    parts: list[Formula] = []
    for place, action in enumerate(acting[agent.name].actions):
        form = Affine.of({name: weight for weight, name in formula.terms if name not in own}, -formula.bound)
        for name, weight in own.items():
            added = affine(agent.actions[action.name][name])
            if added is None:
                what = f"{name} is not affine in the state where {agent.name} does {action.name}"
                raise InputError(what, where, "compare what is affine")
            form = form.plus(added, Fraction(weight))
        kept = below(dict(form.terms), -form.constant, formula.strict)
        inner = of_actions(kept, statement, acting, where)
        beyond = [each for name in own for each in _cut_off(statement, agent, action.name, name)]
        parts.append(disjunction(Not(Acts(agent.name, place)), *beyond, inner))
    return conjunction(*parts)


def _cut_off(statement: Statement, agent: Agent, action: str, name: str) -> Iterator[Formula]:
    """The states in which an action would set an output beyond its bounds: no real agent takes it there."""
    form = affine(agent.actions[action][name])
    if agent.name not in statement.acting or form is None or not form.terms:
        return
    real = statement.acting[agent.name].real
    spec = next((each for each in real.outputs if f"{agent.name}.{each.name}" == name), None)
    if spec is None:  # what an action sets is not cut
        return
    if spec.high is not None:
        yield below({each: -weight for each, weight in form.terms}, form.constant - Fraction(spec.high), strict=True)
    if spec.low is not None:
        yield below(dict(form.terms), Fraction(spec.low) - form.constant, strict=True)


# --- a claim in words from its data alone


EVERY_FLOAT = 1_074  # places of a float64 at most: formulas take no fractions of numbers that large


def spell_claim(claim: SystemClaim, actions: Mapping[str, Sequence[str]], ranges: Mapping[str, Interval]) -> str:
    """The claim in words that are made from its data alone, as a file's own words may say anything. `actions`: of each
    agent, by number. `ranges`: of the system's variables, which bound what a claim about decisions says.
    """
    regions = " or ".join(" and ".join(map(_condition, region)) or "any state" for region in claim.regions)
    if not claim.about_decisions:
        return replace(claim, region=regions).sentence
    named = coordinates(claim.formula).union(*(coordinates(atom(half)) for region in claim.regions for half in region))
    bounds = ", ".join(
        f"{name} in [{plain(low)}, {plain(high)}]" for name, (low, high) in ranges.items() if name in named
    )
    where = "of the ranges" + (f" ({bounds})" if bounds else "") + (f" with {regions}" if regions else "")
    return f"in every state {where}, {spell_formula(claim.formula, actions)}"


def _condition(half: HalfSpace, places: int = MAX_PLACES) -> str:
    """An inequality whose first factor is 1. `places`: of decimals at most, what needs more is a fraction."""
    lead = half.form.terms[0][1] if half.form.terms else Fraction(1)
    form = Affine().plus(half.form, 1 / lead)
    sign = f"{'<' if lead > 0 else '>'}{'' if half.strict else '='}"
    return f"{_sum(form.terms, places)} {sign} {plain(-form.constant, places)}"


def _sum(terms: Sequence[tuple[str, Fraction]], places: int) -> str:
    text = ""
    for name, factor in terms:
        times = name if abs(factor) == 1 else f"{plain(abs(factor), places)}*{name}"
        sign = "-" if factor < 0 else "+"
        text += f" {sign} {times}" if text else times if factor > 0 else f"-{times}"
    return text or "0"


def spell_formula(formula: Formula, actions: Mapping[str, Sequence[str]]) -> str:
    """A formula in the language of files of claims. `actions`: of each agent, by number."""
    match formula:
        case Linear(terms, bound, strict):
            half = HalfSpace(Affine.of({name: factor for factor, name in terms}, -bound), strict)
            return _condition(half, EVERY_FLOAT)
        case Acts(agent, action):
            return f"acts({agent}) == {actions[agent][action]}"
        case Not(part):
            return f"not {spell_formula(part, actions)}"
        case And(()) | Or(()):
            return "true" if isinstance(formula, And) else "false"
        case And(parts) | Or(parts):
            joined = f" {'and' if isinstance(formula, And) else 'or'} ".join(
                spell_formula(part, actions) for part in parts
            )
            return f"({joined})"
        case Goal(landmark):
            return f"goal == {landmark}"
