"""C of others as decision trees, one for each function that decides: written by hand, or by another program.

Does: reads a file, chooses its functions, follows each with the core of all importers of code (symbolic/).
Assumes: what pcpp and pycparser read is what a compiler reads; a compiler without fast-math.
Does not: compile or run anything. What depends on more than the observation is refused with its line.

A function that another one calls is a part of that one; `main`, functions without parameters and those that only print
are skipped. A function whose floating numbers are all `double` compares float64, and so does one of both types; one of
`float` and whole numbers compares float32.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from pycparser import CParser, c_ast
from pycparser.c_parser import ParseError

from codegen.errors import InputError, escape_text
from codegen.importers.c.arithmetic import PRINTING
from codegen.importers.c.compiled import ACT, DECLARING, Asked, ask_compiler
from codegen.importers.c.kinds import (
    STANDARD,
    Inputs,
    Kind,
    Number,
    Object,
    Outside,
    Place,
    Pointer,
    Record,
    Reference,
    Symbol,
    Type,
    Value,
)
from codegen.importers.c.machine import ADVICE, DONE, Machine, collect_assigned, is_const, items_of, parameters_of, walk
from codegen.importers.c.text import Expanded, expand_source
from codegen.importers.c.tree import ENTRIES, find_calls, hoist_statics, is_read, list_callers, list_parts, list_setters
from codegen.importers.reading import NOTHING, Kept, Origin, Said
from codegen.importers.symbolic.feature import Feature
from codegen.importers.symbolic.memory import FINITE, RESETS, Memories, Memory, RemembersError
from codegen.importers.symbolic.paths import OUTSIDE, STATE_ADVICE, Described, Growth, origin_of
from codegen.importers.symbolic.statements import Scope, link_statements
from codegen.ir import Update
from codegen.memory import MAX_VALUE

KIND = "if/else C"
ADJACENT = re.compile(r"(?<![\w#])([A-Za-z_]\w*)(?=[ \t\n]+[A-Za-z_])")
TEXT = re.compile(r'^#.*$|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\'', re.MULTILINE)
KEYWORDS = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while _Bool""".split()  # noqa: SIM905
)
CASES = (c_ast.Switch, c_ast.Case, c_ast.Default)


def from_c(content: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The tree of each function of a C file that decides, by the function's name. InputError with the line for
    everything that is not read.
    """
    text = None
    try:
        text = expand_source(content, where, said.beside)
        types = [*STANDARD]
        if text.missing:  # names that can only be types of headers that are not there, since another name follows them
            found = {each[1] for each in ADJACENT.finditer(TEXT.sub('""', text.text))}
            types += sorted(name for name in found - KEYWORDS if name not in STANDARD)
        parsed = CParser().parse("".join(f"typedef int {each};" for each in types) + f"\n{text.text}", where)
        del parsed.ext[: len(types)]
        for each in walk(parsed) if text.names else ():
            if isinstance(each, DECLARING) and each.coord and each.name in text.names:
                what = f"{escape_text(each.name)} is declared, and a macro of the file, too"
                raise InputError(what, f"{where}, line {each.coord.line}", "give each a name")
        # no switch leads into a loop or another statement within it: a case is sought in its own block
        nodes: list[Any] = [each for each in walk(parsed) if isinstance(each, CASES)]
        own = {id(item) for each in nodes if isinstance(each, c_ast.Switch) for item in items_of(each)}
        for each in nodes:
            if not isinstance(each, c_ast.Switch) and id(each) not in own:
                advice = "write the cases in the block of the switch itself"
                raise InputError("a case stands within another statement", f"{where}, line {each.coord.line}", advice)
        find_calls(parsed, said.reads, where, acting=False)
        find_calls(parsed, said.acts, where, acting=True)
        hoisted = hoist_statics(parsed)
        origins = {name: _origin(name, parsed, text, where, said, hoisted) for name in _deciding(parsed, where, said)}
        return ask_compiler(origins, parsed, text, where, said)
    except ParseError as error:
        at = re.match(r"(.*?):(\d+):\d+: (.*)", str(error), re.DOTALL)
        place, what = (f"{where}, line {at[2]}", at[3]) if at else (where, str(error))
        advice = f"{ADVICE}; {text.missing[0]} is not there" if text and text.missing else ADVICE
        raise InputError(f"not C that is understood: {escape_text(what)[:100]}", place, advice) from None
    except RecursionError:
        raise InputError("the file is nested too deeply", where, "simplify it first") from None
    finally:
        walk.cache_clear()


# --- functions that decide


def _deciding(parsed: Any, where: str, said: Said) -> list[str]:
    """The functions that no other one calls, that no table holds, and that are given something to decide about."""
    functions = {each.decl.name: each for each in parsed.ext if isinstance(each, c_ast.FuncDef)}
    if said.wanted in functions:
        return [said.wanted]
    if said.acts and (callers := list_callers(functions, said.acts)):
        return callers
    deciding = [name for name in functions if name not in ENTRIES and _answers(name, functions)]
    deciding = [name for name in deciding if not _only_resets(name, functions)] or deciding
    if not deciding:
        advice = "write one function per agent, of an observation, that returns its action"
        raise InputError("the file has no function that decides", where, advice)
    called = {inner for name in deciding for inner in _names(functions[name].body) - {name}}
    called |= {name for each in parsed.ext if isinstance(each, c_ast.Decl) and each.init for name in _names(each.init)}
    roots = [name for name in deciding if name not in called] or deciding
    roots = [name for name in roots if not _names_only(functions[name])] or roots
    return [name for name in roots if "static" not in functions[name].decl.storage] or roots  # for whom, nobody knows


def _only_resets(name: str, functions: Mapping[str, Any]) -> bool:
    """Returns True if a function is called so that it resets the one struct that it is given, and returns nothing."""
    given, result = parameters_of(functions[name]), _words_of(functions[name].decl.type.type)
    return bool(RESETS.fullmatch(name)) and result == ["void"] and len(given) == 1


def _names(node: Any) -> set[str]:
    """The names of variables and functions below a node."""
    return {each.name for each in walk(node) if isinstance(each, c_ast.ID)}


def _answers(name: str, functions: Mapping[str, Any]) -> bool:
    """Returns True if a function is given something, and returns something or may write it to a parameter."""
    if _words_of(functions[name].decl.type.type) == ["void"]:
        return bool(_collect_written(name, functions, frozenset()))
    return bool(parameters_of(functions[name]))


def _words_of(node: Any) -> list[str]:
    """The words of a type that is no pointer, array or struct."""
    return list(getattr(node.type, "names", ())) if isinstance(node, c_ast.TypeDecl) else []


def _collect_written(name: str, functions: Mapping[str, Any], outer: frozenset[str]) -> set[str]:
    """The parameters of a function that something may be written through."""
    node, handed = functions[name], set[str]()
    for each in walk(node.body):
        if isinstance(each, c_ast.Assignment):
            handed |= _names(each.lvalue)
        elif isinstance(each, c_ast.FuncCall) and each.args is not None:
            called = each.name.name if isinstance(each.name, c_ast.ID) else ""
            given, known = each.args.exprs, called in functions and called not in outer
            if known:
                inner = _collect_written(called, functions, outer | {name})
                places = zip(parameters_of(functions[called]), given, strict=False)
                given = [argument for parameter, argument in places if parameter.name in inner]
            for argument in given if called not in PRINTING else ():
                handed |= set() if isinstance(argument, c_ast.ArrayRef | c_ast.StructRef) else _names(argument)
    pointers = [each for each in parameters_of(node) if isinstance(each.type, c_ast.PtrDecl | c_ast.ArrayDecl)]
    return {each.name for each in pointers if each.name in handed and not is_const(each.type.type)}


def _names_only(node: Any) -> bool:
    """Returns True if a function gives a text for an enumerator or a whole number, as for printing."""
    given = [each.type for each in parameters_of(node)]
    words = _words_of(given[0]) if len(given) == 1 else []
    whole = words or (len(given) == 1 and isinstance(getattr(given[0], "type", None), c_ast.Enum))
    return bool(whole and not {"float", "double", "bool", "_Bool"} & set(words)) and isinstance(
        node.decl.type.type, c_ast.PtrDecl
    )


# --- one function, followed


def _collect_escaping(node: Any) -> set[str]:
    """The names of objects that stand below a node as they are, not as a part of an expression that reads them."""
    names = set[str]()
    for each in walk(node):
        sized = isinstance(each, c_ast.UnaryOp) and each.op == "sizeof"
        if not sized and not isinstance(each, c_ast.ArrayRef | c_ast.StructRef):
            names |= {part.name for _, part in each.children() if isinstance(part, c_ast.ID)}
    return names


class _Follower(Machine):
    """Follows a function of a file, on one path after the other. `kept`: variables and parameters that are remembered,
    with what a function calls its own; `setting`: whether members that it sets are taken not to be observed.
    """

    def __init__(
        self, name: str, parsed: Any, text: Expanded, where: str, kept: Mapping[str, str], said: Said, *, setting: bool
    ) -> None:
        super().__init__(f"{where}, function {name}", text.names, contracts=text.contracts)
        self.settled = set[Place]()  # what some path sets of what is remembered
        self.limits = dict[str, None]()  # which observations it takes, where not all, in words
        self.answers = list[Place]()
        pointing = [each for each in parsed.ext if isinstance(each, c_ast.Decl) and not is_const(each)]
        pointing = [each for each in pointing if isinstance(each.type, c_ast.ArrayDecl | c_ast.PtrDecl)]
        self.aliased = aliased = {each.name for each in pointing}  # which may be set through another name
        for each in parsed.ext:
            if isinstance(each, c_ast.FuncDef):
                if each.decl.name in self.functions:
                    self.at(each.decl)
                    raise self.make_error(f"there are two functions {escape_text(each.decl.name)}", "keep one of them")
                self.functions[each.decl.name] = each
                self.changing |= collect_assigned(each)
                self.changing |= aliased & _collect_escaping(each.body) if aliased else aliased
        for each in parsed.ext:
            self.at(each)
            decl = each.decl if isinstance(each, c_ast.FuncDef) else each
            if isinstance(decl, c_ast.Decl):
                if is_const(decl):
                    self.changing.discard(decl.name)
                try:  # what cannot be read is an error only where a decision needs it
                    self.declare(decl)
                except InputError:
                    if decl.name is None:
                        raise
                    self.file.names.pop(decl.name, None)
            elif isinstance(each, c_ast.Typedef | c_ast.Pragma | c_ast.StaticAssert):
                self.value(each)
            else:
                raise self.make_error("only functions, types and constants may stand outside functions", ADVICE)
        self.function = self.functions[name]
        parameters = {each.name: self.parameter(each) for each in parameters_of(self.function)}
        self.reads, self.acts = (dict.fromkeys(each) for each in (said.reads, said.acts))
        for each in self.reads:
            if each in parameters or not isinstance(self.results[each], Kind):
                raise self.make_error(f"{escape_text(each)} is no feature", "read a number, of a name of its own")
        parameters |= {each: self.results[each] for each in self.reads}
        begun, self.resets = self._find_kept(parameters, kept)
        self.inputs = self.observed = Inputs(parameters, self.make_error, tuple(begun))
        if setting:
            self.inputs = self.observed = replace(self.inputs, unseen=self.list_set(kept))
        self.numbers = self.arithmetic.numbers = self.observed.numbers
        self.memories, self.arithmetic.memories = self._begin(begun, kept), len(begun)

    def _find_kept(
        self, parameters: Mapping[str, Type], kept: Mapping[str, str]
    ) -> tuple[dict[Place, tuple[Kind, Value]], list[Any]]:
        """The parts that are remembered, each with its type and what it begins with, and the functions that reset them.
        InputError for other functions that set them, and numbers that are no whole ones.
        """
        begun, resets = dict[Place, tuple[Kind, Value]](), list[Any]()
        self.at(self.function.decl)
        for name in kept:
            setters = list_setters(self.function.decl.name, name, self.functions, name in self.aliased)
            named = [each for each in setters if RESETS.fullmatch(each.decl.name)]
            if len(named) < len(setters) and name not in parameters:
                other = next(each for each in setters if each not in named)
                what = f"{escape_text(kept[name])} is set by {escape_text(other.decl.name)}, too"
                raise self.make_error(what, "have one function set it, or call the other one init or reset")
            resets += [each for each in named if each not in resets]
            if name in parameters:
                given = Inputs(parameters, self.make_error).given(name)
                target = given.target if isinstance(given, Reference) else given
                parts = dict.fromkeys(list_parts(target, self.function.decl.name, self.functions))
            else:
                before = self.file.names[name]
                if not isinstance(before, Object):  # a static variable of a block that hides it
                    raise self.make_error(f"the static variable {escape_text(name)} hides another name", "rename it")
                target = Object(Place(name), before.type)
                parts = dict(zip(target.parts(), map(self.constants.get, _places(before)), strict=True))
                self.file.names[name] = target
            for part, value in parts.items():
                if not isinstance(part.type, Kind) or part.type.floating:
                    what = f"what is remembered is no whole number: {escape_text(_call_part(part.place, kept))}"
                    raise self.make_error(what, STATE_ADVICE)
                begun[part.place] = part.type, value or Number(0, part.type)
        return begun, resets

    def _begin(self, begun: Mapping[Place, tuple[Kind, Value]], kept: Mapping[str, str]) -> Memories:
        """What is remembered, as it begins: by functions that reset it, or else its initial value."""
        for each in self.resets:
            found, self.memory = {}, dict[Place, Value]()
            frame = {one.name: self.new_object(self.parameter(one)) for one in parameters_of(each)}
            for target in frame.values():
                pointed = next(name for name in kept if name in self.observed.parameters)
                self.memory[target.place] = self.observed.given(pointed)
            self.answer(each, link_statements([each.body], Scope(frame, self.file)))
            found, self.memory = self.memory, self.constants
            self.observed.written.clear()  # a reset may set what no decision sets, which is no answer
            begun = {place: (kind, found.get(place, value)) for place, (kind, value) in begun.items()}
        known = list[Memory]()
        for place, (kind, value) in begun.items():
            number = self.arithmetic.plain(value)
            if not isinstance(number, Number):
                raise self.make_error(f"what {_call_part(place, kept)} begins with is not read", "set it to a number")
            widest = max(kind.low, -MAX_VALUE), min(kind.high, MAX_VALUE)
            called = _call_part(place, kept)
            while called in [each.name for each in known]:
                called += "_"
            known.append(Memory(called, int(number.value), widest))
        return Memories(known, self.where)

    def find_read_and_set(self, kept: Mapping[str, str]) -> str:
        """A struct of the caller's that was read, and that the function sets elsewhere; "": there is none."""
        for name in self.observed.parameters:
            given = self.observed.given(name)
            target = given.target if isinstance(given, Reference) else None
            looked = name not in kept and any(place.base == name for place in self.observed.read)
            looked = looked and name in _collect_written(self.function.decl.name, self.functions, frozenset())
            if looked and target is not None and isinstance(target.type, Record):
                return name if list_parts(target, self.function.decl.name, self.functions) else ""
        return ""

    def list_set(self, kept: Collection[str]) -> list[Place]:
        """What may be set and not observed: numbers and members of the caller's structs that the function sets, by
        their names, and all members of those that are remembered.
        """
        name, found = self.function.decl.name, list[Place]()
        for each in _collect_written(name, self.functions, frozenset()) & {*self.observed.parameters}:
            type_, place = self.observed.parameters[each], Place(each)
            if isinstance(type_, Pointer) and isinstance(type_.to, Record | Kind):
                target = Object(place, type_.to)
                parts = target.parts() if each in kept else list_parts(target, name, self.functions)
                found += [Place(each, (*more, *part.place.way)) for part in parts for more in ((), (0,))]
        return found

    def reads_set(self) -> bool:
        """Returns True if what was taken to be set only is observed, and makes the numbers others."""
        read = self.observed.read
        unread = [
            each for each in self.observed.unseen if each not in read and Place(each.base, (0, *each.way)) not in read
        ]
        return self.observed.choose_numbers(unread) != self.numbers

    def ensure_settled(self, kept: Mapping[str, str]) -> None:
        """InputError for a member of a struct of the caller's that was taken as remembered, and that no path sets."""
        for place in self.observed.kept:
            if place.base in self.observed.parameters and place not in self.settled:
                what = f"nothing that is read sets {escape_text(_call_part(place, kept))}, whose address is taken"
                raise self.make_error(what, "assign to it, or give it as an observation in a struct that is const")

    def _settle(self) -> tuple[Update, ...]:
        """What the path has made of memory."""
        after = list[Feature | int | None]()
        for at, place in enumerate(self.observed.kept):
            value = self.memory.get(place)
            self.settled |= {place} if value is not None else set()
            given = None if value is None else self.arithmetic.plain(value)
            if isinstance(given, Symbol) and given.feature.place != at:
                given = self.arithmetic.resolve_number(given)
            if isinstance(given, Symbol) and given.feature.place != at:
                raise self.make_error("what is remembered is a feature of many values", FINITE)
            after.append(given.feature if isinstance(given, Symbol) else None if given is None else int(given.value))
        assert self.paths is not None
        return self.memories.settle(self.paths, after)

    def path(self, paths: Growth, state: Any) -> Any:
        """Returns the function's answer on one path."""
        self.paths = self.arithmetic.paths = paths
        self.depth, self.scope = 0, self.file
        try:
            if state is None:
                self.memory, frame = {}, {}
                for name, type_ in self.observed.parameters.items():
                    given = self.observed.given(name)
                    frame[name] = given if isinstance(given, Object) else self.new_object(type_)
                    if isinstance(given, Reference):
                        self.memory[frame[name].place] = given
                open_ = link_statements([self.function.body], Scope(frame, self.file))
            else:
                open_, memory = state
                self.memory = dict(memory)
            returned = self.answer(self.function, open_, marks=True)
        except Outside as outside:
            self.limits[str(outside)] = None
            return OUTSIDE
        label = self._label(returned)
        return Kept(label, self._settle()) if self.observed.kept else label

    def _label(self, returned: Any) -> Any:
        """The answer of a path. RemembersError for a struct that is set beside it, and read on some path."""
        for name in sorted(self.observed.written) if returned is not None or len(self.observed.written) > 1 else ():
            given = self.observed.given(name)
            target = given.target if isinstance(given, Reference) else given
            parts = list_parts(target, self.function.decl.name, self.functions)
            if isinstance(target.type, Record) and is_read(parts, self.function.decl.name, self.functions):
                raise RemembersError(name)
        results = self.observed.results(self.memory)
        if self.acts:
            done: Any = self.memory.get(DONE, ())
            if len(done) != 1 or (results or returned is not None):
                told = "something is returned or written, too" if len(done) == 1 else " and ".join(done) or "none"
                raise self.make_error(f"some path does not call one action: {told}", "call exactly one on every path")
            self.answers = [Place(ACT)]
            return done[0]
        if results and returned is not None:
            what = "an action is returned, and another one is written to a parameter"
            raise self.make_error(what, "do one of both; return void where an answer is written")
        if results:
            self.answers = [each.place for each in results]
            return self.together([self.load(each) for each in results])
        if returned is None:
            raise self.make_error("nothing is returned or written on some path", "return an action on every path")
        target = self.load(returned.target) if isinstance(returned, Reference) else returned
        if isinstance(target, Reference):
            raise self.make_error("a pointer is returned", "return a number or a text")
        whole = target if isinstance(target, Object) else None
        self.answers = [each.place for each in Object(Place(""), whole.type).parts()] if whole else [Place("")]
        value = self.together([self.load(each) for each in whole.parts()] if whole else [target])
        letter = _words_of(self.function.decl.type.type) == ["char"] and isinstance(value, int) and 32 < value < 127
        return chr(value) if letter else value


def _places(of: Object) -> list[Place]:
    return [each.place for each in of.parts()]


def _call_part(place: Place, kept: Mapping[str, str]) -> str:
    """The name of what is remembered: of a member or item, after its variable if that is no parameter."""
    steps = [str(each) for each in place.way]
    return "_".join(
        steps[1:] if steps[:1] == ["0"] and len(steps) > 1 else [kept[str(place.base)], *steps]
    ).removesuffix("_0")


def _origin(
    name: str, parsed: Any, text: Expanded, where: str, said: Said, hoisted: Mapping[str, str]
) -> tuple[Origin, Asked]:
    kept, memories, setting = dict[str, str](), None, True
    while True:  # again, where a path leaves the ranges of what is remembered, or remembers more
        machine = _Follower(name, parsed, text, where, kept, said, setting=setting)
        memories = machine.memories = memories or machine.memories
        try:
            followed = _follow(machine, text, said)
        except RemembersError as found:
            remembered, memories = str(found), None
            if remembered in kept:
                what = f"{escape_text(kept[remembered])} is read and written: what it held decides"
                raise machine.make_error(what, STATE_ADVICE) from None
            called = hoisted.get(remembered, remembered)
            kept[remembered] = remembered if called in kept.values() else called
        except InputError as error:  # where a path that reads a struct comes before one that sets it
            name_read = machine.find_read_and_set(kept)
            if name_read:
                kept[name_read] = name_read
            elif setting and machine.reads_set():
                setting = False
            else:
                raise memories.explain_error(error) from None
            memories = None
        else:
            if setting and machine.reads_set():
                setting, memories = False, None
            elif not memories.widen():
                machine.ensure_settled(kept)
                vars(machine).clear()  # its circles would keep the syntax tree, in which circles are then looked for
                return followed


def _follow(machine: _Follower, text: Expanded, said: Said) -> tuple[Origin, Asked]:
    def describe_program() -> Described:
        used_places, features, count = machine.observed.features(machine.arithmetic.used)
        whole = machine.observed.whole()
        notes = [f"read without {', '.join(text.missing)}"] if text.missing else []
        return Described(
            kind=KIND,
            given="; ".join((f"{'whole numbers' if whole else machine.numbers}, as it declares", *machine.limits)),
            whole=whole,
            places=used_places,
            features=features,
            n_features=count,
            n_read=max(used_places, default=-1) + 1,
            called=machine.named,
            notes=(*notes, *machine.notes),
            scores=said.scores,
            finite=machine.arithmetic.finite,
        )

    memory = machine.memories.list_ranges()
    origin = origin_of(machine.path, machine.where, describe_program, machine.numbers, machine.arithmetic.sums, memory)
    origin = replace(origin, nan=origin.nan and all(kind.floating for kind in machine.observed.kinds()))
    kept = tuple(machine.observed.kept)
    resets = tuple((each.decl.name, bool(parameters_of(each))) for each in machine.resets)
    return origin, Asked(
        machine.function.decl.name,
        (*machine.observed.order, *kept),
        tuple(machine.answers),
        kept,
        resets,
        said.reads,
        said.acts,
    )
