"""Places in TOML files: the line on which each value stands, however it is written."""

import tomllib

import pytest

from codegen.errors import InputError
from verify.toml_places import Place, parse

SOURCE = '''# a file
name = "x"
variables.x = { unit = "m", range = [-1, 1] }
[agents.cart.features]
place = "x"

[[property]]
label = "a"
# the region
region = { box = { x = [-2,
   2] }, where = ["x <= 1",
   "v <= 2"] }
[[property]]
formula = """
x <= 1 and
  v <= 2"""
escaped = "a\\nb"
[property.region.box]
"cart.x" = [0, 1]
cart.y = 3
[agents.cart.actions]
left = { a = 1 }
'''
PLACES = {
    ("name",): "f, line 2: name",
    ("variables", "x", "range", 1): "f, line 3: variables.x.range 2",
    ("agents", "cart"): "f, line 4: agents.cart",
    ("property",): "f, line 7: property",
    ("property", 0): "f, line 7: property 1",
    ("property", 0, "region", "where", 1): "f, line 10: property 1, region.where 2",
    ("property", 1, "formula"): "f, line 14: property 2, formula",
    ("property", 1, "region"): "f, line 18: property 2, region",
    ("property", 1, "region", "box", "cart.x"): "f, line 19: property 2, region.box.cart.x",
    ("property", 1, "region", "box", "cart.y"): "f, line 20: property 2, region.box.cart.y",
    ("property", 1, "region", "box", "v"): "f, line 18: property 2, region.box.v",  # not there: the table
    ("agents", "cart", "actions", "left", "a"): "f, line 22: agents.cart.actions.left.a",
    ("nowhere",): "f: nowhere",
    (): "f",
}


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize(("keys", "told"), PLACES.items(), ids=str)
def test_every_value_has_its_line(keys, told, ends):
    document, place = parse(SOURCE.replace("\n", ends), "f", "what", "next")
    assert document == tomllib.loads(SOURCE)
    for key in keys:
        place = place / key
    assert str(place) == told


def test_offsets_in_texts_of_several_lines_have_the_line_of_the_file():
    document, place = parse(SOURCE, "f", "what", "next")
    texts, place = document["property"][1], place / "property" / 1
    formula = place / "formula"
    assert formula.of_offset(texts["formula"], 0) == "f, line 15: property 2, formula, column 1"
    assert formula.of_offset(texts["formula"], 13) == "f, line 16: property 2, formula, column 3"
    told = (place / "escaped").of_offset(texts["escaped"], 2)
    assert told.startswith("f, line 1") and told.endswith("property 2, escaped, column 1")


def test_words_are_added_and_what_is_no_toml_is_refused():
    assert str((Place("f", SOURCE) / "name").saying("row 2")) == "f, line 2: name, row 2"
    for text in ("name = ", "a = 1\na = 2", "\x00", "a = [" * 3000):
        with pytest.raises(InputError, match="no TOML") as raised:
            parse(text, "f", "no TOML", "next")
        assert raised.value.where.startswith("f: ")


def test_a_long_list_takes_no_long_search():
    rows = ",\n".join("  [1, 2]" for _ in range(20_000))
    _, place = parse(f"A = [\n{rows}\n]\nb = 3\n", "f", "what", "next")
    assert str(place / "b") in ("f, line 20003: b", "f: b")
