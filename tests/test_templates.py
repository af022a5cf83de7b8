"""Templates place values: nothing is computed in them."""

from pathlib import Path

import pytest
from jinja2 import Environment, nodes

from codegen.lowering.render import _Compiled

TEMPLATES = Path(__file__).parent.parent / "templates"
ARITHMETIC = (nodes.Add, nodes.Sub, nodes.Mul, nodes.Div, nodes.FloorDiv, nodes.Mod, nodes.Pow)
COMPUTING = {"abs", "float", "int", "round", "sum"}  # filters that do


def computed(text):
    """The lines and kinds of all arithmetic."""
    tree = Environment().parse(text)
    found = [(node.lineno, type(node).__name__) for node in tree.find_all(ARITHMETIC)]
    found += [(node.lineno, "Neg") for node in tree.find_all(nodes.Neg) if not isinstance(node.node, nodes.Const)]
    return found + [(node.lineno, node.name) for node in tree.find_all(nodes.Filter) if node.name in COMPUTING]


@pytest.mark.parametrize(
    "path", sorted(TEMPLATES.rglob("*.j2")), ids=lambda path: path.relative_to(TEMPLATES).as_posix()
)
def test_a_template_computes_nothing(path):
    assert computed(path.read_text()) == []


@pytest.mark.parametrize(
    "text",
    [
        *(f"{{{{ a {sign} 2 }}}}" for sign in ("+", "-", "*", "/", "//", "%", "**")),
        *("{{ -a }}", "{{ a | sum }}", '{{ "%d" % a }}', "{% if a - b %}x{% endif %}"),
        '{% set pad = " " * (level + 1) %}',
    ],
)
def test_arithmetic_is_found(text):
    assert computed(text)


def test_a_template_is_compiled_again_where_it_changed(tmp_path):
    path, environment = tmp_path / "one.txt.j2", Environment()

    def shown():
        code = _Compiled(environment, path.name, path).get_code(path.name)
        return environment.template_class.from_code(environment, code, {}).render(word="now")

    path.write_text("once {{ word }}")
    assert shown() == shown() == "once now"
    path.write_text("then {{ word }}")  # as long as before, and a moment later
    assert shown() == "then now"
