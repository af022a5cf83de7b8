"""The structural proof of the C: silent about right headers, and by itself enough to find what was planted."""

import re

import pytest
from hypothesis import given, settings
from pycparser import CParser, c_ast, c_generator

from codegen.equivalence import structure
from codegen.lowering.lower import lower
from codegen.targets import emit
from tests import faults
from tests.support.strategies import profiles

NOT_ITS_OWN = (
    *("input check", "range check", "of rows", "last rows"),
    *("world state", "rounded before", "order", "for all"),
)


def proved(profile, style, change=lambda text: text):
    (header,) = emit(profile, ["c"], style=style).values()
    changed = change(header)
    found = structure.faults(changed, profile, lower(profile, style=style))
    assert set(found) == {policy.agent for policy in profile.agents}
    return changed != header, [each for problems in found.values() for each in problems]


@pytest.mark.parametrize("style", ["nested", "ordered", "freestanding", "walk"])
@settings(max_examples=15)
@given(profile=profiles())
@pytest.mark.smoke
def test_right_headers_are_proved(style, profile):
    assert proved(profile, style)[1] == []


HEADER_FAULTS = [fault for fault in faults.TEXT if fault.name.startswith("h: ")]


@pytest.mark.parametrize("fault", HEADER_FAULTS, ids=lambda fault: fault.name)
def test_planted_faults_are_found_without_running_anything(fault, profile):
    changed, found = proved(profile, fault.style, fault.change)
    if any(text in fault.name for text in NOT_ITS_OWN):
        return
    assert changed and found, fault.name


@pytest.mark.parametrize(
    ("style", "change", "said"),
    [
        ("walk", lambda text: text.replace("level < 3", "level < 2"), "another way"),
        ("walk", lambda text: re.sub(r"action\[8\] = \{\d", "action[8] = {9", text, count=1), "takes action 9"),
        ("nested", lambda text: text.replace("static inline int", "static inline long int", 0) + "int x = ;", "not C"),
        ("nested", lambda text: re.sub(r"\w+_agent_0_act\(const", "gone(const", text, count=1), "there is no function"),
        ("nested", lambda text: re.sub(r"(<= -?0x[\w.+-]+)f\)", r"\1)", text, count=1), "has the threshold"),
        ("nested", lambda text: text.replace("const float n0 =", "const float n00 =", 1), "too many or too few"),
        ("ordered", lambda text: text.replace("(uint32_t)", "(int32_t)"), "another type"),
        ("ordered", lambda text: re.sub(r"<= INT32_C", "< INT32_C", text, count=1), "another way"),
        ("freestanding", lambda text: text.replace("(unsigned int)", "(unsigned long)"), "another way"),
        ("freestanding", lambda text: text.replace("0_act(const int *x)", "0_act(const float *x)"), "not of the form"),
    ],
)
def test_other_forms_are_not_waved_through(style, change, said, profile):
    changed, found = proved(profile, style, change)
    assert changed and any(said in each for each in found), found[:3]


def parsed(text):
    """The text as pycparser alone has it, and as it is read with its tables apart: names, kinds and numbers."""
    alone = CParser().parse(structure.TYPES + structure.plain(text))
    return [[c_generator.CGenerator().visit(tree), *constants(tree)] for tree in (alone, structure.syntax(text))]


def constants(node):
    own = [(node.type, node.value)] if isinstance(node, c_ast.Constant) else []
    return [*own, *(each for _, child in node.children() for each in constants(child))]


@pytest.mark.parametrize("style", ["nested", "ordered", "freestanding", "walk"])
def test_tables_that_are_read_apart_are_those_of_the_parser(style, profile):
    (header,) = emit(profile, ["c"], style=style).values()
    alone, apart = parsed(header)
    assert alone == apart


@pytest.mark.parametrize(
    "entry", ["2", "-1", "0x1.8p-3f", "-0x1p+2", "07", "2u", "0x10", "{2, 3}", "A", "1 ,2", "1 + 1"]
)
@pytest.mark.parametrize(
    "place", ["{} void f(void) {{ }}", "void f(void) {{ {} }}", "void f(void) {{ while (1) {{ {} }} }}"]
)
def test_so_are_tables_of_any_form_and_place(entry, place):
    tables = [f"int x[20] = {{{', '.join([each] * 20)}}};" for each in ("1", entry)]
    alone, apart = parsed(f"enum {{A}}; {place.format(' '.join(tables).replace('x[', 'y[', 1))}")
    assert alone == apart


def test_a_name_that_stands_in_for_tables_stands_for_itself_where_a_header_has_it():
    ones = ", ".join("1" * 20)
    name = f"{structure.STANDS_IN}0"
    alone, apart = parsed(f"enum {{{name}}}; int x[3] = {{{name}}}; int y[20] = {{{ones}}};")
    assert alone == apart
