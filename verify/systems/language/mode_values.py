"""What a rule sets a mode to: one of its modes, a variable with the same modes, what an agent does, a choice of these.

Does: such texts as expressions of the numbers of modes.
Assumes: names of variables with their modes, and agents with their actions.
Does not: know how rules are joined (verify/systems/motion.py).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from verify.language.parser import ACTS, CallNode, NameNode, Node, Source
from verify.systems.language.expressions import Expression, Name, Number
from verify.systems.language.parsing import CHOICE, Names, Option, arguments, read_with
from verify.toml_places import Place

Actions = Mapping[str, Sequence[str]]  # of each agent
HOW = "write one of its modes, its name to keep it, acts(AGENT), or choice(.., ..) of these"


def input_of(agent: str, variable: str) -> str:
    """The name of the input by which an agent's action is a mode of a variable. No text can write it."""
    return f"{agent}.acts as {variable}"


def mode_of(text: str, variable: str, names: Names, actions: Actions, where: Place) -> Expression:
    """Reads the value of a mode from a text. InputError for anything else."""
    return read_with(text, names, where, lambda reader, tree: _value(reader.source, tree, variable, names, actions))


def _value(source: Source, node: Node, variable: str, names: Names, actions: Actions) -> Expression:
    known = names.modes[variable]
    match node:
        case NameNode(token) if token.text in known:
            return Number(Fraction(known.index(token.text)))
        case NameNode(token) if token.text in names.modes:
            if tuple(names.modes[token.text]) != tuple(known):
                raise source.wrong(f"{token.text} has other modes than {variable}", token.place, HOW)
            return Name(token.text)
        case NameNode(token):
            raise source.unknown(f"mode of {variable}", token, known)
        case CallNode(token, (NameNode(agent),)) if token.text == ACTS:
            if agent.text not in actions:
                raise source.unknown("agent", agent, actions)
            strange = [action for action in actions[agent.text] if action not in known]
            if strange:
                what = f"{agent.text} has the action {strange[0]}, which is no mode of {variable}"
                raise source.wrong(what, token.place, f"add it to the modes of {variable}")
            return Name(input_of(agent.text, variable))
        case CallNode(token, given) if token.text == CHOICE and len(given) > 1 and names.choices is not None:
            values = [_value(source, each, variable, names, actions) for each in given]
            texts = arguments(source.text[token.place + len(CHOICE) :])
            name = f"{CHOICE} {len(names.choices) + 1}"
            names.choices[name] = tuple(map(Option, values, texts))
            return Name(name)
        case _:
            raise source.wrong("no mode", node.token.place, HOW)
